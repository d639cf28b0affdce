"""Volumes: a three-dimensional array with its affine.

Frame
-----
One frame is used everywhere inside: RAS, millimetres (x grows to the patient's right, y to the front, z to the head).
``affine`` takes the index of a voxel, counted from 0 and meant at its centre, to that frame. Readers convert from what
their format uses; nobody else does.

Non-finite voxels
-----------------
A reader leaves NaN and infinities where the file has them and says so in ``warnings``. They belong to no statistics
(`Volume.statistics`), carry no weight in resampling, and `Volume.filled` replaces them for code that cannot bear them.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from shapery_contracts.errors import InvalidInput

Array = npt.NDArray[Any]
FloatArray = npt.NDArray[np.float64]
Shape = tuple[int, int, int]

GRID_TOLERANCE = 1e-3
"""Fraction of the smallest spacing by which the corners of two grids may differ and still be one grid. Files round
their affines to float32 or to a few decimals, which moves a corner by about 1e-4 of a voxel."""

LARGEST_COORDINATE = 1e9
"""Millimetres. A header with a larger number is damaged; its square would overflow."""
SMALLEST_SPACING = 1e-9
"""Millimetres. A header with a smaller number is damaged; its voxel volume would vanish."""


def check_affine(affine: npt.ArrayLike) -> FloatArray:
    """Return `affine` as a read-only (4, 4) float64 array.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` if it is not finite, not affine, or flat (its axes span no volume).
    """
    matrix = np.array(affine, dtype=np.float64)
    if matrix.shape != (4, 4):
        raise InvalidInput("invalid_volume", f"The affine has shape {matrix.shape}, not (4, 4).")
    if not np.isfinite(matrix).all():
        raise InvalidInput("invalid_volume", "The affine from voxels to millimetres has values that are not finite.")
    if not np.allclose(matrix[3], (0.0, 0.0, 0.0, 1.0), rtol=0.0, atol=1e-9):
        raise InvalidInput("invalid_volume", f"The last row of the affine is {matrix[3].tolist()}, not [0, 0, 0, 1].")
    if np.abs(matrix).max() > LARGEST_COORDINATE:
        raise InvalidInput(
            "invalid_volume", f"The affine has a value of {np.abs(matrix).max():g} mm, which is no place."
        )
    lengths = np.sqrt((matrix[:3, :3] ** 2).sum(axis=0))
    # The determinant of the unit axes: 1 for orthogonal ones, 0 for flat ones, whatever the spacing.
    with np.errstate(all="ignore"):
        flatness = abs(np.linalg.det(matrix[:3, :3] / lengths)) if (lengths > SMALLEST_SPACING).all() else 0.0
    if not flatness > 1e-6:
        raise InvalidInput(
            "invalid_volume",
            f"The axes of the volume span no space: spacing {', '.join(f'{v:g}' for v in lengths)} mm, "
            f"determinant of the directions {flatness:.2g}.",
            "Mend the orientation in the file's header.",
        )
    matrix[3] = (0.0, 0.0, 0.0, 1.0)
    matrix.flags.writeable = False
    return matrix


@dataclass(frozen=True, slots=True)
class VolumeStatistics:
    """Figures of the finite voxels; NaN where there are none."""

    finite: int
    non_finite: int
    minimum: float
    maximum: float


@dataclass(frozen=True, eq=False)
class Volume:
    """A scalar volume and where it lies.

    Parameters
    ----------
    data : (I, J, K) array of bool, integers or floats
        Voxel values. Readers give C-contiguous arrays in native byte order: the file's own integer type where the file
        has no scaling, else float32 (float64 where the file has float64, or float32 would lose digits).
    affine : (4, 4) float64
        From voxel index to RAS millimetres. Kept exactly as given: sheared and left-handed affines too.
    warnings
        What was doubtful when it was read, as sentences for the user.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` for other dimensions or types, or an affine that spans no space; ``empty_content`` without
        voxels.
    """

    data: Array
    affine: FloatArray
    warnings: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        data = np.asarray(self.data)
        if data.ndim != 3:
            raise InvalidInput("invalid_volume", f"A volume has 3 dimensions; this array has shape {data.shape}.")
        if data.dtype.kind not in "biuf":
            raise InvalidInput("invalid_volume", f"A volume holds real numbers; this array holds {data.dtype}.")
        if data.size == 0:
            raise InvalidInput("empty_content", f"The volume of shape {data.shape} has no voxels.")
        object.__setattr__(self, "data", data)
        object.__setattr__(self, "affine", check_affine(self.affine))
        object.__setattr__(self, "warnings", tuple(self.warnings))

    @property
    def shape(self) -> Shape:
        """Voxels along each axis."""
        i, j, k = self.data.shape
        return i, j, k

    @cached_property
    def spacing(self) -> tuple[float, float, float]:
        """Distance in mm between neighbouring voxel centres along each axis."""
        x, y, z = np.sqrt((self.affine[:3, :3] ** 2).sum(axis=0)).tolist()
        return x, y, z

    @cached_property
    def voxel_volume(self) -> float:
        """Volume of one voxel in mm³; of the parallelepiped where the affine is sheared."""
        return float(abs(np.linalg.det(self.affine[:3, :3])))

    @cached_property
    def inverse_affine(self) -> FloatArray:
        """From RAS mm to voxel index, (4, 4) float64."""
        inverse: FloatArray = np.linalg.inv(self.affine).astype(np.float64)
        inverse[3] = (0.0, 0.0, 0.0, 1.0)
        inverse.flags.writeable = False
        return inverse

    def to_world(self, ijk: npt.ArrayLike) -> FloatArray:
        """Return RAS mm (..., 3) of voxel indices (..., 3), which may be fractional."""
        points = np.asarray(ijk, dtype=np.float64)
        world: FloatArray = points @ self.affine[:3, :3].T + self.affine[:3, 3]
        return world

    def to_index(self, xyz: npt.ArrayLike) -> FloatArray:
        """Return fractional voxel indices (..., 3) of points (..., 3) in RAS mm."""
        # Subtracting the origin first keeps the digits where volumes lie far from the scanner's centre.
        points = np.asarray(xyz, dtype=np.float64) - self.affine[:3, 3]
        index: FloatArray = points @ self.inverse_affine[:3, :3].T
        return index

    def contains(self, xyz: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Tell for points (..., 3) in RAS mm whether they lie in a voxel; the outermost voxels count in full."""
        index = self.to_index(xyz)
        inside = (index >= -0.5) & (index <= np.array(self.shape) - 0.5)
        return np.asarray(inside.all(axis=-1))

    def corners(self) -> FloatArray:
        """Return the centres (8, 3) of the corner voxels in RAS mm."""
        return self.to_world(list(itertools.product(*((0, n - 1) for n in self.shape))))

    def with_data(self, data: Array) -> Volume:
        """Return other values on the same grid.

        Raises
        ------
        InvalidInput
            ``grid_mismatch`` if `data` has another shape.
        """
        if data.shape != self.shape:
            raise InvalidInput(
                "grid_mismatch", f"Values of shape {data.shape} do not fit a grid of shape {self.shape}."
            )
        return Volume(data, self.affine)

    def same_grid(self, other: Volume, tolerance: float = GRID_TOLERANCE) -> bool:
        """Tell whether `other` has its voxels at the same places in the same order.

        Parameters
        ----------
        other
            The volume to compare with.
        tolerance
            Largest distance between corresponding corners, as a fraction of the smallest spacing.
        """
        if self.shape != other.shape:
            return False
        # Corners of the grid of voxel *bounds*: along an axis of one voxel its spacing must agree, too.
        bounds = np.array(list(itertools.product(*((-0.5, n - 0.5) for n in self.shape))))
        distance = np.abs(self.to_world(bounds) - other.to_world(bounds)).max()
        return bool(distance <= tolerance * min(self.spacing))

    def statistics(self) -> VolumeStatistics:
        """Return figures of the finite voxels."""
        values = self.data
        if values.dtype.kind == "f":
            finite = np.isfinite(values)
            count = int(np.count_nonzero(finite))
            if count < values.size:
                values = values[finite]
        count = int(values.size)
        missing = self.data.size - count
        if count == 0:
            nan = float("nan")
            return VolumeStatistics(0, missing, nan, nan)
        return VolumeStatistics(
            finite=count,
            non_finite=missing,
            minimum=float(values.min()),
            maximum=float(values.max()),
        )

    def finite(self) -> npt.NDArray[np.bool_]:
        """Return where voxels are finite, (I, J, K) bool."""
        if self.data.dtype.kind != "f":
            return np.ones(self.shape, dtype=np.bool_)
        mask: npt.NDArray[np.bool_] = np.isfinite(self.data)
        return mask

    def filled(self, value: float | None = None) -> Volume:
        """Return the volume with non-finite voxels replaced by `value`, by default the smallest finite one.

        Raises
        ------
        InvalidInput
            ``invalid_volume`` if no voxel is finite.
        """
        finite = self.finite()
        if finite.all():
            return self
        if not finite.any():
            raise InvalidInput("invalid_volume", f"None of the {self.data.size} voxels has a finite value.")
        fill = self.data[finite].min() if value is None else value
        return replace(self, data=np.where(finite, self.data, self.data.dtype.type(fill)))

    def canonical(self) -> tuple[Volume, Reorientation]:
        """Return the volume with its axes nearest to right, anterior, superior, and the way back.

        No value is changed: axes are swapped and reversed only, so an oblique volume stays oblique. The result does
        not depend on the order in which the file stored the axes.

        Examples
        --------
        >>> canonical, reorientation = volume.canonical()
        >>> labels = segment(canonical)
        >>> result = volume.with_data(reorientation.undo_array(labels))
        """
        reorientation = Reorientation.to_canonical(self)
        return reorientation.apply(self), reorientation

    def resampled_to(
        self, grid: Volume, *, method: Literal["linear", "nearest"] = "linear", fill: float = float("nan")
    ) -> Volume:
        """Return these values on the grid of `grid`; see `shapery_geometry.resampling.resample`."""
        # Imported here because the kernels bring numba, which takes longer to import than most volumes to read.
        from shapery_geometry.resampling import resample

        return Volume(resample(self.data, self.affine, grid.shape, grid.affine, method=method, fill=fill), grid.affine)


