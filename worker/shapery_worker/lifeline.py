"""Processes that die with their parent, and trees of processes that are killed and measured as one.

A worker must leave nothing behind however it ends, SIGKILL included. On Linux the kernel sees to it: a process asks
with ``prctl(PR_SET_PDEATHSIG)`` for a signal of its own at its parent's death. Elsewhere a thread compares the parent's
id with the one expected. Only modules of the standard library are imported on top, because the launcher of the
supervisor starts with this module alone.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

LINUX: bool = sys.platform.startswith("linux")
_PR_SET_PDEATHSIG = 1
_WATCH_INTERVAL = 0.25


def tie_to_parent(parent: int) -> None:
    """Make sure that this process does not outlive the process `parent` that started it.

    Parameters
    ----------
    parent
        The id that the parent had when it started this process: comparing it afterwards closes the gap in which the
        parent died before the kernel was asked.
    """
    if LINUX:
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0) != 0:
            errno = ctypes.get_errno()
            raise OSError(errno, f"prctl(PR_SET_PDEATHSIG): {os.strerror(errno)}")
    else:
        watch_parent(parent, lambda: os.kill(os.getpid(), signal.SIGKILL))
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)


def watch_parent(parent: int, on_orphaned: Callable[[], None], interval: float = _WATCH_INTERVAL) -> threading.Thread:
    """Call `on_orphaned` once this process has another parent than `parent`; returns the thread that looks."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(interval)
        on_orphaned()

    thread = threading.Thread(target=watch, name="parent-watch", daemon=True)
    thread.start()
    return thread


def alive(pid: int) -> bool:
    """Tell whether a process `pid` exists and is not a zombie."""
    import psutil

    try:
        return bool(psutil.Process(pid).status() != psutil.STATUS_ZOMBIE)
    except psutil.NoSuchProcess:
        return False


def kill_tree(pid: int) -> None:
    """Kill process `pid`, the group it leads, and everything that descends from it; missing ones are no error.

    Call it before the process is reaped: until then its id, and with it the group's, cannot belong to anyone else.
    """
    import psutil

    victims: list[psutil.Process] = []
    with contextlib.suppress(psutil.Error):  # it may have ended already, while its group has members
        victims = psutil.Process(pid).children(recursive=True)
    try:
        os.killpg(pid, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        # No such group: it was never made (the process died before setsid), or the members ended by themselves.
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    for process in victims:
        try:
            process.kill()
        except psutil.Error:
            continue


def resident_memory(pid: int) -> int:
    """Return the resident bytes of process `pid` alone; 0 when it has ended."""
    if LINUX:
        # One small file instead of a psutil object: the watcher asks ten times a second.
        try:
            pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
        except (OSError, IndexError):
            return 0
        return pages * os.sysconf("SC_PAGE_SIZE")
    import psutil

    try:
        return int(psutil.Process(pid).memory_info().rss)
    except psutil.Error:
        return 0


def resident_memory_of_descendants(pid: int) -> int:
    """Return the resident bytes of all that descends from process `pid`, without itself."""
    import psutil

    total = 0
    try:
        descendants = psutil.Process(pid).children(recursive=True)
    except psutil.Error:
        return 0
    for process in descendants:
        try:
            total += process.memory_info().rss
        except psutil.Error:
            continue
    return total
