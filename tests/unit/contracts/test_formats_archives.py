"""Zip archives from strangers: honest ones are read, the others cost nothing."""

from __future__ import annotations

import io
import os
import stat
import struct
import tracemalloc
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest

from shapery_contracts.archives import ArchiveLimits, open_archive
from shapery_contracts.errors import InvalidInput, LimitExceeded, UserError


def archive_of(*entries: tuple[str | zipfile.ZipInfo, bytes], method: int = zipfile.ZIP_DEFLATED) -> io.BytesIO:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, data in entries:
            archive.writestr(name, data, compress_type=method)
    return stream


def patched(stream: io.BytesIO, change: Callable[[bytearray], None]) -> io.BytesIO:
    raw = bytearray(stream.getvalue())
    change(raw)
    return io.BytesIO(bytes(raw))


def central(raw: bytearray, number: int = 0) -> int:
    """Offset of a record of the directory."""
    at = -1
    for _ in range(number + 1):
        at = raw.index(b"PK\x01\x02", at + 1)
    return at


def code_of(stream: io.BytesIO, **limits: int) -> str:
    def read_all() -> None:
        archive = open_archive(stream, ArchiveLimits(**limits))
        for entry in archive.entries:
            archive.read(entry.name)

    with pytest.raises(UserError) as caught:
        read_all()
    return caught.value.code


def test_honest_archives_are_read_like_the_standard_library_does(tmp_path: Path) -> None:
    noise = os.urandom(200_000)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a/b/text.txt", b"hello " * 50_000)
        archive.writestr("empty", b"")
        archive.writestr("stored", noise, compress_type=zipfile.ZIP_STORED)
        archive.writestr("Gehirn-Köpfe.bin", noise[:1000])
        archive.mkdir("folder")
        with archive.open("sixty-four", "w", force_zip64=True) as entry:
            entry.write(b"x" * 10)
    safe = open_archive(stream)
    with zipfile.ZipFile(stream) as archive:
        expected = {i.filename: archive.read(i) for i in archive.infolist() if not i.is_dir()}
    assert {e.name: e.size for e in safe.entries} == {name: len(data) for name, data in expected.items()}
    assert safe.total_bytes == sum(map(len, expected.values()))
    paths = safe.extract_to(tmp_path)
    for entry, path in zip(safe.entries, paths, strict=True):
        assert safe.read(entry.name) == expected[entry.name] == path.read_bytes()
        assert path == tmp_path / entry.name
    assert safe.read("a/b/text.txt", 5) == b"hello"
    assert "stored" in safe
    assert "folder" not in safe


def test_archives_written_as_a_stream_are_read() -> None:
    # Sizes then stand behind the data, and only the directory has them.
    class Pipe(io.BytesIO):
        def seekable(self) -> bool:
            return False

        def tell(self) -> int:
            raise OSError

        def seek(self, *_: int) -> int:
            raise OSError

    pipe = Pipe()
    with zipfile.ZipFile(pipe, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a", b"1" * 1000)
        archive.writestr("b", b"2" * 1000)
    safe = open_archive(io.BytesIO(pipe.getvalue()))
    assert [safe.read(e.name)[:1] for e in safe.entries] == [b"1", b"2"]


def test_the_mark_of_the_end_in_a_comment_confuses_nobody() -> None:
    comment = b"a PK\x05\x06 in the comment"

    def change(raw: bytearray) -> None:
        struct.pack_into("<H", raw, len(raw) - 2, len(comment))
        raw.extend(comment)

    assert open_archive(patched(archive_of(("a", b"1")), change)).read("a") == b"1"


def test_two_entries_can_be_read_in_turn() -> None:
    one, two = os.urandom(300_000), os.urandom(300_000)
    safe = open_archive(archive_of(("one", one), ("two", two)))
    first, second = safe.open("one"), safe.open("two")
    got: tuple[list[bytes], list[bytes]] = ([], [])
    while (a := first.read(70_001)) and (b := second.read(70_001)):
        got[0].append(a)
        got[1].append(b)
    assert (b"".join(got[0]), b"".join(got[1])) == (one, two)


def test_what_operating_systems_leave_behind_is_not_shown() -> None:
    safe = open_archive(
        archive_of(
            ("a.obj", b"v"), ("__MACOSX/._a.obj", b"x"), ("x/.DS_Store", b"x"), ("._b", b"x"), ("Thumbs.db", b"")
        )
    )
    assert [e.name for e in safe.entries] == ["a.obj"]


@pytest.mark.parametrize(
    "name",
    [
        "../evil",
        "a/../../evil",
        "/etc/passwd",
        "C:/evil",
        "C:evil",
        "..\\evil",
        "a\\..\\..\\evil",
        "\\\\server\\share",
        "a//b",
        "./a",
        "a/./b",
        "a\nb",
        "\x1b[31m",
        "d/" * 40 + "x",
        "x" * 300,
        "..",
    ],
)
def test_paths_that_lead_out_or_astray_are_refused(name: str, tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    info = zipfile.ZipInfo("placeholder")
    info.filename = name
    with pytest.raises(InvalidInput) as caught:
        open_archive(archive_of((info, b"evil"))).extract_to(inside)
    assert caught.value.code == "unsafe_archive"
    assert list(tmp_path.rglob("*")) == [inside]


def test_a_zero_byte_in_a_name_is_refused() -> None:
    def change(raw: bytearray) -> None:
        raw[raw.index(b"namex")] = raw[raw.rindex(b"namex")] = 0

    assert code_of(patched(archive_of(("namex", b"1")), change)) == "unsafe_archive"


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFIFO, stat.S_IFBLK, stat.S_IFCHR, stat.S_IFSOCK])
def test_links_and_devices_are_refused(kind: int) -> None:
    info = zipfile.ZipInfo("link")
    info.external_attr = (kind | 0o777) << 16
    assert code_of(archive_of((info, b"/etc/passwd"))) == "unsafe_archive"


