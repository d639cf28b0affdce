"""Zip archives from strangers: inspected before anything is unpacked, and unpacked within bounds.

The standard library's `zipfile` reads whatever directory an archive claims and follows its names. Here the directory
is read by a parser of its own that stops at the limits, every entry is judged before the first is opened, and an entry
yields exactly as many bytes as the directory declared, checked against its CRC. What an archive claims therefore costs
nothing, and what it holds costs no more than the limits allow. An archive inside an archive is never opened.

Only stored and deflated entries are read; both are what any zip program writes.
"""

from __future__ import annotations

import io
import stat
import struct
import unicodedata
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

from shapery_contracts.errors import InvalidInput, LimitExceeded

__all__ = ["ArchiveEntry", "ArchiveLimits", "SafeArchive", "open_archive"]

_END: Final = struct.Struct("<4s4H2LH")
_END64_LOCATOR: Final = struct.Struct("<4sLQL")
_END64: Final = struct.Struct("<4sQ2H2L4Q")
_CENTRAL: Final = struct.Struct("<4s6H3L5H2L")
_LOCAL: Final = struct.Struct("<4s5H3L2H")
_MAX_COMMENT: Final = 0xFFFF
_STORED, _DEFLATED = 0, 8
_METHODS: Final = {9: "Deflate64", 12: "bzip2", 14: "LZMA", 20: "Zstandard", 93: "Zstandard", 95: "xz", 98: "PPMd"}
_DEFLATE_RATIO: Final = 1032
"""No deflate stream expands further than this; a larger claim is a lie."""
_CHUNK: Final = 1 << 16
_JUNK_FOLDERS: Final = frozenset({"__MACOSX"})
_JUNK_NAMES: Final = frozenset({".DS_Store", "Thumbs.db", "desktop.ini"})


@dataclass(frozen=True, slots=True)
class ArchiveLimits:
    """How much an archive may hold."""

    entries: int = 20_000
    """Files and folders in the directory."""
    total_bytes: int = 8 << 30
    """Sum of the unpacked sizes."""
    entry_bytes: int = 4 << 30
    """Unpacked size of one entry."""
    directory_bytes: int = 32 << 20
    """Size of the directory itself."""


@dataclass(frozen=True, slots=True)
class ArchiveEntry:
    """One file in an archive."""

    name: str
    """Relative path with forward slashes; safe to join to a folder."""
    size: int
    """Unpacked bytes, as declared; an entry that holds another number is refused when read."""
    compressed: int
    """Bytes in the archive."""


@dataclass(frozen=True, slots=True)
class _Location:
    entry: ArchiveEntry
    raw_name: bytes
    offset: int
    method: int
    crc: int


def open_archive(stream: BinaryIO, limits: ArchiveLimits | None = None) -> SafeArchive:
    """Read and judge the directory of a zip archive.

    Parameters
    ----------
    stream
        Seekable; it must stay open as long as the archive is used.
    limits
        By default `ArchiveLimits()`.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` if it is no sound zip archive, ``unsafe_archive`` if it holds paths that lead out of it, links,
        devices, doubled or overlapping entries, ``unsupported_format`` for encryption or an unusual compression.
    LimitExceeded
        ``too_large``.
    """
    return SafeArchive(stream, limits or ArchiveLimits())


class SafeArchive:
    """A judged zip archive; made by `open_archive`.

    Not for use by several threads at once: entries share the one stream.
    """

    def __init__(self, stream: BinaryIO, limits: ArchiveLimits) -> None:
        self._stream = stream
        self._size = stream.seek(0, io.SEEK_END)
        self._locations = _read_directory(stream, self._size, limits)

    @property
    def entries(self) -> tuple[ArchiveEntry, ...]:
        """The files in the directory's order, without folders and what operating systems leave behind."""
        return tuple(location.entry for location in self._locations.values())

    @property
    def total_bytes(self) -> int:
        """Sum of the unpacked sizes of `entries`."""
        return sum(entry.size for entry in self.entries)

    def __contains__(self, name: str) -> bool:
        return name in self._locations

    def open(self, name: str) -> BinaryIO:
        """Return a readable stream, not seekable, of the entry called `name`.

        Raises
        ------
        KeyError
            If there is no such entry.
        InvalidInput
            Here or while reading: ``corrupt_file`` if the entry is damaged or does not hold what was declared,
            ``unsafe_archive`` if its own header contradicts the directory.
        """
        location = self._locations[name]
        start = _data_start(self._stream, location)
        if start + location.entry.compressed > self._size:
            raise _corrupt(f"The archive ends in the middle of its entry {name!r}.")
        return io.BufferedReader(_EntryReader(self._stream, location, start), _CHUNK)

    def read(self, name: str, limit: int | None = None) -> bytes:
        """Return the bytes of the entry called `name`; at most the first `limit`, without checking the rest."""
        with self.open(name) as stream:
            return stream.read(-1 if limit is None else limit)

    def extract_to(self, folder: Path) -> list[Path]:
        """Unpack all entries below `folder`, which must exist, and return their paths in the directory's order.

        Files are created, never overwritten or followed. After an error what was written so far is left there, so
        `folder` should be a scratch folder.
        """
        root = folder.resolve(strict=True)
        paths = []
        for entry in self.entries:
            path = root.joinpath(*entry.name.split("/"))
            path.parent.mkdir(parents=True, exist_ok=True)
            with self.open(entry.name) as source, path.open("xb") as target:
                for chunk in _chunks(source):
                    target.write(chunk)
            paths.append(path)
        return paths


