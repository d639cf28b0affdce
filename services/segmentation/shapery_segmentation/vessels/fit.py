"""From a surface that is right to a voxel to one that is right to a fraction of it.

A surface says what a scanner would have seen of it: every voxel has its share of what is inside and of what is outside
(partial volume). The surface that explains best what the scanner did see, and that is no rougher than vessels are, is
the most probable one. In a vessel of one voxel and a half in radius nearly every voxel is crossed by the wall, so no
threshold of single values, and no line across the wall, tells as much.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import erf

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.volume import Volume
from shapery_segmentation.mesh.dynamic_mesh import DynamicMesh
from shapery_segmentation.vessels import _border_kernels as border_kernels
from shapery_segmentation.vessels import _coverage_kernels as kernels
from shapery_segmentation.vessels.border import CUBE, Border
from shapery_segmentation.vessels.evidence import Evidence

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

ROUNDS = 5
"""Times that the surface is compared with the volume and moved."""

COLUMNS = 4
"""Along either axis of a voxel: its share is measured in so many columns."""

STIFFNESS = 40.0
"""β: a change of curvature counts by its square in units of the curvature itself, over a distance of one radius."""

LARGEST_RADIUS = 5.0
"""Voxels; what is wider is no stiffer."""

BEND_SPREADS = 6
"""Averages over neighbours that the curvature goes through before anything is scaled with it."""

LARGEST_RATIO = 50.0
"""Contrast over noise beyond which the surface is not trusted to explain the values."""

CLIP = 0.3
"""Values that exceed inside or outside by more than this share of the contrast say nothing: bone, calcium, air."""

SOLVED, LARGEST_SOLVE = 0.05, 12
"""Relative residual and steps at which the linear system of a round counts as solved."""

CHEBYSHEV_STEPS, SMOOTHEST = 12, 0.03
"""Iterations of the system that preconditions a round, and the least of its eigenvalues, which are below 2, that they
are meant for."""

SLIDING = 0.3
"""Share of the way to the neighbours' mean that a vertex moves across its normal."""

LARGEST_MOVE = 0.5
"""Voxels that a vertex moves at once at the most."""

LARGEST_SHIFT = 0.1
"""Voxels that faces are moved outwards for the corners they cut at the most."""

LEAST_COTANGENT = 0.02
"""Cotangents are raised to this, so that obtuse corners do not turn a smoothness into its contrary."""

BLURS = (0.0, 0.3, 0.45, 0.6, 0.75, 0.9, 1.05, 1.2)
"""Voxels: deviations of a scanner's blur of which the one is taken that explains the values best."""

BLUR_REACH = 3
"""Voxels to which a blur reaches."""

BLUR_VOXELS = 2000
"""Voxels at about which that is decided."""

LARGEST_BRIGHTER = 1.6
"""Times that a vessel is brighter than its brightest voxels at the most."""

SLAB = 4_000_000
"""Voxels whose shares are held at once."""


@dataclass(frozen=True, eq=False)
class _Curve:
    """The smooth surface that a mesh stands for: each face cut into four, on the curve that the normals tell.

    Parameters
    ----------
    points : (p, 3) float64
        RAS mm.
    faces : (4 m, 3) int32
    follow : (p, n) sparse
        How they follow the mesh's vertices.
    """

    points: FloatArray
    faces: NDArray[np.int32]
    follow: sparse.csr_array


