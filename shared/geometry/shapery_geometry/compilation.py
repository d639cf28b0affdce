"""How kernels that lie in several modules and call each other are compiled.

numba inlines across modules, but its cache on disk looks at the file of the outermost function alone, so after a change
elsewhere it would go on to use what it compiled before. Kernels of a `KernelFamily` are cached under a digest of all
the family's sources together.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from numba import njit

_COMMON = {"nogil": True, "error_model": "numpy"}
"""Division by zero gives infinity instead of an exception, for which every division would need a branch; kernels divide
by what they have checked. Nothing may be contracted or reordered: results are the same on every machine."""

_WITHIN = {**_COMMON, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}

inner = njit(**_WITHIN)
"""For functions that only kernels call. Without the wrappers they compile in half the time, and without counting
references to arrays they run in half. They must not allocate."""

inlined = njit(**_WITHIN, forceinline=True)
"""The same for small functions in the innermost loops."""


class KernelFamily:
    """Kernels that are compiled anew when any of their sources changes.

    Parameters
    ----------
    sources
        Every file that the compiled code depends on.
    """

    def __init__(self, sources: Iterable[Path]) -> None:
        digest = hashlib.sha256(Path(__file__).read_bytes())
        for path in sorted(sources):
            digest.update(path.read_bytes())
        self._digest = digest.hexdigest()

    def kernel(self, function: Any) -> Any:
        """Compile a function that Python calls, and keep what was compiled on disk until a source changes."""
        dispatcher = njit(cache=True, **_COMMON)(function)
        index = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
        # Where numba keeps this elsewhere one day, its cache works as it does by itself.
        if index is not None and hasattr(index, "_source_stamp"):
            index._source_stamp = ("sources", self._digest)
        return dispatcher