class _EntryReader(io.RawIOBase):
    """The unpacked bytes of one entry: as many as declared, with the declared checksum, or an error."""

    def __init__(self, stream: BinaryIO, location: _Location, start: int) -> None:
        super().__init__()
        self._stream = stream
        self._location = location
        self._name = location.entry.name
        self._position = start
        self._packed_left = location.entry.compressed
        self._left = location.entry.size
        self._crc = 0
        self._inflater = zlib.decompressobj(-zlib.MAX_WBITS) if location.method == _DEFLATED else None
        self._input = b""

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override]
        wanted = min(len(buffer), self._left)
        if wanted == 0:
            if len(buffer) > 0:
                self._check_end()
            return 0
        data = self._packed(wanted) if self._inflater is None else self._inflated(wanted)
        if not data:
            raise _corrupt(
                f"Entry {self._name!r} holds {self._location.entry.size - self._left} bytes where the archive's "
                f"directory declares {self._location.entry.size}."
            )
        self._crc = zlib.crc32(data, self._crc)
        self._left -= len(data)
        buffer[: len(data)] = data
        if self._left == 0:
            self._check_end()
        return len(data)

    def _packed(self, size: int) -> bytes:
        self._stream.seek(self._position)
        data = self._stream.read(min(size, self._packed_left))
        self._position += len(data)
        self._packed_left -= len(data)
        return data

    def _inflated(self, size: int) -> bytes:
        assert self._inflater is not None
        while not self._inflater.eof:
            if not self._input:
                self._input = self._packed(_CHUNK)
                if not self._input:
                    break
            try:
                data = self._inflater.decompress(self._input, size)
            except zlib.error as error:
                raise _corrupt(f"Entry {self._name!r} of the archive is damaged ({error}).") from error
            self._input = self._inflater.unconsumed_tail
            if data:
                return data
        return b""

    def _check_end(self) -> None:
        if self._inflater is not None and self._inflated(1):
            raise _corrupt(
                f"Entry {self._name!r} holds more than the {self._location.entry.size} bytes that the archive's "
                "directory declares."
            )
        if self._crc != self._location.crc:
            raise _corrupt(f"Entry {self._name!r} of the archive is damaged: its checksum does not match.")


def _corrupt(message: str) -> InvalidInput:
    return InvalidInput("corrupt_file", message, "Make the archive again and send it once more.")


def _unsafe(message: str) -> InvalidInput:
    return InvalidInput("unsafe_archive", message, "Make a plain zip archive of the files alone.")


def _chunks(stream: BinaryIO) -> Iterator[bytes]:
    while chunk := stream.read(_CHUNK):
        yield chunk


def _read_at(stream: BinaryIO, offset: int, size: int) -> bytes:
    stream.seek(offset)
    return stream.read(size)


