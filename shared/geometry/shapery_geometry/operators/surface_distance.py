"""Distances from points to a surface, and between two surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.bvh import LEAF_SIZE, FaceTree, build_face_tree
from shapery_geometry.mesh import TriangleMesh, checked_vertices
from shapery_geometry.operators import _closest_point_kernels as kernels
from shapery_geometry.operators.laplacian import vertex_areas
from shapery_geometry.operators.sampling import sample_surface


@dataclass(frozen=True, eq=False)
class ClosestPoints:
    """For each of k points the nearest one on a mesh."""

    distances: NDArray[np.float64]
    """(k,) never negative, in the unit of the mesh."""
    faces: NDArray[np.int32]
    """(k,) a face on which the nearest point lies."""
    barycentric: NDArray[np.float64]
    """(k, 3) weights of the corners of that face, summing to 1."""
    points: NDArray[np.float64]
    """(k, 3) the nearest points."""


@dataclass(frozen=True, slots=True)
class SurfaceDistances:
    """How far two surfaces lie apart, in their unit."""

    assd: float
    """Average symmetric surface distance: the mean over both surfaces of the distance to the other one."""
    hd95: float
    """The larger of both 95th percentiles: a twentieth of one surface's area lies farther from the other."""
    hausdorff: float
    """The largest distance from a point looked at to the other surface: never more than the true one."""


def closest_points(mesh: TriangleMesh, points: ArrayLike, *, tree: FaceTree | None = None) -> ClosestPoints:
    """Find the nearest point of a surface for each of some points, exactly to rounding.

    Parameters
    ----------
    mesh
        At least one face; faces may be degenerate.
    points : (k, 3) float64
        In the frame of the mesh.
    tree
        From `shapery_geometry.bvh.build_face_tree`, for several calls with one mesh.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` for a mesh without faces or points that are not finite.
    """
    if not len(mesh.faces):
        raise InvalidInput("invalid_mesh", "A mesh without faces has no nearest point.")
    queries = checked_vertices(points)
    tree = build_face_tree(mesh) if tree is None else tree
    faces, weights, squares = kernels.closest_faces(
        queries, mesh.vertices, mesh.faces, tree.order, tree.nodes, tree.first_leaf, LEAF_SIZE
    )
    nearest = np.einsum("ik,ikj->ij", weights, mesh.corners[faces])
    return ClosestPoints(np.sqrt(squares), faces, weights, nearest)


def surface_distances(
    first: TriangleMesh, second: TriangleMesh, *, samples: int = 0, rng: np.random.Generator | None = None
) -> SurfaceDistances:
    """Compare two surfaces.

    Parameters
    ----------
    first, second
        In one frame. Each must have some area.
    samples
        How many points to draw from each, evenly over its area. By default its vertices are taken, each weighted by its
        share of the area.
    rng
        Needed to draw points.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` for a surface without area.

    References
    ----------
    V. Yeghiazaryan, I. Voiculescu, Family of boundary overlap metrics for the evaluation of medical image segmentation,
    Journal of Medical Imaging 5(1), 2018, doi:10.1117/1.JMI.5.1.015006.
    """
    if samples > 0 and rng is None:
        raise ValueError("points are drawn with a generator: give rng")
    for surface in (first, second):
        if not surface.area > 0:
            raise InvalidInput("invalid_mesh", f"A surface of {len(surface.faces)} faces has no area to compare.")
    found = []
    for source, target in ((first, second), (second, first)):
        if samples > 0 and rng is not None:
            points = sample_surface(source, samples, rng).points
            weights = np.full(samples, source.area / samples)
        else:
            used = source.topology.referenced
            points, weights = source.vertices[used], vertex_areas(source)[used]
        found.append((closest_points(target, points).distances, weights))
    total = sum(float(weights.sum()) for _, weights in found)
    return SurfaceDistances(
        assd=sum(float(distances @ weights) for distances, weights in found) / total,
        hd95=max(_percentile(distances, weights, 0.95) for distances, weights in found),
        hausdorff=max(float(distances.max()) for distances, _ in found),
    )


def _percentile(values: NDArray[np.float64], weights: NDArray[np.float64], share: float) -> float:
    """Return the least value below or at which lies `share` of the weight."""
    order = np.argsort(values, kind="stable")
    cumulative = np.cumsum(weights[order])
    place = int(np.searchsorted(cumulative, share * cumulative[-1], side="left"))
    return float(values[order[min(place, len(order) - 1)]])
