"""Where the surface may go: the density gate against leaks, and the region that a seed reaches through it.

A tumor touches vessels and meninges that enhance as it does. They are thin: around their voxels the share of enhancing
voxels is low, and an erosion parts them. The gate lets the surface move only near voxels that are enhancing, densely
surrounded by enhancing voxels, and connected to the seed through more than a thread of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shapery_segmentation.ground import ground_of, shell, standing_out, unevenness
from shapery_segmentation.labels import fill_enclosed, with_enclosed
from shapery_segmentation.neighborhoods import box_around, connected, eroded, within
from shapery_segmentation.smoothing import gaussian

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

DENSITY_SCALE = 2.0
"""mm: standard deviation of the Gaussian that measures how densely voxels enhance."""

LEAST_DENSITY = 0.4
"""A plane surface has 0.5 at its border; a sheet of 2 mm has 0.38, a tube of 4 mm across 0.39."""

STRICTER = (0.5, 0.6)
"""Densities that are tried in turn where the gate before leaks: partial volume, blur and a threshold that lies lower
make meninges as thick as sheets of 3 mm and more."""

LEAK = 0.85
"""A gate leaks if a stricter one leaves a region with less than this share of the isoperimetric ratio (see
`_raggedness`) that stands out no less. Where meninges and sinuses were reached it falls to 0.23 to 0.71; without a leak
to 0.78 at the least, and what is taken away then is weak tumor, which costs contrast."""

REACH = 2.9
"""mm beyond dense voxels in which the surface may move: sharp corners are less dense than their inside."""

LEVEL = 0.45
"""Share of the way from what surrounds an object to the median inside at which its border lies. Less than half: the
darker margin of a tumor belongs to it, and partial volume with the dark necrosis shifts the half maximum inwards. What
surrounds it need not be normal brain, which is 0: edema and fluid are darker after contrast, too."""

LEVEL_RANGE = (1.2, 2.25)
"""Bounds of the threshold in units of the calibrated difference: below, normal tissue begins; above, a bright tumor
would lose the margin that is anything but normal."""

FARTHEST_RIM = 30.0
"""mm beyond the box of a region in which the thin part of its rim is looked for."""

MORE_ENCLOSED = 1.02
"""Growth of what a region encloses, relative, from which its rim is looked at again."""

ROUNDER = 0.9
"""A rim is followed where it is thin if the raggedness of the whole falls below this share. Where rims closed it
fell to 0.73 to 0.86; where meninges were reached it rose."""

CLOSING_ROUNDS = 4
"""How often what a rim encloses and how far it reaches are made from each other at the most."""

MANY = 20_000
"""Voxels from which on an object's surroundings are looked at in every other voxel along each axis."""

HOPELESS = 0.01
"""Likelihood of its shape below which a region that still grows is not followed farther."""

DOUBTFUL = 0.3
"""Likewise for a region whose seed has no object's shape itself: it might lead through a whole brain."""

LEAST_CONTRAST = 2.4
"""Contrast (see `shapery_segmentation.ground`) below which a region is no object, whatever its gate: meninges stand
out."""

LEAST_CONTRAST_KEPT = 0.85
"""Share of its contrast that a region must keep when the threshold falls. The weaker parts of a tumor leave the
contrast to its surroundings as it was, within a tenth; normal tissue that is a little brighter than the rest (bias
fields that differ between the volumes raise whole lobes) takes a fifth of it away with every step."""

MUCH_MORE = 1.05
"""Growth of a region, relative, since it was last asked about its contrast, from which it is asked again."""

_MARGIN = 8
"""Voxels between a region and the border of the box it is worked out in; the density looks 6 mm far."""


@dataclass(frozen=True, eq=False)
class Region:
    """What a seed reaches.

    Parameters
    ----------
    box
        Slices of the working grid that `inside` and `allowed` lie on.
    inside : bool
        The voxels above the threshold that the seed reaches through the gate.
    allowed : bool
        Where the surface may move.
    threshold
        In units of the calibrated difference.
    floor
        What the threshold must not fall below, because the region would take in what surrounds it.
    ground
        Median of what surrounds the region.
    stands_out
        Its contrast to that (see `shapery_segmentation.ground`; of a large region every eighth voxel tells it).
    likely
        How likely an object has its shape, as far as that was asked.
    parted
        Whether only a stricter gate parted it from what has no object's shape.
    """

    box: tuple[slice, slice, slice]
    inside: BoolArray
    allowed: BoolArray
    threshold: float
    floor: float = LEVEL_RANGE[0]
    ground: float = 0.0
    stands_out: float = 0.0
    likely: float = 1.0
    parted: bool = False