def fit_surface(
    mesh: DynamicMesh,
    evidence: Evidence,
    border: Border,
    grid: Volume,
    *,
    check_cancelled: Callable[[], None] | None = None,
) -> float:
    """Move a surface to the wall of vessels; return the mean of the last moves in mm.

    Parameters
    ----------
    mesh
        Closed, about a voxel from the wall at the most; it is changed. Moves that would make it touch itself are not
        made.
    evidence, border
        Of the volume on the grid `grid`.

    Notes
    -----
    Gauss–Newton steps d along the normals towards the least of

        Σ ((I − outer − (inner − outer)·share) / noise)² + β ∫ |∇H|² / H² dA

    over the voxels that the surface crosses. A voxel of volume V gains dA/V of its share for each area dA in it that
    moves by a unit. β has no unit, so that one value serves vessels of any size; the noise is that of the volume: in a
    clean one, the surface follows what it sees.

    What the scanner blurred is compared with shares that are blurred as much: each round takes the blur that explains
    the values best at the surface of the one before.
    """
    voxel = min(grid.spacing)
    surface, live = mesh.to_triangle_mesh(), mesh.live
    faces, count = surface.faces, len(surface.vertices)
    mean = _averaging(faces, count)
    last, blur = 0.0, 0.0
    nearly: LinearOperator | None = None
    # Only places change: the triangles stay what they are.
    for _ in range(ROUNDS):
        if check_cancelled is not None:
            check_cancelled()
        points = np.ascontiguousarray(mesh.arrays.points[live, :3])
        normals, bend = _bends(points, faces, mean)
        gain, missing, blur = _residual(_curve(points, faces, mean, voxel), bend, evidence, border, grid, blur)
        weights, area = _cotangents(points, faces)
        bend = np.maximum(bend, 1.0 / (LARGEST_RADIUS * voxel))
        stiff = STIFFNESS / bend**2
        # H changes by −Δd − |A|² d, with |A|² = H² on a tube: a tube that is shifted as a whole keeps its curvature.
        plain = _laplacian(weights)
        change = (sparse.diags_array(1.0 / area) @ plain - sparse.diags_array(bend**2)).tocsr()
        rough = _laplacian(_scaled(weights, stiff))
        curvature = np.einsum("ij,ij->i", normals, plain @ points) / area
        system = _system(gain, change, rough)
        wanted = gain.T @ missing - change.T @ (rough @ curvature)
        told = gain.T @ gain.sum(axis=1)
        if nearly is None:
            nearly = _nearly(weights, area, stiff, told)
        move, _ = cg(system, wanted, maxiter=LARGEST_SOLVE, rtol=SOLVED, M=nearly)
        np.clip(move, -LARGEST_MOVE * voxel, LARGEST_MOVE * voxel, out=move)
        way = mean @ points - points
        way -= np.einsum("ij,ij->i", way, normals)[:, None] * normals
        mesh.move(live, points + move[:, None] * normals + SLIDING * way)
        last = float(np.abs(move).mean())
    return last


def half_covered(surface: TriangleMesh, grid: Volume) -> BoolArray:
    """Return the voxels of which at least half lies inside the smooth surface that a mesh stands for.

    Parameters
    ----------
    surface
        Closed, RAS mm; its vertices lie on the smooth surface.
    grid
        The volume on whose grid the mask is wanted.
    """
    mean = _averaging(surface.faces, len(surface.vertices))
    curve = _curve(np.ascontiguousarray(surface.vertices), surface.faces, mean, min(grid.spacing))
    index = np.ascontiguousarray(grid.to_index(curve.points))
    low = np.clip(np.floor(index.min(axis=0) + 0.5), 0, grid.shape).astype(np.int64)
    high = np.clip(np.floor(index.max(axis=0) + 0.5) + 1, low, grid.shape).astype(np.int64)
    inside = np.zeros(grid.shape, dtype=np.bool_)
    part = inside[tuple(slice(a, b) for a, b in zip(low, high, strict=True))]
    for first, shares in _shares(index, _outwards(curve.faces, grid), low, high):
        part[first : first + len(shares)] = shares >= 0.5
    return inside


