"""How a shape stands in its picture and where viewers begin: upright, and seen from a side that shows it.

Files agree on little, but nearly all have their y axis or their z axis upwards. Which of the two it is, is asked of the
shape: one stands on what it touches the ground with, and its top and its bottom differ, while a lying body often has
one side like the other. Nothing of this is compared; descriptors see shapes in any pose.

References
----------
H. Fu, D. Cohen-Or, G. Dror, A. Sheffer, Upright orientation of man-made objects, SIGGRAPH 2008,
doi:10.1145/1399504.1360641 (static stability and symmetry as signs of it).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError, cKDTree

from shapery_geometry.mesh import TriangleMesh
from shapery_retrieval.views import second_moments

CONTACT = 0.02
"""What is so near to the ground, in diagonals, touches it."""
STEADY = np.tan(np.deg2rad(3))
"""What stands falls only when it is tilted by more than this slope."""
ALIKE = 1.1
"""Second moments within this ratio give no direction."""
MOST_SAMPLES = 3000
SIDE, LOW, HIGH = np.deg2rad(32), np.deg2rad(24), np.deg2rad(50)
"""A shape is seen from so far to the left of its front, and from so far above; the higher, the flatter it lies."""


@dataclass(frozen=True, eq=False)
class Pose:
    """How a shape stands.

    Attributes
    ----------
    frame
        (3, 3) rows: to the right, up and to the front, orthonormal and right-handed, in the mesh's frame.
    towards
        (3,) unit vector to whoever looks, in coordinates of `frame`.
    """

    frame: NDArray[np.float64]
    towards: NDArray[np.float64]


def pose_of(mesh: TriangleMesh) -> Pose:
    """Return how a mesh with some area stands; faces should be small, since they are seen by their middles."""
    middles = mesh.corners.mean(axis=1) - mesh.centroid
    weights = mesh.face_areas / mesh.area
    ups = np.eye(3)[[1, 2]]
    slopes = [_slope(mesh, up) for up in ups]
    # of two sides that are each like the opposite one, as a plate's, it lies on the one on which it lies better
    differences = [round(_difference(middles, weights, up) / mesh.diagonal, 4) for up in ups]
    signs = [(slope > STEADY, difference, slope) for slope, difference in zip(slopes, differences, strict=True)]
    up = ups[0] if signs[0] >= signs[1] else ups[1]
    frame = _turned(second_moments(mesh), middles, weights, up)
    return Pose(frame, _towards((mesh.vertices - mesh.centroid) @ frame.T))


def _slope(mesh: TriangleMesh, up: NDArray[np.float64]) -> float:
    """By how much the ground may slope before a shape that stands on it falls; negative where it falls at once."""
    heights = (mesh.vertices - mesh.centroid) @ up
    lowest = heights.min()
    touching = mesh.vertices[heights <= lowest + CONTACT * mesh.diagonal] - mesh.centroid
    try:
        hull = ConvexHull(touching[:, up == 0])
    except (QhullError, ValueError):
        return -np.inf  # it touches the ground in a point or along a line
    return float(hull.equations[:, -1].max() / lowest)


def _difference(middles: NDArray[np.float64], weights: NDArray[np.float64], up: NDArray[np.float64]) -> float:
    """Mean distance of the surface, turned upside down by a mirror, from itself."""
    step = -(-len(middles) // MOST_SAMPLES)
    mirrored = (middles * np.where(up, -1.0, 1.0))[::step]
    distances, _ = cKDTree(middles).query(mirrored)
    return float(np.average(distances, weights=weights[::step]))


def _turned(
    moments: NDArray[np.float64], middles: NDArray[np.float64], weights: NDArray[np.float64], up: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Turn a shape about what is up: its long side across, what reaches out farthest to the right or to the front."""
    right = np.eye(3)[0]
    level = np.stack((right, np.cross(right, up)))
    spread, axes = np.linalg.eigh(level @ moments @ level.T)
    if spread[1] > ALIKE * spread[0]:
        right = axes[:, 1] @ level
    front = np.cross(right, up)
    skew = weights @ (middles @ np.stack((right, front), axis=1)) ** 3
    if skew[np.argmax(np.abs(skew))] < 0:
        right, front = -right, -front
    return np.stack((right, up, front))


def _towards(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return from where points in their frame are seen well."""
    width, height, depth = np.ptp(points, axis=0)
    flat = np.clip((0.4 - height / max(min(width, depth), 1e-12)) / 0.3, 0, 1)
    above = LOW + (HIGH - LOW) * flat
    return np.array([-np.sin(SIDE) * np.cos(above), np.sin(above), np.cos(SIDE) * np.cos(above)])
