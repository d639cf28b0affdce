"""Work that nobody does is said to wait, where it is watched."""

from __future__ import annotations

import threading

import pytest

from shapery_client import Client
from shapery_client.cli import _following
from tests.unit.client.conftest import FlakyServer, answer, problem


class Notes:
    """Stands where the bar does, and keeps what it is told."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.told = threading.Event()

    def note(self, text: str) -> None:
        self.texts.append(text)
        self.told.set()


def kind(name: str, workers: int) -> dict[str, object]:
    return {
        "name": name,
        "service": name,
        "summary": "",
        "inputs": {},
        "params_schema": {},
        "result_schema": {},
        "stages": [],
        "time_limit": 1,
        "memory_limit": 1,
        "workers": workers,
    }


def test_a_kind_without_workers_is_told_of_and_others_are_not(
    client: Client, server: FlakyServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_following, "LOOK_EVERY", 0.01)
    asked = threading.Event()
    answers = iter([lambda handler: problem(handler, 404, "not_found")])

    def kinds(handler):  # type: ignore[no-untyped-def]
        # the first look fails, which is not this thread's to report
        next(answers, lambda h: (answer(h, 200, [kind("segmentation", 0), kind("motion", 1)]), asked.set()))(handler)

    server.routes["GET", "/v1/kinds"] = kinds
    idle, busy = Notes(), Notes()
    with _following.missing_workers_told(client, "segmentation", idle):  # type: ignore[arg-type]
        assert idle.told.wait(10)
    assert "no segmentation worker" in idle.texts[0]
    asked.clear()
    with _following.missing_workers_told(client, "motion", busy):  # type: ignore[arg-type]
        assert asked.wait(10)
    assert busy.texts == []
