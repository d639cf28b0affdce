"""Shape indexing and retrieval by attributed relational graphs.

>>> from shapery_retrieval import build_arg, match
>>> found = match(build_arg(mesh), build_arg(other))
>>> found.score, found.levels[0].transport
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from shapery_retrieval.arg import Arg
    from shapery_retrieval.describe import build_arg
    from shapery_retrieval.matching import Match, match

__all__ = ["Arg", "Match", "build_arg", "match"]

_HOMES = {
    "Arg": "shapery_retrieval.arg",
    "Match": "shapery_retrieval.matching",
    "build_arg": "shapery_retrieval.describe",
    "match": "shapery_retrieval.matching",
}


def __getattr__(name: str) -> Any:
    # Lazily, because the algorithms bring SciPy and numba, which a worker's start and a help page need not wait for.
    if name in _HOMES:
        from importlib import import_module

        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