def _find_directory(stream: BinaryIO, size: int) -> tuple[int, int, int]:
    """Return number of entries, offset and size of the directory."""
    tail_size = min(size, _END.size + _MAX_COMMENT)
    tail = _read_at(stream, size - tail_size, tail_size)
    found = tail.rfind(b"PK\x05\x06")
    while found >= 0:
        if found + _END.size <= len(tail):
            fields = _END.unpack_from(tail, found)
            if found + _END.size + fields[7] == len(tail):
                break
        found = tail.rfind(b"PK\x05\x06", 0, found)
    else:
        raise _corrupt("The zip archive is truncated: its directory, which stands at the end, is missing.")
    end = size - tail_size + found
    _, disk, directory_disk, here, count, directory_size, offset, _ = fields
    if 0xFFFF in (here, count, disk, directory_disk) or 0xFFFFFFFF in (directory_size, offset):
        located = (
            _read_at(stream, end - _END64_LOCATOR.size, _END64_LOCATOR.size) if end >= _END64_LOCATOR.size else b""
        )
        if located.startswith(b"PK\x06\x07"):
            position = _END64_LOCATOR.unpack(located)[2]
            record = _read_at(stream, position, _END64.size) if position <= end - _END64.size else b""
            if not record.startswith(b"PK\x06\x06") or len(record) != _END64.size:
                raise _corrupt("The zip archive's end record contradicts itself.")
            _, _, _, _, disk, directory_disk, here, count, directory_size, offset = _END64.unpack(record)
            end = position
    if disk != 0 or directory_disk != 0 or here != count:
        raise InvalidInput("unsupported_format", "The zip archive is one of several parts.", "Send it in one file.")
    if offset + directory_size != end:
        raise _corrupt(
            f"The zip archive's directory should end at byte {offset + directory_size}, and ends at byte {end}."
        )
    return count, offset, directory_size


def _read_directory(stream: BinaryIO, size: int, limits: ArchiveLimits) -> dict[str, _Location]:
    count, offset, directory_size = _find_directory(stream, size)
    if count > limits.entries:
        raise LimitExceeded("too_large", f"The archive has {count} entries; at most {limits.entries} are allowed.")
    if directory_size > limits.directory_bytes:
        raise LimitExceeded(
            "too_large",
            f"The archive's directory has {directory_size} bytes; at most {limits.directory_bytes} are allowed.",
        )
    directory = _read_at(stream, offset, directory_size)
    names: set[str] = set()
    locations: dict[str, _Location] = {}
    spans: list[tuple[int, int, str]] = []
    total = position = 0
    for _ in range(count):
        if position + _CENTRAL.size > len(directory) or directory[position : position + 4] != b"PK\x01\x02":
            raise _corrupt(f"The zip archive's directory breaks off after {len(spans)} of {count} entries.")
        fields = _CENTRAL.unpack_from(directory, position)
        lengths = fields[10:13]
        start = position + _CENTRAL.size
        position = start + sum(lengths)
        if position > len(directory):
            raise _corrupt(f"The zip archive's directory breaks off after {len(spans)} of {count} entries.")
        raw_name = directory[start : start + lengths[0]]
        extra = directory[start + lengths[0] : start + lengths[0] + lengths[1]]
        location, is_folder = _judge(fields, raw_name, extra, limits)
        name = location.entry.name
        if name in names:
            raise _unsafe(f"The archive holds two entries called {name!r}.")
        names.add(name)
        total += location.entry.size
        if total > limits.total_bytes:
            raise LimitExceeded(
                "too_large",
                f"The archive unpacks to more than {limits.total_bytes} bytes, the most that is allowed.",
            )
        spans.append((location.offset, location.offset + _LOCAL.size + location.entry.compressed, name))
        if not is_folder and not _is_junk(name):
            locations[name] = location
    if position != len(directory):
        raise _corrupt(f"The zip archive's directory holds more than the {count} entries that it declares.")
    _check_spans(spans, offset)
    _check_folders(names, locations)
    return locations


def _check_spans(spans: list[tuple[int, int, str]], directory_offset: int) -> None:
    """Refuse entries that share bytes: the way to pack petabytes into megabytes."""
    end, before = 0, ""
    for start, stop, name in sorted(spans):
        if start < end:
            raise _unsafe(f"Entries {before!r} and {name!r} of the archive share the same bytes.")
        end, before = stop, name
    if end > directory_offset:
        raise _corrupt(f"Entry {before!r} reaches into the archive's directory.")


def _check_folders(names: set[str], locations: dict[str, _Location]) -> None:
    for name in names:
        parts = name.split("/")
        for depth in range(1, len(parts)):
            parent = "/".join(parts[:depth])
            if parent in locations:
                raise _unsafe(f"The archive holds {parent!r} both as a file and as a folder.")


