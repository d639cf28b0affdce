"""What is known of a surface at each of its vertices: heat, waves, thickness and curvature (sections 4.3 and 4.5).

All signals are free of scale, because the surface has unit area, and do not change with rigid motion or reflection.

References
----------
J. Sun, M. Ovsjanikov, L. Guibas, A concise and provably informative multi-scale signature based on heat diffusion,
Computer Graphics Forum 28(5), 2009, doi:10.1111/j.1467-8659.2009.01515.x.
M. Aubry, U. Schlickewei, D. Cremers, The wave kernel signature, ICCV Workshops 2011, doi:10.1109/ICCVW.2011.6130444.
L. Shapira, A. Shamir, D. Cohen-Or, Consistent mesh partitioning and skeletonisation using the shape diameter function,
The Visual Computer 24, 2008, doi:10.1007/s00371-007-0197-5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators.curvature import angle_defects
from shapery_geometry.operators.geodesics import GeodesicSurface, Links
from shapery_geometry.operators.intrinsic import intrinsic_delaunay
from shapery_geometry.operators.laplacian import cotangent_laplacian
from shapery_geometry.operators.rays import first_hits
from shapery_geometry.operators.spectrum import Spectrum, laplacian_spectrum
from shapery_retrieval.normalise import NormalisedMesh

EIGENPAIRS = 100
HEAT_TIMES = np.geomspace(1e-3, 4.0, 16)
"""In units of the surface's area."""
WAVE_ENERGIES = np.linspace(np.log(8.0), np.log(1100.0), 16)
"""Logarithms of eigenvalues; by Weyl's law the hundredth is about 400 π on a surface of unit area."""
WAVE_WIDTH = 0.4
CURVATURE_TIMES = (0.001, 0.004, 0.016)
"""How far curvature is spread before it is used; what is finer is noise."""
RAYS = 10
"""Rays a vertex; thickness is averaged over neighbours afterwards."""
CONE = np.deg2rad(55.0)
LINK_CONDUCTANCE = 0.5
"""Weight of a link between components in the Laplacian; that of an edge between equilateral faces is 0.58."""


@dataclass(frozen=True, eq=False)
class Signals:
    """Signals at the n vertices.

    Attributes
    ----------
    spectrum
        Of the surface; its areas sum to 1.
    geodesics
        For distances along the surface.
    normals : (n, 3)
        Unit normals.
    heat : (n, 16)
        Logarithm of the heat kernel signature, Eq. 4.5 with the square that it lacks: 1 + Σ e^(−λt) φ², over its mean.
    wave : (n, 16)
        Logarithm of the wave kernel signature.
    thickness : (n,)
        Logarithm of the shape diameter.
    mean_curvature, gaussian_curvature : (n, 3)
        Spread by heat for three times, then asinh.
    """

    spectrum: Spectrum
    geodesics: GeodesicSurface
    normals: NDArray[np.float64]
    heat: NDArray[np.float64]
    wave: NDArray[np.float64]
    thickness: NDArray[np.float64]
    mean_curvature: NDArray[np.float64]
    gaussian_curvature: NDArray[np.float64]

    @property
    def areas(self) -> NDArray[np.float64]:
        """(n,) share of the surface of each vertex; in sum 1."""
        return self.spectrum.areas


