"""How the kernels of the codec are compiled.

They lie in several modules and call each other, and numba inlines across modules. Its cache on disk looks at the file
of the outermost function alone, so after a change elsewhere it would go on to use what it compiled before. Kernels
declared here are cached under a digest of all the kernels' sources together.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from numba import njit

_COMMON = {"nogil": True, "error_model": "numpy"}
"""Division by zero gives infinity instead of an exception; kernels divide by what they have checked. Nothing here may
be contracted or reordered: the format prescribes every rounding that a decoder's result depends on."""

_WITHIN = {**_COMMON, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}

inner = njit(**_WITHIN)
"""For functions that only kernels call; they must not allocate."""

inlined = njit(**_WITHIN, forceinline=True)
"""The same for small functions in the innermost loops."""


def _digest() -> str:
    package = Path(__file__).resolve().parent
    digest = hashlib.sha256()
    for path in sorted((*package.glob("**/_*_kernels.py"), package / "compiled.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


_SOURCES = _digest()


def kernel(function: Any) -> Any:
    """Compile a function that Python calls, and keep what was compiled on disk until any of the sources changes."""
    dispatcher = njit(cache=True, **_COMMON)(function)
    index = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    # Where numba keeps this elsewhere one day, its cache works as it does by itself.
    if index is not None and hasattr(index, "_source_stamp"):
        index._source_stamp = ("sources", _SOURCES)
    return dispatcher
