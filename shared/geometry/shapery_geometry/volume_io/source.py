"""What the readers of all formats share: limits, headers, and the choice of one scalar volume from a larger file.

A reader opens a file as a `VolumeSource`: its header is known, its voxels are not loaded yet. `load_volume` checks the
header against the limits and the caller's choice, and only then loads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Protocol

import numpy as np
import numpy.typing as npt

from shapery_contracts.errors import InvalidInput, LimitExceeded
from shapery_geometry.volume import FloatArray, Shape, Volume

Array = npt.NDArray[Any]

COMPONENTS: Final = {
    "complex": ("magnitude", "phase", "real", "imaginary"),
    "rgb": ("luminance", "red", "green", "blue"),
    "rgba": ("luminance", "red", "green", "blue", "alpha"),
}
"""Scalars that can be taken from other voxels; ``luminance`` is 0.299 R + 0.587 G + 0.114 B (BT.601)."""


@dataclass(frozen=True, slots=True)
class ReadLimits:
    """How large a volume may be; checked against headers before anything is loaded."""

    voxels: int = 1 << 30
    """Voxels of the volume that is wanted."""
    bytes: int = 8 << 30
    """Bytes that have to be read or decompressed to get at it."""
    files: int = 20_000
    """Files in a folder or an archive."""


@dataclass(frozen=True, slots=True)
class VolumeHeader:
    """What a file says of its volume before any voxel is read."""

    shape: Shape
    spacing: tuple[float, float, float]
    """Millimetres."""
    dtype: str
    """Type of one number in the file, as NumPy spells it."""
    affine: FloatArray
    """From voxel index to RAS mm."""
    format: str
    """As in `shapery_contracts.formats.FileFormat.format`."""
    warnings: tuple[str, ...] = ()
    frames: int = 1
    """Volumes in the file: time points, channels or vector components."""
    storage: str = "real"
    """``real``, or a key of `COMPONENTS`."""

    @property
    def components(self) -> tuple[str, ...]:
        """What `component` may be when it is read; empty for plain numbers."""
        return COMPONENTS.get(self.storage, ())


class VolumeSource(Protocol):
    """A file whose header was read."""

    @property
    def header(self) -> VolumeHeader:
        """The header."""

    def bytes_needed(self, frame: int) -> int:
        """Return how many bytes must be read or decompressed for `frame`."""

    def load(self, frame: int, component: str | None) -> Array:
        """Return the voxels (I, J, K) of `frame`, C-contiguous, scaled as the header says."""


def load_volume(source: VolumeSource, *, frame: int | None, component: str | None, limits: ReadLimits) -> Volume:
    """Load the one scalar volume that the caller chose; see `shapery_geometry.volume_io.read_volume`."""
    header = source.header
    chosen = _choose_frame(header, frame)
    _check_component(header, component)
    check_size(header.shape, limits)
    needed = source.bytes_needed(chosen)
    if needed > limits.bytes:
        raise LimitExceeded(
            "too_large", f"The volume takes {needed} bytes when it is unpacked; at most {limits.bytes} are allowed."
        )
    data = source.load(chosen, component)
    warnings = list(header.warnings)
    if data.dtype.kind == "f":
        finite = int(np.count_nonzero(np.isfinite(data)))
        if finite == 0:
            raise InvalidInput("invalid_volume", f"None of the {data.size} voxels has a finite value.")
        if finite < data.size:
            missing = data.size - finite
            warnings.append(
                f"{missing} of {data.size} voxels ({missing / data.size:.2%}) are not finite (NaN or infinite)."
            )
    return Volume(data, header.affine, tuple(warnings))


def check_size(shape: Sequence[int], limits: ReadLimits) -> None:
    """Refuse what is no volume, or too large a one.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` for a single slice.
    LimitExceeded
        ``too_large``.
    """
    size = " × ".join(map(str, shape))
    voxels = int(np.prod([int(n) for n in shape], dtype=object))
    if voxels > limits.voxels:
        raise LimitExceeded(
            "too_large", f"The volume has {size} = {voxels} voxels; at most {limits.voxels} are allowed."
        )
    if min(shape) < 2:
        raise flat_image(f"{size} voxels")


def flat_image(what: str) -> InvalidInput:
    """Return the error for an image that has no depth."""
    return InvalidInput(
        "invalid_volume", f"The file holds a flat image with {what}, not a volume.", "Send all slices as one volume."
    )


def _choose_frame(header: VolumeHeader, frame: int | None) -> int:
    if header.frames == 1 and frame in (None, 0):
        return 0
    if frame is None:
        raise InvalidInput(
            "invalid_volume",
            f"The file holds {header.frames} volumes (time points, channels or vector components), and one is needed.",
            f"Choose one with frame=0 … frame={header.frames - 1}, or send a file with that one alone.",
        )
    if not 0 <= frame < header.frames:
        raise InvalidInput("invalid_volume", f"There is no frame {frame}: the file holds {header.frames}, from 0.")
    return frame


def _check_component(header: VolumeHeader, component: str | None) -> None:
    if component in header.components or (component is None and not header.components):
        return
    if not header.components:
        raise InvalidInput("invalid_volume", f"The file holds plain numbers, which have no component {component!r}.")
    what = "complex numbers" if header.storage == "complex" else f"colours ({header.storage.upper()})"
    raise InvalidInput(
        "invalid_volume",
        f"The file holds {what}, not intensities."
        if component is None
        else f"The file holds {what}, which have no component {component!r}.",
        f"Choose a component ({', '.join(header.components)}), or send a file with plain intensities.",
    )


def take_component(values: Array, storage: str, component: str | None) -> Array:
    """Return the chosen scalar of each voxel.

    Parameters
    ----------
    values
        Complex numbers of any shape; or colours (..., 3 or 4).
    storage
        A key of `COMPONENTS`; ``real`` returns `values` as they are.
    component
        One of `COMPONENTS`.
    """
    if storage == "real" or component is None:
        return values
    if storage == "complex":
        if component == "real":
            return values.real
        if component == "imaginary":
            return values.imag
        result: Array = np.abs(values) if component == "magnitude" else np.angle(values)
        return result
    if component == "luminance":
        weights = np.array([0.299, 0.587, 0.114], dtype=np.float32)
        luminance: Array = sum(values[..., c] * weights[c] for c in range(3))
        return luminance
    return values[..., ("red", "green", "blue", "alpha").index(component)]


def scaled(values: Array, slope: float, intercept: float) -> Array:
    """Return ``slope * values + intercept`` as float32, or as float64 where float32 would lose digits of `values`."""
    wide = values.dtype == np.float64 or (values.dtype.kind in "iu" and values.dtype.itemsize >= 4)
    out = np.empty(values.shape, dtype=np.float64 if wide else np.float32)
    with np.errstate(all="ignore"):
        # Slab by slab: the product is formed in double precision without a copy of the whole.
        for index in range(values.shape[0]):
            out[index] = values[index].astype(np.float64) * slope + intercept
    return out


def native(values: Array) -> Array:
    """Return `values` in native byte order."""
    return values.astype(values.dtype.newbyteorder("="), copy=False)
