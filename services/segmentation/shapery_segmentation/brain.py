"""Which voxels are brain: of volumes that were stripped of the skull already, and of whole heads.

A whole head enhances outside the brain too (skin, mucosa, dural sinuses), and its fat and air would spoil the fit of
one volume to the other. The mask need not be exact to a voxel; it must hold all tumors and no scalp.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_geometry.concurrent import both
from shapery_geometry.volume import Volume
from shapery_segmentation.neighborhoods import depths, dilated, eroded, filled
from shapery_segmentation.preparation import WorkingGrid, working_grid
from shapery_segmentation.smoothing import gaussian

BoolArray = NDArray[np.bool_]

COARSE = 3.0
"""mm. Skull and scalp are thicker than this almost everywhere, and a head is then half a million voxels."""

SCALP = 0.95
"""Brightness of the outer 6 mm, relative to the inside, from which they are skin and fat: 1.0 to 1.4 in whole heads.
The cortex and the fluid around a stripped brain have 0.6 to 0.9."""

LARGEST_BRAIN = 2.0e6
"""mm³ that no brain with its fluid exceeds, but a head with its face does."""

CONSTANT_SHARE = 0.95
"""Share of the volume's corners that must have one value for a constant background; noise has many."""

LEAST_BRAIN = 50e3
"""mm³ of brain without which nothing can be judged (an adult's has 1.1 to 1.6 million)."""

HEIGHT = 150.0
"""mm below the vertex at which no brain is left."""

UNDER_SKULL = 15.0
"""mm below the skin: scalp and skull are not as thick."""

BIAS_SCALE = 25.0
"""mm: standard deviation of the Gaussian over which the brain's local brightness is averaged."""

MOSTLY = 0.6
"""Share of tissue around a coarse voxel, by the weights of a Gaussian of one voxel, from which its holes are filled."""

ERODED, REGROWN, CLOSED = 3, 8, 5
"""Coarse voxels by which the head's tissue is eroded, the brain grown back through it, and then closed over its
sulci."""

FACE, LOW = 0.25, 0.35
"""What another erosion parts from the brain is face and neck if it is larger than this share of the rest and lies lower
than this: 1 is the vertex, 0 lies `HEIGHT` below it."""


@dataclass(frozen=True, eq=False)
class Brain:
    """Where the brain is.

    Parameters
    ----------
    grid
        The working grid, cropped to the brain.
    mask : (I, J, K) bool
        On `grid`.
    stripped
        Whether the volume held the brain alone.
    """

    grid: WorkingGrid
    mask: BoolArray
    stripped: bool


def find_brain(reference: Volume, post: Volume) -> Brain:
    """Find the brain and the working grid around it.

    Parameters
    ----------
    reference
        The volume to judge from: before contrast where there is one, since tumors differ least from brain there.
    post
        The volume after contrast.

    Raises
    ------
    InvalidInput
        ``invalid_volume`` where nothing brain-like is in it.
    """
    # Where a file has NaN around the brain, that is its background.
    reference, post_filled = reference.filled(), post.filled()
    full = working_grid(post)
    coarse = working_grid(post, spacing=COARSE)
    image = coarse.sample(reference)
    missing = ~np.isfinite(image)
    if missing.all():
        raise InvalidInput(
            "invalid_volume",
            "The volumes before and after contrast have no place in common.",
            "Give two volumes of one session in one scanner frame, or let them be registered.",
        )
    background = _background_value(reference)
    image[missing] = background if background is not None else float(np.nanmin(image))

    if background is not None:
        # Averages of background and brain lie between the two: more than half of the block must be brain.
        occupied = coarse.sample(reference.with_data((reference.data != background).astype(np.float32)))
        foreground = (np.nan_to_num(occupied, nan=0.0) > 0.5) & ~missing
    else:
        foreground = (image > otsu(image[~missing])) & ~missing
    foreground = largest_part(foreground)
    if foreground.sum() * COARSE**3 < LEAST_BRAIN:
        raise InvalidInput(
            "invalid_volume",
            f"The volume shows {foreground.sum() * COARSE**3 / 1000:.3g} ml of tissue: too little for a brain.",
            "Give the whole volume; if its header has a wrong spacing, mend that.",
        )
    stripped = background is not None and _is_stripped(image, foreground)
    brain = foreground if stripped else _strip(image, foreground)
    if brain.sum() * COARSE**3 < LEAST_BRAIN:
        raise InvalidInput(
            "invalid_volume",
            f"Of the head in the volume, {brain.sum() * COARSE**3 / 1000:.3g} ml look like brain: too little.",
            "Give T1 volumes of the head, or volumes stripped of the skull.",
        )

    grid = full.cropped(*_box_on(full, coarse, brain))
    if stripped:
        mask, known = both(
            lambda: _upsampled(grid, coarse, dilated(brain, 2)) & _not_background(grid, post_filled),
            lambda: _not_background(grid, reference),
        )
        mask &= known
    else:
        mask = _upsampled(grid, coarse, brain)
    return Brain(grid, mask, stripped)


