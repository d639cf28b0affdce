"""The runtime that carries out Shapery jobs."""
