"""Reading of exactly as many bytes as a header claims from files that may be shorter, longer, or bombs."""

from __future__ import annotations

import bz2
import zlib
from typing import BinaryIO, Final, Protocol

import numpy as np
import numpy.typing as npt

from shapery_contracts.formats.model import corrupt

_CHUNK: Final = 1 << 18


class ByteSource(Protocol):
    """A stream of bytes that is read from front to back."""

    def read(self, size: int) -> bytes:
        """Return at least one and at most `size` bytes; none at the end."""

    def close(self) -> None:
        """Close the file below."""


class Inflater:
    """Unpacks deflate streams: zlib and gzip with their checksums, gzip with several members."""

    def __init__(self, raw: BinaryIO) -> None:
        self._raw = raw
        self._new_stream()
        self._input = b""
        self._started = False

    def _new_stream(self) -> None:
        # 32: the header tells whether it is zlib or gzip.
        self._stream = zlib.decompressobj(32 + zlib.MAX_WBITS)

    def read(self, size: int) -> bytes:
        """Return at least one and at most `size` unpacked bytes; none at the end."""
        while True:
            if self._stream.eof:
                self._input = self._stream.unused_data or self._raw.read(_CHUNK)
                if not self._input.startswith(b"\x1f\x8b"):
                    # What follows the last member is padding.
                    return b""
                self._new_stream()
            if not self._input:
                self._input = self._raw.read(_CHUNK)
                if not self._input:
                    raise corrupt(
                        "The compressed data break off before their end.", "The file is truncated; send it again."
                    )
            try:
                data = self._stream.decompress(self._input, size)
            except zlib.error as error:
                raise corrupt(f"The compressed data are damaged ({error}).", "Send the file again.") from error
            self._input = self._stream.unconsumed_tail
            if data:
                return data

    def close(self) -> None:
        """Close the file below."""
        self._raw.close()


class Bunzipper:
    """Unpacks bzip2 streams."""

    def __init__(self, raw: BinaryIO) -> None:
        self._raw = raw
        self._stream = bz2.BZ2Decompressor()

    def read(self, size: int) -> bytes:
        """Return at least one and at most `size` unpacked bytes; none at the end."""
        while not self._stream.eof:
            chunk = self._raw.read(_CHUNK) if self._stream.needs_input else b""
            if self._stream.needs_input and not chunk:
                raise corrupt(
                    "The compressed data break off before their end.", "The file is truncated; send it again."
                )
            try:
                data = self._stream.decompress(chunk, size)
            except OSError as error:
                raise corrupt(f"The compressed data are damaged ({error}).", "Send the file again.") from error
            if data:
                return data
        return b""

    def close(self) -> None:
        """Close the file below."""
        self._raw.close()


def skip(source: ByteSource, count: int) -> None:
    """Read and drop `count` bytes.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` if there are fewer.
    """
    left = count
    while left > 0:
        data = source.read(min(left, _CHUNK))
        if not data:
            raise corrupt(
                f"The data end {left} bytes before the place where the volume begins.",
                "The file is truncated or its header is wrong; send it again.",
            )
        left -= len(data)


def read_exactly(source: ByteSource, count: int) -> npt.NDArray[np.uint8]:
    """Return the next `count` bytes in an array of their own.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` if there are fewer.
    """
    out = np.empty(count, dtype=np.uint8)
    view = out.data
    done = 0
    while done < count:
        data = source.read(min(count - done, _CHUNK))
        if not data:
            raise corrupt(
                f"The header asks for {count} bytes of voxels, and there are {done}.",
                "The file is truncated or its header is wrong; send it again.",
            )
        view[done : done + len(data)] = data
        done += len(data)
    return out


def check_end(source: ByteSource) -> bool:
    """Read on to the end of a compressed stream, whose checksum is checked there, and tell whether more data follow."""
    return bool(source.read(1))
