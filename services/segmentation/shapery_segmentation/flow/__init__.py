"""Flows of a surface over a volume (3.4)."""
