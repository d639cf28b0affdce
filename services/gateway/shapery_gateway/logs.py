"""Logs as one JSON object per line on standard error."""

from __future__ import annotations

import json
import logging
import os
import sys
from datetime import UTC, datetime
from typing import Any

_STANDARD = frozenset(logging.makeLogRecord({}).__dict__) | {"message", "asctime", "taskName", "color_message"}


class JsonFormatter(logging.Formatter):
    """One line per record, with whatever was given as ``extra``."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        entry: dict[str, Any] = {
            "at": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        entry.update((key, value) for key, value in record.__dict__.items() if key not in _STANDARD)
        if record.exc_info:
            entry["traceback"] = self.formatException(record.exc_info)
        return json.dumps(entry, default=str, ensure_ascii=True)


def configure(level: str | None = None) -> None:
    """Write all logs of this process that way. `level`, or ``SHAPERY_LOG_LEVEL``, is the least that is shown."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonFormatter())
    logging.basicConfig(
        level=(level or os.environ.get("SHAPERY_LOG_LEVEL", "info")).upper(), handlers=[handler], force=True
    )
    # Of the libraries only what went wrong: their own lines would say twice what ours say.
    for name in ("uvicorn", "uvicorn.error", "kombu", "celery", "sqlalchemy.engine", "alembic", "asyncio"):
        logging.getLogger(name).setLevel(logging.WARNING)
