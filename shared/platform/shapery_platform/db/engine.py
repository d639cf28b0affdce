"""The database: engine, sessions and migrations for SQLite and PostgreSQL."""

from __future__ import annotations

import json
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event, func, make_url, select, text
from sqlalchemy.engine import URL
from sqlalchemy.orm import Session, sessionmaker

_BUSY_SECONDS = 30.0
"""How long a writer waits for another before it gives up."""
_IDLE_SECONDS = 600.0
"""After so long PostgreSQL ends a transaction in which nothing happens."""

_MIGRATION_LOCK = 0x5348_4150
"""Key of PostgreSQL's advisory lock under which one process at a time migrates."""


def _dump_json(value: Any) -> str:
    # NaN and Infinity are not JSON: PostgreSQL refuses them, and so must SQLite
    return json.dumps(value, allow_nan=False, separators=(",", ":"))


class Database:
    """One engine, its sessions and its migrations.

    Parameters
    ----------
    url
        ``sqlite:///path`` or ``postgresql://user:password@host/name``.
    pool_size
        Connections kept open; twice as many may be open at a time.
    """

    def __init__(self, url: str, *, pool_size: int = 10) -> None:
        self.url = _with_driver(url)
        if self.url.get_backend_name() == "sqlite":
            self.engine = _sqlite_engine(self.url, pool_size)
        else:
            self.engine = _postgresql_engine(self.url, pool_size)
        self._writers = sessionmaker(self.engine, expire_on_commit=False)
        self._readers = sessionmaker(
            self.engine.execution_options(shapery_readonly=True, postgresql_readonly=True), expire_on_commit=False
        )

    @property
    def dialect(self) -> str:
        """``sqlite`` or ``postgresql``."""
        return self.engine.dialect.name

    @contextmanager
    def session(self, *, readonly: bool = False) -> Iterator[Session]:
        """Open a session: it commits on success and rolls back on an error.

        Parameters
        ----------
        readonly
            The session cannot write. In SQLite it then reads beside a writer instead of waiting for it.
        """
        with (self._readers if readonly else self._writers)() as session, session.begin():
            yield session

    def ping(self) -> None:
        """Ask the database a question; raises if it does not answer."""
        with self.session(readonly=True) as session:
            session.execute(text("SELECT 1"))

    def migrate(self) -> None:
        """Bring the tables to the newest version; processes that start together wait for each other."""
        from alembic import command

        with self.engine.connect() as connection, connection.begin():
            if self.dialect == "postgresql":
                connection.execute(select(func.pg_advisory_xact_lock(_MIGRATION_LOCK)))
            command.upgrade(alembic_config(connection), "head")

    def dispose(self) -> None:
        """Close the pooled connections; a process forked from this one calls it with `close` left to the parent."""
        self.engine.dispose()

    def after_fork(self) -> None:
        """Forget the parent's connections without closing them; call it first in a forked child."""
        self.engine.dispose(close=False)


def alembic_config(connection: Connection) -> Any:
    """Return Alembic's configuration for the migrations of this package over an open connection."""
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent / "migrations").replace("%", "%%"))
    config.attributes["connection"] = connection
    return config


def database_now(session: Session) -> datetime:
    """Return the time by which leases are judged: PostgreSQL's, so that hosts whose clocks differ agree."""
    if session.get_bind().dialect.name == "postgresql":
        now: datetime = session.execute(select(func.clock_timestamp())).scalar_one()
        return now.astimezone(UTC)
    return datetime.now(UTC)


def _with_driver(url: str) -> URL:
    parsed = make_url(url)
    if parsed.drivername in ("postgres", "postgresql"):
        return parsed.set(drivername="postgresql+psycopg")
    if parsed.get_backend_name() == "sqlite" and parsed.database in (None, "", ":memory:"):
        raise ValueError("an SQLite database needs a file: several processes share it")
    return parsed


def _postgresql_engine(url: URL, pool_size: int) -> Engine:
    engine = create_engine(
        url,
        json_serializer=_dump_json,
        # each statement sees what was committed before it: the sweep and the leases count on that
        isolation_level="READ COMMITTED",
        pool_size=pool_size,
        max_overflow=pool_size,
        pool_pre_ping=True,
        connect_args={"connect_timeout": 10},
    )

    @event.listens_for(engine, "connect")
    def _connect(connection: Any, _record: Any) -> None:
        # A process that hangs in the middle of a transaction must not hold up the others for ever.
        connection.execute(f"SET lock_timeout = '{_BUSY_SECONDS:g}s'")
        connection.execute(f"SET idle_in_transaction_session_timeout = '{_IDLE_SECONDS:g}s'")
        connection.commit()

    return engine


def _write_ahead(cursor: sqlite3.Cursor) -> None:
    """Let readers and a writer work side by side. SQLite does not wait for others when it changes its journal."""
    deadline = time.monotonic() + _BUSY_SECONDS
    while True:
        try:
            cursor.execute("PRAGMA journal_mode = WAL")
        except sqlite3.OperationalError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.02)
        else:
            return


def _sqlite_engine(url: URL, pool_size: int) -> Engine:
    Path(str(url.database)).parent.mkdir(parents=True, exist_ok=True)
    engine = create_engine(
        url,
        json_serializer=_dump_json,
        pool_size=pool_size,
        max_overflow=pool_size,
        # the driver must not begin transactions by itself: `_begin` does
        connect_args={"timeout": _BUSY_SECONDS, "isolation_level": None, "check_same_thread": False},
    )

    @event.listens_for(engine, "connect")
    def _connect(connection: Any, _record: Any) -> None:
        cursor = connection.cursor()
        _write_ahead(cursor)
        # a job that was answered with 202 must survive the loss of power
        cursor.execute("PRAGMA synchronous = FULL")
        cursor.execute("PRAGMA foreign_keys = ON")
        cursor.close()

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        # A writer takes the lock at once: one that reads first and then writes would fail when another wrote meanwhile.
        if connection.get_execution_options().get("shapery_readonly"):
            connection.exec_driver_sql("PRAGMA query_only = ON")
            connection.exec_driver_sql("BEGIN")
        else:
            connection.exec_driver_sql("PRAGMA query_only = OFF")
            connection.exec_driver_sql("BEGIN IMMEDIATE")

    return engine
