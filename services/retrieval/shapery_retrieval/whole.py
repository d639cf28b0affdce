"""Descriptors of the whole shape, which the root of the graph carries.

References
----------
H. Tabia, H. Laga, D. Picard, P.-H. Gosselin, Covariance descriptors for 3D shape matching and retrieval, CVPR 2014,
doi:10.1109/CVPR.2014.533.
A. Bronstein, M. Bronstein, L. Guibas, M. Ovsjanikov, Shape Google, ACM TOG 30(1), 2011, doi:10.1145/1899404.1899405.
R. Osada, T. Funkhouser, B. Chazelle, D. Dobkin, Shape distributions, ACM TOG 21(4), 2002, doi:10.1145/571647.571648.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_retrieval import _view_kernels
from shapery_retrieval.signals import Signals
from shapery_retrieval.views import view_features
from shapery_retrieval.vocabulary import Vocabulary, vocabulary

QUANTILES = (np.arange(9) + 0.5) / 9
RIDGE = 1e-2
"""Added to covariances of signals of about unit spread, before their logarithm."""


def whole_descriptors(mesh: TriangleMesh, signals: Signals) -> dict[str, NDArray[Any]]:
    """Return all descriptors by name, as `shapery_retrieval.arg.Arg.whole` stores them."""
    words = vocabulary()
    entries, weights = view_words(view_features(mesh), words)
    return {
        "covariance": signal_covariance(signals).astype(np.float32),
        "quantiles": signal_quantiles(signals).astype(np.float32),
        "wave_words": wave_words(signals, words).astype(np.float32),
        "view_words": entries,
        "view_weights": weights,
    }


def signal_covariance(signals: Signals) -> NDArray[np.float64]:
    """Logarithm of the second moments of mixed signals and the constant one, as a vector whose norm is the matrix's."""
    mixed = np.concatenate(
        (
            signals.heat[:, ::3] / 0.6,
            signals.wave[:, ::3] / 0.6,
            signals.thickness[:, None] / 0.6 + 3.0,
            signals.mean_curvature / 0.8,
            signals.gaussian_curvature / 1.5,
            np.ones((len(signals.areas), 1)),
        ),
        axis=1,
    )
    return _log_moments(mixed, signals.areas)


def signal_quantiles(signals: Signals) -> NDArray[np.float64]:
    """Quantiles over the surface of heat, thickness and curvature, one signal after another."""
    columns = np.concatenate(
        (signals.heat, signals.thickness[:, None], signals.mean_curvature, signals.gaussian_curvature), axis=1
    )
    result = np.empty((columns.shape[1], len(QUANTILES)))
    for row, values in zip(result, columns.T, strict=True):
        order = np.argsort(values, kind="stable")
        cumulative = np.cumsum(signals.areas[order])
        middle = (cumulative - 0.5 * signals.areas[order]) / cumulative[-1]
        row[:] = np.interp(QUANTILES, middle, values[order])
    return result.ravel()


def wave_words(signals: Signals, words: Vocabulary) -> NDArray[np.float64]:
    """(w,) share of the surface whose wave kernel signature is nearest to each word, softly."""
    # |x − w|² less |x|², which the shares do not depend on
    apart = (words.waves**2).sum(axis=1) - 2 * signals.wave @ words.waves.T
    apart -= apart.min(axis=1, keepdims=True)
    shares = np.exp(-apart / words.wave_width**2)
    return np.asarray(signals.areas @ (shares / shares.sum(axis=1, keepdims=True)))


def view_words(features: NDArray[np.float32], words: Vocabulary) -> tuple[NDArray[np.uint16], NDArray[np.float16]]:
    """Return which words the views of a shape show, and the share of each, which sum to 1."""
    histogram = np.zeros(len(words.views))
    if len(features):
        projected = (features - words.view_mean) @ words.view_axes
        # the nearest word has the greatest x·w − |w|²/2
        similarity = projected @ words.views.T - 0.5 * (words.views**2).sum(axis=1)
        _view_kernels.soft_assign(similarity, words.view_sharpness, 4, histogram)
    histogram /= max(histogram.sum(), 1e-12)
    entries = np.flatnonzero(histogram > 2e-5)
    return entries.astype(np.uint16), histogram[entries].astype(np.float16)


def _log_moments(columns: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    moments = (columns.T * weights) @ columns
    values, vectors = np.linalg.eigh(moments + RIDGE * np.eye(len(moments)))
    logarithm = (vectors * np.log(np.maximum(values, 1e-9))) @ vectors.T
    rows, cols = np.triu_indices(len(moments))
    return np.asarray(logarithm[rows, cols] * np.where(rows == cols, 1.0, np.sqrt(2.0)))
