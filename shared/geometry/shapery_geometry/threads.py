"""How many threads the linear algebra of NumPy and SciPy takes.

Our matrices are small: on them a second thread of OpenBLAS spends more time waiting, and burning a core meanwhile, than
it saves. Many shapes at once are the business of many processes.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numpy as np
import scipy

_PREFIXES = ("scipy_openblas", "openblas")
_SUFFIXES = ("64_", "")


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let OpenBLAS take one thread within a block or, as a decorator, within a function.

    Holds for the whole process, and for the OpenBLAS that the wheels of NumPy and SciPy bring; others are left as they
    are.
    """
    before = [(put, get()) for get, put in _controls()]
    for put, _ in before:
        put(1)
    try:
        yield
    finally:
        for put, count in before:
            put(count)


@cache
def _controls() -> tuple[tuple[Callable[[], int], Callable[[int], None]], ...]:
    """Return what reads and what sets the number of threads, for each OpenBLAS in this process."""
    found = []
    for package in (np, scipy):
        folder = Path(str(package.__file__)).parent
        for path in (*folder.parent.glob(f"{folder.name}.libs/*openblas*"), *folder.glob(".dylibs/*openblas*")):
            library = ctypes.CDLL(str(path))  # loaded already: this is a handle to it
            for name in (f"{prefix}_%s_num_threads{suffix}" for prefix in _PREFIXES for suffix in _SUFFIXES):
                if hasattr(library, name % "set"):
                    get, put = getattr(library, name % "get"), getattr(library, name % "set")
                    get.argtypes, get.restype = [], ctypes.c_int
                    put.argtypes, put.restype = [ctypes.c_int], None
                    found.append((get, put))
                    break
    return tuple(found)
