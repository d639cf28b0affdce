"""Compression of mesh sequences by clusters of local transformations.

>>> from shapery_motion import decode, encode
>>> encoding = encode(read_sequence("walk.npz"))
>>> sequence = decode(encoding.data)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from shapery_motion.codec import Encoding, encode
    from shapery_motion.inspection import info
    from shapery_motion.playing import Motion, decode, open_motion
    from shapery_motion.reading import open_motion_input

__all__ = ["Encoding", "Motion", "decode", "encode", "info", "open_motion", "open_motion_input"]

_HOMES = {
    "Encoding": "shapery_motion.codec",
    "Motion": "shapery_motion.playing",
    "decode": "shapery_motion.playing",
    "encode": "shapery_motion.codec",
    "info": "shapery_motion.inspection",
    "open_motion": "shapery_motion.playing",
    "open_motion_input": "shapery_motion.reading",
}


def __getattr__(name: str) -> Any:
    # Lazily, because the algorithms bring SciPy and numba, which a worker's start and a help page need not wait for.
    if name in _HOMES:
        from importlib import import_module

        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
