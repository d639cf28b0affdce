"""Damaged motion files: refused naming the section, never a crash, never more memory than the header tells."""

from __future__ import annotations

import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapery_contracts.errors import InvalidInput, LimitExceeded, UserError
from shapery_motion import decode, info, open_motion
from shapery_motion.container.header import MotionLimits
from shapery_motion.container.sections import FRAME_BYTES, MAGIC, SectionReader, pack_section

GOLDEN = Path(__file__).parent.parent / "unit" / "motion" / "golden"
DATA = (GOLDEN / "trajectory-1.3" / "corrected.smc").read_bytes()
OTHERS = {
    "version 1.2": (GOLDEN / "trajectory-1.2" / "waving.smc").read_bytes(),
    "version 1.1": (GOLDEN / "trajectory-1.1" / "waving.smc").read_bytes(),
    "version 1.0": (GOLDEN / "trajectory" / "waving.smc").read_bytes(),
    "gradient": (GOLDEN / "gradient-1.0.smc").read_bytes(),
}
TAGS = {"HEAD", "META", "GRPS", "CONN", "TMOD", "TBA2", "TFL4", "CORR", "END"}


def sections(of: bytes = DATA) -> list[tuple[str, bytes]]:
    reader = SectionReader(memoryview(of), len(MAGIC), len(of))
    found = []
    while reader.offset < len(of):
        tag, payload = reader.next()
        found.append((tag, bytes(payload)))
    return found


SECTIONS = sections()


def rebuilt(changed: dict[int, bytes]) -> bytes:
    """The file with other payloads of the same length, and checksums that agree."""
    return MAGIC + b"".join(pack_section(tag, changed.get(k, payload)) for k, (tag, payload) in enumerate(SECTIONS))


def test_the_sample_has_every_kind_of_section() -> None:
    assert {tag.strip() for tag, _ in SECTIONS} == TAGS
    assert rebuilt({}) == DATA


@settings(max_examples=150, deadline=None)
@given(st.integers(0, len(DATA) - 1))
def test_a_file_that_is_cut_off_is_refused_by_name(length: int) -> None:
    with pytest.raises(InvalidInput) as caught:
        decode(DATA[:length])
    assert caught.value.code in ("corrupt_file", "unknown_format", "empty_content")
    if length >= len(MAGIC):
        assert any(tag in caught.value.message for tag in TAGS)


@settings(max_examples=150, deadline=None)
@given(st.integers(len(MAGIC), len(DATA) - 1), st.integers(0, 7))
def test_a_flipped_bit_is_found_by_a_checksum(at: int, bit: int) -> None:
    damaged = bytearray(DATA)
    damaged[at] ^= 1 << bit
    with pytest.raises(UserError):
        decode(bytes(damaged))
    with pytest.raises(UserError):
        info(bytes(damaged))


@settings(max_examples=80, deadline=None)
@given(st.integers(0, len(SECTIONS) - 2), st.data())
def test_what_agrees_with_its_checksum_and_is_wrong_costs_no_more_than_it_may(which: int, data: st.DataObject) -> None:
    spoil_and_open(SECTIONS, which, data)


@pytest.mark.parametrize("name", OTHERS)
@settings(max_examples=50, deadline=None)
@given(st.data())
def test_so_it_is_with_other_versions_and_profiles(name: str, data: st.DataObject) -> None:
    those = sections(OTHERS[name])
    spoil_and_open(those, data.draw(st.integers(0, len(those) - 2)), data)


def spoil_and_open(those: list[tuple[str, bytes]], which: int, data: st.DataObject) -> None:
    """Alter a section, under a checksum that agrees, and read frames."""
    payload = bytearray(those[which][1])
    for _ in range(data.draw(st.integers(1, 4))):
        payload[data.draw(st.integers(0, len(payload) - 1))] = data.draw(st.integers(0, 255))
    whole = MAGIC + b"".join(
        pack_section(tag, bytes(payload) if k == which else old) for k, (tag, old) in enumerate(those)
    )
    limits = MotionLimits(vertices=10_000, faces=20_000, frames=1_000, memory=8 << 20)
    tracemalloc.start()
    try:
        motion = open_motion(whole, limits=limits)
        for index in range(0, len(motion), 3):
            assert motion.frame(index).shape == (motion.header.vertices, 3)
    except UserError as error:
        assert error.code in ("corrupt_file", "unsupported_format", "too_large")  # noqa: PT017
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < 64 << 20


