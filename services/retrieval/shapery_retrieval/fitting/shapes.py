"""Shapes of many kinds, by random: bodies with limbs, vessels, furniture, machine parts, blobs."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.decimation import decimate
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.repair import repair

Array = NDArray[np.float64]
Field = Callable[[Array], Array]
"""Signed distance, or a bound of it, at (n, 3) points: negative inside."""


def capsule(a: Array, b: Array, start: float, end: float) -> Field:
    """Return a rod from a to b whose radius runs from `start` to `end`."""

    def field(p: Array) -> Array:
        along = np.clip((p - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-12), 0, 1)
        return np.asarray(np.linalg.norm(p - a - along[:, None] * (b - a), axis=1) - (start + along * (end - start)))

    return field


def box(center: Array, half: Array, rounding: float = 0.02) -> Field:
    """Return a box with rounded edges."""

    def field(p: Array) -> Array:
        q = np.abs(p - center) - half + rounding
        return np.asarray(np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0) - rounding)

    return field


def ellipsoid(center: Array, radii: Array) -> Field:
    """Return an ellipsoid (a bound of its distance)."""

    def field(p: Array) -> Array:
        return np.asarray((np.linalg.norm((p - center) / radii, axis=1) - 1) * radii.min())

    return field


def ring(center: Array, axis: int, radius: float, thickness: float) -> Field:
    """Return a torus around a coordinate axis."""

    def field(p: Array) -> Array:
        q = p - center
        flat = np.delete(q, axis, axis=1)
        return np.asarray(np.hypot(np.linalg.norm(flat, axis=1) - radius, q[:, axis]) - thickness)

    return field


def turned(profile: Callable[[Array], Array], low: float, high: float, wall: float | None) -> Field:
    """Return a solid of revolution around z, or, with a wall, a vessel open at the top."""

    def field(p: Array) -> Array:
        out = np.linalg.norm(p[:, :2], axis=1) - profile(p[:, 2])
        body = np.maximum(out, np.maximum(low - p[:, 2], p[:, 2] - high))
        if wall is None:
            return np.asarray(body)
        return np.asarray(np.maximum(body, -np.maximum(out + wall, low + wall - p[:, 2])))

    return field


def joined(fields: list[Field], smooth: float) -> Field:
    """Return the union of bodies, its seams smoothed."""

    def field(p: Array) -> Array:
        values = np.stack([f(p) for f in fields])
        if smooth <= 0:
            return np.asarray(values.min(axis=0))
        low = values.min(axis=0)
        return np.asarray(low - smooth * np.log(np.exp(-(values - low) / smooth).sum(axis=0)))

    return field


def creature(rng: np.random.Generator) -> Field:
    """Draw a trunk with a head and jointed limbs in a random pose."""
    trunk = rng.uniform(0.25, 0.6)
    thick = rng.uniform(0.08, 0.25)
    a, b = np.array([-trunk, 0.0, 0.0]), np.array([trunk, 0.0, 0.0])
    parts = [capsule(a, b, thick * rng.uniform(0.6, 1.2), thick)]
    if rng.random() < 0.8:
        head = b + rng.normal(size=3) * 0.05 + np.array([thick * 1.2, 0, thick * 0.6])
        parts.append(ellipsoid(head, thick * rng.uniform(0.5, 1.1, 3)))
    for _ in range(int(rng.integers(1, 5))):
        at = a + rng.uniform(0, 1) * (b - a)
        direction = rng.normal(size=3) * [0.3, 1, 1]
        length = rng.uniform(0.3, 0.9)
        radius = thick * rng.uniform(0.2, 0.6)
        for mirror in (1, -1) if rng.random() < 0.8 else (1,):
            here, way = at.copy(), direction * [1, mirror, 1] / np.linalg.norm(direction)
            for joint in range(int(rng.integers(1, 4))):
                bent = way + rng.normal(size=3) * 0.4
                there = here + bent / np.linalg.norm(bent) * length / (joint + 1.5)
                parts.append(capsule(here, there, radius, radius * 0.75))
                here, radius = there, radius * 0.75
    return joined(parts, 0.02)


def furniture(rng: np.random.Generator) -> Field:
    """Draw a plate on legs, with or without a back and arms."""
    half = np.array([rng.uniform(0.3, 0.8), rng.uniform(0.3, 0.8), rng.uniform(0.02, 0.08)])
    parts = [box(np.zeros(3), half)]
    height, thick = rng.uniform(0.2, 0.8), rng.uniform(0.03, 0.08)
    if rng.random() < 0.25:
        parts.append(capsule(np.zeros(3), np.array([0, 0, -height]), thick * 1.5, thick * 1.5))
        parts.append(box(np.array([0, 0, -height]), np.array([*half[:2] * 0.6, 0.03])))
    else:
        for x in (-1, 1):
            for y in (-1, 1):
                foot = np.array([x * (half[0] - thick), y * (half[1] - thick), -height])
                parts.append(capsule(foot * [1, 1, 0], foot, thick, thick))
    if rng.random() < 0.6:
        tall = rng.uniform(0.2, 0.7)
        parts.append(box(np.array([-half[0] + 0.04, 0, tall]), np.array([0.04, half[1], tall])))
    if rng.random() < 0.3:
        arms = (np.array([0, y * (half[1] - 0.04), 0.2]) for y in (-1, 1))
        parts += [box(arm, np.array([half[0], 0.04, 0.03])) for arm in arms]
    return joined(parts, 0.0)


def vessel(rng: np.random.Generator) -> Field:
    """Draw a turned body, solid or hollow, often with handles."""
    coefficients = rng.normal(size=4) * [0.0, 0.25, 0.15, 0.1] + [rng.uniform(0.2, 0.5), 0, 0, 0]

    def profile(z: Array) -> Array:
        t = np.clip(z, -0.8, 0.8) * 2
        return np.maximum(np.polynomial.polynomial.polyval(t, coefficients), 0.07)

    wall = rng.uniform(0.06, 0.1) if rng.random() < 0.6 else None
    parts = [turned(profile, -0.7, rng.uniform(0.3, 0.8), wall)]
    radius = float(profile(np.zeros(1))[0])
    for side in (1, -1)[: int(rng.integers(0, 3))]:
        handle = ring(np.array([side * radius, 0, 0.0]), 1, rng.uniform(0.15, 0.28), 0.05)
        parts.append(lambda p, h=handle, s=side, r=radius: np.maximum(h(p), r * 0.9 - s * p[:, 0]))  # type: ignore[misc]
    return joined(parts, 0.0)


def machine(rng: np.random.Generator) -> Field:
    """Draw blocks, drums and rings put together, with bores."""
    parts: list[Field] = []
    for _ in range(int(rng.integers(1, 5))):
        at = rng.uniform(-0.3, 0.3, 3)
        kind = rng.integers(4)
        if kind == 0:
            parts.append(box(at, rng.uniform(0.08, 0.5, 3)))
        elif kind == 1:
            radius, half = rng.uniform(0.1, 0.4), rng.uniform(0.05, 0.5)
            parts.append(turned(lambda z, r=radius: np.full(len(z), r), -half, half, None))  # type: ignore[misc]
        elif kind == 2:
            parts.append(ring(at * 0.3, int(rng.integers(3)), rng.uniform(0.25, 0.5), rng.uniform(0.06, 0.15)))
        else:
            parts.append(capsule(at, rng.uniform(-0.6, 0.6, 3), rng.uniform(0.05, 0.15), rng.uniform(0.05, 0.15)))
    body = joined(parts, 0.0)
    if rng.random() < 0.5:
        bore = rng.uniform(0.05, 0.2)
        axis = int(rng.integers(3))
        return lambda p: np.maximum(body(p), bore - np.linalg.norm(np.delete(p, axis, axis=1), axis=1))
    return body


def blob(rng: np.random.Generator) -> Field:
    """Draw a few ellipsoids melted together: fish, busts, fruit."""
    parts = [ellipsoid(np.zeros(3), rng.uniform(0.15, 0.6, 3))]
    others = int(rng.integers(0, 5))
    parts += [ellipsoid(rng.normal(size=3) * 0.3, rng.uniform(0.04, 0.35, 3)) for _ in range(others)]
    return joined(parts, rng.uniform(0.01, 0.08))


def wire(rng: np.random.Generator) -> Field:
    """Draw a bent rod: springs, hooks, frames."""
    turns, radius, pitch = rng.uniform(0.3, 4), rng.uniform(0.1, 0.5), rng.uniform(0.05, 1.2)
    t = np.linspace(0, 1, 60)
    wobble = rng.normal(size=(3, 3)) * 0.1
    path = np.stack(
        (radius * np.cos(2 * np.pi * turns * t), radius * np.sin(2 * np.pi * turns * t), pitch * (t - 0.5)), 1
    )
    path += np.stack([np.sin(np.pi * (k + 1) * t) for k in range(3)], axis=1) @ wobble
    thick = rng.uniform(0.035, 0.09)
    return joined([capsule(a, b, thick, thick) for a, b in pairwise(path)], 0.0)


def plane_like(rng: np.random.Generator) -> Field:
    """Draw a long body with thin wings or fins."""
    length, thick = rng.uniform(0.5, 0.9), rng.uniform(0.04, 0.15)
    parts: list[Field] = [ellipsoid(np.zeros(3), np.array([length, thick, thick * rng.uniform(0.7, 1.6)]))]
    for _ in range(int(rng.integers(1, 4))):
        at, span = rng.uniform(-0.8, 0.6) * length, rng.uniform(0.15, 0.8)
        sweep = rng.uniform(-0.3, 0.1)
        up = float(rng.random() < 0.3)
        for side in (1, -1) if not up else (1,):
            tip = np.array([at + sweep, side * span * (1 - up), span * up * 0.6])
            for step in np.linspace(-0.12, 0.12, 7):
                shift = np.array([step, 0, 0])
                parts.append(capsule(np.array([at, 0, 0]) + shift, tip + shift * 0.4, 0.03, 0.025))
    return joined(parts, 0.005)


FAMILIES = (creature, creature, furniture, vessel, machine, blob, wire, plane_like)


def generated_shape(rng: np.random.Generator, faces: int = 5000) -> TriangleMesh | None:
    """Draw one shape, or None where the draw came out empty."""
    from skimage.measure import marching_cubes

    field = FAMILIES[int(rng.integers(len(FAMILIES)))](rng)
    axis = np.linspace(-1.6, 1.6, 33)
    coarse = field(np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)).reshape(33, 33, 33)
    inside = np.argwhere(coarse < 0.08)
    if len(inside) < 8:
        return None
    low, high = axis[0] + 0.1 * (inside.min(0) - 1), axis[0] + 0.1 * (inside.max(0) + 1)
    step = float((high - low).max()) / 76
    grids = [np.arange(a, b + 2 * step, step) for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*grids, indexing="ij"), -1)
    values = field(points.reshape(-1, 3)).reshape(points.shape[:3])
    values = np.pad(values, 1, constant_values=step)
    if values.min() >= 0:
        return None
    vertices, triangles, _, _ = marching_cubes(values, 0.0, spacing=(step,) * 3)  # type: ignore[no-untyped-call]
    mesh = repair(TriangleMesh(vertices, triangles)).mesh
    return decimate(mesh, faces) if mesh.area > 0 else None
