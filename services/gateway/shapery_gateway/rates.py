"""How often a key or an address may call."""

from __future__ import annotations

import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable

MAX_TRACKED = 20_000
"""Callers remembered at once; the one that was silent longest is forgotten, and with it at most a minute of calls."""


class RateLimiter:
    """The generic cell rate algorithm: an even rate, with a burst of one minute's worth, in one number per caller.

    The count is this process's own: with several gateways behind one balancer the limit holds for each of them.

    Parameters
    ----------
    per_minute
        Requests per minute; 0: no limit.
    clock
        Seconds on a clock that never goes back.
    """

    def __init__(self, per_minute: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.per_minute = per_minute
        self._interval = 60.0 / per_minute if per_minute else 0.0
        self._clock = clock
        self._earliest: OrderedDict[str, float] = OrderedDict()
        self._lock = threading.Lock()

    def wait(self, caller: str) -> float:
        """Return the seconds until `caller` may call, without counting a call; 0: now."""
        if not self.per_minute:
            return 0.0
        with self._lock:
            return self._wait(caller, self._clock())

    def take(self, caller: str) -> float:
        """Count a call of `caller`, unless it has to wait; return the seconds to wait, 0 where the call counted."""
        if not self.per_minute:
            return 0.0
        with self._lock:
            now = self._clock()
            wait = self._wait(caller, now)
            if wait <= 0:
                self._earliest[caller] = max(self._earliest.get(caller, now), now) + self._interval
                self._earliest.move_to_end(caller)
                if len(self._earliest) > MAX_TRACKED:
                    self._earliest.popitem(last=False)
            return wait

    def _wait(self, caller: str, now: float) -> float:
        # `_earliest` is when the caller's allowance would be whole again; a burst may run ahead of it by a minute.
        ahead = self._earliest.get(caller, now) - now
        return max(0.0, ahead + self._interval - 60.0)


def retry_after(seconds: float) -> dict[str, str]:
    """Return the header ``Retry-After`` for a wait of `seconds`."""
    return {"Retry-After": str(max(1, math.ceil(seconds)))}