@dataclass(frozen=True, eq=False)
class Reorientation:
    """A swap and reversal of axes between two grids, with its exact inverse.

    Parameters
    ----------
    axes
        Axis k of the target is axis ``axes[k]`` of the source.
    flips
        Whether axis k of the target runs against that axis of the source.
    source_shape, source_affine
        The grid that `undo` returns to, bit for bit.
    """

    axes: tuple[int, int, int]
    flips: tuple[bool, bool, bool]
    source_shape: Shape
    source_affine: FloatArray

    @classmethod
    def to_canonical(cls, volume: Volume) -> Reorientation:
        """Return the way from the grid of `volume` to the axes nearest to right, anterior, superior."""
        return cls._along(volume, np.eye(3))

    @classmethod
    def to_codes(cls, volume: Volume, codes: str) -> Reorientation:
        """Return the way to the axes that `codes` names, such as ``"LPS"``: the direction in which each grows."""
        directions = {"R": (1, 0, 0), "L": (-1, 0, 0), "A": (0, 1, 0), "P": (0, -1, 0), "S": (0, 0, 1), "I": (0, 0, -1)}
        if len(codes) != 3 or any(c not in directions for c in codes):
            raise ValueError(f"axis codes are three of R L A P S I, not {codes!r}")
        wanted = np.array([directions[c] for c in codes], dtype=np.float64)
        if abs(np.linalg.det(wanted)) != 1.0:
            raise ValueError(f"axis codes {codes!r} name one axis twice")
        return cls._along(volume, wanted)

    @classmethod
    def _along(cls, volume: Volume, wanted: FloatArray) -> Reorientation:
        """Match the volume's axes to the rows of `wanted`, a signed permutation matrix."""
        axes, signs = _nearest_axes(volume.affine[:3, :3] / np.array(volume.spacing))
        order = [int(np.flatnonzero(row)[0]) for row in wanted]
        chosen = tuple(axes[w] for w in order)
        flips = tuple(bool(signs[w] * wanted[k, w] < 0) for k, w in enumerate(order))
        return cls((chosen[0], chosen[1], chosen[2]), (flips[0], flips[1], flips[2]), volume.shape, volume.affine)

    @property
    def target_shape(self) -> Shape:
        """Shape after `apply`."""
        a, b, c = (self.source_shape[axis] for axis in self.axes)
        return a, b, c

    @cached_property
    def target_affine(self) -> FloatArray:
        """Affine after `apply`, (4, 4) float64."""
        matrix = np.zeros((4, 4))
        matrix[3, 3] = 1.0
        origin = self.source_affine[:3, 3].copy()
        for k, (axis, flip) in enumerate(zip(self.axes, self.flips, strict=True)):
            column = self.source_affine[:3, axis]
            matrix[:3, k] = -column if flip else column
            if flip:
                origin += column * (self.source_shape[axis] - 1)
        matrix[:3, 3] = origin
        return check_affine(matrix + 0.0)  # no negative zeros

    def apply_array(self, data: Array) -> Array:
        """Return a view of `data` (source shape first, more axes may follow) in the target's order."""
        self._check(data, self.source_shape)
        rest = range(3, data.ndim)
        steps = tuple(slice(None, None, -1) if flip else slice(None) for flip in self.flips)
        return data.transpose(*self.axes, *rest)[steps]

    def undo_array(self, data: Array) -> Array:
        """Return a view of `data` (target shape first, more axes may follow) in the source's order."""
        self._check(data, self.target_shape)
        rest = range(3, data.ndim)
        steps = tuple(slice(None, None, -1) if flip else slice(None) for flip in self.flips)
        return data[steps].transpose(*np.argsort(self.axes), *rest)

    def apply(self, volume: Volume) -> Volume:
        """Return `volume`, which lies on the source's grid, in the target's order, C-contiguous."""
        data = np.ascontiguousarray(self.apply_array(volume.data))
        return Volume(data, self.target_affine, volume.warnings)

    def undo(self, volume: Volume) -> Volume:
        """Return `volume`, which lies on the target's grid, on the source's own grid, C-contiguous."""
        data = np.ascontiguousarray(self.undo_array(volume.data))
        return Volume(data, self.source_affine, volume.warnings)

    @staticmethod
    def _check(data: Array, shape: Shape) -> None:
        if data.shape[:3] != shape:
            raise InvalidInput("grid_mismatch", f"An array of shape {data.shape} does not lie on a grid of {shape}.")


