"""From a mesh to its attributed relational graph."""

from __future__ import annotations

from shapery_geometry.mesh import TriangleMesh
from shapery_retrieval.arg import Arg


def build_arg(mesh: TriangleMesh) -> Arg:
    """Return the graph of a mesh."""
    raise NotImplementedError
