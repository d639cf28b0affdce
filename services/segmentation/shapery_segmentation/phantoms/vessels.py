"""Vessels with known truth: a tube, branching trees, and trees synthesised from a label.

Intensities are 100 of tissue and, in full, 200 of bright or 35 of dark vessels; bleedings are half as far again from
the tissue as vessels are. Noise is Gaussian, its standard deviation the vessels' contrast over the SNR. A voxel at the
border has its share of both (partial volume); in the truth it is vessel where it is so by half.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from shapery_geometry.volume import Volume
from shapery_segmentation.labels import MICROHEMORRHAGE, OBJECT, VESSEL
from shapery_segmentation.phantoms import _vessel_kernels as kernels

FloatArray = NDArray[np.float64]
Polarity = Literal["bright", "dark"]

TISSUE = 100.0
CONTRAST = {"bright": 100.0, "dark": -65.0}
BLEEDING, TUMOR = 1.5, -0.15
"""Contrast of bleedings and of tumors in multiples of the vessels'."""

SAMPLES = 5
"""Points along each axis of a voxel at the border that tell its partial volume."""

STEP = 0.5
"""mm between two points of a drawn centerline."""

APART = 3.0
"""Largest voxel spacings that vessels which do not meet keep between them."""


@dataclass(frozen=True, eq=False)
class DrawnBranch:
    """One branch of the truth: ``points`` (n, 3) RAS mm along its middle, ``radii`` (n,) mm, number of its parent."""

    points: FloatArray
    radii: FloatArray
    parent: int


@dataclass(frozen=True, eq=False)
class VesselPhantom:
    """Vessels.

    Parameters
    ----------
    volume
        float32.
    truth
        uint8 on the same grid: 1 tumor, 3 vessel, 4 microhemorrhage.
    branches
        By the order in which they grow; -1 is the parent of a root. Empty where only a label is known.
    polarity
    """

    volume: Volume
    truth: Volume
    branches: tuple[DrawnBranch, ...]
    polarity: Polarity

    @property
    def centerline(self) -> FloatArray:
        """(n, 3) points of all branches, RAS mm."""
        if not self.branches:
            return np.zeros((0, 3))
        return np.concatenate([branch.points for branch in self.branches])


def tube_phantom(
    rng: np.random.Generator,
    shape: tuple[int, int, int] = (64, 64, 64),
    affine: ArrayLike | None = None,
    *,
    radius: float = 3.0,
    bend: float = 0.0,
    polarity: Polarity = "bright",
    snr: float = 10.0,
    bias: float = 0.0,
) -> VesselPhantom:
    """Return one tube through the middle of the volume, ended 6 mm before its border.

    Parameters
    ----------
    rng
    shape, affine
        The grid; 1 mm by default.
    radius
        In mm.
    bend
        Amplitude in mm of the wave that the tube follows.
    polarity, snr, bias
        See `vessel_tree_phantom`.
    """
    grid = _grid(shape, affine)
    half = 0.5 * min((np.array(shape) - 1) * grid.spacing) - 6.0
    t = np.linspace(-half, half, max(2, round(2 * half / STEP)))
    across = np.stack((np.sin(t * np.pi / half), 0.5 * np.sin(2 * t * np.pi / half)), axis=1) * bend
    along, up, side = (
        np.array(v) / np.linalg.norm(v) for v in ((1.0, 0.5, 0.3), (-0.5, 1.0, 0.0), (-0.3, -0.15, 1.25))
    )
    middle = grid.to_world((np.array(shape) - 1) / 2.0)
    points = middle + t[:, None] * along + across[:, :1] * up + across[:, 1:] * side
    branch = DrawnBranch(points, np.full(len(t), radius), -1)
    return _render(rng, grid, (branch,), polarity, snr, bias)


