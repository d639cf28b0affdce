"""Surfaces of tumors and vessels from volumes, by deformable meshes.

>>> from shapery_segmentation import segment, write_outputs
>>> result = segment(post, pre)
>>> write_outputs(result, Path("out"))
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from shapery_segmentation.pipeline import Segmentation, segment
    from shapery_segmentation.report import write_outputs

__all__ = ["Segmentation", "segment", "write_outputs"]

_HOMES = {
    "Segmentation": "shapery_segmentation.pipeline",
    "segment": "shapery_segmentation.pipeline",
    "write_outputs": "shapery_segmentation.report",
}


def __getattr__(name: str) -> Any:
    # Lazily, because the algorithms bring SciPy and numba, which a worker's start and a help page need not wait for.
    if name in _HOMES:
        from importlib import import_module

        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
