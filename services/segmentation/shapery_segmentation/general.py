"""Any object that the user points at, in any volume: nothing of a head is assumed (the general mode).

What the object is follows from the data around the seed:

1. **Region.** For every voxel, the tolerance around the seed's intensity at which a path from the seed reaches it (a
   minimax path). As the tolerance grows, the region fills the object, then stays nearly as it is while the tolerance
   passes through the border, then leaks. The region at the stillest of these places is the object, roughly: an extremal
   region that is maximally stable (Matas et al., 2004), but around the seed's intensity and to both sides of it. Within
   a box, what surrounds the box and the middle of it compete for the voxels instead (`competition`).
2. **Polarity.** The voxels around the region tell what the object borders on: darker tissue, brighter, or both. The
   border lies half-way to each, where partial volume puts it (`borders`).
3. **Flow.** U is the distance to the nearer of these borders in units of the noise, positive inside; the density gate
   of the tumor's way keeps the surface out of leaks, and the normal flow does the rest. In a box where no two values
   tell the object from what is around it, U is the logarithm of the odds that the competition gives.

References
----------
Section 3.4.1 of the dissertation. J. Matas et al., "Robust wide-baseline stereo from maximally stable extremal
regions", Image Vision Comput. 22 (2004), doi:10.1016/j.imavis.2004.02.006.
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
from shapery_segmentation._flood_kernels import flood
from shapery_segmentation.borders import Polarity, borders
from shapery_segmentation.competition import compete
from shapery_segmentation.evolution import Recorder, Scene
from shapery_segmentation.flow.normal import FlowState, NormalFlowParams, normal_flow
from shapery_segmentation.gate import REACH, dense
from shapery_segmentation.neighborhoods import box_around, within
from shapery_segmentation.objects import THIN_EDGE, Recovered
from shapery_segmentation.preparation import averaged
from shapery_segmentation.seeding.ball import seed_ball, surface_of
from shapery_segmentation.shrinking import shrinking_note

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

LARGEST_SEARCH = 4_000_000
"""Voxels of the volume in which the region is looked for; larger ones are averaged for it."""

LEVELS = 2048
"""Tolerances of the flood."""

FINENESS = 0.2
"""Step between them, in units of the noise."""

STILL = 1.25
"""The region is compared at a tolerance so many times larger."""

LEAST_TOLERANCE = 2.0
"""In units of the noise; at less a region has holes wherever the noise has peaks."""

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

RING = 3.0
"""Voxels around an object that tell its contrast then."""

CALM = 0.25
"""Growth (logarithm of the volume) across one step of `STILL` below which a region counts as still."""

BRIDGE = 1.5
"""Voxels: deviation of the Gaussian over the tolerances before the flood. A bridge to a like neighbour that is thinner
than about four of them is as costly as what lies beside it."""

REGROWN = 4.0
"""Units of the noise within which voxels beside the region belong to it."""

DEEPEST = 40.0
"""Units of the noise to which tolerances are cut for that."""

LARGEST_SURFACE = 40_000
"""Vertices at about which edges get longer instead."""

MARGIN = 12
"""Voxels around the region in which the surface is worked out."""

HALF_CONTRAST = 8.0
"""Units of the noise at which the confidence in a border is 0.63."""

ELSEWHERE = "The seed itself lies outside the object that was found around it."

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
    if target.box is None:
        region, noise = _still_region(coarse, target)
        likely = None
    else:
        region, noise, likely = _contested_region(coarse, target, target.box)
    check_cancelled()
    box = box_around(region, region.shape, MARGIN)
    part = Volume(np.ascontiguousarray(coarse.data[box]), _shifted(coarse.affine, [s.start for s in box]))
    inside = np.ascontiguousarray(region[box])
    if coarse is not canonical:
        part, inside = _refined(canonical, part, inside)
    spacing = float(part.voxel_volume ** (1 / 3))
    usable = None if target.box is None else _in_box(part, target.box) & within(inside, GIVE)
    walked = None
    if usable is None or likely is None:
        field, polarity, contrast = borders(part, inside, noise)
    else:
        field, polarity, contrast, walked = _field_in_box(part, inside, noise, usable, likely)
    # The walk has left leaks behind; the gate would cut what is thin off.
    object_voxels, allowed = (inside, usable) if walked and usable is not None else _gated(field, inside, usable)
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
    filled = rasterize(flow.mesh, source)
    if target.box is None and np.count_nonzero(filled) > LARGEST_REGION * filled.size:
        share = 100.0 * np.count_nonzero(filled) / filled.size
        raise _nothing(
            target.seed, f"the surface that started there ran into its surroundings, {share:.0f} % of the volume"
        )
    whole = ndimage.binary_fill_holes(filled)
    notes = [] if target.box is not None or object_voxels[_nearest(part, target.seed)] else [ELSEWHERE]
    if _touches_border(filled):
        notes.append("It reaches the border of the volume: it may go on beyond.")
    note = shrinking_note(seed, flow.mesh, field, part.affine, flow.threshold)
    if note is not None:
        notes.append(note)
    return Recovered(
        seed=to_ball[:3, :3] @ start + to_ball[:3, 3],
        seeded_by="user",
        confidence=float(1.0 - np.exp(-contrast / HALF_CONTRAST)),
        surface=flow.mesh,
        inside=filled,
        enclosed=np.asarray(whole & ~filled),
        threshold=float(flow.threshold),
        iterations=int(flow.iterations),
        converged=bool(flow.converged),
        seed_mm3=float(seed.volume),
        self_intersections=0 if flow.untouched else len(self_intersections(flow.mesh)),
        frames=recorder.frames(flow.mesh),
        polarity=polarity,
        notes=tuple(notes),
    )


def _still_region(volume: Volume, target: Target) -> tuple[BoolArray, float]:
    """Return the stillest region around the seed, and the noise there."""
    seed = np.array(_nearest(volume, target.seed))
    smooth = _smoothed(volume)
    noise = _noise_around(smooth, seed)
    here = tuple(slice(max(int(s) - 1, 0), int(s) + 2) for s in seed)
    centre = float(np.median(smooth[here]))
    spread = float(np.percentile(np.abs(smooth - centre), 99.0))
    if not spread > 0:
        raise _nothing(target.seed, "everything around has the same intensity")
    noise = max(noise, spread / (LEVELS * FINENESS))
    most = int(LARGEST_REGION * smooth.size)
    for _ in range(2):
        tolerance = np.abs(smooth - np.float32(centre)) / np.float32(noise)
        # Without the bridges that lead to like neighbours; where the object is thin itself, with them.
        for bridge in (BRIDGE, 0.0):
            cut = np.minimum(tolerance, np.float32(DEEPEST)) if bridge else tolerance
            wide = ndimage.gaussian_filter(cut, bridge, mode="nearest") if bridge else cut
            cost = np.minimum(wide / FINENESS, LEVELS - 1).astype(np.uint16)
            level = np.full(volume.shape, np.iinfo(np.uint16).max, dtype=np.uint16)
            counts = np.zeros(LEVELS, dtype=np.int64)
            flood(cost, seed[None].astype(np.int64), smooth.size, level, counts)
            stillest = _stillest(np.cumsum(counts), most)
            if stillest is not None:
                break
        if stillest is None:
            raise _nothing(target.seed, "no region around it stands out: it runs into its surroundings at once")
        region = np.asarray(level <= stillest)
        if bridge:
            # Back to where the averaging began: as far as the object itself goes on.
            near = within(region, 2.0 * BRIDGE)
            region |= near & (tolerance < max(REGROWN, float(stillest) * FINENESS))
        # A single voxel's noise must not be the centre: once more from the median of what was found.
        again = float(np.median(smooth[region]))
        if abs(again - centre) < 0.5 * noise:
            break
        centre = again
    return region, noise


def _contested_region(volume: Volume, target: Target, box: NDArray[np.float64]) -> tuple[BoolArray, float, Volume]:
    """Return the region in a box that its surroundings do not win, the noise there, and how likely voxels are in it."""
    usable = _in_box(volume, box)
    corners = np.argwhere(usable)
    middle = np.clip(np.array(_nearest(volume, target.seed)), corners[0], corners[-1])
    smooth = _smoothed(volume)
    spread = float(np.ptp(np.percentile(smooth[usable], (1.0, 99.0))))
    if not spread > 0:
        raise _nothing(target.seed, "everything in the box has the same intensity")
    noise = max(_noise_around(smooth, middle), spread / (LEVELS * FINENESS))
    share = float(np.count_nonzero(usable)) / LARGEST_CONTEST
    coarse = averaged(volume, share ** (1 / 3) * max(volume.spacing)) if share > 1.0 else volume
    given = np.array(_nearest(coarse, volume.to_world(middle))) if target.pointed else None
    likely = Volume(compete(np.asarray(coarse.data, dtype=np.float32), _in_box(coarse, box), given), coarse.affine)
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
) -> tuple[FloatArray, Polarity, float, bool]:
    """Return U, the polarity and the contrast of an object in a box, see `borders`, and whether U is of the walk.

    Where no two values tell the object from what is around it (organs lie against others of like intensity, tumors are
    of several tissues), how likely voxels are in it does, which knows edges and the box as well.
    """
    try:
        found = borders(volume, inside, noise)
    except InvalidInput as error:
        if error.code != "no_object_found" or not (~inside).any():
            raise
        found = None
    if found is not None:
        own = (found[0] > 0) & usable
        if np.count_nonzero(own & inside) >= AGREEMENT * np.count_nonzero(own | inside):
            return *found, False
    share = np.clip(likely.resampled_to(volume, fill=0.0).data.astype(np.float32), 0.001, 0.999)
    polarity, contrast = _stands_out(volume, inside, noise) if found is None else found[1:]
    return np.asarray(np.log(share / (1.0 - share))), polarity, contrast, True


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


def _stillest(volume: NDArray[np.int64], most: int) -> int | None:
    """Return the tolerance at which the region changes least: the first that is still, else the stillest there is."""
    low = int(LEAST_TOLERANCE / FINENESS)
    at = np.arange(low, int(LEVELS / STILL))
    upper = np.minimum((at * STILL).astype(int), LEVELS - 1)
    growth = np.log(np.maximum(volume[upper], 1)) - np.log(np.maximum(volume[(at / STILL).astype(int)], 1))
    right = (volume[at] >= LEAST_REGION) & (volume[upper] <= most)
    if not right.any():
        return None
    growth = np.where(right, growth, np.inf)
    calm = np.flatnonzero(growth < CALM)
    if not len(calm):
        return int(at[int(np.argmin(growth))])
    # The bottom of the first valley.
    end = calm[0]
    while end + 1 < len(growth) and growth[end + 1] < CALM:
        end += 1
    return int(at[calm[0] + int(np.argmin(growth[calm[0] : end + 1]))])


def _in_box(volume: Volume, box: NDArray[np.float64]) -> BoolArray:
    """Tell which voxels lie in a box in RAS mm, at least one along each axis; it stays a box on the grid's axes."""
    corners = volume.to_index(np.array(np.meshgrid(*box.T, indexing="ij")).reshape(3, -1).T)
    low = np.clip(np.floor(corners.min(axis=0) + 0.5), 0, np.array(volume.shape) - 1).astype(int)
    high = np.clip(np.ceil(corners.max(axis=0) + 0.5), low + 1, volume.shape).astype(int)
    inside = np.zeros(volume.shape, dtype=np.bool_)
    inside[tuple(slice(a, b) for a, b in zip(low, high, strict=True))] = True
    return inside


def _gated(field: FloatArray, region: BoolArray, usable: BoolArray | None) -> tuple[BoolArray, BoolArray]:
    """Return the object's voxels and where the surface may go: near voxels that are dense, connected to the region.

    Neither leaves `usable`, the user's box.
    """
    enhancing = field > 0 if usable is None else (field > 0) & usable
    solid = dense(enhancing, 1.0) & ndimage.binary_erosion(enhancing)
    labels, _ = ndimage.label(solid)
    sizes = np.bincount(labels[region & solid], minlength=1)
    sizes[0] = 0
    core = labels == int(sizes.argmax()) if sizes.any() else enhancing & region
    if not core.any():
        core = region
    allowed = within(core, REACH) if usable is None else within(core, REACH) & usable
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
