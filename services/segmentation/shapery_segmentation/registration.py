"""Rigid co-registration of two volumes of one head (S10, 3.3 and 3.5.1).

Where a volume lies is told by its affine, so registration changes the affine and no voxel: nothing is interpolated
twice, and a volume that already lies right comes back as it was.

Agreement is the mutual information of the intensities of both (Viola and Wells, 1997; Mattes et al., 2003), which asks
for no common scale and no common contrast. It is first measured where the volume lies and a little beside that place: a
volume that agrees best where it is stays there, and the search is never begun.

References
----------
Section 3.3 of the dissertation. D. Mattes et al., "PET-CT image registration in the chest using free-form
deformations", IEEE Trans. Med. Imaging 22 (2003), doi:10.1109/TMI.2003.809072.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_contracts.errors import InvalidInput
from shapery_contracts.segmentation import Alignment
from shapery_geometry.concurrent import at_once, both
from shapery_geometry.volume import Volume
from shapery_segmentation import _registration_kernels as kernels
from shapery_segmentation.neighborhoods import eroded, filled
from shapery_segmentation.preparation import averaged
from shapery_segmentation.smoothing import gaussian

FloatArray = NDArray[np.float64]

STEP = 2.0
"""mm: volumes are averaged to voxels of about this size. The position of a head is then found to a fifth of it."""

POINTS = 20_000
"""Places in the head at which the volumes are compared."""

BINS = 32
"""Classes of intensity of either volume."""

BESIDE = 2.0
"""mm and degrees: how far beside its place a volume is tried."""

LEAST_BESIDE = 0.25
"""The same at the end of the ascent: what is nearer differs by the noise of the interpolation."""

ARRIVED_MM = 0.1
"""Way of one step after which the ascent ends."""

STILL_MM = 0.5
"""A volume whose best place is nearer than this is not moved: the search itself is hardly surer."""

NEAR_MM = 3.0
"""A volume whose best place is nearer than this is not searched for, but led up to it."""

LEAST_GAIN = 0.005
"""Mutual information (nat) that a search must gain for the volume to be moved."""

HEAD_RADIUS = 70.0
"""mm at which a rotation is counted as a way."""

BAND = (1.0, 3.0)
"""mm: deviations of the two Gaussians whose difference keeps sulci and ventricles, and drops noise and brightness."""

DEPTH = 8.0
"""mm below the surface of the head, or of the stripped brain, from which fine structure is compared: all surfaces are
alike once they lie on each other."""

DIFFERENT, DOUBTFUL = 0.12, 0.18
"""Correlation of the fine structure below which two volumes do not show one brain, and below which that is in doubt.
On real cases, volumes of one subject before and after contrast have 0.23 to 0.66, those of two subjects −0.02 to
0.12."""

LEAST_OVERLAP = 0.3
"""Share of the head that must lie in both volumes to tell whether they show one."""

TITLES = {"pre": "volume before contrast", "vessels": "volume that shows vessels"}

FINE_ENOUGH = 3.5
"""mm: where voxels are longer, fine structure is averaged away, and unlike volumes are only warned of."""

LEVELS = (4.0, 2.0)
"""Voxels in mm of the search, coarse to fine."""

SEARCHED = 40_000
"""Voxels that the search looks at."""

_STEPS_OF_SEARCH = 200


@dataclass(frozen=True, eq=False)
class Registration:
    """Where one volume lies relative to another.

    Parameters
    ----------
    transform : (4, 4) float64
        Rigid, from where the moving volume's file says a point lies to where it lies in the fixed one, RAS mm.
    moved
        Whether `transform` is anything but the identity.
    agreement, agreement_before
        Mutual information in nat, at that place and where the file says.
    likeness
        Correlation of the fine structure of both at that place: tells one head from two.
    overlaps
        Whether enough of the heads lies in both volumes for that.
    """

    transform: FloatArray
    moved: bool
    agreement: float
    agreement_before: float
    likeness: float
    overlaps: bool

    @property
    def degrees(self) -> float:
        """Angle of the rotation."""
        return rotation_degrees(self.transform)

    def shift(self, point: FloatArray) -> float:
        """Return by how many mm a point of the moving volume is moved."""
        return float(np.linalg.norm(self.transform[:3, :3] @ point + self.transform[:3, 3] - point))

    def apply(self, volume: Volume) -> Volume:
        """Return the moving volume where it lies in the fixed one; the very same if it was not moved."""
        return Volume(volume.data, self.transform @ volume.affine, volume.warnings) if self.moved else volume


def register(moving: Volume, fixed: Volume, *, rng: np.random.Generator) -> Registration:
    """Find the rigid motion that brings `moving` onto `fixed`.

    Parameters
    ----------
    moving, fixed
        Of one head, on any grids, of any contrast.
    rng
        Chooses the places that are compared.

    Notes
    -----
    Near the best place parabolas lead up to it (`_Pair.ascend`). Far from it the search is SimpleITK's: Mattes' mutual
    information, gradient descent, 4 mm and then 2 mm, from the place that the files say and, where that is poor, from
    the place where the centres of both heads meet.
    """
    pair = _Pair(moving, fixed, rng)
    here = np.eye(4)
    before = pair.agreement(here)
    off = _arc(pair.way_up(here, before, BESIDE)) if pair.overlap(here) > 0.5 else float("inf")
    if off < STILL_MM:
        return pair.result(here, False, before)
    if off < NEAR_MM:
        found = pair.ascend(here)
    else:
        starts = [here] if pair.overlap(here) > LEAST_OVERLAP else []
        centred = pair.centred()
        if not starts or np.linalg.norm(centred[:3, 3]) > 10.0:
            starts.append(centred)
        ends = [_search(pair, start, int(rng.integers(1, 2**31))) for start in starts]
        found = max(ends, key=pair.agreement)
    best = pair.agreement(found)
    if best < before + LEAST_GAIN:
        return pair.result(here, False, before)
    return pair.result(found, True, before)


def align(
    moving: Volume,
    fixed: Volume,
    name: Literal["pre", "vessels"],
    move: bool,
    alignments: list[Alignment],
    warnings: list[str],
    *,
    rng: np.random.Generator,
) -> tuple[Volume, float]:
    """Return a volume where it lies in the one after contrast, and how sure it is that both show one head.

    Parameters
    ----------
    moving, fixed
        The volume named `name`, and the one after contrast.
    name
        ``pre`` is of the same kind as `fixed`, so its fine structure must be the same; of ``vessels`` nothing is asked.
    move
        Whether it may be moved; otherwise it is only compared.
    alignments, warnings
        What was found is added; a sentence where the volume was moved, and where it is in doubt whether both show one
        head.
    rng
        See `register`.

    Returns
    -------
    The volume, and a factor in (0, 1] for the confidence of what is found.

    Raises
    ------
    InvalidInput
        ``different_subjects`` where the volume before contrast has no fine structure in common with the one after it.
    """
    found = register(moving, fixed, rng=rng) if move else compare(moving, fixed, rng=rng)
    way = found.shift(moving.to_world((np.array(moving.shape) - 1) / 2))
    alignments.append(
        Alignment(
            input=name,
            moved=found.moved,
            shift_mm=round(way, 3),
            degrees=round(found.degrees, 3),
            mutual_information_before=round(found.agreement_before, 4),
            mutual_information=round(found.agreement, 4),
        )
    )
    if found.moved:
        warnings.append(
            f"The {TITLES[name]} was moved by {way:.1f} mm and turned by {found.degrees:.1f}° onto the one after "
            "contrast."
        )
    if name != "pre" or found.likeness >= DOUBTFUL or not found.overlaps:
        return found.apply(moving), 1.0
    fine = max(*moving.spacing, *fixed.spacing) <= FINE_ENOUGH
    if fine and found.likeness < DIFFERENT:
        raise InvalidInput(
            "different_subjects",
            f"The volumes before and after contrast do not show the same head: their fine structure correlates by "
            f"{found.likeness:.2f}, in one head by 0.23 and more.",
            "Give two T1-weighted volumes of one patient and one session.",
        )
    warnings.append(
        f"It is in doubt whether both volumes show the same head (their fine structure correlates by "
        f"{found.likeness:.2f}): check the result."
    )
    return found.apply(moving), 0.5


def compare(moving: Volume, fixed: Volume, *, rng: np.random.Generator) -> Registration:
    """Return how well two volumes agree where they lie, without moving any."""
    pair = _Pair(moving, fixed, rng)
    return pair.result(np.eye(4), False, pair.agreement(np.eye(4)))


def rotation_degrees(transform: FloatArray) -> float:
    """Return the angle of a rigid transform's rotation."""
    cosine = (float(np.trace(transform[:3, :3])) - 1.0) / 2.0
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def rigid(degrees: FloatArray | tuple[float, float, float], shift: Any, centre: Any) -> FloatArray:
    """Return the rigid transform that turns about x, y and z (in this order) around `centre` and then shifts."""
    a, b, c = np.deg2rad(np.asarray(degrees, dtype=np.float64))
    x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    transform = np.eye(4)
    transform[:3, :3] = z @ y @ x
    transform[:3, 3] = np.asarray(centre) - transform[:3, :3] @ np.asarray(centre) + np.asarray(shift)
    return transform