def otsu(values: NDArray[Any]) -> float:
    """Return the threshold that separates `values` into two classes of least variance within (N. Otsu, 1979)."""
    low, high = (float(v) for v in np.percentile(values, (0.5, 99.5)))
    if high <= low:
        return low
    counts, edges = np.histogram(values, bins=256, range=(low, high))
    centres = (edges[1:] + edges[:-1]) / 2
    weight = np.cumsum(counts)
    moment = np.cumsum(counts * centres)
    rest = weight[-1] - weight
    both = (weight > 0) & (rest > 0)
    between = np.zeros(len(counts))
    between[both] = (moment[-1] * weight / weight[-1] - moment)[both] ** 2 / (weight * rest)[both]
    # Between well separated classes the maximum is a plateau: its middle.
    best = np.flatnonzero(between >= between.max() * (1.0 - 1e-9))
    return float(centres[best].mean())


def largest_part(mask: BoolArray) -> BoolArray:
    """Return the largest part of `mask` that is connected through faces; `mask` itself if it is empty."""
    labels, count = ndimage.label(mask)
    if count < 2:
        return mask
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return np.asarray(labels == int(sizes.argmax()))


def closed(mask: BoolArray, steps: int) -> BoolArray:
    """Return `mask` with its gaps of up to twice `steps` voxels closed and its holes filled."""
    wide = np.pad(mask, steps + 1)
    wide = eroded(dilated(wide, steps), steps)
    inside = (slice(steps + 1, -steps - 1),) * 3
    return np.asarray(filled(wide)[inside] | mask)


def surrounded(mask: BoolArray) -> BoolArray:
    """Return `mask` and the voxels from which it is met in four of the six directions of the axes.

    The inside of a head is no hole where the volume ends in the neck, where nose and orbits open the skull, or where
    the scalp is too dim.
    """
    met = np.zeros(mask.shape, dtype=np.uint8)
    for axis in range(3):
        met += np.logical_or.accumulate(mask, axis=axis)
        met += np.flip(np.logical_or.accumulate(np.flip(mask, axis), axis=axis), axis)
    return np.asarray(met >= 4)


def _is_stripped(image: NDArray[np.float32], foreground: BoolArray) -> bool:
    """Tell whether the foreground is a brain alone: no larger than one, and without a bright skin around it."""
    if foreground.sum() * COARSE**3 > LARGEST_BRAIN:
        return False
    depth = depths(foreground) * COARSE
    inside = image[depth > UNDER_SKULL]
    if not inside.size:
        return True
    return bool(np.median(image[foreground & (depth <= 6.0)]) < SCALP * np.median(inside))


