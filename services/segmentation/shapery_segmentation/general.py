"""Any object that the user points at, in any volume: nothing of a head is assumed (the general mode).

What the object is follows from the data around the seed:

1. **Region.** From a seed a region grows, voxel by voxel: the next is the one that a path reaches at the least cost,
   which is the length and how unlike the seed's the values on it are. So it fills the object first, and leaks late. Of
   all stages the one is taken that hangs together least with the rest, for its size: the links between neighbours
   across its border, weaker where there is an edge, over the volume to the power 2/3. That is the isoperimetric ratio
   (Grady and Schwartz, 2006), which asks for a short border on edges, at any size. Then what surrounds the box and what
   is known of the object compete for the voxels (`competition`): in the user's box its middle, or what is around the
   seed; without one the region, in a box a little larger than itself.
2. **Polarity.** The voxels around the region tell what the object borders on: darker tissue, brighter, or both. The
   border lies half-way to each, where partial volume puts it (`borders`).
3. **Flow.** U is the distance to the nearer of these borders in units of the noise, positive inside; the density gate
   of the tumor's way keeps the surface out of leaks, and the normal flow does the rest. In a box where no two values
   tell the object from what is around it, U is the logarithm of the odds that the competition gives.

References
----------
Section 3.4.1 of the dissertation. L. Grady and E. L. Schwartz, "Isoperimetric graph partitioning for image
segmentation", IEEE TPAMI 28 (2006), doi:10.1109/TPAMI.2006.57.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_contracts.segmentation import SegmentationParams
from shapery_geometry.intersections import self_intersections
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation._flood_kernels import grow
from shapery_segmentation.borders import Polarity, borders
from shapery_segmentation.competition import around, compete
from shapery_segmentation.evolution import Recorder, Scene
from shapery_segmentation.flow.normal import FlowState, NormalFlowParams, normal_flow
from shapery_segmentation.gate import REACH, dense
from shapery_segmentation.neighborhoods import box_around, eroded, filled, within
from shapery_segmentation.objects import THIN_EDGE, Recovered
from shapery_segmentation.preparation import averaged
from shapery_segmentation.seeding.ball import seed_ball, surface_of
from shapery_segmentation.shrinking import shrinking_note

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

LARGEST_SEARCH = 4_000_000
"""Voxels of the volume in which the region is looked for; larger ones are averaged for it."""

LEAST_NOISE = 0.0025
"""Of the range of the values, without its extremes: what is less is not seen."""

LEAST_REGION = 27
"""Voxels below which a region is the seed's own noise."""

LARGEST_REGION = 0.25
"""Share of the volume above which what is found around a seed is its surroundings; a box may hold more."""

LARGEST_CONTEST = 250_000
"""Voxels of a box that compete; of a larger box, averages do."""

GIVE = 1.0
"""Voxels around the region in a box within which the flow looks for the border; with two it leaks where organs meet."""

AGREEMENT = 0.85
"""Intersection over union of the region in a box with what the borders' values take for the object, below which these
values alone do not tell it from what is around it."""

CLEAR = 0.925
"""The same above which an object that was pointed at may go on beyond its region, as a vessel does beyond a narrow."""

RING = 3.0
"""Voxels around an object that tell its contrast then."""

LEAST_GROWN = 100
"""Voxels that a region grows to at least, before which its border is as long as that of noise."""

UNLIKE, STEP, LINK = 2.0, 0.2, 3.0
"""How far from the seed's value a voxel costs one, and how much a link of `exp(-1)` spans, both in units of the values'
deviation around the seed; and what a voxel costs that is like the seed. Nothing hangs on their exact values: of organs
half and double are worth a hundredth or two."""

ALIKE = 0.9
"""Mean link across the border of a region, over that within it, above which it is no object: noise has .91 to .94."""

AROUND_REGION = 0.05
"""Share of its extent by which a region's box is larger than it, on each side."""

LARGEST_SURFACE = 40_000
"""Vertices at about which edges get longer instead."""

MARGIN = 12
"""Voxels around the region in which the surface is worked out."""

HALF_CONTRAST = 8.0
"""Units of the noise at which the confidence in a border is 0.63."""

ELSEWHERE = "The seed itself lies outside the object that was found around it."