def vessel_tree_phantom(
    rng: np.random.Generator,
    shape: tuple[int, int, int] = (96, 96, 96),
    affine: ArrayLike | None = None,
    *,
    root_radius: float = 4.5,
    least_radius: float = 1.5,
    polarity: Polarity = "bright",
    snr: float = 10.0,
    bias: float = 0.0,
    tumor_radius: float = 0.0,
    microhemorrhages: int = 0,
) -> VesselPhantom:
    """Return a branching tree that enters through the low end of the last axis.

    Parameters
    ----------
    rng
    shape, affine
        The grid; 1 mm by default. Any spacing, oblique too.
    root_radius, least_radius
        mm at the root, and at the ends. Radii obey Murray's law, r³ = r₁³ + r₂³, where a branch divides.
    polarity
        Whether vessels are brighter or darker than tissue.
    snr
        Contrast of vessels over the standard deviation of noise; ``inf``: no noise.
    bias
        A smooth field multiplies the intensities by 1 − bias/2 to 1 + bias/2.
    tumor_radius
        mm of a ball beside the tree; 0: none.
    microhemorrhages
        Clusters of bleedings within 6 mm of vessels or tumor, touching neither.
    """
    grid = _grid(shape, affine)
    branches = _grow_tree(rng, grid, root_radius, least_radius)
    return _render(rng, grid, branches, polarity, snr, bias, tumor_radius, microhemorrhages)


def phantom_of_label(
    rng: np.random.Generator,
    label: Volume,
    *,
    polarity: Polarity = "bright",
    snr: float = 10.0,
    bias: float = 0.0,
    blur: float = 0.5,
) -> VesselPhantom:
    """Return a volume as a scanner might have seen the vessels of a label.

    Parameters
    ----------
    rng
    label
        Vessel where it is not 0.
    polarity, snr, bias
        See `vessel_tree_phantom`.
    blur
        Standard deviation in voxels of the Gaussian that gives the label its partial volume.
    """
    mask = np.asarray(label.data != 0)
    coverage = ndimage.gaussian_filter(mask.astype(np.float32), blur)
    truth = np.where(mask, np.uint8(VESSEL), np.uint8(0))
    return VesselPhantom(
        label.with_data(_image(rng, coverage, CONTRAST[polarity], snr, bias)), label.with_data(truth), (), polarity
    )


def _grid(shape: tuple[int, int, int], affine: ArrayLike | None) -> Volume:
    matrix = np.eye(4) if affine is None else np.asarray(affine, dtype=np.float64)
    return Volume(np.zeros(shape, dtype=np.uint8), matrix)


def _render(
    rng: np.random.Generator,
    grid: Volume,
    branches: tuple[DrawnBranch, ...],
    polarity: Polarity,
    snr: float,
    bias: float,
    tumor_radius: float = 0.0,
    microhemorrhages: int = 0,
) -> VesselPhantom:
    vessel = _coverage(grid, [_capsules(branch) for branch in branches])
    truth = np.where(vessel >= 0.5, np.uint8(VESSEL), np.uint8(0))
    weight = vessel.copy()
    far = ndimage.distance_transform_edt(truth == 0, sampling=grid.spacing)
    if tumor_radius > 0:
        tumor = _coverage(grid, [_ball(_free_place(rng, grid, far, tumor_radius), tumor_radius)])
        truth[(tumor >= 0.5) & (truth == 0)] = OBJECT
        weight += TUMOR * tumor * (1.0 - vessel)
        far = ndimage.distance_transform_edt(truth == 0, sampling=grid.spacing)
    for _ in range(microhemorrhages):
        cluster = _coverage(grid, _cluster(rng, grid, far))
        truth[(cluster >= 0.5) & (truth == 0)] = MICROHEMORRHAGE
        weight += BLEEDING * cluster * (1.0 - vessel)
        far = np.minimum(far, ndimage.distance_transform_edt(truth != MICROHEMORRHAGE, sampling=grid.spacing))
    volume = grid.with_data(_image(rng, weight, CONTRAST[polarity], snr, bias))
    return VesselPhantom(volume, grid.with_data(truth), branches, polarity)


