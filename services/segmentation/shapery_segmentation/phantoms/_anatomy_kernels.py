"""Loops of `shapery_segmentation.phantoms.head`: signed distances of a head's parts, and their composition.

Distances are in mm and negative inside. Points are in the head's own frame: RAS, the origin in the middle of the brain.
A surface crosses a voxel softly over the width of a voxel, which is its partial volume.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]

FAR = 1e3

# Tissues: rows of the table of intensities.
AIR, SKIN, FAT, MUSCLE, BONE, MARROW, DURA, FLUID, GREY, WHITE, DEEP_GREY = range(11)
BLOOD, PLEXUS, MUCOSA, RIM, NECROSIS, EDEMA = range(11, 17)
TISSUES = 17

# Rows of `noise`: smooth random fields of standard deviation 1.
FOLDS, WARP, TEXTURE, LOBES, THICKNESS = range(5)

# Columns of a tumor.
T_LOBES, T_RIM, T_EDEMA, T_ROUGH = range(4)


@njit(cache=True, nogil=True)
def ellipsoid(x: float, y: float, z: float, a: float, b: float, c: float) -> float:
    """Return nearly the signed distance from an ellipsoid about the origin; exact on its surface."""
    k0 = np.sqrt((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2)
    k1 = np.sqrt((x / (a * a)) ** 2 + (y / (b * b)) ** 2 + (z / (c * c)) ** 2)
    if k1 < 1e-9:
        return -min(a, b, c)
    return float(k0 * (k0 - 1.0) / k1)


@njit(cache=True, nogil=True)
def smooth_min(a: float, b: float, k: float) -> float:
    """Return the lesser of two distances, rounded over `k` mm where they are alike."""
    h = min(max(0.5 + 0.5 * (b - a) / k, 0.0), 1.0)
    return float(b + (a - b) * h - k * h * (1.0 - h))


@njit(cache=True, nogil=True)
def capsule(x: float, y: float, z: float, s: Array) -> float:
    """Return the distance from a segment whose radius changes linearly; `s`: two ends and their radii (8,)."""
    dx, dy, dz = s[3] - s[0], s[4] - s[1], s[5] - s[2]
    length = dx * dx + dy * dy + dz * dz
    t = 0.0
    if length > 0.0:
        t = min(max(((x - s[0]) * dx + (y - s[1]) * dy + (z - s[2]) * dz) / length, 0.0), 1.0)
    distance = np.sqrt((x - s[0] - t * dx) ** 2 + (y - s[1] - t * dy) ** 2 + (z - s[2] - t * dz) ** 2)
    return float(distance - (s[6] + t * (s[7] - s[6])))


@njit(cache=True, nogil=True)
def share(distance: float, width: float) -> float:
    """Return how much of a voxel of `width` lies inside a surface at `distance` from its centre."""
    return float(min(max(0.5 - distance / width, 0.0), 1.0))


@njit(cache=True, nogil=True)
def lookup(noise: Array, row: int, step: float, x: float, y: float, z: float) -> float:
    """Return a random field at a point: trilinear on a grid of `step` mm centred on the origin, repeated outside."""
    n = noise.shape[1]
    u, v, w = x / step + 0.5 * n, y / step + 0.5 * n, z / step + 0.5 * n
    i, j, k = int(np.floor(u)), int(np.floor(v)), int(np.floor(w))
    fu, fv, fw = u - i, v - j, w - k
    total = 0.0
    for a in range(2):
        wa = fu if a == 1 else 1.0 - fu
        for b in range(2):
            wb = fv if b == 1 else 1.0 - fv
            for c in range(2):
                wc = fw if c == 1 else 1.0 - fw
                total += wa * wb * wc * noise[row, (i + a) % n, (j + b) % n, (k + c) % n]
    return float(total)


@njit(cache=True, nogil=True)
def cavity(x: float, y: float, z: float) -> float:
    """Return the distance from the inside of the skull: a flattened vault and the fossa of the cerebellum."""
    vault = ellipsoid(x, y, z - 4.0, 61.0, 77.0, 57.0)
    floor = -(z + 30.0 + 0.0025 * (y - 10.0) * (y - 10.0) - 14.0 * np.exp(-((y - 20.0) ** 2) / 700.0))
    # Rounded where the base meets the vault.
    vault = -smooth_min(-vault, -floor, 14.0)
    fossa = ellipsoid(x, y + 38.0, z + 34.0, 48.0, 36.0, 32.0)
    return float(smooth_min(vault, fossa, 8.0))


@njit(cache=True, nogil=True)
def outer_head(x: float, y: float, z: float) -> float:
    """Return the distance from the skin: cranium, face and neck."""
    cranium = ellipsoid(x, y, z - 2.0, 73.5, 90.0, 71.0)
    face = ellipsoid(x, y - 36.0, z + 56.0, 50.0, 48.0, 66.0)
    neck = np.sqrt(x * x + (y + 22.0) ** 2) - 50.0 if z < -30.0 else FAR
    if z < -30.0:
        neck = max(neck, z + 30.0)
    return float(smooth_min(smooth_min(cranium, face, 18.0), neck, 14.0))


@njit(cache=True, nogil=True)
def mix(values: Array, tissue: int, part: float, table: Array) -> None:
    """Replace the share `part` of a voxel by a tissue."""
    for n in range(values.shape[0]):
        values[n] += part * (table[tissue, n] - values[n])


@njit(cache=True, nogil=True)
def outside_brain(x: float, y: float, z: float, wall: float, h: float, noise: Array, step: float, table: Array,
                  values: Array) -> None:  # fmt: skip
    """Compose what lies outside the skull's inner table: air, skin, fat, muscle, bone, eyes and nose."""
    warp = lookup(noise, WARP, step, x, y, z)
    skin = outer_head(x, y, z) + 0.8 * warp
    mix(values, SKIN, share(skin, h), table)
    mix(values, FAT, share(skin + 1.8, h), table)
    soft = lookup(noise, TEXTURE, step, 0.6 * x, 0.6 * y, 0.6 * z)
    mix(values, MUSCLE, share(skin + 5.0 + 1.0 * soft, h), table)
    below = share(z + 30.0 - 0.25 * y, 20.0)
    mix(values, FAT, 0.7 * below * share(1.0 - soft, 0.6) * share(skin + 6.0, h), table)
    # Nose and sinuses of the face: air lined with mucosa.
    nose = ellipsoid(abs(x) - 9.0, y - 56.0, z + 62.0, 7.0, 26.0, 16.0) + 1.5 * soft
    mix(values, MUCOSA, share(nose - 3.0, h), table)
    mix(values, AIR, share(nose, h), table)
    eye = np.sqrt((abs(x) - 30.0) ** 2 + (y - 66.0) ** 2 + (z + 32.0) ** 2)
    mix(values, FAT, share(eye - 17.0, h) * share(skin + 2.0, h), table)
    mix(values, FLUID, share(eye - 11.5, h), table)
    # Bone last: the inner and outer tables with marrow between.
    thick = 5.5 + 1.0 * warp
    mix(values, BONE, share(wall - thick, h), table)
    mix(values, MARROW, share(abs(wall - 0.5 * thick) - (0.13 + 0.06 * soft) * thick, h), table)