MAD_TO_SIGMA = 1.4826
"""Median of the absolute deviations of a normal distribution to its standard deviation."""

QUARTILE_TO_SIGMA = 3.138
"""Lower quartile of the absolute values of a normal distribution to its standard deviation."""

NEARBY, WIDER = 3, 1.2
"""Voxels around the seed from which the noise is taken, and the deviation in voxels of the wider average."""


@dataclass(frozen=True, eq=False)
class Target:
    """What the user points at.

    Parameters
    ----------
    seed : (3,) float64
        RAS mm.
    box : (2, 3) float64, optional
        Two corners in RAS mm that the object lies between.
    pointed
        Whether the seed was given, not only the box, of which it is the middle then.
    """

    seed: NDArray[np.float64]
    box: NDArray[np.float64] | None = None
    pointed: bool = True


def targets(params: SegmentationParams) -> list[Target]:
    """Return what the parameters point at: each seed, within the box if there is one, or the middle of the box."""
    box = None if params.box is None else np.sort(np.asarray(params.box, dtype=np.float64).reshape(2, 3), axis=0)
    if params.seeds:
        return [Target(np.asarray(seed, dtype=np.float64), box) for seed in params.seeds]
    return [] if box is None else [Target(box.mean(axis=0), box, pointed=False)]


def recover_object(
    volume: Volume,
    target: Target,
    params: SegmentationParams,
    *,
    check_cancelled: Callable[[], None] = lambda: None,
    scene: Scene | None = None,
) -> Recovered:
    """Recover the object at one target.

    Parameters
    ----------
    volume
        Of any modality, spacing and orientation.
    target
        Inside the volume.
    params
        Of these `edge_length` and `smoothing`.
    check_cancelled
        Called several times a second; what it raises passes through.
    scene
        Where the surface is seen while it flows.

    Raises
    ------
    InvalidInput
        ``no_object_found`` where nothing around the seed stands out from it.
    """
    canonical, _ = volume.filled().canonical()
    step = max(max(canonical.spacing), (canonical.data.size / LARGEST_SEARCH) ** (1 / 3) * min(canonical.spacing))
    coarse = averaged(canonical, step) if canonical.data.size > LARGEST_SEARCH else canonical
    check_cancelled()
    drawn = target.box is not None
    if target.box is not None:
        frame, grown = target.box, None
    else:
        frame, grown = _grown_region(coarse, target.seed)
    check_cancelled()
    region, noise, likely = _contested_region(coarse, target, frame, grown)
    check_cancelled()
    box = box_around(region, region.shape, MARGIN)
    part = Volume(np.ascontiguousarray(coarse.data[box]), _shifted(coarse.affine, [s.start for s in box]))
    inside = np.ascontiguousarray(region[box])
    if coarse is not canonical:
        part, inside = _refined(canonical, part, inside)
    spacing = float(part.voxel_volume ** (1 / 3))
    usable = _in_box(part, frame) & within(inside, GIVE)
    field, polarity, contrast, agreement = _field_in_box(part, inside, noise, usable, likely)
    walked = agreement < AGREEMENT
    if not drawn and agreement >= CLEAR:
        usable = np.ones(part.shape, dtype=np.bool_)
    # The walk has left leaks behind; the gate would cut what is thin off.
    object_voxels, allowed = (inside, usable) if walked else _gated(field, inside, usable)
    check_cancelled()

    ball, to_ball, start = seed_ball(object_voxels, part.affine)
    seed = surface_of(ball, to_ball, even=True)
    # A vertex has about 0.87 of its squared edge length to itself.
    edge = max(spacing, float(np.sqrt(seed.area / (0.87 * LARGEST_SURFACE))))
    edge = params.edge_length if params.edge_length is not None else edge

    recorder = Recorder(scene)

    def on_iteration(state: FlowState) -> None:
        check_cancelled()
        recorder.watch(state)

    flow = normal_flow(
        field,
        allowed,
        part.affine,
        seed,
        NormalFlowParams(
            edge_lengths=(THIN_EDGE * edge, edge),
            curvature_weight=params.smoothing,
            threshold_share=None,
            topology=params.topology,
        ),
        threshold=0.0,
        on_iteration=on_iteration,
    )
    if flow.vanished:
        raise _nothing(target.seed, "the surface that started there shrank to nothing")
    source = Volume(np.broadcast_to(np.zeros((), np.uint8), volume.shape), volume.affine)
    inside = rasterize(flow.mesh, source)
    if not drawn and np.count_nonzero(inside) > LARGEST_REGION * inside.size:
        share = 100.0 * np.count_nonzero(inside) / inside.size
        raise _nothing(
            target.seed, f"the surface that started there ran into its surroundings, {share:.0f} % of the volume"
        )
    whole = filled(inside)
    notes = [] if drawn or object_voxels[_nearest(part, target.seed)] else [ELSEWHERE]
    if _touches_border(inside):
        notes.append("It reaches the border of the volume: it may go on beyond.")
    note = shrinking_note(seed, flow.mesh, field, part.affine, flow.threshold)
    if note is not None:
        notes.append(note)
    return Recovered(
        seed=to_ball[:3, :3] @ start + to_ball[:3, 3],
        seeded_by="user",
        confidence=float(1.0 - np.exp(-contrast / HALF_CONTRAST)),
        surface=flow.mesh,
        inside=inside,
        enclosed=np.asarray(whole & ~inside),
        threshold=float(flow.threshold),
        iterations=int(flow.iterations),
        converged=bool(flow.converged),
        seed_mm3=float(seed.volume),
        self_intersections=0 if flow.untouched else len(self_intersections(flow.mesh)),
        frames=recorder.frames(flow.mesh),
        polarity=polarity,
        notes=tuple(notes),
    )


