"""The vessels of a volume: seeded, tracked, fitted, measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.volume import Reorientation, Volume
from shapery_segmentation.vessels.border import Border, find_border, within
from shapery_segmentation.vessels.centerline import Branch, find_centerlines
from shapery_segmentation.vessels.evidence import Evidence, gather_evidence
from shapery_segmentation.vessels.fit import half_covered
from shapery_segmentation.vessels.outside import measured
from shapery_segmentation.vessels.tracking import edge_length, relative_box, track_tree

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

REACH = 12.0
"""mm around a tumor within which vessels are seeded; once found they are followed as far as they go."""

LARGEST_SHARE, LARGEST_COUNT = 0.25, 20_000_000
"""Share of what was measured of the volume, and voxels, that vessels may fill; more has leaked."""

LEAST_VOXELS = 30
"""Voxels below which a tree is not looked at."""

LEAST_EXTENT = (8.0, 5.0)
"""A tree is a vessel if it is at least so many voxels, and so many of its mean radii, long."""

LEAST_TREE = 0.004
"""Volume of a tree, relative to the largest, below which it is left out if no seed was given for it."""

SNAP = 3
"""Voxels within which a seed that was given moves to the vessel's middle."""


@dataclass(frozen=True, eq=False)
class VesselTree:
    """One connected vessel.

    Parameters
    ----------
    surface
        Closed, manifold, oriented, without self-intersections, RAS mm.
    branches
        See `shapery_segmentation.vessels.centerline.Branch`.
    volume_mm3
        Inside the surface.
    model
        The flow that made it, see `shapery_segmentation.vessels.tracking.Tracked`.
    """

    surface: TriangleMesh
    branches: tuple[Branch, ...]
    volume_mm3: float
    model: Literal["tangential", "normal", "rebuilt"]

    @property
    def length_mm(self) -> float:
        """Sum over the branches."""
        return sum(branch.length for branch in self.branches)

    @property
    def forks(self) -> int:
        """Points where three or more branches meet."""
        ends = [tuple(np.round(b.points[at], 6)) for b in self.branches for at in (0, -1)]
        _, counts = np.unique(np.array(ends).reshape(-1, 3), axis=0, return_counts=True)
        return int(np.count_nonzero(counts > 2))

    @property
    def mean_radius_mm(self) -> float:
        """Over the length."""
        return _weighted([b.radii for b in self.branches], [b.points for b in self.branches])

    @property
    def radius_range_mm(self) -> tuple[float, float]:
        """Least and largest."""
        radii = np.concatenate([b.radii for b in self.branches])
        return float(radii.min()), float(radii.max())


@dataclass(frozen=True, eq=False)
class Vessels:
    """What `segment_vessels` found.

    Parameters
    ----------
    mask : (I, J, K) bool
        Voxels inside vessels, on the grid of the volume that was given.
    trees
        By falling volume.
    polarity
        Whether vessels were taken for bright or for dark.
    warnings
        Sentences for the user.
    """

    mask: BoolArray
    trees: tuple[VesselTree, ...]
    polarity: Literal["bright", "dark"]
    warnings: tuple[str, ...] = ()

    @property
    def surfaces(self) -> tuple[TriangleMesh, ...]:
        """One per tree."""
        return tuple(tree.surface for tree in self.trees)

    @property
    def branches(self) -> tuple[Branch, ...]:
        """Of all trees."""
        return tuple(branch for tree in self.trees for branch in tree.branches)