@njit(cache=True, nogil=True)
def cerebrum(x: float, y: float, z: float, deep: float, h: float, noise: Array, step: float, table: Array,
             values: Array) -> None:  # fmt: skip
    """Compose the folded cortex, the white matter and the deep nuclei at a depth of `deep` mm below the pia."""
    warp = lookup(noise, WARP, step, x, y, z)
    # Folds run along the zero set of a random field; its gradient is about 0.4 per mm.
    fold = 2.4 * abs(lookup(noise, FOLDS, step, x, y, z))
    bottom = 17.0 + 5.0 * warp
    # Between the hemispheres down to the callosal body, and the lateral fissure.
    callosum = ellipsoid(0.0, y - 2.0, z - 6.0, 1.0, 38.0, 17.0) if abs(x) < 60.0 else FAR
    between = max(abs(x + 1.2 * warp), -callosum)
    lateral = max(abs(z + 10.0 - 0.22 * y + 3.0 * warp), 30.0 - abs(x), deep - 22.0)
    cleft = min(max(fold, deep - bottom), between, lateral)
    grey = min(deep - 3.0, cleft - 3.4)
    mix(values, WHITE, 1.0, table)
    for n in range(4):
        if n == 0:
            nucleus = ellipsoid(abs(x) - 10.5, y + 12.0, z - 2.0, 7.5, 13.0, 7.5)
        elif n == 1:
            nucleus = ellipsoid(abs(x) - 24.0, y - 4.0, z - 1.0, 5.5, 16.0, 9.0)
        elif n == 2:
            nucleus = ellipsoid(abs(x) - 12.5, y - 17.0, z - 9.0, 3.8, 10.0, 6.0)
        else:
            nucleus = ellipsoid(abs(x) - 26.0, y + 2.0, z + 20.0, 5.0, 12.0, 5.0)
        mix(values, DEEP_GREY, share(nucleus + 0.8 * warp, 1.5 * h), table)
    mix(values, GREY, share(grey, h), table)
    mix(values, FLUID, share(min(cleft - 0.75, deep), h), table)


