"""The attributed relational graph of a shape: its parts on nested levels, and the whole at the root (section 4.6).

The binary form is described in ``api_schema/arg.md``. It holds nothing but numbers in little-endian arrays, is the same
for the same graph, and is read back bit for bit; damaged or foreign bytes are refused.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_contracts.retrieval import INDEX_VERSION

MAGIC = b"SHPRYARG"
FORMAT_VERSION = 1
MAX_BYTES = 1 << 20
"""No graph is larger; what claims to be is refused before it is looked at."""
MAX_PARTS, MAX_LEVELS, MAX_ARRAYS = 256, 16, 64

_HEADER = struct.Struct("<8sHHIII")
_DTYPES: dict[int, np.dtype[Any]] = {
    0: np.dtype("<f4"),
    1: np.dtype("<f2"),
    2: np.dtype("<i4"),
    3: np.dtype("u1"),
    4: np.dtype("<u2"),
}
_CODES = {dtype: code for code, dtype in _DTYPES.items()}


@dataclass(frozen=True, eq=False)
class Level:
    """One level of the hierarchy: nodes are parts of the surface, edges join adjacent ones.

    Attributes
    ----------
    masses : (k,) float32
        Share of the surface's area of each part; in sum 1.
    features : (k, d) float16
        What `shapery_retrieval.nodes` computes over each part.
    distances : (k, k) float32
        Mean geodesic distance between the points of two parts over its mean on the whole surface; symmetric.
    adjacency : (k, k) bool
        Whether two parts touch; symmetric, false on the diagonal.
    parents : (k,) int32
        The part of the level above that holds each part; at the root −1.
    """

    masses: NDArray[np.float32]
    features: NDArray[np.float16]
    distances: NDArray[np.float32]
    adjacency: NDArray[np.bool_]
    parents: NDArray[np.int32]

    @property
    def parts(self) -> int:
        """Number of nodes."""
        return len(self.masses)

    def children(self, parents: NDArray[np.int32], part: int) -> NDArray[np.int64]:
        """Return the parts of the level below, whose `parents` are given, that lie in `part`."""
        return np.flatnonzero(parents == part)


@dataclass(frozen=True, eq=False)
class Arg:
    """A shape as an attributed relational graph.

    Attributes
    ----------
    levels
        From the root, which is one part, to the finest.
    whole
        Descriptors of the whole shape by name, which the root carries; see `shapery_retrieval.whole`.
    index_version
        Of the code that computed it. Graphs of different versions are not compared.
    """

    levels: tuple[Level, ...]
    whole: Mapping[str, NDArray[Any]]
    index_version: int = INDEX_VERSION

    def same_as(self, other: Arg) -> bool:
        """Whether both have the same binary form."""
        return self.to_bytes() == other.to_bytes()

    def to_bytes(self) -> bytes:
        """Return the binary form of the graph."""
        arrays: list[tuple[str, NDArray[Any]]] = []
        for number, level in enumerate(self.levels):
            upper = np.triu_indices(level.parts)
            arrays += [
                (f"level{number}.masses", level.masses.astype("<f4")),
                (f"level{number}.features", level.features.astype("<f2")),
                (f"level{number}.distances", level.distances[upper].astype("<f4")),
                (f"level{number}.adjacency", np.packbits(level.adjacency[upper])),
                (f"level{number}.parents", level.parents.astype("<i4")),
            ]
        arrays += [(f"whole.{name}", np.asarray(values)) for name, values in sorted(self.whole.items())]
        body = b"".join(_packed(name, values) for name, values in arrays)
        return _HEADER.pack(MAGIC, FORMAT_VERSION, self.index_version, len(arrays), len(body), zlib.crc32(body)) + body

    @classmethod
    def from_bytes(cls, data: bytes, *, trusted: bool = False) -> Arg:
        """Read the binary form.

        Parameters
        ----------
        data
            What `to_bytes` wrote.
        trusted
            Whether the numbers were looked at before, as those of a bank were when it took them. Form and checksum are
            looked at always.

        Raises
        ------
        InvalidInput
            ``corrupt_file`` for anything that `to_bytes` did not write, ``unsupported_format`` for a later version.
        """
        version, arrays = _unpacked(data)
        levels: list[Level] = []
        while f"level{len(levels)}.masses" in arrays:
            levels.append(_level(arrays, len(levels), levels[-1].parts if levels else 0, trusted))
            _demand(len(levels) <= MAX_LEVELS, "it has too many levels")
        _demand(bool(levels) and levels[0].parts == 1, "its root is not one part")
        _demand(len({level.features.shape[1] for level in levels}) == 1, "its levels have different features")
        prefix = "whole."
        whole = {name.removeprefix(prefix): values for name, values in arrays.items() if name.startswith(prefix)}
        _demand(len(whole) + 5 * len(levels) == len(arrays), "it holds arrays that do not belong to it")
        for values in () if trusted else whole.values():
            _demand(values.dtype.kind != "f" or bool(np.isfinite(values).all()), "a descriptor is not finite")
        return cls(tuple(levels), MappingProxyType(whole), version)


def _level(arrays: dict[str, NDArray[Any]], number: int, above: int, trusted: bool) -> Level:
    def part(name: str, dtype: str) -> NDArray[Any]:
        values = arrays.get(f"level{number}.{name}")
        _demand(values is not None and values.dtype == np.dtype(dtype), f"level {number} lacks its {name}")
        assert values is not None
        if not trusted:
            _demand(values.dtype.kind != "f" or bool(np.isfinite(values).all()), f"the {name} are not finite")
        return values

    masses, features, parents = part("masses", "<f4"), part("features", "<f2"), part("parents", "<i4")
    distances, adjacency = part("distances", "<f4"), part("adjacency", "u1")
    k = len(masses)
    pairs = k * (k + 1) // 2
    _demand(masses.ndim == 1 and 1 <= k <= MAX_PARTS, "a level has no parts or too many")
    _demand(features.ndim == 2 and len(features) == k, "the features do not fit the parts")
    _demand(parents.shape == (k,) and distances.shape == (pairs,), "its arrays do not fit together")
    _demand(adjacency.shape == (-(-pairs // 8),), "its arrays do not fit together")
    if not trusted:
        _demand(bool((masses >= 0).all()) and abs(float(masses.sum()) - 1) < 1e-3, "the areas do not sum to the whole")
        _demand(bool((distances >= 0).all()), "a distance is negative")
        _demand(
            bool((parents == -1).all()) if number == 0 else bool(((parents >= 0) & (parents < above)).all()),
            "a part has no parent",
        )
    # each pair was written once
    place = _places(k)
    touching = np.unpackbits(adjacency, count=pairs).view(np.bool_)
    return Level(masses, features, distances[place], touching[place], parents)


@lru_cache(maxsize=2 * MAX_PARTS)
def _places(k: int) -> NDArray[np.intp]:
    """(k, k) where each pair of k parts is among those of the upper triangle."""
    upper = np.triu_indices(k)
    place = np.empty((k, k), dtype=np.intp)
    place[upper] = place.T[upper] = np.arange(len(upper[0]))
    return place


def _packed(name: str, values: NDArray[Any]) -> bytes:
    encoded = name.encode("ascii")
    code = _CODES[values.dtype.newbyteorder("<") if values.dtype.itemsize > 1 else values.dtype]
    head = struct.pack("<BBB", len(encoded), code, values.ndim) + encoded
    return head + struct.pack(f"<{values.ndim}I", *values.shape) + np.ascontiguousarray(values).tobytes()


def _unpacked(data: bytes) -> tuple[int, dict[str, NDArray[Any]]]:
    _demand(len(data) >= _HEADER.size and data[:8] == MAGIC, "it does not begin as one")
    _, file_version, index_version, count, size, crc = _HEADER.unpack_from(data)
    if file_version != FORMAT_VERSION:
        raise InvalidInput(
            "unsupported_format",
            f"The graph has the binary form {file_version}; this version reads form {FORMAT_VERSION}.",
            "Index the mesh again.",
        )
    _demand(len(data) <= MAX_BYTES and len(data) == _HEADER.size + size, "its length is wrong")
    _demand(zlib.crc32(data[_HEADER.size :]) == crc, "its checksum is wrong")
    _demand(count <= MAX_ARRAYS, "it holds too many arrays")
    arrays: dict[str, NDArray[Any]] = {}
    place = _HEADER.size
    for _ in range(count):
        _demand(place + 3 <= len(data), "it ends too early")
        length, code, dimensions = struct.unpack_from("<BBB", data, place)
        place += 3
        _demand(code in _DTYPES and dimensions <= 2 and place + length + 4 * dimensions <= len(data), "it is damaged")
        try:
            name = data[place : place + length].decode("ascii")
        except UnicodeDecodeError:
            raise _damaged("a name in it is damaged") from None
        place += length
        shape = struct.unpack_from(f"<{dimensions}I", data, place)
        place += 4 * dimensions
        items = math.prod(shape)
        dtype = _DTYPES[code]
        _demand(name not in arrays and place + items * dtype.itemsize <= len(data), "an array in it is damaged")
        values = np.frombuffer(data, dtype, items, place).reshape(shape)
        arrays[name] = values
        place += items * dtype.itemsize
    _demand(place == len(data), "something follows its last array")
    return index_version, arrays


def _demand(condition: bool, why: str) -> None:
    if not condition:
        raise _damaged(why)


def _damaged(why: str) -> InvalidInput:
    return InvalidInput("corrupt_file", f"The bytes are no graph of a shape: {why}.", "Index the mesh again.")
