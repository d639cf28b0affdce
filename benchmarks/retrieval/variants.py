"""The same shapes worn: noise, other resolutions, poses in space, holes, crops."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from shapery_geometry.decimation import decimate
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.repair import repair, submesh

Variant = Callable[[TriangleMesh, np.random.Generator], TriangleMesh]


def noise(mesh: TriangleMesh, rng: np.random.Generator) -> TriangleMesh:
    """Move each vertex by 0.3 % of the diagonal."""
    return mesh.with_vertices(mesh.vertices + rng.normal(size=mesh.vertices.shape) * 0.003 / 3**0.5 * mesh.diagonal)


def moved(mesh: TriangleMesh, rng: np.random.Generator) -> TriangleMesh:
    """Turn, scale, shift and mirror."""
    turn = Rotation.random(rng=rng).as_matrix()
    points = mesh.vertices @ turn.T * [-1, 1, 1] * np.exp(rng.uniform(-5, 5)) + rng.normal(size=3)
    return mesh.with_vertices(points).flipped()


def fewer(share: float) -> Variant:
    """Keep a share of the faces."""
    return lambda mesh, _rng: repair(decimate(mesh, max(int(len(mesh.faces) * share), 100))).mesh


def cropped(share: float) -> Variant:
    """Cut by a random plane so that about a share of the surface stays."""

    def cut(mesh: TriangleMesh, rng: np.random.Generator) -> TriangleMesh:
        direction = rng.normal(size=3)
        height = mesh.corners.mean(axis=1) @ direction
        order = np.argsort(height)
        stays = np.cumsum(mesh.face_areas[order]) <= share * mesh.area
        return submesh(mesh, order[stays]).mesh

    return cut


def remeshed(mesh: TriangleMesh, _rng: np.random.Generator) -> TriangleMesh:
    """Put other vertices on the same surface, by isotropic remeshing."""
    import pymeshlab

    held = pymeshlab.MeshSet()
    held.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.faces))
    held.meshing_isotropic_explicit_remeshing(iterations=4, targetlen=pymeshlab.PercentageValue(1.5))
    found = held.current_mesh()
    return repair(TriangleMesh(found.vertex_matrix(), found.face_matrix())).mesh


def holes(mesh: TriangleMesh, rng: np.random.Generator) -> TriangleMesh:
    """Punch five holes of one percent of the surface each."""
    middles = mesh.corners.mean(axis=1)
    keep = np.ones(len(mesh.faces), dtype=bool)
    for centre in middles[rng.choice(len(middles), 5, replace=False)]:
        order = np.argsort(np.linalg.norm(middles - centre, axis=1))
        keep[order[np.cumsum(mesh.face_areas[order]) <= 0.01 * mesh.area]] = False
    return submesh(mesh, keep).mesh


VARIANTS: dict[str, Variant] = {
    "noise 0.3 %": noise,
    "turned, scaled, mirrored": moved,
    "half of the faces": fewer(0.5),
    "a quarter of the faces": fewer(0.25),
    "an eighth of the faces": fewer(0.125),
    "isotropic remeshing": remeshed,
    "five holes": holes,
    "cropped to 70 %": cropped(0.7),
}
