"""The first eigenpairs of the Laplacian of a surface.

References
----------
M. Reuter, F.-E. Wolter, N. Peinecke, Laplace–Beltrami spectra as "Shape-DNA" of surfaces and solids, Computer-Aided
Design 38(4), 2006, doi:10.1016/j.cad.2005.10.011.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, eye_array
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh, splu

from shapery_contracts.errors import InvalidInput


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The first k eigenpairs of L φ = λ A φ.

    Attributes
    ----------
    values : (k,) float64
        Not negative, rising; in one over the square of the surface's unit.
    functions : (n, k) float64
        Orthonormal under the areas: Φᵀ A Φ = 1. Their signs are arbitrary.
    areas : (n,) float64
        The diagonal of A.
    """

    values: NDArray[np.float64]
    functions: NDArray[np.float64]
    areas: NDArray[np.float64]

    def low_pass(self, signal: NDArray[np.float64], time: float) -> NDArray[np.float64]:
        """Return the (n,) or (n, c) signal after heat has spread for a time: Σ e^(−λt) ⟨f, φ⟩ φ."""
        weights = np.exp(-self.values * time)
        coefficients = self.functions.T @ (self.areas * signal.T).T
        return np.asarray(self.functions @ (weights * coefficients.T).T)


def laplacian_spectrum(laplacian: csr_array[np.float64], areas: NDArray[np.float64], count: int) -> Spectrum:
    """Return the first `count` eigenpairs.

    Parameters
    ----------
    laplacian : (n, n) sparse
        Symmetric, positive semidefinite; of a surface that hangs together, or zero eigenvalues repeat.
    areas : (n,) float64
        Positive.
    count
        At most n − 2.

    Raises
    ------
    InvalidInput
        ``invalid_mesh`` where the eigenvalues cannot be computed, or more than one of them is zero.
    """
    n = len(areas)
    if not 2 <= count <= n - 2:
        raise ValueError(f"of {n} vertices 2 to {n - 2} eigenpairs can be computed, not {count}")
    if not (np.isfinite(areas).all() and (areas > 0).all()):
        raise InvalidInput("invalid_mesh", "The mesh has vertices without area.", "Remove degenerate faces.")
    root = 1 / np.sqrt(areas)
    scaling = diags_array(root)
    symmetric = (scaling @ laplacian @ scaling).tocsc()
    shift = 1e-2 / float(areas.sum())
    factor = splu(
        (symmetric + shift * eye_array(n)).tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
    )
    inverse = LinearOperator((n, n), matvec=factor.solve, dtype=np.float64)
    start = np.sqrt(areas) * (1 + 0.5 * np.cos(0.618 * np.arange(n)))
    for extra, tolerance in ((30, 1e-6), (count + 1, 1e-12), (2 * count, 0.0)):
        subspace = min(n - 1, count + extra)
        try:
            inverted, vectors = eigsh(inverse, k=count, which="LM", v0=start, ncv=subspace, tol=tolerance)
        except ArpackNoConvergence as error:
            raise InvalidInput(
                "invalid_mesh", "The spectrum of the surface cannot be computed.", "Look for degenerate faces."
            ) from error
        if _complete(inverse, inverted, vectors):
            break
    order = np.argsort(-inverted, kind="stable")
    values = 1 / inverted[order] - shift
    functions = root[:, None] * vectors[:, order]
    if not (np.isfinite(values).all() and np.isfinite(functions).all()):
        raise InvalidInput("invalid_mesh", "The spectrum of the surface is not finite.", "Look for degenerate faces.")
    if values[1] * float(areas.sum()) < 1e-6:
        raise InvalidInput(
            "invalid_mesh", "The surface does not hang together.", "Weld its vertices, or give one body alone."
        )
    return Spectrum(np.maximum(values, 0.0), functions, areas)


def _complete(inverse: LinearOperator, inverted: NDArray[np.float64], vectors: NDArray[np.float64]) -> bool:
    """Whether no eigenvalue among the found ones was missed.

    Lanczos sees one function of each eigenspace at first, so on a surface with symmetries copies of an eigenvalue may
    be missing. A few steps of inverse iteration beside what was found come upon them.
    """
    rows, columns = np.arange(len(vectors))[:, None] + 1.0, np.arange(3) + 1.0
    block = np.sin(rows * (1.3 + 0.711 * columns) + rows**1.5 * columns)
    for _ in range(4):
        block -= vectors @ (vectors.T @ block)
        block = np.linalg.qr(block)[0]
        image = np.stack([inverse.matvec(column) for column in block.T], axis=1)
        largest = float(np.linalg.eigvalsh(block.T @ image)[-1])
        block = image
    return largest <= float(inverted.min()) * (1 + 1e-3)
