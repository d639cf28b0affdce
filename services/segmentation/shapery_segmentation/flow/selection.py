"""Model selection (S9, 3.4.4): begin with the normal flow, go on with the tangential flow where the object is a tube.

In a ball all of a growing surface moves until it rests. In a tube most of it soon rests on the wall, and what still
moves are a few clusters of adjacent vertices at its ends, which advance by a fraction of an edge length each time the
whole surface is gone through. Then the mesh is opened there, and grows from the openings instead.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.volume import check_affine
from shapery_segmentation.flow.normal import NormalFlowParams, normal_flow
from shapery_segmentation.flow.tangential import TangentialFlowParams, TangentialFlowResult, tangential_flow

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

FIRST_BURST = 16
"""Iterations before the front is looked at: a seed needs some to meet a wall at all."""

SPEED = 0.5
"""Speed, of at most 1, above which a vertex moves outwards with purpose."""

STEADY = 0.75
"""Share of the largest cluster at the last look that it must still have: the end of a tube stays as large as the tube
is wide, while the last moving part of anything else shrinks."""

FEWEST_RESTING = 12
"""Vertices at rest without which there is nothing to keep."""


@dataclass(frozen=True, slots=True)
class SelectionParams:
    """When to change from one flow to the other, and how both flow.

    Parameters
    ----------
    edge_length
        mm, of both.
    gain
        The field enters the normal flow's speed tanh(U − τ) multiplied by this: with 3, a field that goes from −1
        outside to 1 inside over a voxel has full speed at either end.
    moving_share
        Share of moving vertices below which the front is a few clusters.
    most_clusters
        Clusters at the most that are taken for the ends of tubes.
    least_cluster
        Vertices that a cluster has at least; others are stragglers.
    burst
        Iterations of the normal flow between two looks at the front.
    patience
        Looks in a row that must agree: a ball's last moving parts are clusters, too, but not for long.
    most_bursts
        Looks after which the normal flow goes on alone.
    switch
        Whether to switch at all; without, the normal flow runs to its end (for comparison).
    tangential
        Of the second flow; its edge length is replaced.
    """

    edge_length: float
    gain: float = 3.0
    moving_share: float = 0.4
    most_clusters: int = 12
    least_cluster: int = 3
    burst: int = 8
    patience: int = 2
    most_bursts: int = 40
    switch: bool = True
    tangential: TangentialFlowParams = field(default_factory=TangentialFlowParams)


@dataclass(frozen=True, slots=True)
class SelectionResult:
    """What came of both flows.

    Parameters
    ----------
    mesh
        The surface.
    model
        Which flow made it in the end.
    iterations
        Of the normal flow; where it switched, until then.
    clusters
        Of moving vertices when it switched, the largest first.
    tangential
        What the tangential flow did, if it ran.
    vanished
        Whether the seed shrank to nothing: there is no object where it lay.
    """

    mesh: TriangleMesh
    model: Literal["normal", "tangential"]
    iterations: int
    clusters: tuple[int, ...]
    tangential: TangentialFlowResult | None
    vanished: bool


def selected_flow(
    values: NDArray[np.float32],
    affine: ArrayLike,
    seed: TriangleMesh,
    params: SelectionParams,
    *,
    threshold: float = 0.0,
    check_cancelled: Callable[[], None] | None = None,
) -> SelectionResult:
    """Let a surface flow to the border of an object, by the model that its shape asks for.

    Parameters
    ----------
    values : (I, J, K) float32
        Above `threshold` inside; about one unit from inside to the border.
    affine : (4, 4) float64
        From voxel index to RAS mm.
    seed
        Closed, in the object, RAS mm.
    params
    threshold
    check_cancelled
        Called now and then; what it raises ends the flow and passes through.

    Returns
    -------
    SelectionResult

    References
    ----------
    Section 3.4.4 of the dissertation, "Model selection", steps 1 to 4.
    """
    check = check_cancelled if check_cancelled is not None else _nothing
    matrix = check_affine(affine)
    inverse: FloatArray = np.linalg.inv(matrix).astype(np.float64)
    field = np.ascontiguousarray((values - np.float32(threshold)) * np.float32(params.gain), dtype=np.float32)

    def flow(mesh: TriangleMesh, iterations: int) -> tuple[TriangleMesh, int, bool, bool]:
        result = normal_flow(
            field, None, matrix, mesh,
            NormalFlowParams(edge_lengths=(params.edge_length,), threshold_share=None, max_iterations=iterations),
            threshold=0.0, on_iteration=lambda *_: check(),
        )  # fmt: skip
        return result.mesh, result.iterations, result.converged, result.vanished

    if not params.switch:
        mesh, iterations, _, vanished = flow(seed, params.burst * params.most_bursts)
        return SelectionResult(mesh, "normal", iterations, (), None, vanished)
    mesh, iterations = seed, 0
    agreeing = largest = 0
    for look in range(params.most_bursts):
        mesh, done, converged, vanished = flow(mesh, FIRST_BURST if look == 0 else params.burst)
        iterations += done
        if vanished:
            return SelectionResult(mesh, "normal", iterations, (), None, True)
        moving = moving_vertices(field, inverse, mesh)
        sizes = cluster_sizes(mesh, moving)
        large = sizes[sizes >= params.least_cluster]
        front = (
            0 < len(large) <= params.most_clusters
            and moving.mean() <= params.moving_share
            and np.count_nonzero(~moving) >= FEWEST_RESTING
        )
        now = int(large[0]) if len(large) else 0
        agreeing = 0 if not front else agreeing + 1 if now >= STEADY * largest else 1
        largest = now
        if agreeing >= params.patience:
            grown = _go_on(values, matrix, mesh, moving, params, threshold, check)
            return SelectionResult(grown.mesh, "tangential", iterations, tuple(large.tolist()), grown, False)
        if converged and not len(large):
            return SelectionResult(mesh, "normal", iterations, (), None, False)
    mesh, done, _, vanished = flow(mesh, NormalFlowParams().max_iterations)
    return SelectionResult(mesh, "normal", iterations + done, (), None, vanished)


def moving_vertices(field: NDArray[np.float32], inverse: FloatArray, mesh: TriangleMesh) -> BoolArray:
    """Return which vertices move outwards: those that lie well inside the object.

    Parameters
    ----------
    field : (I, J, K) float32
        The normal flow's U − τ.
    inverse : (4, 4) float64
        From RAS mm to voxel index.
    mesh

    Returns
    -------
    (n,) bool
    """
    index = mesh.vertices @ inverse[:3, :3].T + inverse[:3, 3]
    value = ndimage.map_coordinates(field, index.T, order=1, mode="constant", cval=-10.0)
    return np.asarray(np.tanh(value) > SPEED)


def cluster_sizes(mesh: TriangleMesh, chosen: BoolArray) -> NDArray[np.int64]:
    """Return the numbers of vertices of the connected clusters of the chosen vertices, the largest first."""
    if not chosen.any():
        return np.zeros(0, dtype=np.int64)
    edges = mesh.edges
    inner = edges[chosen[edges].all(axis=1)]
    n = len(mesh.vertices)
    graph = coo_array((np.ones(len(inner), dtype=np.int8), (inner[:, 0], inner[:, 1])), shape=(n, n))
    _, labels = connected_components(graph, directed=False)
    _, counts = np.unique(labels[chosen], return_counts=True)
    return np.sort(counts)[::-1].astype(np.int64)


def opened(mesh: TriangleMesh, removed: BoolArray) -> TriangleMesh:
    """Return the mesh without some vertices and the faces at them, and without vertices at which only corners meet.

    Parameters
    ----------
    mesh
        Closed.
    removed : (n,) bool

    Returns
    -------
    TriangleMesh
        Open where something was removed; every vertex has one fan of faces.
    """
    faces = mesh.faces[~removed[mesh.faces].any(axis=1)]
    while len(faces):
        open_mesh = TriangleMesh(mesh.vertices, faces)
        pinched = open_mesh.topology.nonmanifold_vertices
        if not len(pinched):
            break
        bad = np.zeros(len(mesh.vertices), dtype=np.bool_)
        bad[pinched] = True
        faces = faces[~bad[faces].any(axis=1)]
    used = np.unique(faces)
    number = np.zeros(len(mesh.vertices), dtype=np.int32)
    number[used] = np.arange(len(used), dtype=np.int32)
    return TriangleMesh(mesh.vertices[used], number[faces])


def _go_on(
    values: NDArray[np.float32], affine: FloatArray, mesh: TriangleMesh, moving: BoolArray, params: SelectionParams,
    threshold: float, check: Callable[[], None],
) -> TangentialFlowResult:  # fmt: skip
    """Open the mesh at its moving front, and let it grow from there."""
    # What lies beside the front has not quite come to rest.
    edges = mesh.edges
    beside = moving.copy()
    beside[edges[moving[edges].any(axis=1)]] = True
    start = opened(mesh, beside)
    if not len(start.faces):
        start = opened(mesh, moving)
    return tangential_flow(
        values, affine, start, replace(params.tangential, edge_length=params.edge_length), threshold=threshold,
        check_cancelled=check,
    )  # fmt: skip


def _nothing() -> None:
    return None
