"""Patches: what is known of a surface around each of its samples, and does not change where the rest is cut away.

A part of a shape has neither its heat nor its distances from everything else, but around each of its points it bends
and is as thick as the whole is, once its size is known. Which share of a whole it is, is not known: several are
assumed, and all of them vote. Borders are closed by caps before rays are cast and curvature is spread, and what is near
a border counts little.

References
----------
R. Gal, D. Cohen-Or, Salient geometric features for partial shape matching and similarity, ACM TOG 25(1), 2006,
doi:10.1145/1122501.1122507.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators.intrinsic import intrinsic_delaunay
from shapery_geometry.operators.spectrum import Spectrum, laplacian_spectrum
from shapery_retrieval.arg import Arg
from shapery_retrieval.decompose import Samples
from shapery_retrieval.normalise import NormalisedMesh
from shapery_retrieval.signals import (
    CURVATURE_TIMES,
    EIGENPAIRS,
    Signals,
    bent,
    joined_laplacian,
    shape_diameter,
)
from shapery_retrieval.vocabulary import vocabulary

SHARES = (1.0, 0.7, 0.5, 0.35)
"""Of a whole that a partial query is assumed to be."""
RADII = (0.08, 0.16, 0.3)
"""Geodesic reach of what is summed up around a sample, in roots of the whole's area."""
RIM = 0.1
"""Nearer to a border than this, in the same unit, patches count less."""
LEAST = 0.05
FEATURES = 14 + 5 * len(RADII)
BLOCKS = ((1.0, (0, 7)), (1.5, (1, 2, 3, 8, 9, 10)), (1.5, (4, 5, 6, 11, 12, 13)), (1.5, tuple(range(14, FEATURES))))
"""Thickness, mean curvature, Gaussian curvature and the reach around: what each counts, and its columns."""
AT_ONCE = 50
"""Of so many shapes the distances between patches stay in the processor's cache."""

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Patches:
    """Patches of a surface.

    Attributes
    ----------
    masses : (p,) float32
        What each counts; in sum 1.
    features : (p, 29) float32
        Standardised and weighted, so that they are compared by Euclidean distance.
    """

    masses: NDArray[np.float32]
    features: NDArray[np.float32]


def patches_of(arg: Arg) -> Patches:
    """Return the patches that a graph holds."""
    return _standardised(arg.whole["patch_masses"], arg.whole["patch_features"])


def _standardised(masses: NDArray[np.floating], features: NDArray[np.floating]) -> Patches:
    words = vocabulary()
    scale = np.empty(FEATURES)
    for weight, columns in BLOCKS:
        scale[list(columns)] = np.sqrt(weight / len(columns))
    scaled = (features.astype(np.float64) - words.patch_mean) / words.patch_spread * scale
    return Patches((masses / masses.sum()).astype(np.float32), scaled.astype(np.float32))


