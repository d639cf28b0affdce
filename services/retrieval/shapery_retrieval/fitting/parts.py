"""Words of `shapery_retrieval.coverage`, from the patches of generated shapes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapery_retrieval.coverage import WORDS
from shapery_retrieval.fitting.k_means import k_means
from shapery_retrieval.patches import BLOCKS, Patches, nearest_patches
from shapery_retrieval.ranking import RANK
from shapery_retrieval.vocabulary import vocabulary

WeightedFeatures = tuple[NDArray[np.float32], NDArray[np.float16]]


def fit_parts(patches: Sequence[WeightedFeatures], rng: np.random.Generator) -> dict[str, NDArray[np.generic]]:
    """Return the arrays of the vocabulary by which parts are compared.

    Parameters
    ----------
    patches
        Of each generated shape the (p,) weights and (p, 29) features of its patches.
    rng
        Where the search for words begins.
    """
    standards = vocabulary()
    scale = np.empty(len(standards.patch_mean))
    for weight, columns in BLOCKS:
        scale[list(columns)] = np.sqrt(weight / len(columns))
    features = np.concatenate([some.astype(np.float64) for _, some in patches])
    points = (features - standards.patch_mean) / standards.patch_spread * scale
    words = k_means(points, WORDS, rng).astype(np.float16)
    asked = Patches(np.ones(WORDS, np.float32), words.astype(np.float32))
    held = [
        Patches(np.ones(len(some), np.float32), some.astype(np.float32))
        for some in np.split(points, np.cumsum([len(weights) for weights, _ in patches])[:-1])
    ]
    reach = np.sort(nearest_patches(asked, held), axis=1)[:, RANK - 1]
    return {"patch_words": words, "patch_reach": reach.astype(np.float32)}
