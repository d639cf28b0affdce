"""Prediction by the spectrum of the key frame (section 5.3.2, Figs 5.1 and 5.2).

The eigenfunctions of the Laplace–Beltrami operator of the key frame are a basis for functions on the surface; a frame's
positions, or their differences from the key frame, are cut off after the first coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array, eye_array
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators.laplacian import cotangent_laplacian, vertex_areas

FloatArray = NDArray[np.float64]

TEXT_COEFFICIENTS: Final = 1000
"""How many coefficients the text keeps."""
WINDOW: Final = 72
"""How many eigenvalues are sought at once."""


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
        values, vectors = _lowest(matrix, count)
    return SpectralBasis(key.vertices, np.ascontiguousarray(roots[:, None] * vectors), values, masses)


def _lowest(matrix: csc_array[np.float64], count: int) -> tuple[FloatArray, FloatArray]:
    """Return the `count` smallest eigenvalues and their vectors, rising.

    Window by window of `WINDOW` eigenvalues around a shift: the cost of one search grows with the square of how many it
    is for. A window begins where the one before was cut off, at the widest of its last gaps, so that eigenvalues that
    lie close together come from one window and their vectors are orthogonal.
    """
    n = matrix.shape[0]
    start = np.random.default_rng(0).standard_normal(n)
    # a shift below zero, by little on the scale of the spectrum, makes the matrix invertible
    shift = -1e-3 * float(matrix.diagonal().mean()) / n
    size = min(WINDOW, n - 2)
    values, vectors = _around(matrix, size, shift, start)
    while len(values) < count:
        reach = float(values[-1] - values[-min(size // 2, len(values))])
        cut = _widest_gap(values)
        below, kept = 0.5 * float(values[cut - 1] + values[cut]), vectors[:, :cut]
        # near to what is known, so that the window begins below where that was cut off
        ahead = 0.5
        while True:
            found, more = _around(matrix, size, below + ahead * reach, start)
            if found[0] < below < found[-1]:
                break
            ahead /= 2
        fresh = found > below
        values = np.concatenate((values[:cut], found[fresh]))
        vectors = np.concatenate((kept, more[:, fresh]), axis=1)
    return values[:count], vectors[:, :count]


def _around(
    matrix: csc_array[np.float64], count: int, shift: float, start: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the `count` eigenvalues nearest to a shift, rising, and their vectors."""
    shifted = (matrix - shift * eye_array(matrix.shape[0], format="csc")).tocsc()
    # the ordering that scipy takes by default fills a symmetric matrix several times as much
    factor = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options={"SymmetricMode": True})
    inverse = LinearOperator(matrix.shape, matvec=factor.solve, dtype=np.float64)
    values, vectors = eigsh(matrix, k=count, sigma=shift, OPinv=inverse, v0=start)
    order = np.argsort(values)
    return values[order], vectors[:, order]


def _widest_gap(values: FloatArray) -> int:
    """Return where to cut: how many of the values lie below the widest of the last gaps."""
    first = max(len(values) - WINDOW // 6, 1)
    return first + int(np.diff(values[first - 1 :]).argmax())
