"""Tubes of a head: ventricles, dural sinuses, veins, arteries and choroid plexus, each as a chain of capsules."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapery_segmentation.phantoms import _anatomy_kernels as kernels

FloatArray = NDArray[np.float64]


def on_wall(direction: ArrayLike, depth: float) -> FloatArray:
    """Return the point in a direction from the middle of the brain that lies `depth` mm inside the skull."""
    d = np.asarray(direction, dtype=np.float64)
    d = d / np.linalg.norm(d)
    low, high = 0.0, 130.0
    for _ in range(40):
        middle = (low + high) / 2
        if kernels.cavity(*(middle * d)) < -depth:
            low = middle
        else:
            high = middle
    return np.asarray(low * d)


def chain(points: ArrayLike, radii: ArrayLike) -> FloatArray:
    """Return capsules (n − 1, 8) along points, with the radius at each."""
    p = np.asarray(points, dtype=np.float64)
    r = np.broadcast_to(np.asarray(radii, dtype=np.float64), len(p))
    return np.hstack((p[:-1], p[1:], r[:-1, None], r[1:, None]))


def mirrored(segments: FloatArray, scale: float = 1.0) -> FloatArray:
    """Return the same capsules in the left half of the head, with radii times `scale`."""
    return np.asarray(segments * np.array([-1.0, 1.0, 1.0, -1.0, 1.0, 1.0, scale, scale]))


def jittered(points: FloatArray, rng: np.random.Generator, amount: float) -> FloatArray:
    """Return points moved at random by about `amount` mm."""
    return np.asarray(points + rng.normal(0.0, amount, points.shape))


def ventricles(rng: np.random.Generator) -> FloatArray:
    """Return the lateral ventricles with their horns, the third and the fourth."""
    size = rng.uniform(0.8, 1.25)
    path = np.array([[7, 34, 6], [9, 22, 13], [10, 4, 17], [13, -16, 16], [20, -34, 8], [27, -30, -6], [31, -12, -15]])
    radii = size * np.array([4.0, 5.0, 5.0, 5.0, 6.5, 4.0, 2.0])
    right, left = (chain(jittered(path * 1.0, rng, 0.7), radii) for _ in range(2))
    horn = chain([[20, -36, 8], [21, -52, 7], [18, -60, 6]], size * np.array([5.0, 2.8, 1.0]))
    third = chain([[0, 12, 0], [0, -2, 1], [0, -16, 3]], [1.3, 2.0, 1.3])
    third_low = chain([[0, 10, -7], [0, -4, -6]], [1.2, 1.6])
    fourth = chain([[0, -22, -26], [0, -28, -36], [0, -30, -46]], [1.4, 4.2, 1.5])
    return np.concatenate((right, mirrored(left), horn, mirrored(horn, 0.9), third, third_low, fourth))


def plexus(rng: np.random.Generator) -> FloatArray:
    """Return the choroid plexus in the bodies, atria and temporal horns of the lateral ventricles."""
    path = np.array([[9, -4, 14], [13, -18, 14], [20, -33, 7], [26, -31, -4], [30, -16, -13]], dtype=np.float64)
    radii = np.array([0.9, 1.4, 3.0, 1.8, 0.9])
    sides = []
    for sign in (1.0, -1.0):
        segments = chain(jittered(path, rng, 0.8), radii * rng.uniform(0.75, 1.2))
        sides.append(segments if sign > 0 else mirrored(segments))
    return np.concatenate(sides)


def sinuses(rng: np.random.Generator) -> FloatArray:
    """Return the dural sinuses; one of the transverse ones is larger, as in most people."""
    angles = np.deg2rad(np.linspace(20, 195, 24))
    top = [on_wall((0.0, np.cos(a), np.sin(a)), 2.2 + 1.3 * n / 23) for n, a in enumerate(angles)]
    superior = chain(top, np.linspace(1.6, 4.2, 24))
    torcular = top[-1]
    around = np.deg2rad(np.linspace(-85, -17, 10))
    side = [torcular, *(on_wall((np.cos(a), np.sin(a), -0.42), 3.2) for a in around)]
    side += [on_wall((0.75, -0.30, -0.62), 3.0), on_wall((0.58, -0.26, -0.78), 2.5)]
    large, small = rng.uniform(3.6, 4.6), rng.uniform(1.8, 2.8)
    right, left = (large, small) if rng.random() < 0.7 else (small, large)
    junction = np.array([[0.0, -44.0, 10.0], [0.0, -60.0, 2.0]])
    straight = chain(np.concatenate((junction, torcular[None])), [1.6, 2.0, 2.4])
    inner = chain([[2.5, 8.0, 11.0], [2.5, -12.0, 11.0], [1.5, -32.0, 9.0], [0.0, -44.0, 10.0]], [0.8, 1.0, 1.3, 1.8])
    pituitary = chain([[-4, 16, -31], [4, 16, -31]], 3.5)
    cavernous = chain([[12, 20, -31], [13, 8, -31]], 3.0)
    parts: list[FloatArray] = [
        superior,
        chain(np.stack(side), right),
        mirrored(chain(np.stack(side), left)),
        straight,
        inner,
        mirrored(inner),
    ]
    return np.concatenate([*parts, pituitary, cavernous, mirrored(cavernous)])


def vessels(rng: np.random.Generator) -> FloatArray:
    """Return cortical veins, and the arteries at the base and over the callosal body."""
    parts = []
    for sign in (1.0, -1.0):
        for start in np.linspace(35, 150, 8) + rng.normal(0, 5, 8):
            a = np.deg2rad(start)
            lean = rng.normal(0, 0.15)
            points = []
            for t in np.linspace(0.04, rng.uniform(0.45, 0.95), 9):
                ring = np.array([sign * np.sin(t * 1.4), np.cos(a + lean * t), np.sin(a + lean * t)])
                ring[1:] *= np.cos(t * 1.4)
                points.append(on_wall(ring, 2.6) + rng.normal(0, 0.7, 3))
            parts.append(chain(points, np.linspace(rng.uniform(1.0, 1.7), 0.6, 9)))
    carotid = np.array([[12, 8, -30], [13, 12, -22], [22, 13, -18], [34, 10, -14], [42, 2, -8], [46, -8, 2]], float)
    anterior = np.array([[13, 12, -22], [3, 22, -20], [2, 42, -8], [2, 44, 14], [2, 26, 28], [2, 2, 30]], float)
    for sign in (1.0, -1.0):
        for path, radii in ((carotid, [1.9, 1.7, 1.5, 1.3, 1.1, 0.8]), (anterior, [1.3, 1.2, 1.1, 1.0, 0.9, 0.7])):
            segments = chain(jittered(path, rng, 0.8), radii)
            parts.append(segments if sign > 0 else mirrored(segments))
    parts.append(chain([[0, 2, -26], [1, 4, -40], [-1, 0, -56], [4, -4, -70]], [1.5, 1.6, 1.5, 1.4]))
    return np.concatenate(parts)
