"""Run by Blender, or by a Python that has its module `bpy`: import a scene and keep what it shows.

``blender --background --python scene.py -- SCENE.glb SHOWN.npz SECONDS…`` writes the faces, the number of shape keys,
and the vertices of the only mesh at some times, turned back into glTF's axes. The script lies alone: Python looks for
modules beside it first.
"""

import os
import sys
from typing import Any

import bpy
import numpy as np


def shown(scene: str, seconds: list[float]) -> dict[str, Any]:
    """Return what Blender makes of a scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=scene)
    (body,) = (item for item in bpy.data.objects if item.type == "MESH")
    timing = bpy.context.scene.render
    frames = []
    for second in seconds:
        frame = second * timing.fps / timing.fps_base
        bpy.context.scene.frame_set(int(frame), subframe=frame - int(frame))
        mesh = body.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
        points = np.empty(3 * len(mesh.vertices))
        mesh.vertices.foreach_get("co", points)
        world = np.array(body.matrix_world)
        x, y, z = (points.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]).T
        frames.append(np.stack((x, z, -y), axis=1))
    keys = body.data.shape_keys
    return {
        "vertices": np.array(frames),
        "faces": np.array([list(polygon.vertices) for polygon in body.data.polygons]),
        "keys": np.array(len(keys.key_blocks) if keys else 0),
    }


if __name__ == "__main__":
    source, target, *times = sys.argv[sys.argv.index("--") + 1 :]
    np.savez(target, **shown(source, [float(time) for time in times]))
    os._exit(0)  # the module bpy may crash while the interpreter ends
