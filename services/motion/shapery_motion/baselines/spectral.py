"""Prediction by the spectrum of the key frame (section 5.3.2, Figs 5.1 and 5.2).

The eigenfunctions of the Laplace–Beltrami operator of the key frame are a basis for functions on the surface; a frame's
positions, or their differences from the key frame, are cut off after the first coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import diags_array
from scipy.sparse.linalg import eigsh

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators.laplacian import cotangent_laplacian, vertex_areas

FloatArray = NDArray[np.float64]

TEXT_COEFFICIENTS = 1000
"""How many coefficients the text keeps."""


@dataclass(frozen=True, eq=False)
class SpectralBasis:
    """The first eigenfunctions of a key frame."""

    key: FloatArray
    """(n, 3) the key frame."""
    functions: FloatArray
    """(n, k) orthonormal by the vertices' areas, by rising eigenvalue."""
    eigenvalues: FloatArray
    """(k,) in the square of the inverse unit of length."""
    masses: FloatArray
    """(n,) area of each vertex; a vertex without any gets a little, so that it has a value."""

    @property
    def count(self) -> int:
        """Number k of functions."""
        return len(self.eigenvalues)

    def coefficients(self, values: NDArray[Any]) -> FloatArray:
        """Return the coefficients (k, 3) of a function (n, 3) on the surface."""
        return np.asarray(self.functions.T @ (self.masses[:, None] * np.asarray(values, dtype=np.float64)))

    def from_positions(self, target: NDArray[Any]) -> FloatArray:
        """Return what the coefficients of a frame's positions (n, 3) recover of it."""
        return np.asarray(self.functions @ self.coefficients(target))

    def from_differences(self, target: NDArray[Any]) -> FloatArray:
        """Return the key frame plus what the coefficients of the differences from it recover."""
        return np.asarray(self.key + self.functions @ self.coefficients(target - self.key))


def spectral_basis(key: TriangleMesh, count: int = TEXT_COEFFICIENTS) -> SpectralBasis:
    """Return the first eigenfunctions of the Laplace–Beltrami operator of a mesh.

    Parameters
    ----------
    key
        The key frame.
    count
        Number k of functions; at most the number of vertices. From two thirds of it on all are computed at once.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where no face has an area.

    Notes
    -----
    Solves L φ = λ M φ with the cotangent Laplacian L and lumped areas M, as the symmetric M^-½ L M^-½.
    """
    if not key.area > 0:
        raise InvalidInput("invalid_mesh", "The key frame has no area, and so no spectrum.")
    if count < 1:
        raise ValueError(f"the number of functions must be positive, not {count}")
    n = len(key.vertices)
    count = min(count, n)
    masses = vertex_areas(key)
    masses = np.maximum(masses, 1e-6 * masses.mean())
    roots = 1 / np.sqrt(masses)
    matrix = (diags_array(roots) @ cotangent_laplacian(key) @ diags_array(roots)).tocsc()
    if count > 2 * n // 3:
        values, vectors = np.linalg.eigh(matrix.toarray())
        values, vectors = values[:count], vectors[:, :count]
    else:
        # a shift below zero, by little on the scale of the spectrum, makes the matrix invertible
        shift = -1e-3 * float(matrix.diagonal().mean()) / n
        start = np.random.default_rng(0).standard_normal(n)
        values, vectors = eigsh(matrix, k=count, sigma=shift, v0=start)
        order = np.argsort(values)
        values, vectors = values[order], vectors[:, order]
    return SpectralBasis(key.vertices, np.ascontiguousarray(roots[:, None] * vectors), values, masses)
