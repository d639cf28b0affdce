"""Start a program that dies with its parent: ``python leash.py PARENT PROGRAM ARGUMENT…``.

The supervisor starts Redis and the gateway through it, which know nothing of their supervisor. On Linux the wish is
stated to the kernel and survives the ``exec`` that follows, so nothing of this program remains. Elsewhere it stays,
passes signals on, and kills the program when the parent is gone.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from types import FrameType

if __package__ in (None, ""):  # run as a file, so that the package and all it imports stay out of it
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    from lifeline import LINUX, tie_to_parent, watch_parent  # type: ignore[import-not-found,unused-ignore]
else:
    from shapery_worker.lifeline import LINUX, tie_to_parent, watch_parent


def command(program: list[str]) -> list[str]:
    """Return the command line that starts `program` on the leash of the calling process."""
    return [sys.executable, "-I", "-S", str(Path(__file__).resolve()), str(os.getpid()), *program]


def guard(parent: int, program: list[str]) -> int:
    """Run `program` as a child, pass signals on to it, and kill it when `parent` is gone; returns its exit code."""
    child: subprocess.Popen[bytes] | None = None
    early: list[int] = []

    def forward(number: int, _frame: FrameType | None) -> None:
        if child is None:
            early.append(number)
        else:
            child.send_signal(number)

    # Before the program is started: a signal in between would end the guard and leave the program alone.
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, forward)
    child = subprocess.Popen(program)
    for missed in early:
        child.send_signal(missed)
    watch_parent(parent, child.kill)
    code = child.wait()
    return code if code >= 0 else 128 - code


def main(arguments: list[str]) -> int:
    """Entry of the launcher; returns only where the program is guarded rather than replaced."""
    parent, program = int(arguments[0]), arguments[1:]
    if LINUX:
        tie_to_parent(parent)
        os.execvp(program[0], program)  # noqa: S606 (the program is the supervisor's own choice)
    return guard(parent, program)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