def _strip(image: NDArray[np.float32], foreground: BoolArray) -> BoolArray:
    """Return the brain of a whole head, on the coarse grid.

    The tissue deep in the head tells the brain's intensities; of the voxels that have them, those that hang together
    after an erosion (which cuts the bridges of meninges, nerves and vessels through the skull) are grown back.
    """
    # The skull parts brain and scalp, of which only the larger is in the foreground.
    head = surrounded(closed(foreground, 3))
    depth = depths(head) * COARSE
    deep = head & (depth > min(30.0, 0.6 * float(depth.max())))
    if not deep.any():
        return np.zeros_like(foreground)
    # Coils brighten what is near them by a factor of two and more. The tissue below the skull tells by how much; fat
    # and vessels are cut off, or they would stand for it.
    middle = float(np.median(image[deep]))
    inner = (head & (depth > UNDER_SKULL)).astype(np.float32)
    capped = np.minimum(image, 1.5 * middle) * inner
    sigma = BIAS_SCALE / COARSE
    share = gaussian(inner, sigma)
    local = gaussian(capped, sigma) / np.maximum(share, 1e-3)
    even = np.where(share > 1e-3, image / np.maximum(local, 0.1 * middle), 0.0)
    values = even[deep]
    middle = float(np.median(values))
    spread = 1.4826 * float(np.median(np.abs(values - middle)))
    tissue = head & (even > max(middle - 2.5 * spread, 0.6 * middle)) & (even < middle + 4.0 * spread)
    # Sulci and ventricles are holes in the tissue, smaller than the skull is thick: they must not part the brain. Scalp
    # is never deeper than 6 mm; near the rim only what an inner core reaches counts.
    solid = (gaussian(tissue.astype(np.float32), 1.0) > MOSTLY) & (depth > 6.0)
    # The grid's last axis is the one nearest to superior.
    top = int(np.flatnonzero(head.any(axis=(0, 1)))[-1])
    height = np.clip(1.0 - (top - np.arange(head.shape[2])) * COARSE / HEIGHT, 0.0, 1.0)
    core = _core(solid, tissue, depth * height, ERODED)
    # Face and neck hang together with the brain where the base of the skull is thin. They are what goes with further
    # erosions, is large, and lies low.
    for steps in range(ERODED + 1, ERODED + 3):
        less = _core(solid, tissue, depth * height, steps)
        gone = largest_part(core & ~less)
        size = np.count_nonzero(gone)
        if size > FACE * np.count_nonzero(less) > 0 and float(gone.sum(axis=(0, 1)) @ height) < LOW * size:
            core = less
    return np.asarray(closed(core, CLOSED) & (depth > 4.0))


def _core(solid: BoolArray, tissue: BoolArray, weight: NDArray[np.float32], steps: int) -> BoolArray:
    """Return the part of `solid` with the most weight after an erosion, grown back through `tissue`.

    The most depth near the vertex, not the most voxels: the muscles of face and neck are large, but near the skin and
    far below.
    """
    seed = eroded(solid, steps)
    labels, count = ndimage.label(seed)
    if count == 0:
        return np.zeros_like(solid)
    sums = ndimage.sum_labels(np.where(seed, weight, 0.0), labels, np.arange(1, count + 1))
    core = labels == int(np.argmax(sums)) + 1
    # Step by step through tissue: a ball of the same reach would jump the skull.
    for _ in range(REGROWN + steps - ERODED):
        core = core | (dilated(core, 1) & tissue)
    return np.asarray(core)


def _background_value(volume: Volume) -> float | None:
    """Return the value that fills the space around a stripped brain, or None where the background is not constant.

    A brain is round: the eight corners of its volume, an eighth of each edge long, are background.
    """
    data = volume.data
    ends = [(slice(0, max(1, n // 8)), slice(n - max(1, n // 8), n)) for n in data.shape]
    corners = np.concatenate([data[box].ravel() for box in itertools.product(*ends)])
    values, counts = np.unique(corners, return_counts=True)
    share = float(counts.max()) / corners.size
    return float(values[int(counts.argmax())]) if share > CONSTANT_SHARE else None


def _not_background(grid: WorkingGrid, volume: Volume) -> BoolArray:
    background = _background_value(volume)
    if background is None:
        return np.ones(grid.shape, dtype=np.bool_)
    values = grid.sample(volume.with_data((volume.data != background).astype(np.float32)))
    with np.errstate(invalid="ignore"):
        return np.asarray(values > 0.5)


def _upsampled(grid: WorkingGrid, coarse: WorkingGrid, mask: BoolArray) -> BoolArray:
    values = grid.sample(Volume(mask.astype(np.float32), coarse.affine))
    with np.errstate(invalid="ignore"):
        return np.asarray(values >= 0.5)


def _box_on(full: WorkingGrid, coarse: WorkingGrid, mask: BoolArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return first and one past last voxel of `full` around `mask`, with a margin for filters."""
    inside = np.argwhere(mask)
    low, high = inside.min(axis=0) - 1.5, inside.max(axis=0) + 1.5
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1).T
    world = corners @ coarse.affine[:3, :3].T + coarse.affine[:3, 3]
    index = (world - full.affine[:3, 3]) @ np.linalg.inv(full.affine[:3, :3]).T
    first = np.maximum(np.floor(index.min(axis=0)) - 2, 0).astype(np.int64)
    last = np.minimum(np.ceil(index.max(axis=0)) + 3, full.shape).astype(np.int64)
    return first, last
