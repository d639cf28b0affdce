"""Sections: a tag, a length, the payload and a checksum over all three."""

from __future__ import annotations

import struct
import zlib
from typing import Final

from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats.model import corrupt

MAGIC: Final = b"SMC1\r\n\x1a\n"
"""The first bytes of a file; a transfer as text damages them."""
HEAD, META, GROUPS, CONNECTIVITY, CORRECTIONS, END = "HEAD", "META", "GRPS", "CONN", "CORR", "END "
FRAME_BYTES: Final = 12
"""Bytes of a section beside its payload."""

_PREFIX: Final = struct.Struct("<4sI")
_CHECK: Final = struct.Struct("<I")


def pack_section(tag: str, payload: bytes) -> bytes:
    """Return a section as it stands in a file."""
    prefix = _PREFIX.pack(tag.encode("ascii"), len(payload))
    return prefix + payload + _CHECK.pack(zlib.crc32(payload, zlib.crc32(prefix)))


def damaged(tag: str, what: str) -> InvalidInput:
    """Return the error for a section that contradicts itself."""
    return corrupt(f"Section {tag.strip()} of the motion file {what}.")


class SectionReader:
    """Walk through the sections of a file from an offset on.

    Parameters
    ----------
    data
        The file, or a memory map of it.
    offset
        Where the next section begins.
    stop
        Where the sections end; a section that reaches beyond is refused.
    """

    def __init__(self, data: memoryview, offset: int, stop: int) -> None:
        self._data = data
        self.offset = offset
        self._stop = min(stop, len(data))

    def next(self, expected: str | None = None) -> tuple[str, memoryview]:
        """Return the tag and the payload of the next section, whose checksum was compared.

        Raises
        ------
        InvalidInput
            ``corrupt_file``, naming the section.
        """
        name = expected or "after byte " + str(self.offset)
        room = self._stop - self.offset
        if room < FRAME_BYTES:
            raise damaged(name, "is missing: the file is cut off")
        raw, length = _PREFIX.unpack_from(self._data, self.offset)
        tag = raw.decode("ascii", "replace")
        if not tag.isprintable() or not tag.isascii():
            raise damaged(name, "has a damaged tag")
        if expected is not None and tag != expected:
            raise damaged(expected, f"is missing: section {tag.strip()} stands in its place")
        if length > room - FRAME_BYTES:
            raise damaged(tag, f"is cut off: of its {length} bytes {room - FRAME_BYTES} are there")
        end = self.offset + _PREFIX.size + length
        (check,) = _CHECK.unpack_from(self._data, end)
        if zlib.crc32(self._data[self.offset : end]) != check:
            raise damaged(tag, "is damaged: its checksum does not agree")
        payload = self._data[self.offset + _PREFIX.size : end]
        self.offset = end + _CHECK.size
        return tag, payload
