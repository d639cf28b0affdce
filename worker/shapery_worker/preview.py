"""The file in which a handler shows how its result looks so far, seen from its watcher."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from shapery_contracts.handler import MAX_PREVIEW

_FLAGS = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC


class PreviewFile:
    """Reads each preview once. The handler replaces the file as a whole, so that it is never seen half written.

    Parameters
    ----------
    path
        Where it lies, or does not lie yet.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._seen: tuple[int, int] | None = None
        self._read: tuple[int, int] | None = None

    def read(self) -> bytes | None:
        """Return what is new since the last preview that was `taken`; None where nothing is.

        What is no regular file, is empty, or is larger than `MAX_PREVIEW`, is nothing: the handler is not trusted.
        """
        self._read = self._seen
        try:
            # First a look: what is no file is not even opened. Then once more, at what was opened.
            if not stat.S_ISREG(os.lstat(self._path).st_mode):
                return None
            with os.fdopen(
                os.open(self._path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC), "rb"
            ) as file:
                told = os.fstat(file.fileno())
                version = (told.st_ino, told.st_mtime_ns)
                if version == self._seen or not stat.S_ISREG(told.st_mode):
                    return None
                data = file.read(MAX_PREVIEW + 1)
        except OSError:
            return None
        self._read = version
        return data if 0 < len(data) <= MAX_PREVIEW else None

    def taken(self) -> None:
        """Forget what was read last: it is where it belongs."""
        self._seen = self._read
