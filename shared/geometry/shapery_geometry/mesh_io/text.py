"""Lines and numbers of the plain-text formats, read in bounded pieces."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.formats.model import corrupt

_PIECE: Final = 1 << 22
_Number = TypeVar("_Number", int, float)


def line_batches(stream: BinaryIO) -> Iterator[list[bytes]]:
    """Yield the lines of a stream in lists of a few megabytes, stripped of blanks and ends (LF, CR LF or CR)."""
    rest = b""
    while piece := stream.read(_PIECE):
        data = rest + piece
        if b"\r" in data:
            # a CR at the very end may belong to an LF that is not read yet
            tail = b"\r" if data.endswith(b"\r") else b""
            data = data[: len(data) - len(tail)].replace(b"\r\n", b"\n").replace(b"\r", b"\n") + tail
        lines = data.split(b"\n")
        rest = lines.pop()
        yield [line.strip() for line in lines]
    if rest:
        yield [line.strip() for line in rest.split(b"\r")]


def rows_of(stream: BinaryIO, comment: bytes | None = None) -> Iterator[list[bytes]]:
    """Yield the words of each line that has any; what follows the mark of a `comment` does not count."""
    for lines in line_batches(stream):
        for line in lines:
            words = (line.split(comment, 1)[0] if comment is not None and comment in line else line).split()
            if words:
                yield words


def floats(words: list[bytes], what: str) -> NDArray[np.float64]:
    """Return words as numbers.

    Raises
    ------
    InvalidInput
        ``corrupt_file``, saying which of `what` is no number.
    """
    return np.array(_converted(words, what, float), dtype=np.float64)


def integers(words: list[bytes], what: str) -> NDArray[np.int64]:
    """Return words as whole numbers; raises like `floats`."""
    values = _converted(words, what, int)
    if values and max(max(values), -min(values)) >= 1 << 62:
        raise corrupt(f"Among the {what} stands {max(values, key=abs)}, which no file can mean.")
    return np.array(values, dtype=np.int64)


def _converted(words: list[bytes], what: str, kind: type[_Number]) -> list[_Number]:
    try:
        # Python allows underscores in numbers, no file format does
        if b"_" not in b"".join(words):
            return list(map(kind, words))
    except ValueError:
        pass
    name = "number" if kind is float else "whole number"
    bad = next(word for word in words if b"_" in word or not _is(kind, word))
    raise corrupt(f"Among the {what} stands {bad[:40].decode('latin-1')!r}, which is no {name}.")


def _is(kind: type[_Number], word: bytes) -> bool:
    try:
        kind(word)
    except ValueError:
        return False
    return True
