"""MetaImage: MHA, and MHD with its raw file.

Orientation
-----------
As in ITK, row k of ``TransformMatrix`` is the direction of axis k, coordinates are LPS, and ``AnatomicalOrientation``
(which contradicts the matrix in many files) is not looked at.
"""

from __future__ import annotations

import math
from typing import BinaryIO

import numpy as np

from shapery_contracts.formats.metaimage import MAX_HEADER, MetaImageHeader, parse_header
from shapery_contracts.formats.model import corrupt
from shapery_geometry.volume import FloatArray, check_affine
from shapery_geometry.volume_io.source import Array, VolumeHeader, flat_image, native, take_component
from shapery_geometry.volume_io.streams import ByteSource, Inflater, check_end, read_exactly, skip


class MetaImageSource:
    """An open MetaImage file; `data` is the stream with its detached data, where it has such."""

    def __init__(self, stream: BinaryIO, data: BinaryIO | None = None) -> None:
        stream.seek(0)
        self._meta = meta = parse_header(stream.read(MAX_HEADER))
        self._stream = stream if data is None else data
        self._begin = meta.header_bytes if data is None else 0
        if len(meta.sizes) < 3:
            raise flat_image(f"{len(meta.sizes)} axes ({' × '.join(map(str, meta.sizes))} pixels)")
        # Bytes in threes or fours are colours; other channels are like time points.
        self._storage = {3: "rgb", 4: "rgba"}.get(meta.channels, "real") if meta.dtype == "uint8" else "real"
        affine, warnings = _affine(meta)
        x, y, z = np.sqrt((affine[:3, :3] ** 2).sum(axis=0)).tolist()
        self.header = VolumeHeader(
            shape=(meta.sizes[0], meta.sizes[1], meta.sizes[2]),
            spacing=(x, y, z),
            dtype=meta.dtype,
            affine=affine,
            format="metaimage",
            warnings=tuple(warnings),
            frames=math.prod(meta.sizes[3:]) * (meta.channels if self._storage == "real" else 1),
            storage=self._storage,
        )

    def bytes_needed(self, frame: int) -> int:  # noqa: ARG002  # channels are interleaved, so all are read
        """Return how many bytes must be read or decompressed."""
        return self._meta.data_bytes

    def load(self, frame: int, component: str | None) -> Array:
        """Return the voxels (I, J, K) of `frame`; channels count before time points."""
        meta = self._meta
        dtype = np.dtype(meta.dtype).newbyteorder(">" if meta.big_endian else "<")
        i, j, k = self.header.shape
        times = math.prod(meta.sizes[3:])
        values = native(self._raw().view(dtype)).reshape(times, k, j, i, meta.channels)
        if self._storage == "real":
            time, channel = divmod(frame, meta.channels)
            return np.ascontiguousarray(values[time, ..., channel].T)
        return np.ascontiguousarray(take_component(values[frame], self._storage, component).T)

    def _raw(self) -> Array:
        meta = self._meta
        size = self._stream.seek(0, 2)
        self._stream.seek(self._begin)
        if meta.compressed:
            skip(self._stream, max(meta.skip, 0))
            source: ByteSource = Inflater(self._stream)
            raw = read_exactly(source, meta.data_bytes)
            check_end(source)
            return raw
        if meta.skip == -1:
            if size - self._begin < meta.data_bytes:
                raise corrupt(f"The MetaImage header asks for the last {meta.data_bytes} bytes of a file of {size}.")
            self._stream.seek(size - meta.data_bytes)
        else:
            skip(self._stream, meta.skip)
        return read_exactly(self._stream, meta.data_bytes)


def _affine(meta: MetaImageHeader) -> tuple[FloatArray, list[str]]:
    warnings = []
    if not meta.oriented:
        warnings.append("The file does not say how the volume lies; it was taken as LPS, as ITK does.")
    matrix = np.eye(4)
    with np.errstate(all="ignore"):
        for axis in range(3):
            matrix[:3, axis] = np.array(meta.directions[axis][:3]) * meta.spacing[axis]
        matrix[:3, 3] = meta.origin[:3]
        matrix[:2] *= -1.0
    return check_affine(matrix + 0.0), warnings