def segment_vessels(
    volume: Volume,
    seeds: Sequence[ArrayLike] | None = None,
    *,
    around: BoolArray | None = None,
    polarity: Literal["auto", "bright", "dark"] = "auto",
    max_trees: int = 16,
    check_cancelled: Callable[[], None] | None = None,
) -> Vessels:
    """Recover the surfaces of blood vessels.

    Parameters
    ----------
    volume
        SWI (veins are dark), MRA, time-of-flight or CTA (arteries are bright); any spacing and orientation.
    seeds
        Points (3,) in RAS mm in vessels; found automatically if none are given.
    around : (I, J, K) bool
        On the grid of `volume`: seeds are looked for within 12 mm of it, and vessels don't enter it (a tumor). Without
        it they are looked for everywhere.
    polarity
        ``auto``: whichever of bright and dark tubes are stronger in the data.
    max_trees
        Connected vessels that are returned at the most; the largest ones.
    check_cancelled
        Called several times a second; what it raises ends the work and passes through.

    Returns
    -------
    Vessels
        Without trees, and with a warning, where there are none.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` where all voxels are alike or not finite, ``grid_mismatch`` where `around` has another shape,
        ``invalid_params`` for seeds outside the volume, ``no_object_found`` where none of the seeds given lies in a
        vessel, or what they lie in is no vessel but a large part of the volume.

    Notes
    -----
    The result does not depend on the order in which the volume's axes are stored. Memory is about 20 bytes per voxel;
    time grows with the surface, but for one look at every voxel.

    References
    ----------
    Sections 3.4.2, 3.4.3 and 3.5.3 of the dissertation.
    """
    check = check_cancelled if check_cancelled is not None else _nothing
    if around is not None and around.shape != volume.shape:
        raise InvalidInput(
            "grid_mismatch", f"The region has the shape {around.shape}, the volume with the vessels {volume.shape}."
        )
    canonical, order = volume.canonical()
    values, outside = measured(canonical)
    if float(values.max()) <= float(values.min()):
        raise InvalidInput("invalid_volume", "All voxels of the volume with the vessels have the same value.")
    grid = Volume(values, canonical.affine)
    region = None if around is None else np.ascontiguousarray(order.apply_array(around))
    where = None if region is None else _near(region, grid)
    if outside is not None:
        where = ~outside if where is None else where & ~outside
        blocked = outside if region is None else outside | region
    else:
        blocked = region
    check()

    evidence = gather_evidence(values, grid.spacing, polarity, where, outside)
    check()
    start = evidence.seeds if where is None or seeds else evidence.seeds[where[tuple(evidence.seeds.T)]]
    if region is not None and len(start):
        start = start[~region[tuple(start.T)]]
    if seeds:
        start = _given(seeds, grid, evidence)
    warnings = list(volume.warnings)
    if not len(start):
        warnings.append("No vessels were found; check the polarity, or give a seed in one.")
        return Vessels(np.zeros(volume.shape, dtype=np.bool_), (), evidence.polarity, tuple(warnings))

    there = values.size if outside is None else int(np.count_nonzero(~outside))
    most = min(LARGEST_COUNT, int(LARGEST_SHARE * there))
    border = find_border(evidence, start, most=most, blocked=blocked)
    check()
    if len(border.voxels) >= most:
        leaked = f"What was taken for {evidence.polarity} vessels has leaked into other tissue: it fills more than "
        leaked += f"{100.0 * most / there:.0f} % of what was measured."
        if seeds:
            raise InvalidInput(
                "no_object_found", leaked, "Place seeds in the middle of vessels, and check the polarity."
            )
        warnings.append(f"{leaked} No vessels are shown; check the polarity, or give a seed in one.")
        return Vessels(np.zeros(volume.shape, dtype=np.bool_), (), evidence.polarity, tuple(warnings))
    trees, mask = _trees(evidence, border, grid, max_trees, seeds is not None and len(seeds) > 0, check)
    if not trees:
        if seeds:
            raise InvalidInput(
                "no_object_found",
                f"No vessel was reached from the {len(seeds)} seeds given.",
                f"Place seeds in the middle of vessels; they were taken for {evidence.polarity}.",
            )
        warnings.append("No vessels were found; check the polarity, or give a seed in one.")
    return Vessels(_given_order(mask, order), tuple(trees), evidence.polarity, tuple(warnings))