class _Pair:
    """Both volumes, coarse, and the places at which they are compared."""

    def __init__(self, moving: Volume, fixed: Volume, rng: np.random.Generator) -> None:
        self.moving, self.fixed = at_once(_coarse, (moving, fixed))
        head = _head(self.fixed)
        index = np.argwhere(head)
        self.centre = self.fixed.to_world(index.mean(axis=0))
        moving_head = np.argwhere(_head(self.moving))
        self.moving_centre = self.moving.to_world(moving_head.mean(axis=0))
        chosen = index[rng.integers(0, len(index), POINTS)]
        # Anywhere in the voxels: at their centres one volume would be interpolated and the other not, and agreement
        # would jump where the grids meet.
        self.points = np.ascontiguousarray(self.fixed.to_world(chosen + rng.uniform(-0.5, 0.5, chosen.shape)))
        values, _ = _sampled(self.fixed, self.points)
        self.fixed_bins = _bins(values)
        low, high = np.percentile(self.moving.data[_head(self.moving)], (0.5, 99.5))
        self.range = (float(min(low, self.moving.data.min())), float(high))

    def overlap(self, transform: FloatArray) -> float:
        """Return the share of the places that lie within the moving volume when it is moved."""
        return float(np.mean(_sampled(self.moving, self._back(transform))[1]))

    def agreement(self, transform: FloatArray) -> float:
        """Return the mutual information in nat with the moving volume moved; 0 where they hardly overlap."""
        # To the moving volume's index: back to where its file says, and from there into its grid.
        into = np.linalg.inv(transform @ self.moving.affine)
        matrix, offset = np.ascontiguousarray(into[:3, :3]), np.ascontiguousarray(into[:3, 3])
        joint = np.empty((BINS, BINS))
        data = self.moving.data
        count = kernels.joint_histogram(data, matrix, offset, self.points, self.fixed_bins, *self.range, joint)
        if count < 0.2 * len(self.points):
            return 0.0
        return float(kernels.mutual_information(joint, count))

    def way_up(self, start: FloatArray, here: float, beside: float) -> FloatArray:
        """Return how far along each of six axes (mm, degrees) the place of best agreement lies from `start`.

        Parameters
        ----------
        start, here
            A place, and the agreement there.
        beside
            mm and degrees at which agreement is looked at to either side: the way leads to the top of the parabola
            through the three. It is infinite where the best of them is at a side, or they have no top.
        """
        way = np.empty(6)
        for axis in range(6):
            step = np.zeros(6)
            step[axis] = beside
            back, forth = (self.agreement(self._beside(start, sign * step)) for sign in (-1.0, 1.0))
            bend = 2.0 * here - back - forth
            top = here > max(back, forth) and bend > 0
            way[axis] = 0.5 * (forth - back) / bend * beside if top else np.copysign(np.inf, forth - back)
        return way

    def ascend(self, start: FloatArray) -> FloatArray:
        """Return the place of best agreement near `start`: parabola by parabola, from ever nearer sides."""
        here = self.agreement(start)
        beside = BESIDE
        while beside >= LEAST_BESIDE:
            way = np.clip(self.way_up(start, here, beside), -beside, beside)
            there = self._beside(start, way)
            agreement = self.agreement(there)
            if agreement > here:
                start, here = there, agreement
                if _arc(way) < ARRIVED_MM:
                    break
            beside /= 2.0
        return start

    def _beside(self, start: FloatArray, way: FloatArray) -> FloatArray:
        return np.asarray(rigid(way[3:], way[:3], self.centre) @ start)

    def centred(self) -> FloatArray:
        """Return the shift that brings the centre of the moving head to that of the fixed one."""
        transform = np.eye(4)
        transform[:3, 3] = self.centre - self.moving_centre
        return transform

    def result(self, transform: FloatArray, moved: bool, before: float) -> Registration:
        """Return the registration with this transform."""
        likeness = self.likeness(transform)
        after = self.agreement(transform) if moved else before
        return Registration(transform, moved, after, before, likeness, self.overlap(transform) > LEAST_OVERLAP)

    def likeness(self, transform: FloatArray) -> float:
        """Return the correlation of the fine structure deep in both heads, with the moving volume moved."""
        (deep, fixed), (deep_too, moving) = both(
            lambda: _fine_structure(self.fixed, self.points),
            lambda: _fine_structure(self.moving, self._back(transform)),
        )
        deep &= deep_too
        values = (fixed, moving)
        if np.count_nonzero(deep) < 100:
            return 0.0
        # Vessels and tumors, which only one of the two shows, are cut off.
        a, b = (np.clip(v[deep], *np.percentile(v[deep], (5.0, 95.0))) for v in values)
        if not a.std() * b.std() > 0:
            return 0.0
        return float(np.corrcoef(a, b)[0, 1])

    def _back(self, transform: FloatArray) -> FloatArray:
        inverse = np.linalg.inv(transform)
        return np.asarray(self.points @ inverse[:3, :3].T + inverse[:3, 3])


