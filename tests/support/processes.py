"""Starting server processes that end with the test run, however it ends."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

_LAUNCHER = """
import ctypes, os, signal, sys
uid, gid, parent = (int(word) for word in sys.argv[1:4])
os.setsid()
if uid >= 0:
    os.setgroups([]); os.setgid(gid); os.setuid(uid)
# 1 is PR_SET_PDEATHSIG; set after the change of user, which would clear it
ctypes.CDLL(None).prctl(1, signal.SIGTERM)
if os.getppid() != parent:
    sys.exit(1)
os.execv(sys.argv[4], sys.argv[4:])
"""


class ServerDied(RuntimeError):
    """A server ended before it answered; the text is the end of its log."""


def command(words: Sequence[str | Path], user: tuple[int, int] | None = None) -> list[str]:
    """Return the command that runs `words` as `user` (uid, gid), in a session of its own, until this process ends."""
    uid, gid = user or (-1, -1)
    return [sys.executable, "-S", "-c", _LAUNCHER, str(uid), str(gid), str(os.getpid()), *map(str, words)]


def spawn(
    words: Sequence[str | Path],
    log: Path,
    *,
    user: tuple[int, int] | None = None,
    environment: dict[str, str] | None = None,
    cwd: Path | None = None,
) -> subprocess.Popen[bytes]:
    """Start a server that writes to the file `log`."""
    with log.open("ab") as output:
        return subprocess.Popen(
            command(words, user),
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            env={**os.environ, **(environment or {})},
            cwd=cwd,
        )


def wait_until(ready: Callable[[], bool], process: subprocess.Popen[bytes], log: Path, seconds: float = 60.0) -> None:
    """Wait until `ready` says so; raises `ServerDied` when the process ends first or takes too long."""
    end = time.monotonic() + seconds
    while not ready():
        if process.poll() is not None or time.monotonic() > end:
            raise ServerDied(log.read_text(errors="replace")[-4000:])
        time.sleep(0.02)


def wait_for(condition: Callable[[], bool], seconds: float = 30.0) -> None:
    """Wait until a condition holds; an `AssertionError` where it does not within a generous time."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f"not within {seconds:g} s"
        time.sleep(0.01)


def end(process: subprocess.Popen[bytes], by: int = signal.SIGTERM, seconds: float = 15.0) -> None:
    """End a server by a signal, and by force where it does not follow."""
    if process.poll() is None:
        process.send_signal(by)
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            process.kill()
    process.wait()


def free_port() -> int:
    """Return a port on which nobody listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def listens(port: int) -> bool:
    """Tell whether somebody listens on a port of this machine."""
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1):
        return True
    return False