def _residual(
    curve: _Curve, bend: FloatArray, evidence: Evidence, border: Border, grid: Volume, blur: float
) -> tuple[sparse.csr_array, FloatArray, float]:
    """Return what the voxels gain when vertices move along their normals, what they lack, and the blur they tell.

    The first two are in units of the noise, with `blur` as the deviation of the scanner's blur in voxels.
    """
    index = np.ascontiguousarray(grid.to_index(curve.points))
    # Nothing is known beyond the grid: there the surface goes on as it comes.
    low = np.clip(np.floor(index.min(axis=0) + 0.5), 0, grid.shape).astype(np.int64)
    high = np.clip(np.floor(index.max(axis=0) + 0.5) + 1, low, grid.shape).astype(np.int64)
    shape = high - low
    room = 9 * len(curve.faces)
    voxel, vertex, area = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64), np.empty(room)
    found = kernels.crossed(index, curve.points, curve.faces, low, shape, voxel, vertex, area)
    voxel, vertex, area = voxel[:found], vertex[:found], area[:found]
    names, row = np.unique(voxel, return_inverse=True)
    place = np.stack(np.unravel_index(names, tuple(shape)), axis=1)
    some = np.arange(0, len(names), max(1, len(names) // BLUR_VOXELS))
    share, shares_of = np.empty((len(names), 1)), np.empty((len(some), len(BLURS)))
    for first, shares in _shares(index, _outwards(curve.faces, grid), low, high, halo=BLUR_REACH):
        last = first + len(shares) - 2 * BLUR_REACH
        for deviations, where, seen in (((blur,), np.arange(len(names)), share), (BLURS, some, shares_of)):
            a, b = np.searchsorted(place[where, 0], (first, last))
            at = place[where[a:b]] - np.array((first - BLUR_REACH, 0, 0))
            kernels.blurred(shares, at, _bells(deviations), seen[a:b])
    moved = sparse.csr_array((area, (row, vertex)), shape=(len(names), len(curve.points))) @ curve.follow
    value, contrast = np.empty(len(names)), np.empty(len(names))
    border_kernels.relative_values(evidence.values, border.inside, border.inner, border.outer, float(CUBE), place + low,
                                   value, contrast)  # fmt: skip
    brighter = _brighter(min(grid.spacing) * (moved @ bend) / np.maximum(moved.sum(axis=1), 1e-12), blur)
    value, contrast = value / brighter, contrast * brighter
    value = np.clip(value, -CLIP, 1.0 + CLIP)
    weight = np.minimum(contrast / max(evidence.noise, 1e-30), LARGEST_RATIO)
    # Of what a wall adds to a voxel by moving, the blur leaves so much in it.
    left = erf(0.5 / (np.sqrt(2.0) * max(blur, 1e-3)))
    gain = sparse.diags_array(left * weight / grid.voxel_volume) @ moved
    wrong = (weight[some, None] * (value[some, None] - shares_of)) ** 2
    return gain.tocsr(), weight * (value - share[:, 0]), BLURS[int(wrong.sum(axis=0).argmin())]


def _brighter(bend: FloatArray, blur: float) -> FloatArray:
    """Return how much brighter than its brightest voxels a tube is inside.

    Parameters
    ----------
    bend : (n,) float64
        Its curvature in 1/voxel, that is one over its radius r.
    blur
        Deviation σ in voxels.

    Notes
    -----
    On its axis a blurred tube shows 1 − exp(−r² / 2σ²) of what is in it.
    """
    radius = 1.0 / np.maximum(bend, 1e-3)
    return np.asarray(np.minimum(1.0 / -np.expm1(-0.5 * (radius / max(blur, 1e-3)) ** 2), LARGEST_BRIGHTER))


def _bells(deviations: Sequence[float]) -> FloatArray:
    """Return the shares that neighbours, up to `BLUR_REACH` away along one axis, have in what a blurred voxel shows."""
    at = np.arange(-BLUR_REACH, BLUR_REACH + 1)
    bells = np.exp(-0.5 * (at / np.maximum(np.asarray(deviations), 1e-3)[:, None]) ** 2)
    return np.asarray(bells / bells.sum(axis=1, keepdims=True))


def _system(gain: sparse.csr_array, change: sparse.csr_array, rough: sparse.csr_array) -> LinearOperator:
    """Return a round's system, whose matrix would take twenty times the memory of what it is made of."""
    back, changed = gain.T.tocsr(), change.T.tocsr()

    def apply(x: FloatArray) -> FloatArray:
        return np.asarray(back @ (gain @ x) + changed @ (rough @ (change @ x)))

    return LinearOperator((gain.shape[1],) * 2, matvec=apply, dtype=np.float64)


def _nearly(weights: sparse.csr_array, area: FloatArray, stiff: FloatArray, told: FloatArray) -> LinearOperator:
    """Return nearly the inverse of a round's system, to precondition it.

    Parameters
    ----------
    weights, area
        See `_cotangents`.
    stiff : (n,) float64
        β / H².
    told : (n,) float64
        What the data say about each vertex's move when all move alike.

    Notes
    -----
    For waves of number k the system is ρ + stiff·k⁶ per area. That is up to four times less than the third power of
    ∛ρ + ∛stiff·k², which takes a matrix as sparse as the mesh.
    """
    least = 1e-3 * float(np.mean(told) / np.mean(area))
    root = sparse.diags_array(area * np.cbrt(np.maximum(told / area, least)))
    solve = _nearly_inverse((root + _laplacian(_scaled(weights, np.cbrt(stiff)))).tocsr())

    def apply(x: FloatArray) -> FloatArray:
        return np.asarray(solve(area * solve(area * solve(x))))

    return LinearOperator((len(area), len(area)), matvec=apply, dtype=np.float64)


def _nearly_inverse(matrix: sparse.csr_array) -> Callable[[FloatArray], FloatArray]:
    """Return nearly the inverse of a positive, diagonally dominant matrix.

    Notes
    -----
    Time and memory are those of the matrix, whatever the surface: the factors of a surface with many loops (a sponge,
    trabecular bone) are as full as those of a solid.

    Chebyshev's polynomial of the matrix scaled by its diagonal, whose eigenvalues lie between 0 and 2 (Gershgorin). It
    is the same linear, symmetric and positive map for every vector, as conjugate gradients ask of a preconditioner; of
    eigenvalues below `SMOOTHEST` it gives less of the inverse.

    References
    ----------
    Y. Saad, "Iterative methods for sparse linear systems", 2nd ed., SIAM 2003, section 12.3.2.
    """
    scale = 1.0 / matrix.diagonal()
    middle, half = 0.5 * (2.0 + SMOOTHEST), 0.5 * (2.0 - SMOOTHEST)

    def solve(x: FloatArray) -> FloatArray:
        ratio = half / middle
        step = scale * x / middle
        result = step.copy()
        for _ in range(CHEBYSHEV_STEPS):
            following = 1.0 / (2.0 * middle / half - ratio)
            step = following * ratio * step + (2.0 * following / half) * scale * (x - matrix @ result)
            result += step
            ratio = following
        return result

    return solve


def _scaled(weights: sparse.csr_array, factors: FloatArray) -> sparse.csr_array:
    """Return weights of edges times the mean of the factors at their ends."""
    pairs = weights.tocoo()
    start, end = pairs.coords
    return sparse.csr_array((pairs.data * 0.5 * (factors[start] + factors[end]), (start, end)), shape=weights.shape)


def _cotangents(points: FloatArray, faces: NDArray[np.int32]) -> tuple[sparse.csr_array, FloatArray]:
    """Return half the cotangents opposite to each edge, added up, and a third of the area around each vertex."""
    count = len(points)
    sides = [points[faces[:, k - 1]] - points[faces[:, k - 2]] for k in range(3)]
    double = np.maximum(np.linalg.norm(np.cross(sides[0], sides[1]), axis=1), 1e-12)
    halves = [
        0.5 * np.maximum(-np.einsum("ij,ij->i", sides[k - 2], sides[k - 1]) / double, LEAST_COTANGENT) for k in range(3)
    ]
    start = np.concatenate([faces[:, k - 2] for k in range(3)])
    end = np.concatenate([faces[:, k - 1] for k in range(3)])
    half = np.concatenate(halves)
    weights = sparse.csr_array(
        (np.concatenate((half, half)), (np.concatenate((start, end)), np.concatenate((end, start)))),
        shape=(count, count),
    )
    return weights, np.asarray(
        np.bincount(faces.ravel(), np.repeat(double / 6.0, 3), minlength=count), dtype=np.float64
    )


def _laplacian(weights: sparse.csr_array) -> sparse.csr_array:
    return sparse.csr_array(sparse.diags_array(np.asarray(weights.sum(axis=1)).ravel()) - weights)


def _curve(points: FloatArray, faces: NDArray[np.int32], mean: sparse.csr_array, voxel: float) -> _Curve:
    """Return the smooth surface that a mesh stands for.

    Notes
    -----
    Faces cut corners: each is cut into four, the new vertices on the curve between the old ones that their normals
    tell, and what is left of it, Σκ·e²/16 for edges e, is added.

    References
    ----------
    The curve is that of A. Vlachos et al., "Curved PN triangles", Symp. Interactive 3D Graphics 2001,
    doi:10.1145/364338.364387.
    """
    count = len(points)
    normals, bend = _bends(points, faces, mean)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    keys = np.minimum(start, end).astype(np.int64) * count + np.maximum(start, end)
    edges, number = np.unique(keys, return_inverse=True)
    a, b = np.divmod(edges, count)
    way = points[b] - points[a]
    rise = np.einsum("ij,ij->i", way, normals[a])[:, None] * normals[a]
    rise -= np.einsum("ij,ij->i", way, normals[b])[:, None] * normals[b]
    places = np.concatenate((points, 0.5 * (points[a] + points[b]) - rise / 8.0))
    # The new vertex on the edge that begins at each corner of a face.
    middle = (count + number.reshape(-1, 3)).astype(np.int32)
    parts = [np.stack((faces[:, k], middle[:, k], middle[:, k - 1]), axis=1) for k in range(3)]
    fine = np.ascontiguousarray(np.concatenate([*parts, middle]), dtype=np.int32)
    normals, square = np.empty(places.shape), np.empty(len(places))
    border_kernels.surround(places, fine, normals, square)
    ends = np.repeat(np.arange(len(edges)), 2), np.stack((a, b), axis=1).ravel()
    halves = sparse.csr_array((np.full(2 * len(edges), 0.5), ends), shape=(len(edges), count))
    follow = sparse.vstack((sparse.eye_array(count, format="csr"), halves), format="csr")
    outwards = np.clip((follow @ bend) * square / 16.0, -LARGEST_SHIFT * voxel, LARGEST_SHIFT * voxel)
    return _Curve(places + outwards[:, None] * normals, fine, follow)


def _shares(
    index: FloatArray, faces: NDArray[np.int32], low: IntArray, high: IntArray, halo: int = 0
) -> Iterator[tuple[int, NDArray[np.float32]]]:
    """Yield slabs of the box from `low` to `high`: the first slice of each, and the share of its voxels inside.

    A slab has `halo` more slices at both ends.
    """
    shape = high - low
    thick = max(1, SLAB // max(1, int(shape[1] * shape[2])))
    for first in range(0, int(shape[0]), thick):
        count = min(thick, int(shape[0]) - first) + 2 * halo
        shares = np.zeros((count, int(shape[1]), int(shape[2])), dtype=np.float32)
        kernels.cover(index, faces, COLUMNS, low + np.array((first - halo, 0, 0)), shares)
        yield first, shares


def _outwards(faces: NDArray[np.int32], grid: Volume) -> NDArray[np.int32]:
    """Return faces that look outwards in voxel indices, too, where the grid is a mirror image."""
    mirrored = np.linalg.det(grid.affine[:3, :3]) < 0
    return np.ascontiguousarray(faces[:, ::-1]) if mirrored else faces


def _bends(points: FloatArray, faces: NDArray[np.int32], mean: sparse.csr_array) -> tuple[FloatArray, FloatArray]:
    """Return normals and smoothed sums of curvatures (1/mm)."""
    normals, square = np.empty(points.shape), np.empty(len(points))
    border_kernels.surround(points, faces, normals, square)
    # On a regular mesh the way to the neighbours' mean is −(κ₁ + κ₂)/4 times the mean squared edge.
    along = np.einsum("ij,ij->i", mean @ points - points, normals)
    bend = -4.0 * along / np.maximum(square, 1e-12)
    for _ in range(BEND_SPREADS):
        bend = 0.5 * (bend + mean @ bend)
    return normals, bend


def _averaging(faces: NDArray[np.int32], count: int) -> sparse.csr_array:
    """Return the (n, n) matrix that takes values to the means over each vertex's neighbours."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    degree = np.bincount(start, minlength=count)
    return sparse.csr_array((1.0 / degree[start], (start, end)), shape=(count, count))