def test_doubled_names_are_refused() -> None:
    with pytest.warns(UserWarning, match="Duplicate"):
        stream = archive_of(("a", b"1"), ("a", b"2"))
    assert code_of(stream) == "unsafe_archive"
    # Two spellings of one name: a letter with its accent, and letter and accent apart.
    assert code_of(archive_of(("\u00e9", b"1"), ("e\u0301", b"2"))) == "unsafe_archive"


def test_a_name_that_is_both_file_and_folder_is_refused() -> None:
    assert code_of(archive_of(("a", b"1"), ("a/b", b"2"))) == "unsafe_archive"


def test_encryption_is_refused_by_name() -> None:
    def change(raw: bytearray) -> None:
        raw[central(raw) + 8] |= 1

    stream = patched(archive_of(("secret.dcm", b"1")), change)
    with pytest.raises(InvalidInput, match=r"secret\.dcm.*encrypted") as caught:
        open_archive(stream)
    assert caught.value.code == "unsupported_format"


@pytest.mark.parametrize(("method", "name"), [(zipfile.ZIP_BZIP2, "bzip2"), (zipfile.ZIP_LZMA, "LZMA")])
def test_unusual_compression_is_refused_by_name(method: int, name: str) -> None:
    with pytest.raises(InvalidInput, match=name) as caught:
        open_archive(archive_of(("a", b"1" * 1000), method=method))
    assert caught.value.code == "unsupported_format"


class TestBombs:
    def test_entries_sizes_and_totals_are_bounded(self) -> None:
        stream = archive_of(*((f"{n}", bytes(1000)) for n in range(10)))
        assert code_of(stream, entries=9) == "too_large"
        assert code_of(stream, total_bytes=9999) == "too_large"
        assert code_of(stream, entry_bytes=999) == "too_large"
        assert code_of(stream, directory_bytes=100) == "too_large"
        assert len(open_archive(stream, ArchiveLimits(10, 10_000, 1000, 600)).entries) == 10

    def test_a_claim_that_deflate_cannot_keep_is_refused(self) -> None:
        def change(raw: bytearray) -> None:
            struct.pack_into("<L", raw, central(raw) + 24, 1 << 30)

        assert code_of(patched(archive_of(("a", bytes(1000))), change)) == "unsafe_archive"

    @pytest.mark.parametrize("claimed", [999, 1, 1001, 9000])
    def test_an_entry_yields_what_it_declares_or_is_refused(self, claimed: int) -> None:
        def change(raw: bytearray) -> None:
            struct.pack_into("<L", raw, central(raw) + 24, claimed)

        assert code_of(patched(archive_of(("a", bytes(range(250)) * 4)), change)) == "corrupt_file"

    def test_an_entry_that_unpacks_to_more_is_stopped_at_what_it_declares(self) -> None:
        packed = archive_of(("a", bytes(50_000_000)))

        def change(raw: bytearray) -> None:
            struct.pack_into("<L", raw, central(raw) + 24, 100)

        stream = patched(packed, change)
        tracemalloc.start()
        try:
            assert code_of(stream) == "corrupt_file"
            assert tracemalloc.get_traced_memory()[1] < 2_000_000
        finally:
            tracemalloc.stop()

    def test_a_large_honest_entry_is_read_in_flat_memory(self, tmp_path: Path) -> None:
        stream = archive_of(("a", bytes(50_000_000)))
        tracemalloc.start()
        try:
            open_archive(stream).extract_to(tmp_path)
            assert tracemalloc.get_traced_memory()[1] < 2_000_000
        finally:
            tracemalloc.stop()
        assert (tmp_path / "a").stat().st_size == 50_000_000

    def test_entries_that_share_bytes_are_refused(self) -> None:
        # One kernel of data, described by many records of the directory.
        stream = archive_of(("a", bytes(10_000)), ("b", bytes(10_000)))

        def change(raw: bytearray) -> None:
            second = central(raw, 1)
            struct.pack_into("<L", raw, second + 42, 0)

        assert code_of(patched(stream, change)) == "unsafe_archive"

    def test_a_directory_that_claims_many_entries_is_not_believed(self) -> None:
        def change(raw: bytearray) -> None:
            end = raw.rindex(b"PK\x05\x06")
            struct.pack_into("<2H", raw, end + 8, 60_000, 60_000)

        stream = patched(archive_of(("a", b"1")), change)
        assert code_of(stream) == "too_large"
        assert code_of(stream, entries=70_000) == "corrupt_file"