def _grown_region(volume: Volume, point: NDArray[np.float64]) -> tuple[NDArray[np.float64], BoolArray]:
    """Return the region around a seed that hangs together least with the rest, and before it a box around that."""
    seed = np.array(_nearest(volume, point))
    smooth = np.ascontiguousarray(_smoothed(volume))
    here = smooth[tuple(slice(max(int(s) - NEARBY, 0), int(s) + NEARBY + 1) for s in seed)]
    spread = float(np.ptp(np.percentile(smooth, (1.0, 99.0))))
    if not spread > 0:
        raise _nothing(point, "everything around has the same intensity")
    center = float(np.median(here))
    unit = max(MAD_TO_SIGMA * float(np.median(np.abs(here - center))), 2.0 * LEAST_NOISE * spread)
    most = int(LARGEST_REGION * smooth.size)
    order, held = np.empty(most, dtype=np.int64), np.empty(most)
    count = grow(smooth, seed, center, UNLIKE * unit, STEP, LINK * unit, most, order, held)
    sizes = np.arange(1, count + 1)
    ratio = np.where(sizes >= LEAST_GROWN, held[:count] / sizes ** (2.0 / 3.0), np.inf)
    size = int(np.argmin(ratio)) + 1 if count >= LEAST_GROWN else count
    if size == most:
        raise _nothing(point, "no region around it stands out: it runs into its surroundings at once")
    region = np.zeros(smooth.shape, dtype=np.bool_)
    region.ravel()[order[:size]] = True
    region = filled(region)
    if not _hangs_together(smooth, region, LINK * unit):
        raise _nothing(point, "no region around it stands out: what is next to it looks as it does")
    low, high = (np.array([f(i) for i in np.nonzero(region)]) for f in (np.min, np.max))
    more = AROUND_REGION * (high - low + 1) + 0.5
    corners = np.array(np.meshgrid(*np.stack((low - more, high + more), axis=1), indexing="ij")).reshape(3, -1).T
    world = volume.to_world(corners)
    return np.stack((world.min(axis=0), world.max(axis=0))), region


def _hangs_together(values: FloatArray, region: BoolArray, scale: float) -> bool:
    """Tell whether neighbours in a region are more alike than those on both sides of its border."""
    across, within_ = [0.0, 0], [0.0, 0]
    for axis in range(3):
        links = np.exp(np.abs(np.diff(values, axis=axis)) / -scale)
        first, second = (np.take(region, np.arange(a, region.shape[axis] - 1 + a), axis=axis) for a in (0, 1))
        for found, which in ((across, first != second), (within_, first & second)):
            found[0] += float(links[which].sum(dtype=np.float64))
            found[1] += int(np.count_nonzero(which))
    return across[0] * within_[1] < ALIKE * within_[0] * across[1]


