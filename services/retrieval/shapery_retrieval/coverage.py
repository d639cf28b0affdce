"""The vector by which a bank is scanned for shapes that a part may be of.

Words are typical patches of surfaces (`shapery_retrieval.patches`). A shape covers each word as near as its nearest
patch comes to it, and a part asks for the words that its own patches are nearest to, and for shapes that cover others
less: one that covers everything somewhat is not what it looks for. What it asks for, times how it is covered, is about
what `shapery_retrieval.search` finds by looking at all patches of both. A last number fills the vector of a shape up to
a length that all share; then the largest product is the least Euclidean distance. What is asked for has that length,
too: beside it the rounding to 16 bits, in which pgvector keeps vectors, is small.

References
----------
Y. Bachrach et al., Speeding up the Xbox recommender system using a Euclidean transformation for inner-product spaces,
RecSys 2014, doi:10.1145/2645710.2645741.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.retrieval import VECTOR_DIMENSION
from shapery_retrieval.arg import Arg
from shapery_retrieval.patches import Patches, nearest_patches, patches_of
from shapery_retrieval.vocabulary import vocabulary

WORDS = VECTOR_DIMENSION - 1
ALL = 0.7
"""Share of what is asked for in the mean that is taken off what is asked for of each word; .5 to .8 are as good."""
REACH = 1.5
"""A word counts as covered within so many times the distance at which the twelfth nearest generated shape has it."""

Array = NDArray[np.float64]


def coverage_of(arg: Arg) -> Array:
    """(256,) vector of what a shape covers: for each word a number in [0, 1], and what fills the length up to √255."""
    return np.asarray(covered_by([patches_of(arg)])[0])


def covered_by(shapes: list[Patches]) -> Array:
    """(n, 256) vectors of what shapes of these patches cover; see `coverage_of`."""
    words = vocabulary().patch_words
    apart = nearest_patches(Patches(np.ones(len(words), np.float32), words), shapes).T
    covered = np.exp(-((apart / (REACH * vocabulary().patch_reach)) ** 2))
    filling = np.sqrt(WORDS - np.square(covered).sum(axis=1))
    return np.concatenate((covered, filling[:, None]), axis=1)


def asked_of(hypotheses: Sequence[Patches]) -> Array:
    """(256,) vector of a part: the shares of its patches that are nearest to each word, less `ALL` of their mean.

    Its length is √255.

    Parameters
    ----------
    hypotheses
        Its patches, for each size that it may have in a whole.
    """
    words = vocabulary().patch_words
    asked = np.zeros(VECTOR_DIMENSION)
    lengths = np.square(words).sum(axis=1)
    for patches in hypotheses:
        nearest = np.argmin(lengths - 2 * patches.features @ words.T, axis=1)
        asked[:WORDS] += np.bincount(nearest, patches.masses, WORDS)
    asked[:WORDS] -= ALL * asked[:WORDS].mean()
    return asked * np.sqrt(WORDS / (asked @ asked))
