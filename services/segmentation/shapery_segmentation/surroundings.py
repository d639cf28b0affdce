"""Vessels and bleedings around what was found, from a further volume of the same head (3.5.3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.segmentation import SegmentationParams
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.rasterize import rasterize
from shapery_geometry.volume import Volume
from shapery_segmentation.microhemorrhage import Microhemorrhages, find_microhemorrhages
from shapery_segmentation.seeding.ball import surface_of
from shapery_segmentation.vessels import Vessels, segment_vessels

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What lies around the objects.

    Parameters
    ----------
    vessels
    vessel_voxels : (I, J, K) bool
        On the grid of the volume after contrast.
    bleedings
        None where they were not looked for.
    bleeding_voxels : (I, J, K) bool
        On the same grid.
    bleeding_surface
        Of all clusters, RAS mm; None without any.
    warnings
        Sentences for the user.
    """

    vessels: Vessels
    vessel_voxels: BoolArray
    bleedings: Microhemorrhages | None
    bleeding_voxels: BoolArray
    bleeding_surface: TriangleMesh | None
    warnings: tuple[str, ...]


def find_surroundings(
    volume: Volume,
    objects: BoolArray,
    grid: Volume,
    params: SegmentationParams,
    *,
    check_cancelled: Callable[[], None],
) -> Surroundings:
    """Recover vessels, and bleedings beside them.

    Parameters
    ----------
    volume
        Shows vessels; already where the head lies in `grid`.
    objects : (I, J, K) bool
        What was found, on `grid`; if it is empty, vessels are looked for everywhere.
    grid
        The volume after contrast.
    params
        Of these `polarity`, `vessel_seeds` and `microhemorrhages`.
    check_cancelled
        See `shapery_segmentation.segment`.

    Raises
    ------
    InvalidInput
        ``no_object_found`` where none of the user's seeds lies in a vessel; see `segment_vessels` for the rest.
    """
    around: BoolArray | None = grid.with_data(objects.astype(np.uint8)).resampled_to(volume, method="nearest").data > 0
    if around is not None and not around.any():
        around = None
    vessels = segment_vessels(
        volume,
        params.vessel_seeds or None,
        around=around,
        polarity=params.polarity,
        check_cancelled=check_cancelled,
    )
    warnings = list(vessels.warnings)
    bleedings = None
    kind = params.microhemorrhages
    if kind == "auto":
        kind = "dark" if vessels.polarity == "dark" else "off"
    if kind != "off" and (vessels.mask.any() or around is not None):
        bleedings = find_microhemorrhages(
            volume, vessels=vessels.mask, tumor=around, polarity=kind, check_cancelled=check_cancelled
        )
    empty = np.zeros(grid.shape, dtype=np.bool_)
    bled = bleedings is not None and bool(bleedings.clusters)
    return Surroundings(
        vessels=vessels,
        vessel_voxels=_on(grid, volume, vessels.mask, vessels.surfaces),
        bleedings=bleedings,
        bleeding_voxels=_on(grid, volume, bleedings.mask, ()) if bleedings is not None and bled else empty,
        bleeding_surface=surface_of(bleedings.mask, volume.affine) if bleedings is not None and bled else None,
        warnings=tuple(warnings),
    )


def _on(grid: Volume, volume: Volume, mask: BoolArray, surfaces: tuple[TriangleMesh, ...]) -> BoolArray:
    """Return a mask of `volume` on `grid`: as it is on the same grid, else what lies inside its surfaces or near it."""
    if volume.same_grid(grid):
        return mask
    if surfaces:
        inside = np.zeros(grid.shape, dtype=np.bool_)
        for surface in surfaces:
            inside |= rasterize(surface, grid)
        return inside
    values = volume.with_data(mask.astype(np.float32)).resampled_to(grid, fill=0.0).data
    return np.asarray(values >= 0.5)