@njit(cache=True, nogil=True)
def cerebellum(x: float, y: float, z: float, deep: float, h: float, noise: Array, step: float, table: Array,
               values: Array) -> None:  # fmt: skip
    """Compose the cerebellum (thin leaves of grey matter around white) and the brain stem."""
    warp = lookup(noise, WARP, step, x, y, z)
    radius = np.sqrt(x * x * 0.6 + (y + 38.0) ** 2 + (z + 34.0) ** 2)
    leaf = np.sin(1.9 * radius + 2.0 * warp + 0.25 * abs(x))
    mix(values, GREY, 1.0, table)
    mix(values, WHITE, 0.45 * share(-leaf, 1.2), table)
    half = ellipsoid(abs(x) - 17.0, y + 36.0, z + 34.0, 14.0, 15.0, 9.0)
    core = min(half, ellipsoid(x, y + 30.0, z + 33.0, 8.0, 10.0, 8.0))
    mix(values, WHITE, share(core + 1.5 * warp, 2.0 * h), table)
    # The notch behind, between the two halves.
    notch = max(abs(x) - 1.2, y + 60.0)
    mix(values, FLUID, share(min(deep, notch), h), table)


@njit(cache=True, nogil=True)
def brain_stem(x: float, y: float, z: float) -> float:
    """Return the distance from midbrain, pons and medulla."""
    middle = -10.0 + 0.32 * (z + 15.0)
    d = np.sqrt(x * x + (y - middle) ** 2) - 11.5
    pons = ellipsoid(x, y - middle - 3.0, z + 36.0, 15.0, 13.0, 13.0)
    return float(max(smooth_min(d, pons, 4.0), z + 8.0))