def _image(
    rng: np.random.Generator, weight: NDArray[np.float32], contrast: float, snr: float, bias: float
) -> NDArray[np.float32]:
    image = TISSUE + contrast * weight.astype(np.float64)
    if bias:
        axes = [np.linspace(0.0, 1.0, n) for n in weight.shape]
        field = np.zeros(weight.shape)
        for _ in range(4):
            a, b, c = (np.cos(np.pi * (rng.uniform(0.3, 1.2) * t + rng.uniform(0, 2))) for t in axes)
            field += rng.normal() * (a[:, None, None] + b[None, :, None] + c[None, None, :])
        field = (field - field.min()) / np.ptp(field)
        image *= 1.0 + bias * (field - 0.5)
    return (image + rng.normal(0.0, abs(contrast) / snr, weight.shape)).astype(np.float32)


def _capsules(branch: DrawnBranch) -> FloatArray:
    return np.concatenate(
        (branch.points[:-1], branch.points[1:], branch.radii[:-1, None], branch.radii[1:, None]), axis=1
    )


def _ball(center: FloatArray, radius: float) -> FloatArray:
    return np.concatenate((center, center, (radius, radius)))[None]


def _coverage(grid: Volume, parts: Sequence[FloatArray]) -> NDArray[np.float32]:
    """Return the share of each voxel in the union of capsules."""
    capsules = np.concatenate(parts)
    centers = grid.to_index(0.5 * (capsules[:, :3] + capsules[:, 3:6]))
    reach = 0.5 * np.linalg.norm(capsules[:, 3:6] - capsules[:, :3], axis=1) + capsules[:, 6:].max(axis=1)
    # A ball of that reach, in index coordinates, and a voxel around it.
    extent = reach[:, None] * np.linalg.norm(grid.inverse_affine[:3, :3], axis=1) + 1.0
    low = np.clip(np.floor(centers - extent), 0, grid.shape).astype(np.int64)
    high = np.clip(np.ceil(centers + extent) + 1, 0, grid.shape).astype(np.int64)
    boxes = np.stack((low, high), axis=2).reshape(-1, 6)
    seen = (high > low).all(axis=1)
    coverage = np.zeros(grid.shape, dtype=np.float32)
    kernels.add_coverage(
        np.ascontiguousarray(capsules[seen]), boxes[seen], np.ascontiguousarray(grid.affine[:3]), SAMPLES, coverage
    )
    return coverage


def _grow_tree(
    rng: np.random.Generator, grid: Volume, root_radius: float, least_radius: float
) -> tuple[DrawnBranch, ...]:
    shape = np.array(grid.shape)
    start = grid.to_world((shape[0] / 2 - 0.5, shape[1] / 2 - 0.5, 0.0))
    up = grid.affine[:3, 2] / np.linalg.norm(grid.affine[:3, 2])
    gap = APART * max(grid.spacing)
    branches: list[DrawnBranch] = []
    waiting = [(start - 4.0 * root_radius * up, up, root_radius, -1)]
    while waiting:
        origin, direction, radius, parent = waiting.pop(0)
        for attempt in range(30):
            turned = direction if parent < 0 else _bent(rng, direction, 0.12 * attempt)
            length = rng.uniform(7.0, 11.0) * radius + (4.0 * root_radius if parent < 0 else 6.0)
            branch = _draw(rng, origin, turned, length, radius, parent)
            if _fits(branch, branches, grid, gap, least_radius):
                break
        else:
            continue
        number = len(branches)
        branches.append(branch)
        end, tip = branch.points[-1], float(branch.radii[-1])
        onward = branch.points[-1] - branch.points[-8]
        onward /= np.linalg.norm(onward)
        share = rng.uniform(0.4, 0.6)
        across = _perpendicular(rng, onward)
        for part, sign in ((share, 1.0), (1.0 - share, -1.0)):
            child = tip * part ** (1.0 / 3.0)
            # Ends taper by a tenth, so that they stay as wide as was asked for.
            if 0.9 * child >= least_radius:
                angle = np.deg2rad(rng.uniform(32.0, 48.0))
                heading = np.cos(angle) * onward + sign * np.sin(angle) * across
                waiting.append((end, heading, child, number))
    return tuple(branches)


