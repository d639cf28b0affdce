"""Databases with the tables of the platform."""

from __future__ import annotations

from shapery_platform.db import Database


def migrated(url: str) -> str:
    """Make the tables in an empty database and return its address."""
    database = Database(url)
    database.migrate()
    database.dispose()
    return url
