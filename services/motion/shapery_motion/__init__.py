"""Compression of mesh sequences by clusters of local transformations."""
