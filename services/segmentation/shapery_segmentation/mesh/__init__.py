"""The dynamic mesh: a closed surface whose triangles split, flip and collapse while it moves (3.4.1)."""

from shapery_segmentation.mesh.dynamic_mesh import DynamicMesh, RemeshCount

__all__ = ["DynamicMesh", "RemeshCount"]
