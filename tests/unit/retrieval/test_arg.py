"""The graph's binary form: read back bit for bit, and nothing else is read."""

from __future__ import annotations

import dataclasses
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapery_contracts.errors import InvalidInput
from shapery_retrieval.arg import Arg, Level
from shapery_retrieval.describe import Description

HEADER = struct.Struct("<8sHHIII")


def small_arg(parts: tuple[int, ...] = (1, 2, 3), seed: int = 0) -> Arg:
    rng = np.random.default_rng(seed)
    levels = []
    for number, k in enumerate(parts):
        masses = rng.random(k).astype(np.float32) + 0.1
        masses /= masses.sum()
        square = rng.random((k, k)).astype(np.float32)
        touching = rng.random((k, k)) < 0.5
        touching = np.triu(touching, 1)
        parents = np.full(1, -1) if number == 0 else rng.integers(parts[number - 1], size=k)
        features = rng.normal(size=(k, 4)).astype(np.float16)
        levels.append(Level(masses, features, square + square.T, touching | touching.T, parents.astype(np.int32)))
    return Arg(tuple(levels), {"one": np.float32([1, 2]), "two": np.uint16([3])})


@given(st.integers(0, 1000))
@settings(max_examples=20, deadline=None)
def test_what_is_written_is_read_bit_for_bit(seed: int) -> None:
    arg = small_arg((1, 2 + seed % 5, 5 + seed % 7), seed)
    again = Arg.from_bytes(arg.to_bytes())
    assert again.to_bytes() == arg.to_bytes()
    for level, other in zip(arg.levels, again.levels, strict=True):
        for field in dataclasses.fields(Level):
            np.testing.assert_array_equal(getattr(level, field.name), getattr(other, field.name))
    assert again.whole["two"].dtype == np.uint16


def test_a_real_graph_is_small_and_survives(described_egg: Description) -> None:
    data = described_egg.arg.to_bytes()
    assert 4_000 < len(data) < 40_000
    assert Arg.from_bytes(data).same_as(described_egg.arg)
    assert [level.parts for level in described_egg.arg.levels] == [1, 16, 32]
    for above, below in zip(described_egg.arg.levels, described_egg.arg.levels[1:], strict=False):
        # children make up their parents
        sums = np.bincount(below.parents, weights=below.masses, minlength=above.parts)
        np.testing.assert_allclose(sums, above.masses, atol=1e-5)


@given(st.binary(max_size=200))
@settings(max_examples=60, deadline=None)
def test_foreign_bytes_are_refused(data: bytes) -> None:
    with pytest.raises(InvalidInput, match="no graph of a shape"):
        Arg.from_bytes(data)


@given(st.data())
@settings(max_examples=150, deadline=None)
def test_damaged_bytes_are_refused_even_where_the_checksum_fits(data: st.DataObject) -> None:
    good = bytearray(small_arg().to_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        good[data.draw(st.integers(8, len(good) - 1))] = data.draw(st.integers(0, 255))
    body = bytes(good[HEADER.size : data.draw(st.integers(HEADER.size, len(good)))])
    magic, form, version, count, _, _ = HEADER.unpack_from(good)
    forged = HEADER.pack(magic, form, version, count, len(body), zlib.crc32(body)) + body
    try:
        read = Arg.from_bytes(forged)
    except InvalidInput:
        return
    # what is read after all must be a sound graph
    assert all(np.isfinite(level.features).all() for level in read.levels)
    assert Arg.from_bytes(read.to_bytes()).same_as(read)


@pytest.mark.parametrize("end", [0, 7, 23, 24, 60, -1])
def test_truncated_bytes_are_refused(end: int) -> None:
    with pytest.raises(InvalidInput, match="no graph of a shape"):
        Arg.from_bytes(small_arg().to_bytes()[:end])


def test_a_flipped_bit_is_noticed() -> None:
    data = bytearray(small_arg().to_bytes())
    data[-3] ^= 1
    with pytest.raises(InvalidInput, match="checksum"):
        Arg.from_bytes(bytes(data))


def test_another_form_is_named() -> None:
    data = bytearray(small_arg().to_bytes())
    data[8] = 9
    with pytest.raises(InvalidInput, match="binary form 9") as refusal:
        Arg.from_bytes(bytes(data))
    assert refusal.value.code == "unsupported_format"


def test_the_form_is_documented() -> None:
    text = (Path(__file__).parents[3] / "api_schema" / "arg.md").read_text()
    for name in ("masses", "features", "distances", "adjacency", "parents", "SHPRYARG"):
        assert name in text
    assert f'`"{HEADER.format}"`' in text
