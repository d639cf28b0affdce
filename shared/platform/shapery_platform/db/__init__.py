"""Models, engine and migrations; queries live in `shapery_platform.db.repositories`."""

from shapery_platform.db.engine import Database, database_now
from shapery_platform.db.types import new_id, utc_now

__all__ = ["Database", "database_now", "new_id", "utc_now"]
