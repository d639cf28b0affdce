"""Fewer faces for the same shape, by quadric edge collapse.

This is the one part of the geometry that needs pymeshlab, an extra of this package (``shapery-geometry[repair]``).

References
----------
M. Garland, P. S. Heckbert, Surface simplification using quadric error metrics, SIGGRAPH 1997,
doi:10.1145/258734.258849.
"""

from __future__ import annotations

import contextlib
import io
import re
from typing import Any

import numpy as np

from shapery_contracts.errors import Unavailable
from shapery_geometry.mesh import TriangleMesh


def decimate(mesh: TriangleMesh, faces: int, *, keep_topology: bool = True) -> TriangleMesh:
    """Return the mesh with about `faces` faces.

    Parameters
    ----------
    mesh
        Best welded, manifold and oriented.
    faces
        How many to keep. A mesh that has no more is returned as it is; where topology is kept, the work may stop
        earlier, for instance on meshes that are not manifold.
    keep_topology
        Whether handles, components and holes are kept.

    Raises
    ------
    Unavailable
        ``missing_dependency`` where pymeshlab, or a system library that it needs, is not installed.
    ValueError
        For fewer than four faces.
    """
    if faces < 4:
        raise ValueError(f"a closed surface has 4 faces at least, not {faces}")
    if len(mesh.faces) <= faces:
        return mesh
    pymeshlab = _pymeshlab()
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.array(mesh.vertices), np.array(mesh.faces)))
    meshes.meshing_decimation_quadric_edge_collapse(
        targetfacenum=int(faces),
        preservetopology=keep_topology,
        preservenormal=True,
        preserveboundary=True,
        optimalplacement=True,
    )
    result = meshes.current_mesh()
    return TriangleMesh(result.vertex_matrix(), result.face_matrix())


def _pymeshlab() -> Any:
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said):
            import pymeshlab
    except ModuleNotFoundError as error:
        raise Unavailable(
            "missing_dependency",
            "Decimation needs the Python package pymeshlab, which is not installed.",
            "Install shapery-geometry with its extra: pip install 'shapery-geometry[repair]'.",
        ) from error
    except ImportError as error:
        raise _libraries_missing(str(error)) from error
    # with some libraries missing, pymeshlab loads, prints which of its parts did not, and lacks these
    if not hasattr(pymeshlab.MeshSet, "meshing_decimation_quadric_edge_collapse"):
        raise _libraries_missing(said.getvalue())
    return pymeshlab


def _libraries_missing(said: str) -> Unavailable:
    """Return the error that names the libraries a loader's message speaks of, without its paths."""
    named = sorted(set(re.findall(r"\blib(?:GL|OpenGL|GLU|GLX|EGL)\.so\.[0-9]+", said)))
    which = " and ".join(named) or "part of what it needs"
    return Unavailable(
        "missing_dependency",
        f"Decimation needs pymeshlab, and {which} cannot be loaded from this system.",
        "On Debian and Ubuntu install the libraries with: apt-get install libgl1 libopengl0.",
    )