def _draw(
    rng: np.random.Generator, origin: FloatArray, direction: FloatArray, length: float, radius: float, parent: int
) -> DrawnBranch:
    """Return a smoothly winding branch that tapers by a tenth."""
    n = max(16, round(length / STEP))
    step, heading = length / n, direction
    axis = _perpendicular(rng, heading)
    points = [origin]
    for k in range(n):
        if k % 12 == 11:
            axis = _perpendicular(rng, heading)
        heading = heading + 0.35 * step / (4.0 * radius) * axis
        heading /= np.linalg.norm(heading)
        points.append(points[-1] + step * heading)
    return DrawnBranch(np.array(points), np.linspace(radius, 0.9 * radius, n + 1), parent)


def _fits(branch: DrawnBranch, others: list[DrawnBranch], grid: Volume, gap: float, least_radius: float) -> bool:
    """Return whether a branch stays in the grid, and away from all others but those that it meets at its origin."""
    index = grid.to_index(branch.points if branch.parent >= 0 else branch.points[-1:])
    margin = (2.0 * least_radius + 2.0) / np.array(grid.spacing)
    if (index < margin).any() or (index > np.array(grid.shape) - 1 - margin).any():
        return False
    for number, other in enumerate(others):
        near = 0
        if number == branch.parent or (other.parent == branch.parent and branch.parent >= 0):
            # At the fork they meet; what comes after four radii must not.
            near = int(np.searchsorted(np.arange(len(branch.points)) * STEP, 4.5 * branch.radii[0] + gap))
        points = branch.points[near:]
        if not len(points):
            continue
        distance = np.linalg.norm(points[:, None] - other.points[None], axis=2)
        if (distance < branch.radii[near:, None] + other.radii[None] + gap).any():
            return False
    return True


def _perpendicular(rng: np.random.Generator, direction: FloatArray) -> FloatArray:
    across = np.cross(direction, rng.normal(size=3))
    return np.asarray(across / np.linalg.norm(across))


def _bent(rng: np.random.Generator, direction: FloatArray, amount: float) -> FloatArray:
    turned = direction + amount * _perpendicular(rng, direction) * rng.random()
    return np.asarray(turned / np.linalg.norm(turned))


def _free_place(rng: np.random.Generator, grid: Volume, far: FloatArray, radius: float) -> FloatArray:
    """Return a point from which a ball reaches neither what `far` is measured from nor the border, but nearly."""
    inner = np.pad(np.ones([n - 2 for n in grid.shape], dtype=np.bool_), 1)
    room = np.minimum(far, ndimage.distance_transform_edt(inner, sampling=grid.spacing))
    fitting = np.argwhere((room > radius + 2.0) & (far < radius + 5.0))
    if not len(fitting):
        raise ValueError("there is no room for the tumor")
    return np.asarray(grid.to_world(fitting[rng.integers(len(fitting))]))


def _cluster(rng: np.random.Generator, grid: Volume, far: FloatArray) -> list[FloatArray]:
    """Return a few balls that overlap, within 6 mm of what `far` is measured from."""
    largest = 2.2 * max(grid.spacing) + 0.6
    inner = np.pad(np.ones([n - 2 for n in grid.shape], dtype=np.bool_), 1)
    room = ndimage.distance_transform_edt(inner, sampling=grid.spacing)
    keep = largest + 2.0 * max(grid.spacing)
    fitting = np.argwhere((far > keep) & (far < max(6.0, keep + 1.5)) & (room > 2 * largest))
    if not len(fitting):
        raise ValueError("there is no room for another bleeding")
    places = [grid.to_world(fitting[rng.integers(len(fitting))])]
    balls = [_ball(places[0], largest)]
    for _ in range(20):
        if len(balls) == 4:
            break
        radius = largest * rng.uniform(0.7, 0.95)
        place = places[rng.integers(len(places))] + largest * _perpendicular(rng, rng.normal(size=3))
        i, j, k = np.clip(np.rint(grid.to_index(place)), 0, np.array(grid.shape) - 1).astype(int)
        if far[i, j, k] > radius + 1.5 * max(grid.spacing):
            places.append(place)
            balls.append(_ball(place, radius))
    return balls
