"""The middle of vessels: branches with their radii, from voxels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from shapery_geometry.volume import Volume
from shapery_segmentation.vessels import _centerline_kernels as kernels
from shapery_segmentation.vessels._border_kernels import NEIGHBOURS

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

COVERED = 1.3
"""Radii around a centerline that belong to it; what sticks out further is a branch."""

JOINING = 0.6
"""Radii around a centerline within which another one joins it."""

LEAST_LENGTH = 2.0
"""Radii of the vessel it leaves by which a branch must stick out of it."""

WINDOW = 2
"""Points before and after one over which place and radius are averaged."""


@dataclass(frozen=True, eq=False)
class Branch:
    """A piece of vessel between two ends or forks.

    Parameters
    ----------
    points : (n, 3) float64
        Along its middle, RAS mm.
    radii : (n,) float64
        mm: of the circle with the area of the cross-section.
    tree
        Number of the connected tree it belongs to, from 0.
    """

    points: FloatArray
    radii: FloatArray
    tree: int

    @property
    def length(self) -> float:
        """Mm along the middle."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


def find_centerlines(mask: BoolArray, grid: Volume) -> tuple[Branch, ...]:
    """Return the branches of vessels, tree by tree, the largest first.

    Parameters
    ----------
    mask : (I, J, K) bool
        The inside of vessels.
    grid
        The volume on whose grid the mask lies.

    Notes
    -----
    In every connected part the path from its far end to each other end runs where it is cheapest, at a cost of one over
    the squared distance from the wall, which keeps it in the middle. Ends are taken by falling distance among the
    voxels that no path so far lies near. Then points move to the mean of the voxels nearest to them, which are also
    counted for the area of the cross-section: both are good to a fraction of a voxel. A tree is all it can give: a loop
    is cut where its two ways meet.

    References
    ----------
    M. Sato et al., "TEASAR: tree-structure extraction algorithm for accurate and robust skeletons", Pacific Graphics
    2000, doi:10.1109/PCCGA.2000.883951, with a local cost.
    """
    if not mask.any():
        return ()
    index = np.argwhere(mask)
    low = index.min(axis=0) - 1
    box = np.pad(mask[tuple(slice(a, b) for a, b in zip(low + 1, index.max(axis=0) + 1, strict=True))], 1)
    spacing = np.array(grid.spacing)
    parts, count = ndimage.label(box, np.ones((3, 3, 3)))
    sizes = np.bincount(parts.ravel(), minlength=count + 1)[1:]
    voxels = np.argwhere(box).astype(np.int32)
    ranks = np.full(box.shape, -1, dtype=np.int32)
    ranks[tuple(voxels.T)] = np.arange(len(voxels), dtype=np.int32)
    of_part = parts[tuple(voxels.T)] - 1
    by_part = np.split(np.argsort(of_part, kind="stable"), np.cumsum(np.bincount(of_part, minlength=count))[:-1])
    cut = ((voxels + low == 0) | (voxels + low == np.array(mask.shape) - 1)).any(axis=1)
    inner = _depths(ranks, voxels, spacing, -low, np.array(mask.shape) - low)
    steps = NEIGHBOURS
    lengths = np.linalg.norm(steps * spacing, axis=1)
    centers = grid.to_world(voxels + low)
    branches: list[Branch] = []
    for tree, part in enumerate(np.argsort(-sizes, kind="stable")):
        paths = _paths(ranks, voxels, inner, by_part[part], steps, lengths, spacing, cut)
        if paths:
            branches += _measured(paths, centers, by_part[part], inner, grid.voxel_volume, tree)
    return tuple(branches)


def _depths(
    ranks: NDArray[np.int32], voxels: NDArray[np.int32], spacing: FloatArray, first: IntArray, end: IntArray
) -> FloatArray:
    """Return the distance (n,) in mm of each voxel from the nearest one outside; memory follows the surface.

    Beyond the volume, whose first voxel is `first` and whose past-the-end one `end`, nothing is outside: there the
    vessel goes on.
    """
    outside = []
    for step in NEIGHBOURS:
        beside = voxels + step.astype(np.int32)
        outside.append(beside[(ranks[tuple(beside.T)] < 0) & ((beside >= first) & (beside < end)).all(axis=1)])
    if not sum(len(part) for part in outside):
        return np.full(len(voxels), float(spacing.max()))
    code = np.unique(np.ravel_multi_index(tuple(np.concatenate(outside).T), ranks.shape))
    rim = np.stack(np.unravel_index(code, ranks.shape), axis=1)
    distance, _ = cKDTree(rim * spacing).query(voxels * spacing)
    return np.asarray(distance, dtype=np.float64)