def _arc(way: FloatArray) -> float:
    """Return a way along six axes as mm: over a head a turn moves by its arc."""
    return float(np.sqrt(np.square(way[:3]).sum() + np.square(np.deg2rad(way[3:]) * HEAD_RADIUS).sum()))


def _fine_structure(volume: Volume, points: FloatArray) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
    """Return which points lie deep in the head, and the volume there without its noise and its brightness."""
    sides = np.array(volume.spacing)
    inner = filled(_head(volume))
    for _ in range(max(1, round(DEPTH / float(sides.min())))):
        inner = eroded(inner)
    deep = _sampled(Volume(inner.astype(np.float32), volume.affine), points)[0] > 0.9
    fine, coarse = (gaussian(volume.data, list(sigma / sides), truncate=4.0) for sigma in BAND)
    return deep, _sampled(Volume(fine - coarse, volume.affine), points)[0]


def _coarse(volume: Volume) -> Volume:
    coarse = averaged(volume.filled().canonical()[0], STEP)
    return Volume(np.ascontiguousarray(coarse.data, dtype=np.float32), coarse.affine)


def _head(volume: Volume) -> NDArray[np.bool_]:
    """Return roughly where tissue is: brighter than a share of the bright part."""
    data = volume.data
    low, high = float(data.min()), float(np.percentile(data, 98.0))
    mask = np.asarray(data > low + 0.15 * (high - low))
    return mask if mask.any() else np.ones(data.shape, dtype=np.bool_)


