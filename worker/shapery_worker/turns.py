"""Who may run beside whom among the processes of one service on one machine.

A job that was tried before and did not end may be a poisonous one, which takes its whole worker with it. If it ran
beside others, they would be lost as often as it is, and would end as crashed with it. So a job that is tried again
runs alone; whatever dies then is that job's doing only. A worker with room for one job takes no turns.
"""

from __future__ import annotations

import fcntl
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

_POLL = 0.05


class Turns:
    """Shared and exclusive turns.

    Parameters
    ----------
    folder
        A folder that all who take turns have in common; two lock files are kept in it.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._gate = folder / "turns.gate"
        self._room = folder / "turns.room"

    @contextmanager
    def take(self, *, alone: bool, give_up: Callable[[], bool]) -> Iterator[int | None]:
        """Wait for a turn.

        Whoever wants to be alone waits inside the gate, so that nobody who comes later overtakes.

        Yields
        ------
        The descriptor that holds the turn: a process that is forked meanwhile shares it, and must close it lest it
        keep the turn. None when `give_up` said so before the turn came.
        """
        gate = os.open(self._gate, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        room = os.open(self._room, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            entered = _lock(gate, fcntl.LOCK_EX, give_up) and _lock(
                room, fcntl.LOCK_EX if alone else fcntl.LOCK_SH, give_up
            )
            os.close(gate)
            gate = -1
            yield room if entered else None
        finally:
            for descriptor in (gate, room):
                if descriptor >= 0:
                    os.close(descriptor)


def _lock(descriptor: int, operation: int, give_up: Callable[[], bool]) -> bool:
    while True:
        try:
            # flock, and not lockf: a record lock would vanish when another part of this process closed the file
            fcntl.flock(descriptor, operation | fcntl.LOCK_NB)
        except BlockingIOError:
            if give_up():
                return False
            time.sleep(_POLL)
        else:
            return True
