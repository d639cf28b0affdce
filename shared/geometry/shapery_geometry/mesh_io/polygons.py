"""What mesh files hold, polygons, and how they become triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats.model import corrupt
from shapery_geometry.mesh import TriangleMesh, checked_vertices
from shapery_geometry.mesh_io.limits import MeshLimits

_MOST_CONCAVE: Final = 1000
"""Corners of a concave polygon; clipping its ears takes the square of their number."""


@dataclass(frozen=True, eq=False)
class PolygonMesh:
    """What a reader found, before polygons are cut."""

    vertices: NDArray[np.float64]
    """(n, 3)."""
    corners: NDArray[np.int64]
    """(c,) vertex indices of all polygons one after another."""
    counts: NDArray[np.int64]
    """(p,) number of corners of each polygon, c in sum."""

    @classmethod
    def of_triangles(cls, vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> PolygonMesh:
        """Return triangles (m, 3) in this form."""
        return cls(vertices, triangles.reshape(-1), np.full(len(triangles), 3, dtype=np.int64))

    def triangulated(self, limits: MeshLimits) -> TriangleMesh:
        """Return the mesh of triangles; see `triangulated`."""
        vertices = checked_vertices(self.vertices)
        return TriangleMesh(vertices, triangulated(self.corners, self.counts, vertices, limits))


def triangulated(
    corners: NDArray[np.int64], counts: NDArray[np.int64], vertices: NDArray[np.float64], limits: MeshLimits
) -> NDArray[np.int64]:
    """Cut polygons into triangles over the same vertices.

    Parameters
    ----------
    corners : (c,) int64
        Vertex indices of all polygons one after another.
    counts : (p,) int64
        Number of corners of each polygon, c in sum.
    vertices : (n, 3) float64
        What the indices name.
    limits
        The number of triangles is checked before they are made.

    Returns
    -------
    (m, 3) int64
        In the order and the orientation of the polygons: one triangle for each corner above two. Convex polygons are
        cut from their first corner, concave ones so that no triangle lies outside.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` for less than three corners, ``invalid_mesh`` for indices out of range, ``unsupported_format``
        for concave polygons of very many corners.
    LimitExceeded
        ``too_large``.
    """
    if len(counts) and counts.min() < 3:
        bad = int(np.flatnonzero(counts < 3)[0])
        raise corrupt(f"Face {bad} has {int(counts[bad])} corners; a face needs at least 3.")
    check_range(corners, counts, len(vertices))
    limits.check(faces=int((counts - 2).sum()))
    if not len(counts) or counts.max() == 3:
        return corners.reshape(-1, 3)
    starts = np.cumsum(counts) - counts
    # fans: the k-th triangle of a polygon is (0, k + 1, k + 2)
    first = np.cumsum(counts - 2) - (counts - 2)
    owner = np.repeat(np.arange(len(counts)), counts - 2)
    step = np.arange(len(owner)) - first[owner]
    base = starts[owner]
    triangles = np.stack((corners[base], corners[base + step + 1], corners[base + step + 2]), axis=1)
    large = counts > 3
    bad_fans = _concave(triangles, owner, large, vertices)
    for polygon in np.flatnonzero(bad_fans).tolist():
        count, at = int(counts[polygon]), int(first[polygon])
        loop = corners[starts[polygon] : starts[polygon] + count]
        triangles[at : at + count - 2] = loop[_clip_ears(vertices[loop])]
    return triangles


def check_range(corners: NDArray[np.int64], counts: NDArray[np.int64], vertex_count: int) -> None:
    """Refuse the first face that names a vertex that does not exist."""
    wrong = (corners < 0) | (corners >= vertex_count)
    if wrong.any():
        at = int(np.flatnonzero(wrong)[0])
        face = int(np.searchsorted(np.cumsum(counts), at, side="right"))
        raise InvalidInput(
            "invalid_mesh",
            f"Face {face} names vertex {int(corners[at])}, and the file has {vertex_count} vertices (counted from 0).",
            "Check the file with the program that wrote it, and send it again.",
        )


def _concave(
    triangles: NDArray[np.int64], owner: NDArray[np.int64], large: NDArray[np.bool_], vertices: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """(p,) whether some triangle of a polygon's fan looks the other way than the polygon."""
    result = np.zeros(len(large), dtype=bool)
    rows = np.flatnonzero(large[owner])
    a, b, c = (vertices[triangles[rows, k]] for k in range(3))
    with np.errstate(all="ignore"):
        normals = np.cross(b - a, c - a)
        sums = np.stack([np.bincount(owner[rows], normals[:, k], len(large)) for k in range(3)], axis=1)
        against = np.einsum("ij,ij->i", normals, sums[owner[rows]]) < 0
    result[owner[rows[against]]] = True
    return result


def _clip_ears(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Cut a polygon into triangles by clipping ears, seen along its mean normal.

    References
    ----------
    G. H. Meisters, Polygons have ears, The American Mathematical Monthly 82, 1975, doi:10.2307/2319703.
    """
    n = len(points)
    if n > _MOST_CONCAVE:
        raise InvalidInput(
            "unsupported_format",
            f"A face is a concave polygon of {n} corners; at most {_MOST_CONCAVE} are read.",
            "Triangulate the mesh with the program that wrote it.",
        )
    centred = points - points.mean(axis=0)
    normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    axis = int(np.argmax(np.abs(normal)))
    x, y = (axis + 1) % 3, (axis + 2) % 3
    flat = centred[:, [x, y]] if normal[axis] > 0 else centred[:, [y, x]]
    ring = list(range(n))
    triangles = []
    while len(ring) > 3:
        shape = flat[ring]
        before, after = np.roll(shape, 1, axis=0), np.roll(shape, -1, axis=0)
        turn = _turn(before, shape, after)
        ears = np.flatnonzero(turn > 0)
        chosen = -1
        for k in ears.tolist():
            p, q, r = before[k], shape[k], after[k]
            others = np.delete(shape, [k - 1, k, (k + 1) % len(ring)], axis=0)
            inside = (_turn(p, q, others) >= 0) & (_turn(q, r, others) >= 0) & (_turn(r, p, others) >= 0)
            # a corner at the place of p or r is where the polygon touches itself, and hides nothing
            same = (others == p).all(axis=1) | (others == r).all(axis=1)
            if not (inside & ~same).any():
                chosen = k
                break
        if chosen < 0:
            # straight corners first; else the polygon crosses itself, and no cut is right
            straight = np.flatnonzero(turn == 0)
            chosen = int(straight[0]) if len(straight) else int(ears[0]) if len(ears) else 0
        triangles.append((ring[chosen - 1], ring[chosen], ring[(chosen + 1) % len(ring)]))
        del ring[chosen]
    triangles.append((ring[0], ring[1], ring[2]))
    return np.array(triangles, dtype=np.int64)


def _turn(p: NDArray[np.float64], q: NDArray[np.float64], r: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(
        (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])
    )