class TestDamage:
    def test_truncation_and_other_files(self) -> None:
        whole = archive_of(("a", b"1" * 1000), ("b", b"2")).getvalue()
        for kept in range(0, len(whole), 7):
            assert code_of(io.BytesIO(whole[:kept])) == "corrupt_file"
        assert code_of(io.BytesIO(b"no archive" * 100)) == "corrupt_file"

    def test_a_changed_byte_is_noticed(self) -> None:
        for method in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            stream = archive_of(("a", os.urandom(1000)), method=method)

            def change(raw: bytearray) -> None:
                raw[500] ^= 0xFF

            assert code_of(patched(stream, change)) == "corrupt_file"

    def test_a_local_header_that_contradicts_the_directory_is_refused(self) -> None:
        def rename(raw: bytearray) -> None:
            raw[30] = ord("z")

        def other_method(raw: bytearray) -> None:
            raw[8] = 0

        def gone(raw: bytearray) -> None:
            raw[0] = 0

        for change, code in ((rename, "unsafe_archive"), (other_method, "unsafe_archive"), (gone, "corrupt_file")):
            assert code_of(patched(archive_of(("a", b"1" * 100)), change)) == code

    def test_parts_of_a_split_archive_are_refused(self) -> None:
        def change(raw: bytearray) -> None:
            struct.pack_into("<H", raw, raw.rindex(b"PK\x05\x06") + 4, 3)

        assert code_of(patched(archive_of(("a", b"1")), change)) == "unsupported_format"

    def test_extraction_never_overwrites(self, tmp_path: Path) -> None:
        (tmp_path / "a").write_text("mine")
        with pytest.raises(FileExistsError):
            open_archive(archive_of(("a", b"theirs"))).extract_to(tmp_path)
        assert (tmp_path / "a").read_text() == "mine"

    def test_unknown_names_are_key_errors(self) -> None:
        with pytest.raises(KeyError):
            open_archive(archive_of(("a", b"1"))).open("b")

    def test_sixty_four_bit_fields(self) -> None:
        # An archive whose every size and offset stands in the 64-bit extra field, and whose end record does, too.
        data = b"x" * 1000
        packed = zlib.compress(data, wbits=-15)
        local = struct.pack("<4s5H3L2H", b"PK\x03\x04", 45, 0, 8, 0, 0, zlib.crc32(data), 2**32 - 1, 2**32 - 1, 1, 20)
        local += b"a" + struct.pack("<2H2Q", 1, 16, len(data), len(packed)) + packed
        extra = struct.pack("<2H3Q", 1, 24, len(data), len(packed), 0)
        full = 2**32 - 1
        fields = (45, 45, 0, 8, 0, 0, zlib.crc32(data), full, full, 1, len(extra), 0, 0, 0, 0, full)
        record = struct.pack("<4s6H3L5H2L", b"PK\x01\x02", *fields)
        record += b"a" + extra
        end64 = struct.pack("<4sQ2H2L4Q", b"PK\x06\x06", 44, 45, 45, 0, 0, 1, 1, len(record), len(local))
        locator = struct.pack("<4sLQL", b"PK\x06\x07", 0, len(local) + len(record), 1)
        end = struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, 0xFFFF, 0xFFFF, 2**32 - 1, 2**32 - 1, 0)
        stream = io.BytesIO(local + record + end64 + locator + end)
        assert open_archive(stream).read("a") == data

        def huge(raw: bytearray) -> None:
            struct.pack_into("<Q", raw, len(local) + 46 + 1 + 4, 1 << 60)

        with pytest.raises(LimitExceeded):
            open_archive(patched(stream, huge))