@pytest.mark.parametrize(
    ("offset", "form", "value", "said"),
    [
        (4, "<I", 1 << 30, "vertices"),
        (8, "<I", 1 << 30, "faces"),
        (12, "<I", 1 << 30, "frames"),
        (28, "<Q", 1 << 50, "bytes of memory"),
    ],
)
def test_claims_are_held_against_limits_before_anything_is_allocated(
    offset: int, form: str, value: int, said: str
) -> None:
    head = bytearray(SECTIONS[0][1])
    struct.pack_into(form, head, offset, value)
    tracemalloc.start()
    with pytest.raises(LimitExceeded, match=said):
        open_motion(rebuilt({0: bytes(head)}))
    assert tracemalloc.get_traced_memory()[1] < 1 << 20
    tracemalloc.stop()


@pytest.mark.parametrize(("at", "value", "code"), [(0, 2, "unsupported_format"), (2, 77, "unsupported_format")])
def test_other_versions_and_profiles_are_told_apart_from_damage(at: int, value: int, code: str) -> None:
    head = bytearray(SECTIONS[0][1])
    head[at] = value
    with pytest.raises(InvalidInput) as caught:
        open_motion(rebuilt({0: bytes(head)}))
    assert caught.value.code == code


def test_a_group_that_asks_for_more_than_the_header_tells_is_refused() -> None:
    head = bytearray(SECTIONS[0][1])
    struct.pack_into("<Q", head, 28, 400 * 168 + 1000)
    with pytest.raises(InvalidInput, match=r"TMOD|CORR"):
        open_motion(rebuilt({0: bytes(head)})).frame(0)


def test_sections_that_readers_do_not_know_are_passed_over_within_groups() -> None:
    """A later minor version may add sections to groups."""
    extra = pack_section("NEWS", b"something")
    first = next(k for k, (tag, _) in enumerate(SECTIONS) if tag == "TMOD")
    before = MAGIC + b"".join(pack_section(tag, payload) for tag, payload in SECTIONS[:first])
    head, groups = bytearray(SECTIONS[0][1]), bytearray(SECTIONS[2][1])
    struct.pack_into("<Q", head, 20, len(DATA) + len(extra))
    (length,) = struct.unpack_from("<Q", groups, 16)
    struct.pack_into("<Q", groups, 16, length + len(extra))
    (offset,) = struct.unpack_from("<Q", groups, 32)
    struct.pack_into("<Q", groups, 32, offset + len(extra))
    longer = before + extra + DATA[len(before) :]
    front = MAGIC + pack_section("HEAD", bytes(head)) + pack_section("META", SECTIONS[1][1])
    front += pack_section("GRPS", bytes(groups))
    assert np.array_equal(decode(front + longer[len(front) :]).vertices, decode(DATA).vertices)


def test_checksums_are_those_of_zip() -> None:
    tag, payload = SECTIONS[0]
    section = DATA[len(MAGIC) : len(MAGIC) + len(payload) + FRAME_BYTES]
    assert struct.unpack("<I", section[-4:])[0] == zlib.crc32(section[:-4])
    assert section[:4] == tag.encode()


def test_a_header_that_tells_of_millions_of_vertices_is_refused_before_anything_is_made() -> None:
    head = bytearray(SECTIONS[0][1])
    struct.pack_into("<I", head, 4, 1_000_000)
    with pytest.raises(InvalidInput, match=r"HEAD.*1000000 vertices"):
        open_motion(rebuilt({0: bytes(head)}))