class LocalSurface:
    """A surface, perhaps a part of a whole, ready to be described by patches.

    Parameters
    ----------
    normalised, signals, samples
        Of one surface.
    """

    def __init__(self, normalised: NormalisedMesh, signals: Signals, samples: Samples) -> None:
        mesh = normalised.mesh
        self._mesh, self._samples, self._areas = mesh, samples, signals.areas
        n = len(mesh.vertices)
        border = np.unique(mesh.boundary_edges.ravel())
        self._to_border = samples.reach[:, border].min(axis=1) if len(border) else np.full(len(samples.areas), np.inf)
        capped = closed_by_caps(mesh) if len(border) else mesh
        if len(capped.faces) == len(mesh.faces):
            self._spectrum, self._thickness = signals.spectrum, signals.thickness
        else:
            triangulation = intrinsic_delaunay(capped)
            areas = triangulation.vertex_areas()
            areas = np.maximum(areas, 1e-6 * areas.mean())
            laplacian = joined_laplacian(triangulation.laplacian(), normalised.links)
            self._spectrum = laplacian_spectrum(laplacian, areas, min(EIGENPAIRS, len(areas) - 2))
            self._thickness = shape_diameter(capped)[:n]
        bending, defects = bent(mesh)
        bending[border] = 0.0
        counted = signals.areas.copy()
        counted[border] = 0.0
        more = len(self._spectrum.areas) - n
        self._bending, self._defects, self._counted = (
            np.pad(values, (0, more)) for values in (bending, defects, counted)
        )

    def described(self, share: float, cells: int | None = None) -> tuple[NDArray[np.float32], NDArray[np.float16]]:
        """Return (p,) weights and (p, 29) features of patches around the first `cells` samples, as graphs hold them.

        Parameters
        ----------
        share
            Which share of a whole of unit area the surface is.
        cells
            By default as many as there are samples.
        """
        reach = self._samples.reach[: cells or len(self._samples.areas)]
        size = float(np.sqrt(share))
        cell = np.argmin(reach, axis=0)
        used, cell = np.unique(cell, return_inverse=True)
        cell = cell.reshape(-1)
        areas = self._areas * share
        masses = np.bincount(cell, weights=areas)

        def means(columns: Array) -> Array:
            sums = np.stack([np.bincount(cell, weights=areas * column) for column in columns.T], axis=1)
            return np.asarray(sums / masses[:, None])

        signals = self._signals(size)
        mean = means(signals)
        deviation = np.sqrt(np.maximum(means((signals - mean[cell]) ** 2), 0.0))
        around = self._around(reach[used] * size, size, areas)
        near_border = np.clip(self._to_border[used] * size / RIM, LEAST, 1.0)
        weights = masses * near_border
        features = np.concatenate((mean, deviation, around), axis=1)
        return (weights / weights.sum()).astype(np.float32), features.astype(np.float16)

    def patches(self, share: float) -> Patches:
        """Return patches of the surface as a share of a whole, as many as the whole would have there."""
        return _standardised(*self.described(share, max(12, round(len(self._samples.areas) * share))))

    def _signals(self, size: float) -> Array:
        """(n, 7) thickness, mean and Gaussian curvature where the root of the area is `size`."""
        n = len(self._areas)
        values = self._spectrum.values / size**2
        count = min(len(values), max(12, round(EIGENPAIRS * float(self._spectrum.areas.sum()) * size**2)))
        spectrum = Spectrum(values[:count], self._spectrum.functions[:, :count] / size, self._spectrum.areas * size**2)
        counted = self._counted * size**2

        def spread(integrated: Array, time: float) -> Array:
            """Return a density from what each vertex has in all, over the surface that is there."""
            weights = np.exp(-spectrum.values * time)
            both = np.stack((integrated, counted), axis=1)
            found = spectrum.functions[:n] @ (weights[:, None] * (spectrum.functions.T @ both))
            return np.asarray(found[:, 0] / np.maximum(found[:, 1], 0.1))

        thick = np.pad(self._thickness + np.log(size), (0, len(counted) - n))
        columns = [spread(thick * counted, 5e-4)]
        columns += [np.arcsinh(spread(self._bending * size, time) / 2) for time in CURVATURE_TIMES]
        columns += [np.arcsinh(spread(self._defects, time) / 8) for time in CURVATURE_TIMES]
        return np.stack(columns, axis=1)

    def _around(self, reach: Array, size: float, areas: Array) -> Array:
        """(p, 15) how the surface lies around each sample: its extents, how its normals agree, and its area."""
        points, normals = self._mesh.vertices * size, self._mesh.vertex_normals
        products = (points[:, :, None] * points[:, None, :]).reshape(len(points), 9)
        columns = []
        for radius in RADII:
            weights = np.exp(-((reach / radius) ** 2)) * areas
            total = np.maximum(weights.sum(axis=1), 1e-12)
            middle = weights @ points / total[:, None]
            moments = (weights @ products / total[:, None]).reshape(-1, 3, 3) - middle[:, :, None] * middle[:, None, :]
            extents = np.sqrt(np.maximum(np.linalg.eigvalsh(moments), 0.0)) / radius
            agreement = np.linalg.norm(weights @ normals / total[:, None], axis=1)
            columns += [extents, agreement[:, None], np.log(np.maximum(total / radius**2, 1e-3))[:, None]]
        return np.concatenate(columns, axis=1)


def closed_by_caps(mesh: TriangleMesh) -> TriangleMesh:
    """Close each border by a fan around its middle; the vertices of the mesh stay the first ones."""
    edges = mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).astype(np.int64)
    n = len(mesh.vertices)
    border = edges[~np.isin(edges[:, 0] * n + edges[:, 1], edges[:, 1] * n + edges[:, 0])]
    if not len(border):
        return mesh
    touching = coo_array((np.ones(len(border)), (border[:, 0], border[:, 1])), shape=(n, n))
    loops = connected_components(touching, directed=False)[1][border[:, 0]]
    points, faces = [mesh.vertices], [mesh.faces]
    middle = n
    for loop in np.unique(loops):
        around = border[loops == loop]
        if len(around) < 3:
            continue
        ends = mesh.vertices[around]
        lengths = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
        points.append((lengths @ ends.mean(axis=1) / max(float(lengths.sum()), 1e-300))[None])
        faces.append(np.column_stack((around[:, ::-1], np.full(len(around), middle))).astype(mesh.faces.dtype))
        middle += 1
    return TriangleMesh(np.concatenate(points), np.concatenate(faces))


def nearest_patches(query: Patches, others: list[Patches]) -> Array:
    """(p, n) distance of each patch of a query from the nearest one of each of n shapes."""
    own = (query.features**2).sum(axis=1)[:, None]
    # |b|² − 2 a·b is one product of a row that ends in 1 with one that ends in |b|²; |a|² changes no nearest one
    rows = np.concatenate((-2 * query.features, np.ones_like(own)), axis=1)
    result = np.empty((len(query.masses), len(others)))
    for begin in range(0, len(others), AT_ONCE):
        block = others[begin : begin + AT_ONCE]
        features = np.concatenate([shape.features for shape in block])
        starts = np.cumsum([0, *(len(shape.masses) for shape in block[:-1])])
        columns = np.concatenate((features, np.einsum("pf,pf->p", features, features)[:, None]), axis=1)
        result[:, begin : begin + len(block)] = np.minimum.reduceat(rows @ columns.T, starts, axis=1)
    return np.asarray(np.sqrt(np.maximum(result + own, 0.0)))
