"""Shapes that the tests of retrieval share."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_geometry.mesh import TriangleMesh, icosphere
from shapery_retrieval.describe import Description, describe


def torus(around: int = 60, across: int = 30, radius: float = 1.0, thickness: float = 0.4) -> TriangleMesh:
    """A torus of quadrilaterals cut in two."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = 2 * np.pi * u.ravel() / around, 2 * np.pi * v.ravel() / across
    ring = radius + thickness * np.cos(b)
    points = np.stack((ring * np.cos(a), ring * np.sin(a), thickness * np.sin(b)), axis=1)
    i, j = u.ravel(), v.ravel()
    corner = i * across + j
    right, up = ((i + 1) % around) * across + j, i * across + (j + 1) % across
    beyond = ((i + 1) % around) * across + (j + 1) % across
    return TriangleMesh(
        points, np.concatenate((np.stack((corner, right, beyond), 1), np.stack((corner, beyond, up), 1)))
    )


def cylinder(around: int = 48, along: int = 40, height: float = 3.0) -> TriangleMesh:
    """A closed cylinder of radius 1 whose caps are fans of rings."""
    rings = [(r, -height / 2) for r in (0.34, 0.67)]
    rings += [(1.0, z) for z in np.linspace(-height / 2, height / 2, along)]
    rings += [(r, height / 2) for r in (0.67, 0.34)]
    angle = 2 * np.pi * np.arange(around) / around
    points = [np.array([[0, 0, -height / 2]])]
    points += [np.stack((r * np.cos(angle), r * np.sin(angle), np.full(around, z)), axis=1) for r, z in rings]
    points.append(np.array([[0, 0, height / 2]]))
    here, there = np.arange(around), (np.arange(around) + 1) % around
    faces = [np.stack((np.zeros(around, int), 1 + there, 1 + here), axis=1)]
    for ring in range(len(rings) - 1):
        low, high = 1 + ring * around, 1 + (ring + 1) * around
        faces.append(np.stack((low + here, low + there, high + there), axis=1))
        faces.append(np.stack((low + here, high + there, high + here), axis=1))
    last = 1 + (len(rings) - 1) * around
    faces.append(np.stack((last + here, last + there, np.full(around, last + around)), axis=1))
    return TriangleMesh(np.concatenate(points), np.concatenate(faces))


def egg(subdivisions: int = 3) -> TriangleMesh:
    """A body without symmetries: an ellipsoid with a bump and a bend."""
    ball = icosphere(subdivisions=subdivisions)
    p = ball.vertices * [1.0, 1.4, 2.2]
    bump = 0.6 * np.exp(-4 * ((ball.vertices - [0.6, 0.8, 0.0]) ** 2).sum(axis=1))
    p = p * (1 + bump[:, None])
    p[:, 0] += 0.25 * p[:, 2] ** 2 * (1 + 0.2 * p[:, 2])
    return ball.with_vertices(p)


@pytest.fixture(scope="session")
def described_egg() -> Description:
    return describe(egg())


@pytest.fixture(scope="session")
def described_torus() -> Description:
    return describe(torus())
