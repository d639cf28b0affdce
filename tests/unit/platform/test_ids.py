"""UUIDv7 ids (RFC 9562)."""

from __future__ import annotations

import threading
import time
from uuid import UUID

import pytest

from shapery_platform.db import new_id
from shapery_platform.db import types as types_module


def test_version_variant_and_time() -> None:
    before = time.time_ns() // 1_000_000
    made = new_id()
    after = time.time_ns() // 1_000_000
    assert made.version == 7
    assert made.variant == "specified in RFC 4122"
    assert before <= made.int >> 80 <= after + 1


def test_ids_of_a_process_rise_strictly() -> None:
    made: list[list[UUID]] = [[] for _ in range(4)]
    threads = [
        threading.Thread(target=lambda own=own: own.extend(new_id() for _ in range(2000)))  # type: ignore[misc]
        for own in made
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(own == sorted(own) for own in made)
    assert len({entry for own in made for entry in own}) == 8000


def test_ids_rise_also_when_the_clock_goes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    first = new_id()
    monkeypatch.setattr(types_module.time, "time_ns", lambda: 1_600_000_000_000_000_000)
    assert first < new_id() < new_id()


def test_the_order_of_text_is_the_order_of_ids() -> None:
    made = [new_id() for _ in range(100)]
    assert sorted(entry.hex for entry in made) == [entry.hex for entry in made]
