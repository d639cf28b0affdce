"""How the kernels of the mesh and of its flows are compiled: together (see `shapery_geometry.compilation`)."""

from __future__ import annotations

from pathlib import Path

from shapery_geometry.compilation import KernelFamily, inlined, inner

__all__ = ["inlined", "inner", "kernel"]

_PACKAGE = Path(__file__).resolve().parent.parent

kernel = KernelFamily((*_PACKAGE.glob("mesh/*.py"), *_PACKAGE.glob("flow/_*.py"))).kernel
