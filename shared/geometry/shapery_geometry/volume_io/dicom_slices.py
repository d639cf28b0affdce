"""From single DICOM slices to one regular volume, or a report of why they form none.

Slices are ordered by where they lie along their normal; names and instance numbers decide nothing.

References
----------
DICOM PS3.3 section C.7.6.2.1.1 (image position and orientation).
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from shapery_contracts.errors import InvalidInput
from shapery_geometry.volume import FloatArray, check_affine

LARGEST_DEVIATION: Final = 0.1
"""How far a slice may lie from its place in an even stack, as a fraction of the slice distance. Positions rounded to
0.1 mm deviate by up to 0.07 of a distance of 0.7 mm; a missing slice makes a deviation of at least 0.2."""
LARGEST_DRIFT: Final = 0.25
"""The same within the plane, as a fraction of the pixel spacing."""
LARGEST_TURN: Final = 1e-3
"""Largest difference of a direction cosine between slices of one orientation."""
_NAMED: Final = 5
"""How many places a report names."""

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class DicomSlice:
    """One slice, or one frame of a multi-frame file."""

    file: int
    """Index into the list of files."""
    name: str
    """File name, with the frame's number where it has several."""
    frame: int
    series: str
    description: str
    """Modality and series description."""
    rows: int
    columns: int
    position: Vector | None
    """Centre of the first pixel, LPS mm."""
    row_direction: Vector | None
    """Direction in which the column index grows."""
    column_direction: Vector | None
    spacing: tuple[float, float] | None
    """Distance between rows, and between columns, in mm."""
    slope: float
    intercept: float
    moment: tuple[float, ...]
    """Orders slices at the same place: time, echo, b-value, instance."""
    uid: str


@dataclass(frozen=True, slots=True)
class DicomStack:
    """Slices in their order."""

    volumes: tuple[tuple[DicomSlice, ...], ...]
    """Per volume at the same place (time point, echo, …) its slices along the normal."""
    affine: FloatArray
    """From (column, row, slice) to RAS mm."""
    warnings: tuple[str, ...]


def choose_series(slices: Sequence[DicomSlice], series: str | None) -> list[DicomSlice]:
    """Return the slices of the one series.

    Raises
    ------
    InvalidInput
        ``mixed_series`` with a list of them, if there are several and `series` chooses none.
    """
    groups: dict[str, list[DicomSlice]] = defaultdict(list)
    for item in slices:
        groups[item.series].append(item)
    if series is None and len(groups) == 1:
        return list(slices)
    if series is not None and series in groups:
        return groups[series]
    ordered = sorted(groups.items(), key=lambda item: -len(item[1]))
    listed = "; ".join(
        f"{group[0].description or 'without a description'}: {_count(len(group), 'slice')} of "
        f"{group[0].columns}×{group[0].rows}, series {uid or 'without a UID'}"
        for uid, group in ordered[:20]
    )
    more = f"; and {len(ordered) - 20} more" if len(ordered) > 20 else ""
    if series is not None:
        raise InvalidInput("mixed_series", f"No file belongs to series {series}. There are: {listed}{more}.")
    raise InvalidInput(
        "mixed_series",
        f"The files belong to {len(groups)} series. {listed}{more}.",
        "Send the files of one series, or choose one by its UID.",
    )


