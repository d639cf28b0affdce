"""The cotangent Laplacian and the mass matrices that go with it.

References
----------
U. Pinkall, K. Polthier, Computing discrete minimal surfaces and their conjugates, Experimental Mathematics 2(1), 1993,
doi:10.1080/10586458.1993.10504266.
M. Meyer, M. Desbrun, P. Schröder, A. H. Barr, Discrete differential-geometry operators for triangulated 2-manifolds,
Visualization and Mathematics III, 2003, doi:10.1007/978-3-662-05105-4_2.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from shapery_geometry.mesh import TriangleMesh


def corner_cotangents(mesh: TriangleMesh) -> NDArray[np.float64]:
    """(m, 3) cotangent of each face's angle at each corner; zero in faces without area."""
    p = mesh.corners
    double_area = 2 * mesh.face_areas
    solid = double_area > 0
    cotangents = np.zeros((len(p), 3))
    for k in range(3):
        dots = np.einsum("ij,ij->i", p[:, (k + 1) % 3] - p[:, k], p[:, (k + 2) % 3] - p[:, k])
        np.divide(dots, double_area, out=cotangents[:, k], where=solid)
    return cotangents


def cotangent_laplacian(mesh: TriangleMesh) -> csr_array[np.float64]:
    """Return the stiffness matrix of linear elements.

    Parameters
    ----------
    mesh
        Any mesh. Faces without area are passed over, and vertices without a face get empty rows.

    Returns
    -------
    (n, n) sparse float64
        Symmetric and positive semidefinite: L_ij = −(cot α_ij + cot β_ij) / 2 for an edge with the opposite angles α
        and β, and rows that sum to zero. It has no unit. With the matrix M of `mass_matrix`, −M⁻¹L is the Laplacian.
    """
    n = len(mesh.vertices)
    half = 0.5 * corner_cotangents(mesh)
    # the angle at corner k is opposite the side from k + 1 to k + 2
    i = np.roll(mesh.faces, -1, axis=1).ravel()
    j = np.roll(mesh.faces, -2, axis=1).ravel()
    weights = half.ravel()
    rows = np.concatenate((i, j, i, j))
    columns = np.concatenate((j, i, i, j))
    values = np.concatenate((-weights, -weights, weights, weights))
    return coo_array((values, (rows, columns)), shape=(n, n)).tocsr()


def vertex_areas(mesh: TriangleMesh, kind: Literal["barycentric", "mixed"] = "barycentric") -> NDArray[np.float64]:
    """Share the area of the mesh among its vertices.

    Parameters
    ----------
    mesh
        Any mesh.
    kind
        ``barycentric``: a third of each face to each corner. ``mixed``: what is nearer to a corner than to the others,
        or, in faces with an obtuse angle, half to that corner and a quarter to each other (Meyer et al., Fig. 4).

    Returns
    -------
    (n,) float64
        Never negative; in sum the area of the mesh; zero where a vertex has no face.
    """
    n = len(mesh.vertices)
    areas = mesh.face_areas
    if kind == "barycentric":
        shares = np.repeat(areas[:, None] / 3, 3, axis=1)
    elif kind == "mixed":
        shares = _mixed_shares(mesh)
    else:
        raise ValueError(f"kind must be 'barycentric' or 'mixed', not {kind!r}")
    return np.bincount(mesh.faces.ravel(), weights=shares.ravel(), minlength=n).astype(np.float64)


def _mixed_shares(mesh: TriangleMesh) -> NDArray[np.float64]:
    p = mesh.corners
    cotangents = corner_cotangents(mesh)
    # squared length of the side opposite each corner
    sides = np.stack([((p[:, (k + 2) % 3] - p[:, (k + 1) % 3]) ** 2).sum(axis=1) for k in range(3)], axis=1)
    parts = sides * cotangents / 8
    shares = np.roll(parts, -1, axis=1) + np.roll(parts, -2, axis=1)
    obtuse = cotangents < 0
    areas = mesh.face_areas[:, None]
    wide = obtuse.any(axis=1, keepdims=True)
    return np.where(wide, np.where(obtuse, areas / 2, areas / 4), shares)


def mass_matrix(mesh: TriangleMesh, *, lumped: bool = True) -> csr_array[np.float64]:
    """Return the mass matrix of linear elements, in the square of the mesh's unit.

    Parameters
    ----------
    mesh
        Any mesh.
    lumped
        The diagonal matrix of the barycentric `vertex_areas`; else the full one: a sixth of the areas at a vertex on
        the diagonal, a twelfth of those at an edge beside it.

    Returns
    -------
    (n, n) sparse float64
        Its elements sum to the area of the mesh.
    """
    n = len(mesh.vertices)
    if lumped:
        return csr_array((vertex_areas(mesh), np.arange(n), np.arange(n + 1)), shape=(n, n))
    i = mesh.faces.ravel()
    j = np.roll(mesh.faces, -1, axis=1).ravel()
    twelfths = np.repeat(mesh.face_areas / 12, 3)
    rows, columns = np.concatenate((i, j, i)), np.concatenate((j, i, i))
    return coo_array((np.concatenate((twelfths, twelfths, 2 * twelfths)), (rows, columns)), shape=(n, n)).tocsr()