def _judge(fields: tuple[int, ...], raw_name: bytes, extra: bytes, limits: ArchiveLimits) -> tuple[_Location, bool]:
    flags, method, crc, packed, unpacked = fields[3], fields[4], fields[7], fields[8], fields[9]
    attributes, offset = fields[15], fields[16]
    name = _decode(raw_name, utf8=bool(flags & 0x800))
    is_folder = name.endswith("/")
    _check_name(name.rstrip("/") if is_folder else name)
    name = name.rstrip("/")
    unpacked, packed, offset = _zip64(extra, unpacked, packed, offset, name)
    mode = attributes >> 16
    if stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR):
        kind = "a symbolic link" if stat.S_ISLNK(mode) else "a device or pipe"
        raise _unsafe(f"Entry {name!r} of the archive is {kind}.")
    if flags & (0x1 | 0x40 | 0x2000):
        raise InvalidInput("unsupported_format", f"Entry {name!r} of the archive is encrypted.", "Send it unencrypted.")
    if not is_folder and method not in (_STORED, _DEFLATED):
        known = _METHODS.get(method, f"method {method}")
        raise InvalidInput(
            "unsupported_format",
            f"Entry {name!r} of the archive is compressed with {known}.",
            "Make the archive with the usual compression (deflate), or none.",
        )
    if unpacked > limits.entry_bytes:
        raise LimitExceeded(
            "too_large", f"Entry {name!r} unpacks to {unpacked} bytes; at most {limits.entry_bytes} are allowed."
        )
    honest = packed if method == _STORED else packed * _DEFLATE_RATIO
    if unpacked > honest or (method == _STORED and unpacked != packed):
        raise _unsafe(f"Entry {name!r} claims to unpack {packed} bytes to {unpacked}, which is not possible.")
    return _Location(ArchiveEntry(name, unpacked, packed), raw_name, offset, method, crc), is_folder


def _zip64(extra: bytes, unpacked: int, packed: int, offset: int, name: str) -> tuple[int, int, int]:
    """Return sizes and offset with those that did not fit into 32 bits taken from the extra field."""
    values = [unpacked, packed, offset]
    if 0xFFFFFFFF not in values:
        return unpacked, packed, offset
    position = 0
    while position + 4 <= len(extra):
        tag, length = struct.unpack_from("<2H", extra, position)
        body = extra[position + 4 : position + 4 + length]
        if tag == 1:
            for index, value in enumerate(values):
                if value == 0xFFFFFFFF and len(body) >= 8:
                    values[index] = int.from_bytes(body[:8], "little")
                    body = body[8:]
            break
        position += 4 + length
    if 0xFFFFFFFF in values:
        raise _corrupt(f"Entry {name!r} of the archive has no size.")
    return values[0], values[1], values[2]


def _decode(raw: bytes, *, utf8: bool) -> str:
    if b"\0" in raw:
        raise _unsafe("The archive holds an entry with a zero byte in its name.")
    try:
        name = raw.decode("utf-8" if utf8 else "cp437")
    except UnicodeDecodeError as error:
        raise _corrupt("The archive holds an entry whose name is not valid UTF-8.") from error
    # Some programs write the separators of their own system.
    return unicodedata.normalize("NFC", name.replace("\\", "/"))


def _check_name(name: str) -> None:
    if not name:
        raise _unsafe("The archive holds an entry without a name.")
    shown = name if len(name) <= 80 else name[:77] + "..."
    if name.startswith("/") or name[1:2] == ":":
        raise _unsafe(f"The archive holds the absolute path {shown!r}.")
    parts = name.split("/")
    if ".." in parts:
        raise _unsafe(f"The archive holds the path {shown!r}, which leads out of it.")
    if "" in parts or "." in parts or len(parts) > 32 or any(len(part.encode()) > 255 for part in parts):
        raise _unsafe(f"The archive holds the path {shown!r}, which is not a plain relative path.")
    if len(name.encode()) > 1024 or any(unicodedata.category(c) == "Cc" for c in name):
        raise _unsafe(f"The archive holds the name {shown!r}, which is too long or holds control characters.")


def _is_junk(name: str) -> bool:
    parts = name.split("/")
    return parts[0] in _JUNK_FOLDERS or parts[-1] in _JUNK_NAMES or parts[-1].startswith("._")


def _data_start(stream: BinaryIO, location: _Location) -> int:
    header = _read_at(stream, location.offset, _LOCAL.size)
    name = location.entry.name
    if len(header) != _LOCAL.size or not header.startswith(b"PK\x03\x04"):
        raise _corrupt(f"Entry {name!r} does not begin where the archive's directory says.")
    _, _, flags, method, _, _, _, _, _, name_length, extra_length = _LOCAL.unpack(header)
    if stream.read(name_length) != location.raw_name or method != location.method or flags & 0x1:
        raise _unsafe(f"Entry {name!r} is described differently in the archive's directory and before its data.")
    return location.offset + _LOCAL.size + int(name_length) + int(extra_length)
