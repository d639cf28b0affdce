"""How the kernels of the codec are compiled: together (see `shapery_geometry.compilation`)."""

from __future__ import annotations

from pathlib import Path

from shapery_geometry.compilation import KernelFamily, inlined, inner

__all__ = ["inlined", "inner", "kernel"]

kernel = KernelFamily(Path(__file__).resolve().parent.glob("**/_*_kernels.py")).kernel
