"""Shapes of the shape database."""