def running_threshold(values: NDArray[np.floating], ground: float = 0.0) -> float:
    """Return the threshold that follows from the enhancement inside an object and around it.

    Parameters
    ----------
    values : (n,) float32
        Inside.
    ground
        What surrounds the object.

    Returns
    -------
    0.45 of the way from `ground` to the median of `values`, within bounds.
    """
    return float(np.clip(ground + LEVEL * (float(np.median(values)) - ground), *LEVEL_RANGE))


def on_even_ground(field: FloatArray, region: Region, around: BoolArray, spacing: float) -> FloatArray:
    """Return the field less what the running threshold would rise by from place to place.

    Parameters
    ----------
    field : (I, J, K) float32
        Calibrated difference in the region's box.
    region
        What a seed reaches.
    around : (I, J, K) bool
        The shell around it (see `shapery_segmentation.ground`).
    spacing
        Edge of a voxel in mm.

    Notes
    -----
    The threshold lies 0.45 of the way from the ground to the median inside, so it rises by 0.55 of what the ground
    does: one threshold for all of the object ends it too late at the cortex, the dura or a vessel, and too early in
    edema. Where the threshold is at its lower bound, only what exceeds the bound raises it further.
    """
    rise = np.float32(1.0 - LEVEL) * unevenness(field, around, spacing)
    unbounded = region.ground + LEVEL * (float(np.median(field[region.inside])) - region.ground)
    bound = np.float32(max(0.0, region.floor - unbounded))
    return np.asarray(field - np.where(rise > 0.0, np.maximum(rise - bound, 0.0), rise), dtype=np.float32)


def dense(enhancing: BoolArray, spacing: float, least: float = LEAST_DENSITY) -> BoolArray:
    """Return the voxels that enhance and around which enough others do.

    Parameters
    ----------
    enhancing : (I, J, K) bool
        Where the calibrated difference exceeds the threshold.
    spacing
        Edge of a voxel in mm.
    least
        Share of enhancing voxels, by the weights of a Gaussian of 2 mm, above which there are enough.
    """
    return np.asarray(enhancing & (_density(enhancing, spacing) > least))


def _density(enhancing: BoolArray, spacing: float) -> FloatArray:
    return gaussian(enhancing.astype(np.float32), DENSITY_SCALE / spacing)


def reach(
    field: FloatArray,
    brain: BoolArray,
    seed: BoolArray,
    spacing: float,
    *,
    rounds: int = 8,
    likely_shape: Callable[[BoolArray], float] | None = None,
) -> Region:
    """Return the region that `seed` reaches.

    Parameters
    ----------
    field : (I, J, K) float32
        Calibrated difference.
    brain : (I, J, K) bool
    seed : (I, J, K) bool
        Voxels inside the object, at least one.
    spacing
        Edge of a voxel in mm.
    rounds
        How often threshold and region are made from each other at the most.
    likely_shape
        Returns how likely an object has the shape of the voxels inside, in [0, 1]. It is asked about every region that
        is reached. Where that is hopeless and gets near the end of its box, it is not followed farther, because leaks
        through a whole brain cost most of all; what is less likely than not is looked for with stricter gates, too.

    Notes
    -----
    In turns: threshold from the medians of what is inside and around it; dense voxels whose six neighbours enhance
    too, as far as they are connected to the inside; 2.9 mm around them; the enhancing voxels in there that are
    connected to the inside. The threshold falls as the region takes in weaker parts; the gate keeps it from taking in
    everything, and a step that costs more than 15 % of the contrast to the surroundings is not taken. All this is done
    in a box around the seed; as soon as the region gets near its end, that round is done again in a larger one. If the
    gate leaks all the same, a stricter one takes its place. In the end the rim around what the region encloses is
    followed where it is thinner than the gate lets through (see `_closed`).
    """
    shapeless = likely_shape is not None and likely_shape(seed[box_around(seed, seed.shape, 0)]) < 0.5
    hopeless = DOUBTFUL if shapeless else HOPELESS
    region = _reach(field, brain, seed, spacing, rounds, likely_shape, LEAST_DENSITY, hopeless)
    lost = region.likely < 0.5
    if lost and shapeless:
        # A tree or a sheet from the beginning.
        return region
    if region.stands_out < LEAST_CONTRAST:
        return region
    whole = with_enclosed(region.inside, spacing)
    taken = LEAST_DENSITY
    for density in STRICTER if lost else _promising(field, brain, region, whole, seed, spacing):
        stricter = _reach(field, brain, seed, spacing, rounds, likely_shape, density, hopeless)
        if lost:
            better = stricter.likely >= 0.5
            lost, stricter = not better, replace(stricter, parted=True)
        else:
            rounder = _raggedness(with_enclosed(stricter.inside, spacing)) < LEAK * _raggedness(whole)
            better = rounder and stricter.stands_out >= region.stands_out
        if better:
            region, whole, taken = stricter, with_enclosed(stricter.inside, spacing), density
            break
    return region if lost else _closed(field, brain, region, whole, spacing, taken)


