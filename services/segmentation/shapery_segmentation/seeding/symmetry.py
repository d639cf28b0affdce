"""The plane between the halves of the brain, estimated rather than taken from the middle of the array."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_geometry.concurrent import in_halves
from shapery_segmentation.blocks import block_mean
from shapery_segmentation.seeding import _symmetry_kernels as kernels

COARSE_STEP = 6.0
"""mm. Wide enough that the search cannot be caught by gyri."""

FINE_STEP = 3.0
"""mm. The plane is then known to about a millimetre, less than a head's own asymmetry."""

SAMPLES = 100_000
"""Voxels from which the brain's range of intensities is taken."""

ANGLES = (-30.0, 30.0, 7.5)
"""Degrees searched about each of two axes: first, last, step. A head lies no more askew than this in a scanner."""


@dataclass(frozen=True, eq=False)
class SymmetryPlane:
    """A plane ``normal · x = distance``.

    Parameters
    ----------
    normal : (3,) float64
        Unit vector in mm along the axes of the grid, towards the patient's right.
    distance
        In mm from the centre of the grid's first voxel.
    likeness
        Correlation of the volume with its mirror image, in [-1, 1].
    """

    normal: NDArray[np.float64]
    distance: float
    likeness: float

    def reflection(self, spacing: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (3, 3) matrix and (3,) offset that take a voxel index to the index of its mirror image."""
        matrix = np.eye(3) - 2.0 * np.outer(self.normal, self.normal)
        return matrix, 2.0 * self.distance * self.normal / spacing


def find_symmetry(image: NDArray[np.float32], mask: NDArray[np.bool_], spacing: float) -> SymmetryPlane:
    """Find the plane about which the brain is most alike.

    Parameters
    ----------
    image : (I, J, K) float32
        The volume before contrast; axes nearest to right, anterior, superior.
    mask : (I, J, K) bool
        The brain.
    spacing
        Edge of a voxel in mm.

    Notes
    -----
    The correlation of the volume with its mirror image is maximised over the plane's distance and two angles: by
    trying a grid of angles on voxels of 6 mm, then by halving steps on voxels of 3 mm. Voxels outside the brain count
    as the brain's own lower end, so the outline guides the search as much as what is inside.
    """
    inside = image[mask]
    low, high = (float(v) for v in np.percentile(inside[:: max(1, len(inside) // SAMPLES)], (2, 98)))
    values = np.where(mask, np.clip(image, low, high) - np.float32(low), np.float32(0.5 * (low - high)))
    plane: tuple[float, float, float] | None = None
    best = -2.0
    for step in (COARSE_STEP, FINE_STEP):
        factor = max(1, round(step / spacing))
        coarse = block_mean(values, factor)
        size = factor * spacing
        weight = (block_mean(mask.astype(np.float32), factor) > 0.5).astype(np.float32)
        centre = np.array(ndimage.center_of_mass(weight)) * size
        if plane is None:
            grid = np.deg2rad(np.arange(ANGLES[0], ANGLES[1] + 1e-6, ANGLES[2]))
            best, plane = _search(coarse, weight, size, centre, grid)
            best, plane = _descend(coarse, weight, size, centre, plane, (6.0, np.deg2rad(4.0)), 4)
        else:
            best, plane = _descend(coarse, weight, size, centre, plane, (2.0, np.deg2rad(1.5)), 4)
        origin = (factor - 1) / 2 * spacing
        normal = _normal(plane[1], plane[2])
        distance = float(normal @ (centre + origin)) + plane[0]
    return SymmetryPlane(normal, distance, best)


def _normal(yaw: float, roll: float) -> NDArray[np.float64]:
    return np.array([np.cos(yaw) * np.cos(roll), np.sin(yaw) * np.cos(roll), np.sin(roll)])


def _likeness(
    image: NDArray[np.float32],
    weight: NDArray[np.float32],
    size: float,
    centre: NDArray[np.float64],
    plane: tuple[float, float, float],
) -> float:
    normal = _normal(plane[1], plane[2])
    matrix = np.eye(3) - 2.0 * np.outer(normal, normal)
    offset = 2.0 * (float(normal @ centre) + plane[0]) * normal / size
    return float(kernels.mirrored_correlation(image, weight, matrix, offset))


def _search(
    image: NDArray[np.float32],
    weight: NDArray[np.float32],
    size: float,
    centre: NDArray[np.float64],
    angles: NDArray[np.float64],
) -> tuple[float, tuple[float, float, float]]:
    """Return the best plane of a grid of angles, through the centre or 8 mm beside it."""
    planes = [(shift, float(yaw), float(roll)) for yaw in angles for roll in angles for shift in (-8.0, 0.0, 8.0)]

    def likenesses(first: int, end: int) -> list[float]:
        return [_likeness(image, weight, size, centre, plane) for plane in planes[first:end]]

    found = list(itertools.chain.from_iterable(in_halves(likenesses, len(planes), 2)))
    best = int(np.argmax(found))
    return found[best], planes[best]


def _descend(
    image: NDArray[np.float32],
    weight: NDArray[np.float32],
    size: float,
    centre: NDArray[np.float64],
    start: tuple[float, float, float],
    steps: tuple[float, float],
    halvings: int,
) -> tuple[float, tuple[float, float, float]]:
    """Improve a plane by steps along each of its three parameters, halved when none helps."""
    best, chosen = _likeness(image, weight, size, centre, start), start
    shift, turn = steps
    for _ in range(halvings):
        moved = True
        while moved:
            moved = False
            for axis, step in ((0, shift), (1, turn), (2, turn)):
                for sign in (1.0, -1.0):
                    trial = list(chosen)
                    trial[axis] += sign * step
                    plane = (trial[0], trial[1], trial[2])
                    value = _likeness(image, weight, size, centre, plane)
                    if value > best + 1e-6:
                        best, chosen, moved = value, plane, True
        shift, turn = shift / 2, turn / 2
    return best, chosen