def compute_signals(normalised: NormalisedMesh) -> Signals:
    """Compute all signals.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where a signal has no meaning.
    """
    mesh, links = normalised.mesh, normalised.links
    triangulation = intrinsic_delaunay(mesh)
    laplacian = triangulation.laplacian()
    areas = triangulation.vertex_areas()
    areas = np.maximum(areas, 1e-6 * areas.mean())
    areas /= areas.sum()
    laplacian = joined_laplacian(laplacian, links)
    spectrum = laplacian_spectrum(laplacian, areas, min(EIGENPAIRS, len(areas) - 2))
    squares = spectrum.functions**2
    heat = 1.0 + squares[:, 1:] @ np.exp(-spectrum.values[1:, None] * HEAT_TIMES)
    heat = np.log(np.maximum(heat / (areas @ heat), 1e-6))
    energies = np.log(np.maximum(spectrum.values[1:, None], 1e-3))
    weights = np.exp(-((WAVE_ENERGIES - energies) ** 2) / (2 * WAVE_WIDTH**2))
    wave = squares[:, 1:] @ weights / np.maximum(weights.sum(axis=0), 1e-6)
    wave = np.log(np.maximum(wave, 1e-3))
    normals = mesh.vertex_normals
    thickness = spectrum.low_pass(shape_diameter(normalised.mesh), 5e-4)
    bending, defects = bent(mesh)
    mean = np.stack([_spread(spectrum, bending, t) for t in CURVATURE_TIMES], axis=1)
    gaussian = np.stack([_spread(spectrum, defects, t) for t in CURVATURE_TIMES], axis=1)
    result = Signals(
        spectrum=spectrum,
        geodesics=GeodesicSurface(triangulation, links),
        normals=normals,
        heat=heat,
        wave=wave,
        thickness=thickness,
        mean_curvature=np.arcsinh(mean / 2),
        gaussian_curvature=np.arcsinh(gaussian / 8),
    )
    for values in (heat, wave, result.thickness, result.mean_curvature, result.gaussian_curvature):
        if not np.isfinite(values).all():
            raise InvalidInput("invalid_mesh", "The surface has no meaningful signals.", "Look for degenerate faces.")
    return result


def joined_laplacian(laplacian: csr_array[np.float64], links: Links) -> csr_array[np.float64]:
    """Let heat run along links between components, too."""
    if not len(links.lengths):
        return laplacian
    i, j = links.ends.T
    w = np.full(len(i), LINK_CONDUCTANCE)
    rows, columns = np.concatenate((i, j, i, j)), np.concatenate((j, i, i, j))
    joined = coo_array((np.concatenate((-w, -w, w, w)), (rows, columns)), shape=laplacian.shape)
    return (laplacian + joined).tocsr()


def bent(mesh: TriangleMesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n,) mean and (n,) Gaussian curvature that each vertex has in all."""
    bending = np.einsum("ij,ij->i", np.asarray(cotangent_laplacian(mesh) @ mesh.vertices), mesh.vertex_normals) / 2
    return bending, _angle_defects(mesh)


def _spread(spectrum: Spectrum, integrated: NDArray[np.float64], time: float) -> NDArray[np.float64]:
    """Return a density from what each vertex has in all, spread by heat for a time."""
    coefficients = np.exp(-spectrum.values * time) * (spectrum.functions.T @ integrated)
    return np.asarray(spectrum.functions @ coefficients)


def _angle_defects(mesh: TriangleMesh) -> NDArray[np.float64]:
    defects = angle_defects(mesh)
    # on a border the defect tells how the border bends, not the surface
    defects[mesh.boundary_edges.ravel()] = 0.0
    return np.clip(defects, -2 * np.pi, 2 * np.pi)


def shape_diameter(mesh: TriangleMesh) -> NDArray[np.float64]:
    """(n,) logarithm of the mean length of rays into the body, those far from their median left out."""
    n, normals = len(mesh.vertices), mesh.vertex_normals
    # a sunflower of directions in the cone around the inward normal
    place = (np.arange(RAYS) + 0.5) / RAYS
    tilt = np.arccos(1 - place * (1 - np.cos(CONE)))
    turn = np.arange(RAYS) * np.pi * (3 - np.sqrt(5))
    helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    first = np.cross(normals, helper)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-12)
    second = np.cross(normals, first)
    sideways = np.cos(turn)[None, :, None] * first[:, None] + np.sin(turn)[None, :, None] * second[:, None]
    directions = np.sin(tilt)[None, :, None] * sideways - np.cos(tilt)[None, :, None] * normals[:, None]
    origins = np.repeat(mesh.vertices, RAYS, axis=0)
    lengths, _ = first_hits(mesh, origins, directions.reshape(-1, 3), beyond=1e-4)
    lengths = np.minimum(lengths, mesh.diagonal).reshape(n, RAYS)
    middle = np.median(lengths, axis=1, keepdims=True)
    spread = lengths.std(axis=1, keepdims=True)
    near = np.abs(lengths - middle) <= spread + 1e-9
    return np.asarray(np.log(np.maximum((lengths * near).sum(axis=1) / near.sum(axis=1), 1e-3)))
