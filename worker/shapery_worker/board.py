"""A page of memory that a handler's process and its watcher share.

The handler writes its newest progress on it and reads from it whether it shall stop. Nothing here blocks, allocates or
makes a system call: a handler may report in its innermost loop, the watcher looks at its own pace and sees the newest
word only, and a handler that is stuck in native code can neither fill a pipe nor hold up its watcher.
"""

from __future__ import annotations

import json
import math
import mmap
import struct
import zlib
from dataclasses import dataclass

_STOP = 0
_RECORD = struct.Struct("<QII")
"""Count of writes begun and ended (odd while one is going on), length and checksum of the text that follows."""
_RECORD_AT = 8
_TEXT_AT = _RECORD_AT + _RECORD.size
_SIZE = 4096
_MAX_STAGE = 64
_MAX_MESSAGE = 500


@dataclass(frozen=True, slots=True)
class Progress:
    """The newest word of a handler: its stage, the fraction in [0, 1] of the work done, and a message."""

    stage: str = ""
    fraction: float = 0.0
    message: str = ""


class Board:
    """One shared page; make it before the fork."""

    def __init__(self) -> None:
        self._page = mmap.mmap(-1, _SIZE)
        self._count = 0

    def ask_to_stop(self) -> None:
        """Tell the handler, from the watcher's side, that its result is no longer wanted."""
        self._page[_STOP] = 1

    @property
    def stop_asked(self) -> bool:
        """Whether the handler was told to stop."""
        return self._page[_STOP] != 0

    def write(self, progress: Progress) -> None:
        """Replace the progress on the board; only the handler's process may."""
        fraction = progress.fraction if math.isfinite(progress.fraction) else 0.0
        message = progress.message[:_MAX_MESSAGE]
        text = json.dumps([progress.stage[:_MAX_STAGE], min(max(fraction, 0.0), 1.0), message]).encode()
        while len(text) > _SIZE - _TEXT_AT:  # escapes make a character up to twelve bytes long
            message = message[: len(message) // 2]
            text = json.dumps([progress.stage[:_MAX_STAGE], min(max(fraction, 0.0), 1.0), message]).encode()
        self._count += 2
        _RECORD.pack_into(self._page, _RECORD_AT, self._count - 1, 0, 0)
        self._page[_TEXT_AT : _TEXT_AT + len(text)] = text
        _RECORD.pack_into(self._page, _RECORD_AT, self._count, len(text), zlib.crc32(text))

    def read(self) -> Progress | None:
        """Return the newest progress; None when there is none, or when it is being written at this moment."""
        count, length, checksum = _RECORD.unpack_from(self._page, _RECORD_AT)
        if count == 0 or count % 2 or length > _SIZE - _TEXT_AT:
            return None
        text = self._page[_TEXT_AT : _TEXT_AT + length]
        # The checksum rather than a second look at the count: it also holds where the memory model is weak.
        if zlib.crc32(text) != checksum:
            return None
        stage, fraction, message = json.loads(text)
        return Progress(stage, fraction, message)

    def close(self) -> None:
        """Give the page back; only when the handler's process has ended."""
        self._page.close()