def _trees(
    evidence: Evidence, border: Border, grid: Volume, max_trees: int, given: bool, check: Callable[[], None]
) -> tuple[list[VesselTree], BoolArray]:
    """Return the trees by falling volume, and the voxels in them."""
    mask = np.zeros(grid.shape, dtype=np.bool_)
    if not len(border.voxels):
        return [], mask
    field = relative_box(evidence, border, grid)
    check()
    labels, count = ndimage.label(field.depth > 0, np.ones((3, 3, 3)))
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    sizes[0] = 0
    least = max(LEAST_VOXELS, 0 if given else LEAST_TREE * sizes.max())
    places = ndimage.find_objects(labels)
    trees: list[VesselTree] = []
    for label in np.argsort(-sizes, kind="stable"):
        if sizes[label] < least or len(trees) == max_trees:
            break
        check()
        place = places[label - 1]
        part = np.pad(labels[place] == label, 1)
        corner = np.array([s.start - 1 for s in place])
        affine = field.affine.copy()
        affine[:3, 3] += affine[:3, :3] @ corner
        rough = find_centerlines(part, Volume(part, affine))
        if not _is_vessel(rough, grid, int(sizes[label])):
            continue
        radii = np.concatenate([branch.radii for branch in rough])
        wall = 2.0 * np.pi * float(radii.mean()) * sum(branch.length for branch in rough)
        wall = max(wall, _wall(part, grid))
        edge = edge_length(grid, float(np.percentile(radii, 10)), wall)
        tracked = track_tree(
            np.argwhere(part) + corner + field.low, field, edge, evidence, border, grid, check_cancelled=check
        )
        inside = half_covered(tracked.surface, grid)
        check()
        branches = find_centerlines(inside & ~mask, grid)
        mask |= inside
        if branches:
            trees.append(VesselTree(tracked.surface, branches, float(tracked.surface.volume), tracked.model))
    return trees, mask


def _wall(part: BoolArray, grid: Volume) -> float:
    """Return about how many mm² of wall a region has: of a slanted one, voxels show half as much again."""
    area = 0.0
    for axis in range(3):
        across = np.abs(np.cross(grid.affine[:3, (axis + 1) % 3], grid.affine[:3, (axis + 2) % 3]))
        steps = np.moveaxis(part, axis, 0)
        area += float(np.linalg.norm(across)) * np.count_nonzero(steps[1:] != steps[:-1])
    return area / 1.5


def _is_vessel(branches: tuple[Branch, ...], grid: Volume, voxels: int) -> bool:
    """Return whether a region is long for its thickness."""
    if not branches:
        return False
    voxel = grid.voxel_volume ** (1 / 3)
    length = sum(b.length for b in branches)
    radius = np.sqrt(voxels * grid.voxel_volume / (np.pi * max(length, voxel)))
    return bool(length >= LEAST_EXTENT[0] * voxel and length >= LEAST_EXTENT[1] * radius)


def _near(region: BoolArray, grid: Volume) -> BoolArray:
    """Return the voxels within `REACH` of a region."""
    if not region.any():
        raise InvalidInput("invalid_params", "The region around which to look for vessels is empty.")
    return within(region, grid.spacing, REACH)


def _given(seeds: Sequence[ArrayLike], grid: Volume, evidence: Evidence) -> NDArray[np.int64]:
    """Return the voxels of seeds, each moved to the brightest smoothed value nearby."""
    points = np.array([np.asarray(seed, dtype=np.float64) for seed in seeds]).reshape(len(seeds), -1)
    if points.shape[1] != 3 or not np.isfinite(points).all():
        raise InvalidInput("invalid_params", "Seeds are points of three finite numbers, RAS mm.")
    outside = ~grid.contains(points)
    if outside.any():
        raise InvalidInput(
            "invalid_params",
            f"The seed {points[outside][0].round(1).tolist()} lies outside the volume with the vessels.",
            "Seeds are given in RAS mm.",
        )
    found = []
    for index in np.clip(np.rint(grid.to_index(points)), 0, np.array(grid.shape) - 1).astype(np.int64):
        low = np.maximum(index - SNAP, 0)
        part = evidence.smoothed[tuple(slice(a, b + SNAP + 1) for a, b in zip(low, index, strict=True))]
        found.append(low + np.array(np.unravel_index(int(part.argmax()), part.shape)))
    return np.array(found, dtype=np.int64)


def _given_order(mask: BoolArray, order: Reorientation) -> BoolArray:
    return np.ascontiguousarray(order.undo_array(mask))


def _weighted(values: list[FloatArray], lines: list[FloatArray]) -> float:
    total = weight = 0.0
    for value, line in zip(values, lines, strict=True):
        step = np.linalg.norm(np.diff(line, axis=0), axis=1)
        total += float((0.5 * (value[:-1] + value[1:]) * step).sum())
        weight += float(step.sum())
    return total / weight if weight else 0.0


def _nothing() -> None:
    return None
