"""Readers and writers of triangle meshes, one module per format.

`read_mesh` tells the format from the content, checks counts against limits before it loads anything, and keeps the
number and the order of the vertices as they are in the file.
"""

from __future__ import annotations

from shapery_geometry.mesh_io.glb import write_scene_glb
from shapery_geometry.mesh_io.limits import MeshLimits
from shapery_geometry.mesh_io.obj import write_obj
from shapery_geometry.mesh_io.off import write_off
from shapery_geometry.mesh_io.ply import write_ply
from shapery_geometry.mesh_io.reading import read_mesh, read_mesh_bytes
from shapery_geometry.mesh_io.stl import write_stl
from shapery_geometry.mesh_io.writing import write_mesh

__all__ = [
    "MeshLimits",
    "read_mesh",
    "read_mesh_bytes",
    "write_mesh",
    "write_obj",
    "write_off",
    "write_ply",
    "write_scene_glb",
    "write_stl",
]
