"""Real workers over a real Redis, on SQLite and on PostgreSQL."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.databases import migrated
from tests.support.redis import RedisServer, redis_server
from tests.support.stack import Stack, running_stack

QUICK = {"lease_seconds": 3.0, "heartbeat_interval": 0.5}
"""A pulse at which tests need not wait long for the loss of a worker to be noticed."""


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def any_database_url(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> str:
    """A migrated database of each sort."""
    if request.param == "sqlite":
        url = f"sqlite:///{tmp_path_factory.mktemp('database') / 'shapery.db'}"
    else:
        url = request.getfixturevalue("postgres").create_database()
    return migrated(url)


@pytest.fixture(scope="module")
def redis() -> Iterator[RedisServer]:
    with redis_server() as server:
        yield server


@pytest.fixture(scope="module")
def shared_stack(tmp_path_factory: pytest.TempPathFactory, any_database_url: str) -> Iterator[Stack]:
    """A worker with room for three jobs and a reaper, for the tests of one module that leave them in peace."""
    home = tmp_path_factory.mktemp("home")
    limits = {"job_time_limit": {"probe-brief": 1.0}, "job_memory_limit": {"probe-lean": 400 << 20}}
    with redis_server() as redis, running_stack(home, any_database_url, redis, **limits) as stack:
        stack.start_worker(concurrency=3)
        stack.start_reaper()
        yield stack


@pytest.fixture(scope="module")
def robust_stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stack]:
    """A worker with room for three jobs and a reaper that survive what the tests of one module do to them.

    It lives beside the stacks of single tests, so it has a queue of its own.
    """
    home = tmp_path_factory.mktemp("home")
    url = migrated(f"sqlite:///{home / 'shapery.db'}")
    with redis_server() as redis, running_stack(home, url, redis, **QUICK) as stack:
        stack.start_worker(concurrency=3)
        stack.start_reaper()
        yield stack


@pytest.fixture
def stack(tmp_path: Path, redis: RedisServer) -> Iterator[Stack]:
    """An empty stack on SQLite, for tests that kill."""
    redis.clear()
    url = migrated(f"sqlite:///{tmp_path / 'shapery.db'}")
    with running_stack(tmp_path, url, redis, **QUICK) as stack:
        yield stack