def _raggedness(whole: BoolArray) -> float:
    """Return the isoperimetric ratio of a set of voxels: faces on its border to the power 3/2 over voxels."""
    wide = np.pad(whole, 1)
    faces = sum(int(np.count_nonzero(np.diff(wide, axis=axis))) for axis in range(3))
    return float(faces**1.5 / max(np.count_nonzero(whole), 1))


def _promising(
    field: FloatArray, brain: BoolArray, region: Region, whole: BoolArray, seed: BoolArray, spacing: float
) -> Iterator[float]:
    """Yield the densities of gates that would have left much less ragged a region at the same threshold."""
    enhancing = (field[region.box] > region.threshold) & brain[region.box]
    solid, dense_there = eroded(enhancing), _density(enhancing, spacing)
    ragged = _raggedness(whole)
    for density in STRICTER:
        core = connected(solid & (dense_there > density), seed[region.box])
        kept = region.inside & within(core, REACH / spacing)
        if kept.any() and _raggedness(with_enclosed(kept, spacing)) < LEAK * ragged:
            yield density


def _closed(
    field: FloatArray, brain: BoolArray, region: Region, whole: BoolArray, spacing: float, density: float
) -> Region:
    """Return a region whose rim is followed to where it is a thin sheet, or the region itself where that is no rounder.

    The rim around a necrosis is often thinner than what the gate lets through. But on one side of it is what the object
    encloses, where a meninx has none: the gate is asked once more, with the enclosed voxels counted as object. Enclosed
    is what all enhancing voxels that are connected to the region enclose, as far as that is connected to what the
    region itself does; `whole` is the region with that.
    """
    known = whole & ~region.inside
    ragged = before = _raggedness(whole)
    closed = region
    for number in range(CLOSING_ROUNDS):
        if not known.any():
            break
        if number == 1:
            # The first look was at the box that the region came with: where it leaks, that shows there.
            margin = round(FARTHEST_RIM / spacing)
            i, j, k = (
                slice(max(b.start - margin, 0), min(b.stop + margin, n))
                for b, n in zip(closed.box, brain.shape, strict=True)
            )
            known = _moved(known, closed.box, (i, j, k))
            closed = _in_box(closed, (i, j, k))
        usable = brain[closed.box]
        enhancing = (field[closed.box] > closed.threshold) & usable
        hollow = fill_enclosed(connected(enhancing, closed.inside), spacing) & ~enhancing & usable
        hollow = connected(hollow | known, known)
        if np.count_nonzero(hollow) <= MORE_ENCLOSED * np.count_nonzero(known):
            break
        full = enhancing | hollow
        core = connected(full & (_density(full, spacing) > density) & eroded(full), closed.inside)
        allowed = closed.allowed | (within(core, REACH / spacing) & usable)
        inside = connected(enhancing & allowed, closed.inside)
        rounder = _raggedness(with_enclosed(inside, spacing))
        if rounder >= ragged:
            break
        closed, known, ragged = replace(closed, inside=inside, allowed=allowed), hollow, rounder
    return closed if ragged < ROUNDER * before else region


def _in_box(region: Region, box: tuple[slice, slice, slice]) -> Region:
    """Return a region in another box that holds its own."""
    return replace(
        region, box=box, inside=_moved(region.inside, region.box, box), allowed=_moved(region.allowed, region.box, box)
    )


def _moved(mask: BoolArray, box: tuple[slice, slice, slice], other: tuple[slice, slice, slice]) -> BoolArray:
    """Return what `mask` on one box is on another that holds it."""
    out = np.zeros([side.stop - side.start for side in other], dtype=np.bool_)
    out[tuple(slice(a.start - b.start, a.stop - b.start) for a, b in zip(box, other, strict=True))] = mask
    return out


