"""NRRD with attached or detached header.

Orientation
-----------
``space directions`` and ``space origin`` are taken in the named space and turned to RAS. Where the space is none of
RAS, LAS and LPS, or is not named, the coordinates are taken as RAS and a warning says so.
"""

from __future__ import annotations

import binascii
import math
import re
from typing import BinaryIO, Final

import numpy as np

from shapery_contracts.formats.model import corrupt
from shapery_contracts.formats.nrrd import MAX_HEADER, NrrdHeader, parse_header
from shapery_geometry.volume import FloatArray, check_affine
from shapery_geometry.volume_io.source import Array, VolumeHeader, flat_image, native, take_component
from shapery_geometry.volume_io.streams import Bunzipper, ByteSource, Inflater, check_end, read_exactly, skip

_TO_RAS: Final = {"RAS": (1.0, 1.0, 1.0), "LAS": (-1.0, 1.0, 1.0), "LPS": (-1.0, -1.0, 1.0)}
_STORAGE: Final = {"complex": "complex", "rgb-color": "rgb", "rgba-color": "rgba"}
_LENGTH: Final = {"complex": 2, "rgb": 3, "rgba": 4}


class NrrdSource:
    """An open NRRD file; `data` is the stream with its detached data, where it has such."""

    def __init__(self, stream: BinaryIO, data: BinaryIO | None = None) -> None:
        stream.seek(0)
        self._nrrd = nrrd = parse_header(stream.read(MAX_HEADER))
        self._stream = stream if data is None else data
        self._begin = nrrd.header_bytes if data is None else 0
        space = nrrd.space_axes
        if len(space) != 3:
            raise flat_image(f"{len(space)} axes of space ({' × '.join(map(str, nrrd.sizes))} values)")
        self._space = (space[0], space[1], space[2])
        self._colour = next((a for a, kind in enumerate(nrrd.kinds) if kind in _STORAGE and a not in space), None)
        self._rest = tuple(a for a in range(len(nrrd.sizes)) if a not in space and a != self._colour)
        storage = "real" if self._colour is None else _STORAGE[nrrd.kinds[self._colour]]
        if self._colour is not None and nrrd.sizes[self._colour] != _LENGTH[storage]:
            raise corrupt(f"The NRRD header gives {nrrd.sizes[self._colour]} values to a {nrrd.kinds[self._colour]}.")
        affine, warnings = _affine(nrrd, self._space)
        x, y, z = np.sqrt((affine[:3, :3] ** 2).sum(axis=0)).tolist()
        self.header = VolumeHeader(
            shape=(nrrd.sizes[space[0]], nrrd.sizes[space[1]], nrrd.sizes[space[2]]),
            spacing=(x, y, z),
            dtype=nrrd.dtype,
            affine=affine,
            format="nrrd",
            warnings=tuple(warnings),
            frames=math.prod(nrrd.sizes[a] for a in self._rest),
            storage=storage,
        )

    def bytes_needed(self, frame: int) -> int:  # noqa: ARG002  # frames may be interleaved, so all are read
        """Return how many bytes must be read or decompressed."""
        return self._nrrd.data_bytes

    def load(self, frame: int, component: str | None) -> Array:
        """Return the voxels (I, J, K) of `frame`; further axes are counted with the faster first."""
        nrrd = self._nrrd
        values = native(self._values())
        # In memory the last axis is the fastest: axis a of the file is axis -1 - a.
        values = values.reshape(nrrd.sizes[::-1]).transpose()
        order = (*self._rest, *self._space, *(() if self._colour is None else (self._colour,)))
        values = values.transpose(order)
        chosen = np.unravel_index(frame, tuple(nrrd.sizes[a] for a in self._rest), order="F") if self._rest else ()
        values = values[tuple(int(index) for index in chosen)]
        if self.header.storage == "complex":
            values = values[..., 0] + 1j * values[..., 1]
        return np.ascontiguousarray(take_component(values, self.header.storage, component))

    def _values(self) -> Array:
        nrrd = self._nrrd
        self._stream.seek(self._begin)
        for _ in range(nrrd.line_skip):
            if not self._stream.readline(1 << 20):
                raise corrupt(f"The NRRD header skips {nrrd.line_skip} lines, and its data have fewer.")
        dtype = np.dtype(nrrd.dtype)
        if nrrd.encoding in ("text", "hex"):
            return self._written_out(dtype)
        source: ByteSource = self._stream
        if nrrd.encoding == "gzip":
            source = Inflater(self._stream)
        elif nrrd.encoding == "bzip2":
            source = Bunzipper(self._stream)
        if nrrd.byte_skip == -1:
            # Raw data only: they are the last bytes of the file.
            size = self._stream.seek(0, 2)
            if nrrd.encoding != "raw" or size < nrrd.data_bytes:
                raise corrupt(f"The NRRD header asks for the last {nrrd.data_bytes} bytes of a file of {size}.")
            self._stream.seek(size - nrrd.data_bytes)
        else:
            skip(source, nrrd.byte_skip)
        raw = read_exactly(source, nrrd.data_bytes)
        if nrrd.encoding != "raw":
            check_end(source)
        return raw.view(dtype.newbyteorder(">" if nrrd.big_endian else "<"))

    def _written_out(self, dtype: np.dtype[np.generic]) -> Array:
        """Return values that are written as decimal or hexadecimal text."""
        nrrd = self._nrrd
        count = math.prod(nrrd.sizes)
        # No number takes more than 40 characters with its separators.
        text = self._stream.read(count * 40)
        if nrrd.encoding == "hex":
            digits = re.sub(rb"\s+", b"", text)[: 2 * nrrd.data_bytes]
            try:
                raw = binascii.unhexlify(digits)
            except ValueError as error:
                raise corrupt("The hexadecimal data of the NRRD file hold something else.") from error
            if len(raw) != nrrd.data_bytes:
                raise corrupt(f"The NRRD header asks for {nrrd.data_bytes} bytes, and there are {len(raw)}.")
            return np.frombuffer(raw, dtype.newbyteorder(">" if nrrd.big_endian else "<"))
        words = re.split(rb"[\s,]+", text.strip(), maxsplit=count)[:count]
        if len(words) != count:
            raise corrupt(f"The NRRD header asks for {count} numbers, and there are {len(words)}.")
        try:
            numbers = np.array(words, dtype="S40").astype(np.float64)
            with np.errstate(invalid="raise"):
                return numbers.astype(dtype)
        except (ValueError, FloatingPointError) as error:
            raise corrupt("The data of the NRRD file hold something that is no number of their type.") from error