def stack_slices(slices: Sequence[DicomSlice]) -> DicomStack:
    """Order the slices of one series and check that they form a regular volume.

    Raises
    ------
    InvalidInput
        ``irregular_series`` with a report, or ``invalid_volume`` for a single slice.
    """
    _check_alike(slices)
    first = slices[0]
    assert first.row_direction is not None
    assert first.column_direction is not None
    assert first.spacing is not None
    along_row = np.array(first.row_direction)
    along_column = np.array(first.column_direction)
    normal = np.cross(along_row, along_column)
    normal /= np.linalg.norm(normal)
    ordered = sorted(slices, key=lambda s: (float(np.dot(s.position or (0, 0, 0), normal)), s.moment, s.name))
    depth = np.array([np.dot(s.position or (0, 0, 0), normal) for s in ordered])
    places = _group_places(ordered, depth)
    if len(places) == 1:
        raise InvalidInput(
            "invalid_volume",
            f"The series holds a flat image with {first.columns} × {first.rows} pixels at one position, not a volume.",
            "Send all slices of the series.",
        )
    _check_places(places, ordered, depth)
    volumes = tuple(
        zip(*(sorted((ordered[i] for i in place), key=lambda s: s.moment) for place in places), strict=True)
    )
    warnings: list[str] = []
    step, origin = _check_even(volumes[0], normal, min(first.spacing), warnings)
    matrix = np.eye(4)
    matrix[:3, 0] = along_row * first.spacing[1]
    matrix[:3, 1] = along_column * first.spacing[0]
    matrix[:3, 2] = step
    matrix[:3, 3] = origin
    # LPS to RAS
    matrix[:2] *= -1.0
    return DicomStack(volumes, check_affine(matrix + 0.0), tuple(warnings))


def _irregular(message: str, hint: str = "Send all slices of one regular series, each once.") -> InvalidInput:
    return InvalidInput("irregular_series", message, hint)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _named(items: Sequence[str]) -> str:
    more = f" and {len(items) - _NAMED} more" if len(items) > _NAMED else ""
    return "; ".join(items[:_NAMED]) + more


def _check_alike(slices: Sequence[DicomSlice]) -> None:
    """Refuse slices without a place, of several sizes, spacings or orientations."""
    lost = [s.name for s in slices if s.position is None or s.row_direction is None or s.column_direction is None]
    if lost:
        raise _irregular(
            f"{len(lost)} of {_count(len(slices), 'slice')} do not say where they lie (no image position or "
            f"orientation): {_named(lost)}.",
            "Send the original images, not secondary captures or screenshots.",
        )
    unscaled = [s.name for s in slices if s.spacing is None]
    if unscaled:
        raise _irregular(
            f"{len(unscaled)} of {_count(len(slices), 'slice')} have no pixel spacing: {_named(unscaled)}."
        )
    _check_one("sizes", [(f"{s.columns}×{s.rows}", s.name) for s in slices])
    reference = slices[0]
    spacings = np.array([s.spacing for s in slices])
    if np.abs(spacings - spacings[0]).max() > 1e-3 * spacings[0].min():
        _check_one("pixel spacings", [(f"{s.spacing[0]:g}×{s.spacing[1]:g} mm", s.name) for s in slices if s.spacing])
    directions = np.array([[*(s.row_direction or ()), *(s.column_direction or ())] for s in slices])
    if np.abs(directions - directions[0]).max() > LARGEST_TURN:
        kinds = [("\\".join(f"{v:.3f}" for v in row), s.name) for row, s in zip(directions, slices, strict=True)]
        _check_one("orientations", kinds)
        raise _irregular(f"The orientation of the slices varies by up to {np.ptp(directions, axis=0).max():.4f}.")
    across = abs(float(np.dot(reference.row_direction or (), reference.column_direction or ())))
    if across > 1e-2:
        raise _irregular(f"Rows and columns of the slices are not at right angles (cosine {across:.3f}).")


def _check_one(what: str, kinds: Sequence[tuple[str, str]]) -> None:
    counts = Counter(kind for kind, _ in kinds)
    if len(counts) < 2:
        return
    examples = dict(reversed(kinds))
    listed = [f"{number} with {kind} (such as {examples[kind]})" for kind, number in counts.most_common()]
    raise _irregular(
        f"The slices have {len(counts)} different {what}: {_named(listed)}.",
        "Leave out the slices that do not belong to the volume, such as localizers.",
    )