@njit(cache=True, nogil=True)
def paint(affine: Array, h: float, noise: Array, step: float, table: Array, texture: float, out: Array) -> None:
    """Write the intensities of a head without vessels, ventricles and tumors.

    Parameters
    ----------
    affine : (3, 4) float64
        From voxel index to the head's frame.
    h : float
        Width of a voxel in mm.
    noise : (5, n, n, n) float32
    step : float
        Grid of `noise` in mm.
    table : (TISSUES, 2) float64
        Intensity of each tissue before and after contrast.
    texture : float
        Standard deviation of the variation within tissues, relative.
    out : (I, J, K, 2) float32
        Written.
    """
    values = np.zeros(2)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            for k in range(out.shape[2]):
                x = affine[0, 0] * i + affine[0, 1] * j + affine[0, 2] * k + affine[0, 3]
                y = affine[1, 0] * i + affine[1, 1] * j + affine[1, 2] * k + affine[1, 3]
                z = affine[2, 0] * i + affine[2, 1] * j + affine[2, 2] * k + affine[2, 3]
                values[0] = table[AIR, 0]
                values[1] = table[AIR, 1]
                if outer_head(x, y, z) > 4.0 + h:
                    out[i, j, k, 0] = values[0]
                    out[i, j, k, 1] = values[1]
                    continue
                wall = cavity(x, y, z)
                if wall > -h:
                    outside_brain(x, y, z, wall, h, noise, step, table, values)
                if wall < h:
                    inside = share(wall, h)
                    mix(values, DURA, inside, table)
                    mix(values, FLUID, share(wall + 1.0, h), table)
                    gap = 2.4 + 0.7 * lookup(noise, WARP, step, 0.5 * x, 0.5 * y, 0.5 * z)
                    deep = -wall - gap
                    if deep > -h:
                        before, after = values[0], values[1]
                        tent = z + 24.0 + 0.30 * (y + 30.0) - 0.004 * x * x
                        stem = brain_stem(x, y, z)
                        behind = y + 4.0 - 0.3 * z
                        if stem < h:
                            mix(values, WHITE, 1.0, table)
                            if z < -14.0 and (y > -10.0 + 0.32 * (z + 15.0) or z < -48.0):
                                mix(values, FLUID, 1.0 - share(stem, h), table)
                        elif stem < 3.0 and z < -14.0:
                            # Cisterns before and below; behind are the peduncles of the cerebellum.
                            free = y > -10.0 + 0.32 * (z + 15.0) or z < -48.0
                            mix(values, FLUID if free else WHITE, 1.0, table)
                        elif tent < 0.0 and behind < 0.0:
                            cerebellum(x, y, z, min(deep, -tent - 1.2), h, noise, step, table, values)
                        elif behind < 0.0 or z > -44.0:
                            under = deep if behind > 0.0 else min(deep, tent - 1.0)
                            cerebrum(x, y, z, under, h, noise, step, table, values)
                            mix(values, FLUID, share(under, h), table)
                        inner = share(-deep, h)
                        values[0] = before + inner * (values[0] - before)
                        values[1] = after + inner * (values[1] - after)
                grain = 1.0 + texture * lookup(noise, TEXTURE, step, 1.7 * x, 1.7 * y, 1.7 * z)
                out[i, j, k, 0] = values[0] * grain
                out[i, j, k, 1] = values[1] * grain


@njit(cache=True, nogil=True)
def tubes(segments: Array, inverse: Array, affine: Array, limits: Array, best: Array) -> None:
    """Lower `best` to the distance from a set of capsules.

    Parameters
    ----------
    segments : (n, 8) float64
        Two ends and their radii, in the head's frame.
    inverse, affine : (3, 4) float64
        From the head's frame to voxel index, and back.
    limits : (3,) float64
        Voxels per mm along each axis, at the most: how far around a segment to look.
    best : (I, J, K) float32
    """
    shape = best.shape
    for n in range(segments.shape[0]):
        s = segments[n]
        reach = max(s[6], s[7]) + 2.0
        low, high = np.zeros(3, np.int64), np.zeros(3, np.int64)
        for axis in range(3):
            a = inverse[axis, 0] * s[0] + inverse[axis, 1] * s[1] + inverse[axis, 2] * s[2] + inverse[axis, 3]
            b = inverse[axis, 0] * s[3] + inverse[axis, 1] * s[4] + inverse[axis, 2] * s[5] + inverse[axis, 3]
            low[axis] = max(int(np.floor(min(a, b) - reach * limits[axis])), 0)
            high[axis] = min(int(np.ceil(max(a, b) + reach * limits[axis])) + 1, shape[axis])
        for i in range(low[0], high[0]):
            for j in range(low[1], high[1]):
                for k in range(low[2], high[2]):
                    x = affine[0, 0] * i + affine[0, 1] * j + affine[0, 2] * k + affine[0, 3]
                    y = affine[1, 0] * i + affine[1, 1] * j + affine[1, 2] * k + affine[1, 3]
                    z = affine[2, 0] * i + affine[2, 1] * j + affine[2, 2] * k + affine[2, 3]
                    d = capsule(x, y, z, s)
                    if d < best[i, j, k]:
                        best[i, j, k] = d


@njit(cache=True, nogil=True)
def blend(best: Array, h: float, tissue: int, table: Array, out: Array) -> None:
    """Replace by a tissue what lies inside `best`, softly over a voxel."""
    for i in range(best.shape[0]):
        for j in range(best.shape[1]):
            for k in range(best.shape[2]):
                part = share(best[i, j, k], h)
                if part > 0.0:
                    for n in range(2):
                        out[i, j, k, n] += part * (table[tissue, n] - out[i, j, k, n])


