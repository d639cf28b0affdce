"""Collections of the shape database."""