def _contested_region(
    volume: Volume, target: Target, box: NDArray[np.float64], grown: BoolArray | None
) -> tuple[BoolArray, float, Volume]:
    """Return the region in a box that its surroundings do not win, the noise there, and how likely voxels are in it.

    What is known of the object is what has `grown` from a seed, or what is around it, or the middle of the box.
    """
    usable = _in_box(volume, box)
    corners = np.argwhere(usable)
    middle = np.clip(np.array(_nearest(volume, target.seed)), corners[0], corners[-1])
    smooth = _smoothed(volume)
    spread = float(np.ptp(np.percentile(smooth[usable], (1.0, 99.0))))
    if not spread > 0:
        raise _nothing(target.seed, "everything in the box has the same intensity")
    noise = max(_noise_around(smooth, middle), LEAST_NOISE * spread)
    share = float(np.count_nonzero(usable)) / LARGEST_CONTEST
    coarse = averaged(volume, share ** (1 / 3) * max(volume.spacing)) if share > 1.0 else volume
    contested, known = _in_box(coarse, box), None
    if grown is not None:
        known = Volume(grown.astype(np.float32), volume.affine).resampled_to(coarse, fill=0.0).data >= 0.5
    elif target.pointed:
        known = around(contested, np.array(_nearest(coarse, volume.to_world(middle))))
    likely = Volume(compete(np.asarray(coarse.data, dtype=np.float32), contested, known), coarse.affine)
    if coarse is not volume:
        likely = likely.resampled_to(volume, fill=0.0)
    labels, _ = ndimage.label((likely.data > 0.5) & usable)
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    own = int(labels[tuple(middle)]) or int(sizes.argmax())
    if sizes[own] < LEAST_REGION:
        raise _nothing(target.seed, "what surrounds the box looks as what is in it does")
    return np.asarray(labels == own), noise, likely


def _field_in_box(
    volume: Volume, inside: BoolArray, noise: float, usable: BoolArray, likely: Volume
) -> tuple[FloatArray, Polarity, float, float]:
    """Return U, the polarity and the contrast of an object in a box, see `borders`, and how far its values bear it out.

    Where no two values tell the object from what is around it (organs lie against others of like intensity, tumors are
    of several tissues), how likely voxels are in it does, which knows edges and the box as well.
    """
    try:
        found = borders(volume, inside, noise)
    except InvalidInput as error:
        if error.code != "no_object_found" or not (~inside).any():
            raise
        found = None
    agreement = 0.0
    if found is not None:
        own = (found[0] > 0) & usable
        agreement = float(np.count_nonzero(own & inside) / np.count_nonzero(own | inside))
        if agreement >= AGREEMENT:
            return *found, agreement
    share = np.clip(likely.resampled_to(volume, fill=0.0).data.astype(np.float32), 0.001, 0.999)
    polarity, contrast = _stands_out(volume, inside, noise) if found is None else found[1:]
    return np.asarray(np.log(share / (1.0 - share))), polarity, contrast, agreement


def _stands_out(volume: Volume, inside: BoolArray, noise: float) -> tuple[Polarity, float]:
    """Return whether an object is brighter or darker than what is around it, and by how much in units of the noise."""
    ring = within(inside, RING) & ~inside
    step = float(np.median(volume.data[inside])) - float(np.median(volume.data[ring]))
    return "bright" if step >= 0 else "dark", abs(step) / noise


def _noise_around(smooth: FloatArray, seed: NDArray[np.int64]) -> float:
    """Return the noise around a voxel."""
    around = tuple(slice(max(int(s) - 3 * NEARBY, 0), int(s) + 3 * NEARBY + 1) for s in seed)
    middle = tuple(
        slice(max(int(s) - b.start - NEARBY, 0), int(s) - b.start + NEARBY + 1)
        for s, b in zip(seed, around, strict=True)
    )
    return _noise(smooth[around], middle)


