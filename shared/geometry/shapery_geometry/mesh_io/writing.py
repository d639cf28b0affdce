"""The one door to the writers: the ending of the name chooses the format."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io.glb import write_scene_glb
from shapery_geometry.mesh_io.obj import write_obj
from shapery_geometry.mesh_io.off import write_off
from shapery_geometry.mesh_io.ply import write_ply
from shapery_geometry.mesh_io.stl import write_stl


def _write_glb(mesh: TriangleMesh, path: Path) -> None:
    write_scene_glb([(path.stem, mesh, (0.8, 0.8, 0.8, 1.0))], path)


WRITERS: Final[Mapping[str, Callable[[TriangleMesh, Path], None]]] = MappingProxyType(
    {".ply": write_ply, ".obj": write_obj, ".stl": write_stl, ".off": write_off, ".glb": _write_glb}
)


def write_mesh(mesh: TriangleMesh, path: Path | str) -> None:
    """Write a mesh in the format that the ending of `path` names.

    Raises
    ------
    InvalidInput
        ``unsupported_format`` for an ending that is not known.
    """
    path = Path(path)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise InvalidInput(
            "unsupported_format",
            f"There is no mesh format with the ending {path.suffix!r}.",
            f"Known endings: {', '.join(WRITERS)}.",
        )
    writer(mesh, path)
