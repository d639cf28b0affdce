"""The normal surface flow (3.4.1): a closed surface moves along its normals until it rests on the object.

The equation
------------
The dissertation's Eq. 3.1–3.3, with n the outward unit normal, H the mean curvature and v a constant::

    ∂s/∂t = (g·(v + H) − ∇g·n) n,     g = 1 / (1 + |∇(Gσ ∗ I)|²)

and its rule (3.4.1) that a vertex moves outwards where the intensity exceeds a threshold, inwards where it does not.
Two models of the speed are offered; both work in mm, whatever the spacing and orientation of the grid.

``model="threshold"``
    F = tanh(U − τ) where the surface is allowed, −1 elsewhere. F stands for g·v: its sign is the rule's, and it falls
    to zero at the border as g would, but to both sides of it, so the border attracts and −∇g·n is not needed. U is in
    units of the noise (see `shapery_segmentation.calibration`), and tanh makes all that is surely inside equally fast.
    τ runs: a share of the median inside, within bounds.
``model="gradient"``
    Eq. 3.1 itself, with the gradient in units of a percentile of its own (see `shapery_segmentation.flow.edges`),
    because g of Eq. 3.3 changes with the unit of the intensities. It stops at edges of any brightness, and runs through
    gaps in them.

In both a vertex moves ``step·h·F`` along n in one iteration, h the edge length (near the border of the threshold model,
where the slope of F along n tells how far it is, by up to three times as much: Newton's step), and on top of that
``curvature_weight`` of the way to the plane of its neighbours: for a regular mesh that is H·h²/2 with H negative where
the surface is convex, so the term g·H of Eq. 3.1 with a weight that falls with h² (in the gradient model it is
multiplied by g). Across n it moves ``tangential_weight`` of the way to the mean of its neighbours, which spreads
vertices evenly and does not change the surface.

How it ends
-----------
A vertex sleeps when its net way along the normal is small, wakes when its neighbours move, is stopped when it has
changed its direction too often (S5), and is frozen
while another part of the surface is in its way (S4). Frozen vertices that guard a small feature get finer triangles;
those on a thin piece that is not object collapse. The moves of one or two iterations are tested before they count
where anything is near that they could meet, and in the end all of the surface is (see `shapery_segmentation.mesh`), so
what is returned is closed, manifold, oriented, and free of self-intersections, whatever the field. It keeps the seed's
genus, too, unless
``topology="adaptive"`` lets fronts that meet inside the object merge and necks outside of it split (see
`shapery_segmentation.flow.topology`).

Where the data show no border under the surface at rest, vertices are interpolated between those that have one (S8).

A seed that lies in nothing shrinks until it is gone; that is told by ``vanished`` and is no error, because dropping
false alarms this way is part of the method (3.5.1).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.volume import check_affine
from shapery_segmentation.flow.evolving import Evolution
from shapery_segmentation.flow.params import FlowResult, FlowState, NormalFlowParams, StageRecord
from shapery_segmentation.mesh.dynamic_mesh import MENDINGS

__all__ = ["FlowResult", "FlowState", "NormalFlowParams", "StageRecord", "normal_flow"]


def normal_flow(
    field: NDArray[np.float32],
    allowed: NDArray[np.bool_] | None,
    affine: NDArray[np.float64],
    seed: TriangleMesh,
    params: NormalFlowParams | None = None,
    *,
    threshold: float,
    on_iteration: Callable[[FlowState], None] | None = None,
) -> FlowResult:
    """Let a surface flow to the border of an object.

    Parameters
    ----------
    field : (I, J, K) float32
        For the threshold model the calibrated difference; for the gradient model any intensity. Voxels that are not
        finite count as not allowed.
    allowed : (I, J, K) bool
        Where the surface may go; everywhere in the grid if it is not given.
    affine : (4, 4) float64
        From voxel index to RAS mm; any spacing, oblique, sheared or mirrored.
    seed
        Closed, manifold surface in RAS mm with faces that look outwards, without self-intersections.
    params
        How; the defaults are those measured on enhancing tumors at 1 mm.
    threshold
        τ to begin with, in the field's units. The gradient model does not use it.
    on_iteration
        Called after each iteration; what it raises ends the flow and passes through. After every second one the
        surface that it can ask for may not have been tested yet.

    Returns
    -------
    FlowResult

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where the seed is not as demanded; ``invalid_volume`` where shapes differ or the affine spans
        no space.

    Notes
    -----
    The same input gives the same bytes. Time and memory grow with the surface, not with the volume.

    References
    ----------
    Section 3.4.1 of the dissertation, Eq. 3.1–3.3, Figs 3.1–3.5.
    """
    p = params if params is not None else NormalFlowParams()
    if not np.isfinite(threshold):
        raise ValueError(f"the threshold must be finite, not {threshold}")
    if field.ndim != 3 or (allowed is not None and allowed.shape != field.shape):
        other = "" if allowed is None else f", the region allowed has {allowed.shape}"
        raise InvalidInput(
            "invalid_volume", f"The field has the shape {field.shape}{other}: three equal sizes are due."
        )
    affine = check_affine(affine)
    # What hardly ever touches anything is not tested while it moves, but in the end. Should it touch something all the
    # same, that is mended where it is; where it cannot be, the flow begins again, and every move is tested.
    untouched = False
    for thorough in (False, True):
        evolution = Evolution(field, allowed, affine, seed, p, threshold, thorough)
        for stage in range(len(p.edge_lengths)):
            evolution.run_stage(stage, on_iteration)
            if evolution.vanished:
                break
        if untouched := evolution.mesh.mend(0 if thorough else MENDINGS):
            break
    return evolution.result(untouched)