def _bins(values: NDArray[np.floating]) -> NDArray[np.int64]:
    low, high = np.percentile(values, (0.5, 99.5))
    scaled = np.clip((values - low) / max(float(high - low), 1e-30), 0.0, 1.0) * (BINS - 1)
    return np.asarray(scaled, dtype=np.int64)


def _sampled(volume: Volume, points: FloatArray) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return interpolated values at points in RAS mm, and which of them lie in the volume."""
    index = volume.to_index(points)
    inside = np.asarray(((index >= -0.5) & (index <= np.array(volume.shape) - 0.5)).all(axis=1))
    return ndimage.map_coordinates(volume.data, index.T, order=1, mode="nearest"), inside


def _search(pair: _Pair, start: FloatArray, seed: int) -> FloatArray:
    """Return the place of best mutual information that SimpleITK finds from `start`."""
    import SimpleITK as sitk  # noqa: N813

    initial = sitk.Euler3DTransform()
    # SimpleITK maps points of the fixed volume into the moving one: the inverse of what is looked for.
    back = np.linalg.inv(start)
    initial.SetMatrix(back[:3, :3].ravel().tolist())
    initial.SetCenter(pair.centre.tolist())
    initial.SetTranslation((back[:3, :3] @ pair.centre + back[:3, 3] - pair.centre).tolist())
    method = sitk.ImageRegistrationMethod()
    # More threads add in another order each time, and the last digits would differ.
    method.SetNumberOfThreads(1)
    method.SetMetricAsMattesMutualInformation(BINS)
    method.SetMetricSamplingStrategy(method.RANDOM)
    method.SetMetricSamplingPercentagePerLevel(
        [min(1.0, SEARCHED * round(step / STEP) ** 3 / pair.fixed.data.size) for step in LEVELS], seed
    )
    method.SetInterpolator(sitk.sitkLinear)
    method.SetOptimizerAsRegularStepGradientDescent(
        learningRate=2.0, minStep=0.005, numberOfIterations=_STEPS_OF_SEARCH, relaxationFactor=0.6,
        gradientMagnitudeTolerance=1e-6,
    )  # fmt: skip
    # A radian moves the head's surface by its radius; ITK's own estimate of this draws samples that no seed rules.
    method.SetOptimizerScales([HEAD_RADIUS**2] * 3 + [1.0] * 3)
    method.SetShrinkFactorsPerLevel([round(step / STEP) for step in LEVELS])
    method.SetSmoothingSigmasPerLevel([0.5 * step for step in LEVELS])
    method.SmoothingSigmasAreSpecifiedInPhysicalUnitsOn()
    method.SetInitialTransform(initial, inPlace=True)
    try:
        method.Execute(_itk_image(pair.fixed), _itk_image(pair.moving))
    except RuntimeError:  # it ran to where the two don't overlap: nothing is to be found from this start
        return start
    # Its sums differ in their last digits from run to run; beyond these the place says nothing anyway.
    initial.SetParameters([round(value, 6) for value in initial.GetParameters()])
    forward = np.eye(4)
    forward[:3, :3] = np.array(initial.GetMatrix()).reshape(3, 3)
    centre = np.array(initial.GetCenter())
    forward[:3, 3] = centre + np.array(initial.GetTranslation()) - forward[:3, :3] @ centre
    return np.asarray(np.linalg.inv(forward))


def _itk_image(volume: Volume) -> Any:
    """Return a volume for SimpleITK, in the frame RAS: axes as columns of the direction, no flip to LPS."""
    import SimpleITK as sitk  # noqa: N813

    image = sitk.GetImageFromArray(np.ascontiguousarray(volume.data.transpose(2, 1, 0)))
    spacing = np.array(volume.spacing)
    # ITK takes rotations only: the nearest one to axes that are sheared or mirrored.
    axes = volume.affine[:3, :3] / spacing
    image.SetSpacing(spacing.tolist())
    image.SetDirection(axes.ravel().tolist())
    image.SetOrigin(volume.affine[:3, 3].tolist())
    return image
