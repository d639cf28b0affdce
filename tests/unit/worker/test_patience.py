"""What is tried again, and what is not."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import pytest

from shapery_contracts.errors import LimitExceeded, Unavailable
from shapery_worker import patience
from shapery_worker.patience import Interrupted, patiently


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """A clock that sleeping moves on."""
    times = [0.0]
    monkeypatch.setattr(patience.time, "monotonic", lambda: times[-1])
    monkeypatch.setattr(patience.time, "sleep", lambda seconds: times.append(times[-1] + seconds))
    return times


def failing(error: Exception, times: int) -> Callable[[], str]:
    left = [error] * times

    def action() -> str:
        if left:
            raise left.pop()
        return "done"

    return action


@pytest.mark.parametrize("error", [OSError("away"), Unavailable("service_unavailable", "away"), RuntimeError("away")])
def test_an_outage_is_waited_for(error: Exception, clock: list[float], caplog: pytest.LogCaptureFixture) -> None:
    assert patiently(failing(error, 4), "storing", 60.0) == "done"
    assert clock == pytest.approx([0.0, 0.1, 0.3, 0.7, 1.5])
    assert caplog.text.count("storing failed and is tried again") == 4


def test_but_not_for_ever(clock: list[float]) -> None:
    with pytest.raises(OSError, match="away"):
        patiently(failing(OSError("away"), 1000), "storing", 60.0)
    assert 50.0 < clock[-1] <= 60.0
    assert max(after - before for before, after in itertools.pairwise(clock)) <= 5.0 + 1e-9


@pytest.mark.parametrize("error", [LimitExceeded("storage_full", "It is full."), Interrupted("cancelled")])
def test_what_another_try_does_not_mend_is_raised_at_once(error: Exception, clock: list[float]) -> None:
    with pytest.raises(type(error)):
        patiently(failing(error, 1), "storing", 60.0)
    assert clock == [0.0]


def test_a_wait_ends_when_the_work_is_no_longer_wanted(clock: list[float]) -> None:
    def go_on() -> None:
        if clock[-1] > 1.0:
            raise Interrupted("cancelled")

    with pytest.raises(Interrupted):
        patiently(failing(OSError("away"), 1000), "storing", 60.0, go_on)
    assert clock[-1] < 2.0