def _in_box(volume: Volume, box: NDArray[np.float64]) -> BoolArray:
    """Tell which voxels lie in a box in RAS mm, at least one along each axis; it stays a box on the grid's axes."""
    corners = volume.to_index(np.array(np.meshgrid(*box.T, indexing="ij")).reshape(3, -1).T)
    low = np.clip(np.floor(corners.min(axis=0) + 0.5), 0, np.array(volume.shape) - 1).astype(int)
    high = np.clip(np.ceil(corners.max(axis=0) + 0.5), low + 1, volume.shape).astype(int)
    inside = np.zeros(volume.shape, dtype=np.bool_)
    inside[tuple(slice(a, b) for a, b in zip(low, high, strict=True))] = True
    return inside


def _gated(field: FloatArray, region: BoolArray, usable: BoolArray) -> tuple[BoolArray, BoolArray]:
    """Return the object's voxels and where the surface may go: near voxels that are dense, connected to the region.

    Neither leaves `usable`.
    """
    enhancing = (field > 0) & usable
    solid = dense(enhancing, 1.0) & eroded(enhancing)
    labels, _ = ndimage.label(solid)
    sizes = np.bincount(labels[region & solid], minlength=1)
    sizes[0] = 0
    core = labels == int(sizes.argmax()) if sizes.any() else enhancing & region
    if not core.any():
        core = region
    allowed = within(core, REACH) & usable
    inside, _ = ndimage.label(enhancing & allowed)
    own = np.bincount(inside[core & enhancing], minlength=1)
    own[0] = 0
    voxels = inside == int(own.argmax()) if own.any() else core
    return np.asarray(voxels), np.asarray(allowed)


def _refined(volume: Volume, coarse: Volume, inside: BoolArray) -> tuple[Volume, BoolArray]:
    """Return the part of `volume` that `coarse` covers, and the region on its grid."""
    bounds = volume.to_index(coarse.to_world(np.stack((np.full(3, -0.5), np.array(coarse.shape) - 0.5))))
    low = np.clip(np.ceil(bounds.min(axis=0)), 0, np.array(volume.shape) - 1).astype(int)
    high = np.clip(np.floor(bounds.max(axis=0)) + 1, low + 1, volume.shape).astype(int)
    box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
    part = Volume(np.ascontiguousarray(volume.data[box]), _shifted(volume.affine, low.tolist()))
    fine = Volume(inside.astype(np.float32), coarse.affine).resampled_to(part, fill=0.0).data
    return part, np.asarray(fine >= 0.5)


def _smoothed(volume: Volume) -> FloatArray:
    scale = float(volume.voxel_volume ** (1 / 3))
    return np.asarray(
        ndimage.gaussian_filter(volume.data.astype(np.float32), 0.7 * scale / np.array(volume.spacing), mode="nearest")
    )


def _noise(values: FloatArray, inner: tuple[slice, ...]) -> float:
    """Return the deviation of the noise, and of the object's own texture: of what a wider average takes away.

    Differences of neighbours would not do: most files were filtered or resampled, and neighbours are alike. The lower
    quartile, in the middle of `values` alone, because a border may be near.
    """
    rest = np.abs(values - ndimage.gaussian_filter(values, WIDER, mode="nearest"))[inner]
    return QUARTILE_TO_SIGMA * float(np.percentile(rest, 25.0))


def _nearest(volume: Volume, point: NDArray[np.float64]) -> tuple[int, int, int]:
    index = np.clip(np.rint(volume.to_index(point)), 0, np.array(volume.shape) - 1).astype(int)
    i, j, k = index.tolist()
    return i, j, k


def _touches_border(mask: BoolArray) -> bool:
    return any(bool(np.take(mask, end, axis=axis).any()) for axis in range(3) for end in (0, -1))


def _shifted(affine: NDArray[np.float64], corner: Sequence[int]) -> NDArray[np.float64]:
    moved = affine.copy()
    moved[:3, 3] += affine[:3, :3] @ np.asarray(corner)
    return moved


def _nothing(seed: NDArray[np.float64], why: str) -> InvalidInput:
    return InvalidInput(
        "no_object_found",
        f"No object was found at the seed ({_shown(seed)}): {why}.",
        "Place the seed in the middle of the object, or draw a box around it.",
    )


def _shown(point: NDArray[np.float64]) -> str:
    return ", ".join(f"{x:.4g}" for x in point)
