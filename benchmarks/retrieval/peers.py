"""Descriptors of others that are compared with: simple, well known, and needing no training.

References
----------
M. Kazhdan, T. Funkhouser, S. Rusinkiewicz, Rotation invariant spherical harmonic representation of 3D shape
descriptors, SGP 2003.
D. Vranić, 3D model retrieval, PhD thesis, Leipzig, 2004 (depth buffers of an aligned shape, their Fourier transform).
A. Bronstein, M. Bronstein, L. Guibas, M. Ovsjanikov, Shape Google, ACM TOG 30(1), 2011, doi:10.1145/1899404.1899405.
M. Reuter, F.-E. Wolter, N. Peinecke, Laplace–Beltrami spectra as Shape-DNA of surfaces and solids, CAD 38(4), 2006,
doi:10.1016/j.cad.2005.10.011.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray
from scipy.special import sph_harm_y

from benchmarks.retrieval.features import cached, keep
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators.rays import first_hits
from shapery_geometry.operators.sampling import sample_surface
from shapery_retrieval.normalise import normalise
from shapery_retrieval.signals import compute_signals

Array = NDArray[np.float64]
POINTS, SHELLS, DEGREES = 6000, 16, 13
GRID, KEPT = 48, 9
WORDS, SIGNATURES = 64, 400


def peers_of(mesh: TriangleMesh) -> dict[str, Array]:
    """Return what the peers know of a mesh, from the cache where its content was seen before."""
    path = cached(mesh, "peers-")
    if not path.exists():
        normalised = normalise(mesh)
        signals = compute_signals(normalised)
        rng = np.random.default_rng(0)
        chosen = rng.choice(len(signals.areas), SIGNATURES, p=signals.areas / signals.areas.sum())
        keep(
            path,
            heat=signals.heat[chosen],
            harmonics=spherical_harmonics(normalised.mesh, rng),
            depth=depth_buffers(normalised.mesh, rng),
        )
    with np.load(path, allow_pickle=False) as stored:
        found = dict(stored)
    if find_spec("lapy") is not None:
        path = cached(mesh, "lapy-")
        if not path.exists():
            keep(path, lapy=lapy_eigenvalues(normalise(mesh).mesh))
        with np.load(path, allow_pickle=False) as stored:
            found["lapy"] = stored["lapy"]
    return found


def lapy_eigenvalues(mesh: TriangleMesh, count: int = 31) -> Array:
    """Return the first eigenvalues as LaPy has them; NaN where it gives up."""
    from lapy import Solver, TriaMesh  # type: ignore[import-not-found]

    try:
        return np.asarray(Solver(TriaMesh(mesh.vertices, mesh.faces)).eigs(k=count)[0], dtype=np.float64)
    except (ValueError, RuntimeError):
        return np.full(count, np.nan)


def spherical_harmonics(mesh: TriangleMesh, rng: np.random.Generator) -> Array:
    """(16 × 13,) energies by shell and degree of the surface around its centroid, each shell's points as impulses."""
    points = sample_surface(mesh, POINTS, rng).points
    points = points - points.mean(axis=0)
    radii = np.linalg.norm(points, axis=1)
    # as in the paper the mean distance comes to half of the outermost shell
    shells = np.minimum((radii / radii.mean() / 2 * SHELLS).astype(int), SHELLS - 1)
    polar = np.arccos(np.clip(points[:, 2] / np.maximum(radii, 1e-12), -1, 1))
    azimuth = np.arctan2(points[:, 1], points[:, 0])
    energies = np.zeros((SHELLS, DEGREES))
    for degree in range(DEGREES):
        for order in range(degree + 1):
            values = sph_harm_y(degree, order, polar, azimuth)
            sums = np.bincount(shells, values.real, SHELLS) + 1j * np.bincount(shells, values.imag, SHELLS)
            energies[:, degree] += (1 if order == 0 else 2) * np.abs(sums / POINTS) ** 2
    return np.sqrt(energies).ravel()


def depth_buffers(mesh: TriangleMesh, rng: np.random.Generator) -> Array:
    """(3 × 2 × 9 × 9,) low frequencies of six depth images in the frame of the principal axes."""
    points = sample_surface(mesh, POINTS, rng).points
    centre = points.mean(axis=0)
    axes = np.linalg.eigh(np.cov((points - centre).T))[1][:, ::-1]
    turned = mesh.with_vertices((mesh.vertices - centre) @ axes)
    reach = 1.01 * float(np.abs(turned.vertices).max())
    ticks = (np.arange(GRID) + 0.5) / GRID * 2 * reach - reach
    across, up = (grid.ravel() for grid in np.meshgrid(ticks, ticks, indexing="ij"))
    found = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            origins = np.insert(np.stack((across, up), axis=1), axis, side * 2 * reach, axis=1)
            directions = np.zeros_like(origins)
            directions[:, axis] = -side
            depth = first_hits(turned, origins, directions)[0].reshape(GRID, GRID)
            near = np.where(np.isfinite(depth), 1 - (depth - reach) / (2 * reach), 0.0)
            # magnitudes: the sense of an axis is not known
            found.append(np.abs(np.fft.fft2(near))[:KEPT, :KEPT].ravel() / GRID**2)
    return np.concatenate(found)


def bag_of_words(signatures: Sequence[Array], rng: np.random.Generator) -> Array:
    """(n, 64) shares of heat kernel signatures near to each of the words of all of them."""
    points = np.concatenate(signatures)
    words = points[rng.choice(len(points), WORDS, replace=False)]
    for _ in range(12):
        nearest = _nearest(points, words)
        counts = np.maximum(np.bincount(nearest, minlength=WORDS), 1)
        words = np.stack([np.bincount(nearest, column, WORDS) / counts for column in points.T], axis=1)
    return np.stack([np.bincount(_nearest(rows, words), minlength=WORDS) / len(rows) for rows in signatures])


def _nearest(points: Array, words: Array) -> NDArray[np.intp]:
    return np.argmax(points @ words.T - 0.5 * (words**2).sum(axis=1), axis=1)


def peer_matrices(peers: Sequence[dict[str, Array]]) -> dict[str, Array]:
    """Return the score matrix of each peer: negative distances."""
    bags = bag_of_words([peer["heat"] for peer in peers], np.random.default_rng(0))
    found = {
        "bag of 64 HKS words": _nearness(np.sqrt(bags)),
        "spherical harmonics": _nearness(np.stack([peer["harmonics"] for peer in peers])),
        "aligned depth buffers, Fourier": _nearness(np.stack([peer["depth"] for peer in peers]), 1),
    }
    if all("lapy" in peer for peer in peers):
        values = np.stack([peer["lapy"] for peer in peers])[:, 1:]
        known = np.nan_to_num(np.log(np.maximum(values, 1e-9)), nan=1e3)
        found["ShapeDNA by LaPy, 30 log eigenvalues"] = _nearness(known)
    return found


def _nearness(vectors: Array, order: int = 2) -> Array:
    return -np.stack([np.linalg.norm(vectors - row, ord=order, axis=1) for row in vectors])
