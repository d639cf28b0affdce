"""Batches: many jobs of one kind, asked for at once."""
