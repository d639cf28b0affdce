"""The vector by which candidates are found: the root's descriptors, projected.

References
----------
D. Achlioptas, Database-friendly random projections, JCSS 66(4), 2003, doi:10.1016/S0022-0000(03)00025-4.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.retrieval import VECTOR_DIMENSION
from shapery_retrieval.arg import Arg
from shapery_retrieval.matching import WHOLE_UNLIKE
from shapery_retrieval.packing import whole_arrays

SHARES = {"covariance": 72, "quantiles": 72, "views": 112}
"""How many of the numbers each descriptor gets."""


def vector_of(arg: Arg) -> NDArray[np.float64]:
    """(256,) vector of a graph; shapes near each other by it are worth a closer look."""
    whole = whole_arrays([arg])
    parts = []
    for name, size in SHARES.items():
        values = whole[name][0].astype(np.float64) / WHOLE_UNLIKE[name]
        if name == "quantiles":
            # these are compared by their mean difference, the others by distance
            values = values / np.sqrt(len(values))
        parts.append(values @ _projection(len(values), size))
    result = np.concatenate(parts)
    assert len(result) == VECTOR_DIMENSION
    return result.astype(np.float32).astype(np.float64)


@cache
def _projection(rows: int, columns: int) -> NDArray[np.float64]:
    """Random signs that are the same everywhere, scaled so that lengths are kept on average."""
    bits = np.random.PCG64(2011 + rows).random_raw(rows * columns) >> np.uint64(63)
    return np.asarray((2.0 * bits.reshape(rows, columns).astype(np.float64) - 1.0) / np.sqrt(columns))