def _group_places(ordered: Sequence[DicomSlice], depth: FloatArray) -> list[list[int]]:
    """Return indices of slices grouped by place along the normal."""
    gaps = np.diff(depth)
    real = gaps[gaps > 1e-4]
    tolerance = max(1e-4, 0.05 * float(np.median(real))) if real.size else 1e-4
    places: list[list[int]] = [[0]]
    for index in range(1, len(ordered)):
        if depth[index] - depth[places[-1][0]] <= tolerance:
            places[-1].append(index)
        else:
            places.append([index])
    return places


def _check_places(places: Sequence[Sequence[int]], ordered: Sequence[DicomSlice], depth: FloatArray) -> None:
    """Refuse places that hold different numbers of slices, or one slice twice."""
    usual, _ = Counter(len(place) for place in places).most_common(1)[0]
    odd = [place for place in places if len(place) != usual or len({ordered[i].uid for i in place}) != len(place)]
    if not odd:
        return
    listed = [f"{depth[place[0]]:.2f} mm: {', '.join(ordered[i].name for i in place[:4])}" for place in odd]
    raise _irregular(
        f"{_count(len(odd), 'position')} of {len(places)} hold another number of slices than the usual {usual}, or "
        f"one slice twice. At {_named(listed)}."
    )


def _check_even(
    volume: Sequence[DicomSlice], normal: FloatArray, pixel: float, warnings: list[str]
) -> tuple[FloatArray, FloatArray]:
    """Return the step from slice to slice and the first slice's position, LPS mm."""
    positions = np.array([s.position for s in volume])
    count = len(positions)
    step = (positions[-1] - positions[0]) / (count - 1)
    distance = float(step @ normal)
    steps = np.arange(count)
    # Each slice is compared with the even stack that fits best, so that a gap shows where it is.
    slope, start = np.polyfit(steps, positions, 1)
    residual = positions - (start + steps[:, None] * slope)
    off = np.abs(residual @ normal)
    if off.max() > LARGEST_DEVIATION * distance:
        raise _irregular(_gap_report(volume, positions @ normal))
    drift = residual - (residual @ normal)[:, None] * normal
    sideways = np.sqrt((drift**2).sum(axis=1))
    if sideways.max() > LARGEST_DRIFT * pixel:
        worst = int(sideways.argmax())
        raise _irregular(
            f"Slice {volume[worst].name} lies {sideways[worst]:.2f} mm beside its neighbours, within its plane."
        )
    if off.max() > 0.02 * distance:
        warnings.append(
            f"The slice distance varies between {np.diff(positions @ normal).min():.3f} and "
            f"{np.diff(positions @ normal).max():.3f} mm; an even {distance:.3f} mm was taken."
        )
    tilt = math.degrees(math.acos(min(1.0, distance / float(np.linalg.norm(step)))))
    if tilt > 0.1:
        warnings.append(f"The slices are tilted by {tilt:.1f}° against the stack; the volume is kept sheared.")
    return step, positions[0]


def _gap_report(volume: Sequence[DicomSlice], depth: FloatArray) -> str:
    distances = np.diff(depth)
    usual = float(np.median(distances))
    odd = [i for i, d in enumerate(distances) if abs(d - usual) > LARGEST_DEVIATION * usual]
    if not odd:
        return (
            f"The distance between slices drifts from {distances.min():.3f} to {distances.max():.3f} mm over "
            f"{len(volume)} slices."
        )
    places = []
    for i in odd:
        missing = round(float(distances[i]) / usual) - 1
        note = f", so {_count(missing, 'slice')} {'is' if missing == 1 else 'are'} missing" if missing > 0 else ""
        places.append(
            f"{distances[i]:.3f} mm between {volume[i].name} at {depth[i]:.2f} mm and {volume[i + 1].name} at "
            f"{depth[i + 1]:.2f} mm{note}"
        )
    return f"Slices lie {usual:.3f} mm apart, but {_named(places)}."