def _nearest_axes(directions: FloatArray) -> tuple[tuple[int, int, int], tuple[float, float, float]]:
    """Assign to each world axis the array axis nearest to it, each once.

    The product of the cosines is maximised: it vanishes for every assignment only if the directions are flat, so the
    sign of each assigned cosine is well defined. Assignments that tie (a rotation by 45°) are told apart by the sense
    of the rotation that remains, which does not depend on the order of the array's axes.
    """
    best: tuple[tuple[float, ...], tuple[int, int, int], tuple[float, float, float]] | None = None
    candidates = []
    for axes in itertools.permutations(range(3)):
        cosines = directions[(0, 1, 2), axes]
        signs = np.where(cosines < 0, -1.0, 1.0)
        rotation = directions[:, axes] * signs
        sense = (rotation - rotation.T)[(1, 2, 2), (0, 0, 1)]
        candidates.append((float(abs(cosines.prod())), np.round(sense, 6).tolist(), axes, signs.tolist()))
    limit = max(c[0] for c in candidates) - 1e-6
    for product, sense, axes, signs in candidates:
        if product >= limit and (best is None or tuple(sense) > best[0]):
            best = (tuple(sense), (axes[0], axes[1], axes[2]), (signs[0], signs[1], signs[2]))
    assert best is not None
    return best[1], best[2]
