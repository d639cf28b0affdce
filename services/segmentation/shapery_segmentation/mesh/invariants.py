"""What must hold of a dynamic mesh after every operation, checked plainly and slowly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapery_segmentation.mesh.arrays import (
    AFTER,
    AREA,
    BEFORE,
    CELL,
    CORNER,
    FACE_COUNT,
    FACE_TOP,
    FREE_FACE,
    FREE_VERTEX,
    NORMAL,
    ORIGIN,
    OUT,
    RADIUS,
    SKIP,
    TWIN,
    VERTEX_COUNT,
    VERTEX_TOP,
    MeshArrays,
)
from shapery_segmentation.mesh.dynamic_mesh import DynamicMesh


def defects(mesh: DynamicMesh) -> list[str]:
    """Return what is wrong with a dynamic mesh, as sentences; nothing if it is sound.

    Notes
    -----
    Checked are: twins are mutual and run the other way; no edge occurs twice; every vertex has one fan of faces; free
    slots are exactly those in the free lists; what is derived from positions (centroids, normals, areas, grid) is up to
    date; positions are float32 values; nothing touches.
    """
    m = mesh.arrays
    found: list[str] = []
    vertices, faces = int(m.layout[VERTEX_TOP]), int(m.layout[FACE_TOP])
    out = m.vertices[:vertices, OUT]
    origin, twins = m.half_edges[: 3 * faces, ORIGIN], m.half_edges[: 3 * faces, TWIN]
    corners = origin.reshape(-1, 3)
    live, used = np.flatnonzero(corners[:, 0] >= 0), np.flatnonzero(out >= 0)
    if _chain(corners[:, 0], int(m.layout[FREE_FACE])) != set(np.flatnonzero(corners[:, 0] < 0).tolist()):
        found.append("the free faces are not those in the list")
    if _chain(out, int(m.layout[FREE_VERTEX])) != set(np.flatnonzero(out < 0).tolist()):
        found.append("the free vertices are not those in the list")
    if len(live) != m.layout[FACE_COUNT] or len(used) != m.layout[VERTEX_COUNT]:
        found.append("vertices or faces are counted wrongly")

    half_edges = (3 * live[:, None] + np.arange(3)).ravel()
    start = origin[half_edges]
    end = np.roll(corners[live], -1, axis=1).ravel()
    twin = twins[half_edges]
    destination = np.full(3 * faces, -1, dtype=np.int64)
    destination[half_edges] = end
    if (twin < 0).any() or not np.array_equal(twins[twin], half_edges):
        found.append("twins are not mutual")
        return found
    if not np.array_equal(origin[twin], end) or not np.array_equal(destination[twin], start):
        found.append("a twin does not run the other way")
    if len(np.unique(np.stack((start, end)), axis=1).T) != len(start):
        found.append("an edge occurs twice in one direction")
    if (start == end).any():
        found.append("an edge starts where it ends")

    if not np.array_equal(np.unique(start), used):
        found.append("vertices in use and vertices of faces differ")
    if not np.array_equal(origin[out[used]], used):
        found.append("an outgoing half-edge starts elsewhere")
    # All vertices turn around their fans at once; those that are back wait.
    at, count = out[used].astype(np.int64), np.ones(len(used), dtype=np.int64)
    turning = np.ones(len(used), dtype=np.bool_)
    while turning.any() and count.max() <= len(start):
        at = np.where(turning, twins[np.where(at % 3 == 0, at + 2, at - 1)], at)
        turning &= at != out[used]
        count += turning
    if not np.array_equal(count, np.bincount(start, minlength=vertices)[used]):
        found.append("the faces of a vertex form more than one fan")

    p = m.points[corners[live], :3]
    center = p.mean(axis=1)
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    length = np.linalg.norm(normal, axis=1)
    expected = np.empty((len(live), AREA + 1))
    expected[:, :3] = center
    expected[:, RADIUS] = np.linalg.norm(p - center[:, None], axis=2).max(axis=1)
    expected[:, NORMAL : NORMAL + 3] = normal / np.where(length > 0, length, 1.0)[:, None]
    expected[:, AREA] = 0.5 * length
    # Kept in single precision; the normals of needles lose digits to cancellation before that.
    if not np.allclose(m.facets[live, : AREA + 1], expected, rtol=1e-5, atol=1e-6 * (1.0 + float(np.abs(p).max()))):
        found.append("what is known of a face is not what its corners say")
    if not np.array_equal(m.links[live, CORNER : CORNER + 3], corners[live]):
        found.append("the vertices noted for a face are not those of its half-edges")
    if (length == 0).any():
        found.append("a face has no area")
    if not np.array_equal(m.points[used, :3], m.points[used, :3].astype(np.float32)):
        found.append("a position is not a float32 value")

    found += _grid_defects(m, live)
    if m.links[:faces, SKIP].any():
        found.append("a face is still marked as about to be replaced")
    contacts = mesh.contacts()
    if contacts:
        found.append(f"{contacts} faces touch others")
    return found


def _chain(column: NDArray[np.int32], first: int) -> set[int]:
    """Return the slots of a free list that runs through `column` from `first`."""
    slots: set[int] = set()
    while first >= 0 and first not in slots:
        slots.add(first)
        first = -2 - int(column[first])
    return slots


def _grid_defects(m: MeshArrays, live: NDArray[np.intp]) -> list[str]:
    """Return what is wrong with the grid's lists of faces."""
    listed: list[int] = []
    for cell in np.flatnonzero(m.head >= 0).tolist():
        f, previous = int(m.head[cell]), -1
        while f >= 0:
            listed.append(f)
            if m.links[f, CELL] != cell or m.links[f, BEFORE] != previous:
                return [f"face {f} is linked wrongly in cell {cell}"]
            f, previous = int(m.links[f, AFTER]), f
    # The grid is filled when operations begin.
    if listed and sorted(listed) != live.tolist():
        return ["the faces in the grid are not those in use"]
    return []