def _paths(
    ranks: NDArray[np.int32], voxels: NDArray[np.int32], depth: FloatArray, members: IntArray, steps: IntArray,
    lengths: FloatArray, spacing: FloatArray, cut: BoolArray,
) -> list[IntArray]:  # fmt: skip
    """Return the paths of one tree, split at forks, as ranks of voxels."""
    n = len(voxels)
    distance, parent = np.empty(n), np.empty(n, dtype=np.int32)

    def spread(cost: FloatArray, source: int) -> None:
        kernels.shortest_paths(ranks, voxels, steps, lengths, cost, np.array([source]), distance, parent)

    plain = np.ones(n)
    deepest = int(members[np.argmax(depth[members])])
    spread(plain, deepest)
    at_cut = members[cut[members]]

    def centered(end: int) -> int:
        """Return the middle of the cross-section that the volume's border cuts, where the end lies in one."""
        if not cut[end]:
            return end
        near = at_cut[np.linalg.norm((voxels[at_cut] - voxels[end]) * spacing, axis=1) <= 2.5 * depth[at_cut]]
        if not len(near):
            return end
        deep = near[depth[near] >= 0.8 * depth[near].max()]
        places = voxels[deep] * spacing
        return int(deep[np.argmin(np.linalg.norm(places - places.mean(axis=0), axis=1))])

    root = centered(int(members[np.argmax(distance[members])]))
    spread(plain, root)
    far = distance.copy()
    # Relative to the voxel, so that the cost does not depend on the unit; the wall's own voxels have half a voxel.
    spread(1.0 / np.square(depth / spacing.min()), root)

    covered, joining = np.full(n, -1, dtype=np.int64), np.full(n, -1, dtype=np.int64)
    paths: list[IntArray] = []
    order = members[np.argsort(-far[members], kind="stable")]
    for end in order:
        if covered[end] >= 0:
            continue
        path = [centered(int(end))]
        while parent[path[-1]] >= 0 and joining[path[-1]] < 0:
            path.append(int(parent[path[-1]]))
        if joining[path[-1]] >= 0 and joining[path[-1]] != path[-1]:
            # Near another path: from here on they would run side by side.
            path.append(int(joining[path[-1]]))
        line = np.array(path, dtype=np.int64)
        if paths:
            joint = line[-1]
            way = _arc(voxels[line] * spacing)
            out = way[-1] - depth[joint] - depth[line[len(line) // 2]]
            if len(line) < 4 or out < (LEAST_LENGTH - 1.0) * depth[line[: len(line) // 2 + 1]].max():
                kernels.cover(ranks, voxels, line, COVERED * depth[line] + spacing.max(), spacing, covered)
                continue
        kernels.cover(ranks, voxels, line, COVERED * depth[line] + spacing.max(), spacing, covered)
        joining[line] = line
        kernels.cover(ranks, voxels, line, JOINING * depth[line], spacing, joining)
        paths.append(line)
    return _split(paths, depth, voxels * spacing, cut)


def _split(paths: list[IntArray], depth: FloatArray, places: FloatArray, cut: BoolArray) -> list[IntArray]:
    """Cut paths where others join them, and their free ends where the wall begins to close in on them."""
    joints = {int(path[-1]) for path in paths[1:]}
    pieces: list[IntArray] = []
    for number, path in enumerate(paths):
        if not cut[path[0]]:
            path = _trimmed(path, depth, places)
        if number == 0 and not cut[path[-1]]:
            path = _trimmed(path[::-1], depth, places)[::-1]
        cuts = [at for at in range(1, len(path) - 1) if int(path[at]) in joints]
        for first, last in zip([0, *cuts], [*cuts, len(path) - 1], strict=True):
            if last > first:
                pieces.append(path[first : last + 1])
    return pieces


def _trimmed(path: IntArray, depth: FloatArray, places: FloatArray) -> IntArray:
    """Return the path without the beginning, where it is nearer to the end of the vessel than to its side."""
    way = _arc(places[path])
    within = np.flatnonzero(way >= depth[path])
    return path[within[0] :] if len(within) and len(path) - within[0] >= 3 else path


def _measured(
    paths: list[IntArray], centers: FloatArray, members: IntArray, depth: FloatArray, voxel: float, tree: int
) -> list[Branch]:
    """Return the branches with their points moved to the middle, and radii."""
    lines = [_averaged(centers[path], 2) for path in paths]
    ends = [(path[0], path[-1]) for path in paths]
    for final in (False, True):
        points = np.concatenate(lines)
        start = np.cumsum([0] + [len(line) for line in lines])
        _, nearest = cKDTree(points).query(centers[members])
        count = np.asarray(np.bincount(nearest, minlength=len(points)), dtype=np.float64)
        sums = np.stack([np.bincount(nearest, centers[members][:, a], len(points)) for a in range(3)], axis=1)
        moved, radii = [], []
        for number, line in enumerate(lines):
            own = slice(start[number], start[number + 1])
            amount, total = _windowed(count[own]), _windowed(sums[own].astype(np.float64))
            place = np.where(amount[:, None] > 0, total / np.maximum(amount, 1e-9)[:, None], line)
            # Across only: along, the nearest voxels of an end lie beyond it.
            along = np.gradient(line, axis=0) if len(line) > 1 else np.zeros_like(line)
            along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
            way = place - line
            way -= (way * along).sum(axis=1, keepdims=True) * along
            limit = 0.5 * depth[paths[number]]
            size = np.linalg.norm(way, axis=1)
            way *= np.minimum(1.0, limit / np.maximum(size, 1e-9))[:, None]
            way[[0, -1]] *= 0.5
            moved.append(_averaged(line + way, 1))
            if final:
                length = _windowed(_spans(line))
                area = amount * voxel / np.maximum(length, 1e-9)
                radius = np.sqrt(area / np.pi)
                # Forks and caps hold voxels that belong to no cross-section: there the neighbours tell.
                radius[: WINDOW + 1] = radius[min(WINDOW + 1, len(line) - 1)]
                radius[-WINDOW - 1 :] = radius[max(len(line) - WINDOW - 2, 0)]
                radii.append(np.clip(radius, 0.8 * depth[paths[number]], 2.0 * depth[paths[number]] + voxel ** (1 / 3)))
        lines = moved
    # Branches that meet still meet.
    shared: dict[int, list[FloatArray]] = {}
    for line, (first, last) in zip(lines, ends, strict=True):
        shared.setdefault(int(first), []).append(line[0].copy())
        shared.setdefault(int(last), []).append(line[-1].copy())
    found = []
    for line, (first, last), radius in zip(lines, ends, radii, strict=True):
        line[0], line[-1] = np.mean(shared[int(first)], axis=0), np.mean(shared[int(last)], axis=0)
        found.append(Branch(line, radius, tree))
    return found


def _arc(points: FloatArray) -> FloatArray:
    return np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))


def _spans(points: FloatArray) -> FloatArray:
    """Return the length of line that belongs to each point."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return 0.5 * (np.concatenate((step, [0.0])) + np.concatenate(([0.0], step)))


def _windowed(values: FloatArray) -> FloatArray:
    """Return sums over each entry and its neighbours."""
    total = np.cumsum(np.concatenate((np.zeros((1, *values.shape[1:])), values)), axis=0)
    n = len(values)
    high = np.minimum(np.arange(n) + WINDOW + 1, n)
    low = np.maximum(np.arange(n) - WINDOW, 0)
    return np.asarray(total[high] - total[low])


def _averaged(points: FloatArray, rounds: int) -> FloatArray:
    """Return the points moved half-way to the mean of their neighbours, the ends held."""
    points = points.copy()
    for _ in range(rounds):
        points[1:-1] = 0.5 * points[1:-1] + 0.25 * (points[:-2] + points[2:])
    return points
