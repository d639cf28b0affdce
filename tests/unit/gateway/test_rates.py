from __future__ import annotations

import pytest

from shapery_gateway import rates
from shapery_gateway.rates import RateLimiter, retry_after


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_a_burst_of_a_minute_and_then_an_even_rate() -> None:
    clock = Clock()
    limiter = RateLimiter(60, clock)
    assert all(limiter.take("a") == 0 for _ in range(60))
    assert limiter.take("a") == pytest.approx(1.0)
    assert limiter.wait("a") == pytest.approx(1.0)
    clock.now += 1.0
    assert limiter.take("a") == 0
    assert limiter.take("a") > 0
    clock.now += 30
    assert sum(limiter.take("a") == 0 for _ in range(60)) == 30


def test_callers_do_not_share() -> None:
    limiter = RateLimiter(1, Clock())
    assert limiter.take("a") == 0
    assert limiter.take("b") == 0
    assert limiter.take("a") > 0


def test_a_refused_call_costs_nothing() -> None:
    clock = Clock()
    limiter = RateLimiter(1, clock)
    limiter.take("a")
    for _ in range(100):
        assert limiter.take("a") > 0
    clock.now += 60
    assert limiter.take("a") == 0


def test_zero_is_no_limit() -> None:
    limiter = RateLimiter(0, Clock())
    assert all(limiter.take("a") == 0 and limiter.wait("a") == 0 for _ in range(1000))


def test_memory_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rates, "MAX_TRACKED", 10)
    limiter = RateLimiter(1, Clock())
    for number in range(100):
        limiter.take(str(number))
    assert limiter.take("99") > 0, "the latest are remembered"
    assert limiter.take("0") == 0, "the oldest were forgotten"


def test_retry_after_is_whole_and_never_zero() -> None:
    assert retry_after(0.01) == {"Retry-After": "1"}
    assert retry_after(1.2) == {"Retry-After": "2"}