@njit(cache=True, nogil=True)
def tumor_distance(x: float, y: float, z: float, lobes: Array, shape: Array, noise: Array, step: float) -> float:
    """Return the distance from a tumor's surface: lobes (n, 4) melted together, roughened, and cut by the skull."""
    d = FAR
    for n in range(lobes.shape[0]):
        r = np.sqrt((x - lobes[n, 0]) ** 2 + (y - lobes[n, 1]) ** 2 + (z - lobes[n, 2]) ** 2)
        d = smooth_min(d, r - lobes[n, 3], 5.0) if n > 0 else r - lobes[n, 3]
    d += shape[T_ROUGH] * lookup(noise, LOBES, step, x, y, z)
    return float(max(d, cavity(x, y, z) + 1.2))


@njit(cache=True, nogil=True)
def tumor(lobes: Array, shape: Array, affine: Array, h: float, noise: Array, step: float, table: Array, out: Array,
          parts: Array) -> None:  # fmt: skip
    """Paint one tumor with its rim, its necrosis and the edema around it.

    Parameters
    ----------
    lobes : (n, 4) float64
        Centres and radii in the head's frame.
    shape : (4,) float64
        Columns ``T_…``: unused, mean thickness of the rim, reach of the edema, roughness; all in mm.
    parts : (I, J, K, 2) float32
        Raised to the share of each voxel that is rim, and that is necrosis.
    """
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            for k in range(out.shape[2]):
                x = affine[0, 0] * i + affine[0, 1] * j + affine[0, 2] * k + affine[0, 3]
                y = affine[1, 0] * i + affine[1, 1] * j + affine[1, 2] * k + affine[1, 3]
                z = affine[2, 0] * i + affine[2, 1] * j + affine[2, 2] * k + affine[2, 3]
                reach = shape[T_EDEMA] + 12.0
                near = False
                for n in range(lobes.shape[0]):
                    r = (x - lobes[n, 0]) ** 2 + (y - lobes[n, 1]) ** 2 + (z - lobes[n, 2]) ** 2
                    if r < (lobes[n, 3] + reach) ** 2:
                        near = True
                if not near:
                    continue
                d = tumor_distance(x, y, z, lobes, shape, noise, step)
                swollen = d - shape[T_EDEMA] * (1.0 + 0.5 * lookup(noise, WARP, step, x, y, z))
                white = table[WHITE, 0]
                # Edema follows white matter: grey matter and fluid stay as they are.
                if swollen < 3.0 and out[i, j, k, 0] > 0.86 * white and cavity(x, y, z) < -3.0:
                    part = share(swollen, 6.0)
                    for n in range(2):
                        out[i, j, k, n] += part * (table[EDEMA, n] - out[i, j, k, n])
                whole = share(d, h)
                if whole == 0.0:
                    continue
                thick = shape[T_RIM] * (1.0 + 0.45 * lookup(noise, THICKNESS, step, x, y, z))
                core = share(d + max(thick, 1.2), h)
                rim = whole - core
                uptake = 1.0 + 0.12 * lookup(noise, TEXTURE, step, x, y, z)
                for n in range(2):
                    enhanced = table[RIM, 0] + (table[RIM, n] - table[RIM, 0]) * uptake
                    out[i, j, k, n] = (1.0 - whole) * out[i, j, k, n] + rim * enhanced + core * table[NECROSIS, n]
                parts[i, j, k, 0] = parts[i, j, k, 0] * (1.0 - whole) + rim
                parts[i, j, k, 1] = parts[i, j, k, 1] * (1.0 - whole) + core


@njit(cache=True, nogil=True)
def within_cavity(affine: Array, depth: float, inside: Array) -> None:
    """Write where voxel centres lie more than `depth` mm inside the skull."""
    for i in range(inside.shape[0]):
        for j in range(inside.shape[1]):
            for k in range(inside.shape[2]):
                x = affine[0, 0] * i + affine[0, 1] * j + affine[0, 2] * k + affine[0, 3]
                y = affine[1, 0] * i + affine[1, 1] * j + affine[1, 2] * k + affine[1, 3]
                z = affine[2, 0] * i + affine[2, 1] * j + affine[2, 2] * k + affine[2, 3]
                inside[i, j, k] = cavity(x, y, z) < -depth