def _affine(nrrd: NrrdHeader, space: tuple[int, int, int]) -> tuple[FloatArray, list[str]]:
    warnings: list[str] = []
    signs = _TO_RAS.get(nrrd.space)
    if signs is None:
        named = f"in the space {nrrd.space!r}" if nrrd.space else "in a space without a name"
        warnings.append(f"The file gives its orientation {named}; it was taken as RAS, and sides may be swapped.")
        signs = _TO_RAS["RAS"]
    if not nrrd.unit_known:
        warnings.append("The file's unit of length is not known here; it was taken as mm.")
    elif nrrd.unit_mm != 1.0:
        warnings.append(f"The file's unit of length is {nrrd.unit_mm:g} mm; all lengths were converted to mm.")
    matrix = np.eye(4)
    for column, axis in enumerate(space):
        direction = nrrd.directions[axis]
        if direction is not None:
            matrix[:3, column] = direction
        elif math.isfinite(nrrd.spacings[axis]):
            matrix[:3, column] = np.eye(3)[column] * nrrd.spacings[axis]
        else:
            warnings.append(f"The file gives no spacing along axis {column}; it was taken as 1 mm.")
    if nrrd.origin is not None:
        matrix[:3, 3] = nrrd.origin
    with np.errstate(all="ignore"):
        matrix[:3] *= np.array(signs)[:, None] * nrrd.unit_mm
    return check_affine(matrix + 0.0), warnings