@dataclass(frozen=True, eq=False)
class _Progress:
    """How far a region has come: after so many rounds, and how large it was when it was last asked for its contrast."""

    region: Region | None = None
    rounds: int = 0
    asked: int = 0


def _reach(
    field: FloatArray,
    brain: BoolArray,
    seed: BoolArray,
    spacing: float,
    rounds: int,
    likely_shape: Callable[[BoolArray], float] | None,
    density: float,
    hopeless: float,
) -> Region:
    """Return what `reach` does for one gate, in a box that is large enough."""
    box = box_around(seed, seed.shape, 3 * _MARGIN)
    so_far = _Progress()
    while True:
        region, so_far = _reach_in(field, brain, seed, spacing, rounds, box, density, so_far)
        if likely_shape is not None:
            region = replace(region, likely=likely_shape(region.inside))
        if region.likely < hopeless or not _near_end(region.inside, box, seed.shape):
            return region
        near = box_around(region.inside | seed[box], region.inside.shape, 0)
        more = 4 * _MARGIN
        i, j, k = (
            slice(max(b.start + min(t.start - more, 0), 0), min(max(b.start + t.stop + more, b.stop), n))
            for t, b, n in zip(near, box, seed.shape, strict=True)
        )
        box = (i, j, k)


def _near_end(inside: BoolArray, box: tuple[slice, slice, slice], shape: tuple[int, ...]) -> bool:
    """Return whether a region gets near an end of its box that is not the end of the grid."""
    touched = box_around(inside, inside.shape, _MARGIN)
    return any(
        (t.start == 0 and b.start > 0) or (t.stop == b.stop - b.start and b.stop < n)
        for t, b, n in zip(touched, box, shape, strict=True)
    )


def _reach_in(
    field: FloatArray,
    brain: BoolArray,
    seed: BoolArray,
    spacing: float,
    rounds: int,
    box: tuple[slice, slice, slice],
    density: float,
    so_far: _Progress,
) -> tuple[Region, _Progress]:
    """Return what `reach` does for one gate in one box, and how far it had come before it got near the box's end."""
    values = np.ascontiguousarray(field[box])
    usable, given = np.ascontiguousarray(brain[box]), np.ascontiguousarray(seed[box])
    last = None if so_far.region is None else _in_box(so_far.region, box)
    asked, stood_out = so_far.asked, 0.0 if last is None else last.stands_out
    inside = allowed = given if last is None else last.inside
    threshold, previous = 0.0, -1 if last is None else int(np.count_nonzero(last.inside))

    def around(part: BoolArray) -> tuple[float, float]:
        # Of a large object every eighth voxel tells the same.
        step = 2 if np.count_nonzero(part) >= MANY else 1
        every = (slice(None, None, step),) * 3
        some = np.ascontiguousarray(part[every])
        return ground_of(values[every][shell(with_enclosed(some, step * spacing), usable[every], step * spacing)])

    own, outside = values[inside], around(inside)
    for done in range(so_far.rounds, rounds):
        so_far = _Progress(last, done, asked)
        threshold = running_threshold(own, outside[0])
        enhancing = (values > threshold) & usable
        solid = dense(enhancing, spacing, density) & eroded(enhancing)
        core = connected(solid, inside)
        if not core.any():
            # Too thin for the gate: the seed alone is what there is.
            core = inside & enhancing
            core = core if core.any() else inside
        allowed = within(core, REACH / spacing) & usable
        inside = connected(enhancing & allowed, inside | core)
        own = values[inside]
        count = len(own)
        if count == 0:
            inside = given
            own = values[inside]
            break
        outside = around(inside)
        if count > MUCH_MORE * asked:
            stands_out = standing_out(own, outside)
            if last is not None and stands_out < LEAST_CONTRAST_KEPT * stood_out:
                return replace(last, floor=last.threshold), so_far
            asked, stood_out = count, stands_out
        if abs(count - previous) <= 0.002 * count or _near_end(inside, box, brain.shape):
            break
        previous = count
        last = Region(box, inside, allowed, threshold, ground=outside[0], stands_out=stood_out)
    stands_out = standing_out(own, outside)
    return Region(box, inside, allowed, threshold, ground=outside[0], stands_out=stands_out), so_far
