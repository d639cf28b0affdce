"""A shape as it looks: local features of depth images from 26 sides.

The surface is turned into the frame of its principal axes and seen from the faces, edges and corners of a cube. A view
does not tell left from right: each feature is turned to its mean gradient and mirrored to one side of it, so that the
signs and the handedness of the axes do not matter.

References
----------
R. Ohbuchi, K. Osada, T. Furuya, T. Banno, Salient local visual features for shape-based 3D model retrieval, SMI 2008,
doi:10.1109/SMI.2008.4547955.
D. Lowe, Distinctive image features from scale-invariant keypoints, IJCV 60(2), 2004,
doi:10.1023/B:VISI.0000029664.99615.94 (for the histograms of gradients).
R. Arandjelović, A. Zisserman, Three things everyone should know to improve object retrieval, CVPR 2012 (for the square
roots).
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_retrieval import _view_kernels as kernels

SIZE = 96
"""Side of the largest image; the second one is half as large."""
STEP, RADIUS = 8, 10
"""Distance of features, and half the side of their patch, in pixels of each image."""
BACKGROUND = 0.35
"""How far the background lies behind the middle of the shape, in radii: a step at the outline, not an abyss."""
MOST_FEATURES = 5000

DIRECTIONS = np.array([d for d in itertools.product((-1, 0, 1), repeat=3) if any(d)], dtype=np.float64)
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)


def second_moments(mesh: TriangleMesh) -> NDArray[np.float64]:
    """(3, 3) second moments of the surface about its centroid, times 12."""
    corners = mesh.corners - mesh.centroid
    weights = mesh.face_areas / mesh.area
    middles = corners.mean(axis=1)
    # exact for linear functions squared over triangles: (9 m mᵀ + Σ c cᵀ) / 12
    moments = np.einsum("f,fi,fj->ij", 9 * weights, middles, middles)
    moments += np.einsum("f,fki,fkj->ij", weights, corners, corners)
    return np.asarray(moments)


def principal_frame(mesh: TriangleMesh) -> NDArray[np.float64]:
    """(3, 3) rows: the axes of the surface's second moments, the longest first."""
    _, axes = np.linalg.eigh(second_moments(mesh))
    return np.asarray(axes.T[::-1])


def depth_images(mesh: TriangleMesh, size: int = SIZE) -> NDArray[np.float64]:
    """(26, size, size) heights above the middle plane in radii, −inf where nothing is seen."""
    points = (mesh.vertices - mesh.centroid) @ principal_frame(mesh).T
    radius = float(np.sqrt((points**2).sum(axis=1).max()))
    points = points / radius
    images = np.full((len(DIRECTIONS), size, size), -np.inf)
    ids = np.empty((size, size), dtype=np.int32)
    scale = (size / 2) * 0.96
    for image, direction in zip(images, DIRECTIONS, strict=True):
        helper = np.eye(3)[int(np.argmin(np.abs(direction)))]
        right = np.cross(helper, direction)
        right /= np.linalg.norm(right)
        seen = points @ np.stack((right, np.cross(direction, right), direction), axis=1)
        seen[:, :2] = seen[:, :2] * scale + size / 2
        ids.fill(-1)
        kernels.render(seen, mesh.faces, size, image, ids)
    return images


def view_features(mesh: TriangleMesh) -> NDArray[np.float32]:
    """(k, 128) local features of all views, each of unit length."""
    out = np.empty((MOST_FEATURES, 128), dtype=np.float32)
    place = 0
    for image in depth_images(mesh):
        inside = np.isfinite(image)
        filled = np.where(inside, image, -BACKGROUND).astype(np.float32)
        np.maximum(filled, -BACKGROUND, out=filled)
        place = kernels.describe_image(filled, inside, STEP, RADIUS, 0.05, out, place)
        half = kernels.halve(filled)
        covered = inside[::2, ::2] | inside[1::2, ::2] | inside[::2, 1::2] | inside[1::2, 1::2]
        place = kernels.describe_image(half, covered, STEP // 2, RADIUS, 0.05, out, place)
    return out[:place]
