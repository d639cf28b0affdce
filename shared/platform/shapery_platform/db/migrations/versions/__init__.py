"""Alembic migrations, one for both databases."""
