"""What tells the left of a surface from its right, and how far its samples are from each other.

All that is known of a sample by distances and heat is the same on the left and on the right. Of two such fields f and g
the density n·(∇f × ∇g) is not: a mirror changes its sign. These *sides* tell left from right, as orientation does in
maps between surfaces (Ren et al.).

References
----------
J. Ren, A. Poulenard, P. Wonka, M. Ovsjanikov, Continuous and orientation-preserving correspondences via functional
maps, ACM TOG 37(6), 2018, doi:10.1145/3272127.3275040.
"""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_retrieval.decompose import Samples
from shapery_retrieval.signals import Signals

SMOOTH, SPREAD = 0.002, 0.004
"""For how long heat spreads the fields that sides are made of, and the sides, in units of the area."""
LEAST_SPREADS = (0.08, 0.2, 0.3, 0.15, 0.8)
"""Spread below which each of these fields counts as even; about half of what bodies with limbs have."""
SIDES = tuple(combinations(range(len(LEAST_SPREADS)), 2))
Array = NDArray[np.float64]


def sample_arrays(mesh: TriangleMesh, signals: Signals, samples: Samples) -> dict[str, NDArray[Any]]:
    """Return what a graph keeps of the samples of its surface, besides their patches, to lay surfaces on each other.

    Parameters
    ----------
    mesh
        As it was analysed.
    signals, samples
        Of this mesh.

    Returns
    -------
    ``patch_sides`` (s, 10) float16; ``patch_distances`` (s(s−1)/2) uint8, of all pairs, in 255ths of the largest; and
    ``patch_reach`` (1) float32, the largest over the mean of the surface.
    """
    distances = samples.distances
    mean_distance = float(samples.areas @ distances @ samples.areas)
    largest = max(float(distances.max()), 1e-12)
    whole = np.log(np.maximum(samples.areas @ samples.reach / mean_distance, 1e-3))
    columns = (signals.areas[:, None] * sides(mesh, signals, whole)).T
    sums = np.stack([np.bincount(samples.cells, column, len(samples.areas)) for column in columns], axis=1)
    return {
        "patch_sides": (sums / samples.areas[:, None]).astype(np.float16),
        "patch_distances": np.round(255 / largest * distances[np.triu_indices(len(distances), 1)]).astype(np.uint8),
        "patch_reach": np.array([largest / mean_distance], dtype=np.float32),
    }


def sides(mesh: TriangleMesh, signals: Signals, whole: Array) -> Array:
    """(n, 10) fields of about unit spread that change their sign in a mirror, and do not change with the pose.

    Parameters
    ----------
    mesh, signals
        Of one surface.
    whole : (n,)
        Logarithm of the mean geodesic distance of each vertex to all others.
    """
    spectrum, areas = signals.spectrum, signals.areas
    fields = np.stack(
        (whole, signals.heat[:, 9], signals.thickness, signals.mean_curvature[:, 2], signals.gaussian_curvature[:, 2]),
        axis=1,
    )
    fields = spectrum.low_pass(fields, SMOOTH)
    fields -= areas @ fields
    fields /= np.maximum(np.sqrt(areas @ fields**2), LEAST_SPREADS)
    corners = fields[mesh.faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    # over a face n·(∇f × ∇g) is, times its area, half the determinant of the differences along two edges
    f, g = np.array(SIDES).T
    wedges = (first[:, f] * second[:, g] - second[:, f] * first[:, g]) / 2
    at_vertices = np.stack(
        [np.bincount(mesh.faces.ravel(), np.repeat(column / 3, 3), len(areas)) for column in wedges.T], axis=1
    )
    spread = np.exp(-spectrum.values * SPREAD)[:, None] * (spectrum.functions.T @ at_vertices)
    result = spectrum.functions @ spread
    return np.asarray(result / np.maximum(np.sqrt(areas @ result**2), 1.0))
