"""A head with a known tumor: the volumes before and after contrast, and the truth.

Anatomy is drawn from formulas and random fields, not from any scan, so it may be passed on freely.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shapery_geometry.volume import Volume
from shapery_segmentation.phantoms import _anatomy_kernels as kernels
from shapery_segmentation.phantoms import anatomy

FloatArray = NDArray[np.float64]
Site = Literal["deep", "surface", "midline"]

NOISE_GRID, NOISE_STEP = 64, 3.0
"""The random fields: so many points along each axis, every 3 mm; the head is smaller than their 192 mm."""

FINEST = 1.25
"""mm: voxels longer than this and than their shortest edge are painted in layers and averaged, as a scanner does."""

ENHANCING, CORE = 1, 2
"""Labels of the truth: rim, and what it encloses; the same as in the service's results."""

# Relative intensities of T1-weighted images before contrast, and what contrast agent adds to them.
_TISSUES = {
    kernels.AIR: (0.0, 0.0),
    kernels.SKIN: (0.75, 0.12),
    kernels.FAT: (1.55, 0.0),
    kernels.MUSCLE: (0.62, 0.08),
    kernels.BONE: (0.12, 0.0),
    kernels.MARROW: (0.70, 0.03),
    kernels.DURA: (0.40, 0.40),
    kernels.FLUID: (0.27, 0.0),
    kernels.GREY: (0.76, 0.03),
    kernels.WHITE: (1.0, 0.015),
    kernels.DEEP_GREY: (0.86, 0.03),
    kernels.BLOOD: (0.42, 0.95),
    kernels.PLEXUS: (0.55, 0.60),
    kernels.MUCOSA: (0.70, 0.70),
    kernels.RIM: (0.72, 0.75),
    kernels.NECROSIS: (0.48, 0.02),
    kernels.EDEMA: (0.76, 0.0),
}


@dataclass(frozen=True, slots=True)
class TumorSpec:
    """One tumor to be drawn.

    Parameters
    ----------
    radius
        Mean radius in mm.
    site
        ``"deep"`` in the white matter, ``"surface"`` grown against the dura, ``"midline"`` across the middle plane.
    rim
        Mean thickness of the enhancing rim in mm; a third of it more or less from place to place.
    enhancement
        Uptake of the rim, relative to the usual.
    edema
        Reach of the edema in mm.
    """

    radius: float = 16.0
    site: Site = "deep"
    rim: float = 4.5
    enhancement: float = 1.0
    edema: float = 10.0


@dataclass(frozen=True, eq=False)
class DrawnTumor:
    """Where a tumor of the truth lies, RAS mm and mm³."""

    center: tuple[float, float, float]
    enhancing_mm3: float
    core_mm3: float


@dataclass(frozen=True, eq=False)
class HeadPhantom:
    """A head.

    Parameters
    ----------
    pre, post
        int16, before and after contrast, on one grid.
    truth
        uint8 on the same grid: 1 rim, 2 necrotic core.
    tumors
        What is in the truth.
    """

    pre: Volume
    post: Volume
    truth: Volume
    tumors: tuple[DrawnTumor, ...] = field(default=())


def head_phantom(
    rng: np.random.Generator,
    shape: tuple[int, int, int] = (160, 192, 160),
    spacing: tuple[float, float, float] = (1.0, 1.0, 1.0),
    *,
    tumors: Sequence[TumorSpec] = (TumorSpec(),),
    rotation: tuple[float, float, float] = (0.0, 0.0, 0.0),
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0),
    axes: FloatArray | None = None,
    noise: float = 0.025,
    bias: float = 0.15,
    stripped: bool = False,
) -> HeadPhantom:
    """Draw a head.

    Parameters
    ----------
    rng
        Source of everything random: anatomy, tumors, intensities, bias and noise.
    shape, spacing
        Of the volumes; spacing in mm. The field of view of 160 × 192 × 160 mm just holds the head.
    tumors
        None for a healthy head.
    rotation, shift
        How the head lies in the scanner: degrees about x, y and z, and mm.
    axes : (3, 3) float64, optional
        Columns: directions of the array's axes in RAS, orthonormal; an oblique or reordered grid.
    noise
        Standard deviation of the noise relative to white matter; Rician, as of magnitudes.
    bias
        Deviation of the smooth fields that brighten parts of either volume, relative.
    stripped
        Set everything outside the brain to 0, as after skull stripping.

    Notes
    -----
    The scales of the two volumes are unrelated, and so are their bias fields and the contrast between their tissues.
    """
    directions = np.eye(3) if axes is None else np.asarray(axes, dtype=np.float64)
    affine = np.eye(4)
    affine[:3, :3] = directions * np.asarray(spacing)
    affine[:3, 3] = -affine[:3, :3] @ ((np.array(shape) - 1) / 2)
    finest = max(FINEST, min(spacing))
    layers = np.array([max(1, int(np.ceil(s / finest - 1e-6))) for s in spacing])
    fine = affine.copy()
    fine[:3, :3] = affine[:3, :3] / layers
    fine[:3, 3] = affine[:3, 3] - fine[:3, :3] @ ((layers - 1) / 2)
    turn = _rotation(rotation)
    to_head = np.hstack((turn.T @ fine[:3, :3], (turn.T @ (fine[:3, 3] - shift))[:, None]))

    fields = _random_fields(rng)
    table = _intensities(rng)
    width = float(np.prod(np.asarray(spacing) / layers) ** (1 / 3))
    grid = tuple(int(n) for n in np.array(shape) * layers)
    image = np.empty((*grid, 2), dtype=np.float32)
    kernels.paint(to_head, width, fields, NOISE_STEP, table, 0.03, image)
    _tubes(image, to_head, width, table, rng)
    parts, lobes = _tumors(image, to_head, width, fields, table, tumors, rng)

    image, parts = _averaged(image, layers), _averaged(parts, layers)
    truth = np.zeros(shape, dtype=np.uint8)
    for n in range(len(tumors)):
        whole = parts[..., 2 * n] + parts[..., 2 * n + 1]
        truth[whole >= 0.5] = ENHANCING
        truth[(whole >= 0.5) & (parts[..., 2 * n + 1] > parts[..., 2 * n])] = CORE
    drawn = _drawn(parts, lobes, affine, turn, np.asarray(shift))

    inside = _brain_voxels(affine, shape, turn, np.asarray(shift)) if stripped else None
    volumes = []
    for n in range(2):
        values = image[..., n] * _bias_field(shape, affine, rng, bias)
        sigma = noise * table[kernels.WHITE, n]
        real = rng.standard_normal(shape, dtype=np.float32) * np.float32(sigma)
        imaginary = rng.standard_normal(shape, dtype=np.float32) * np.float32(sigma)
        values = np.hypot(values + real, imaginary)
        # From scanner to scanner the same tissue has a few hundred units, or several thousand.
        scale = np.float32(np.exp(rng.uniform(np.log(150), np.log(4000))))
        data = np.clip(np.rint(values * scale), 0, 32767).astype(np.int16)
        if inside is not None:
            data = np.where(inside, np.maximum(data, 1), 0).astype(np.int16)
        volumes.append(Volume(data, affine))
    return HeadPhantom(volumes[0], volumes[1], Volume(truth, affine), drawn)


def _rotation(degrees: tuple[float, float, float]) -> FloatArray:
    a, b, c = np.deg2rad(degrees)
    x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return np.asarray(z @ y @ x)


def _random_fields(rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the fields that fold, warp and texture the head; the first two are mostly alike in both halves."""
    scales = {kernels.FOLDS: 0.9, kernels.WARP: 4.0, kernels.TEXTURE: 0.8, kernels.LOBES: 1.7, kernels.THICKNESS: 2.0}
    fields = np.empty((len(scales), NOISE_GRID, NOISE_GRID, NOISE_GRID), dtype=np.float32)
    for row, sigma in scales.items():
        values = ndimage.gaussian_filter(rng.normal(size=(NOISE_GRID,) * 3), sigma, mode="wrap")
        if row in (kernels.FOLDS, kernels.WARP):
            # Index n/2 is the middle plane; the mirror image of i is n − i.
            values = 0.85 * (values + np.roll(values[::-1], 1, axis=0)) + 0.35 * values
        fields[row] = values / values.std()
    return fields


def _intensities(rng: np.random.Generator) -> FloatArray:
    """Return the intensity (tissues, 2) of each tissue before and after contrast, a little different in each head."""
    table = np.zeros((kernels.TISSUES, 2))
    gamma = rng.uniform(0.85, 1.1)
    for tissue, (before, uptake) in _TISSUES.items():
        base = before * (1.0 + rng.normal(0.0, 0.02))
        # Another sequence after contrast: other contrast between the same tissues.
        table[tissue] = base, base**gamma + uptake * rng.uniform(0.9, 1.1)
    return table


def _tubes(
    image: NDArray[np.float32], to_head: FloatArray, width: float, table: FloatArray, rng: np.random.Generator
) -> None:
    linear = np.linalg.inv(to_head[:, :3])
    inverse = np.ascontiguousarray(np.hstack((linear, -(linear @ to_head[:, 3])[:, None])))
    limits = np.abs(linear).sum(axis=1)
    for segments, tissue in (
        (anatomy.ventricles(rng), kernels.FLUID),
        (anatomy.plexus(rng), kernels.PLEXUS),
        (anatomy.sinuses(rng), kernels.BLOOD),
        (anatomy.vessels(rng), kernels.BLOOD),
    ):
        best = np.full(image.shape[:3], kernels.FAR, dtype=np.float32)
        kernels.tubes(np.ascontiguousarray(segments), inverse, to_head, limits, best)
        kernels.blend(best, width, tissue, table, image)


def _tumors(
    image: NDArray[np.float32],
    to_head: FloatArray,
    width: float,
    fields: NDArray[np.float32],
    table: FloatArray,
    tumors: Sequence[TumorSpec],
    rng: np.random.Generator,
) -> tuple[NDArray[np.float32], list[FloatArray]]:
    """Paint the tumors; returns shares (…, 2n) of rim and core per tumor, and the lobes of each."""
    parts = np.zeros((*image.shape[:3], 2 * len(tumors)), dtype=np.float32)
    placed: list[FloatArray] = []
    for n, spec in enumerate(tumors):
        lobes = _place(spec, placed, rng)
        placed.append(lobes)
        own = table.copy()
        own[kernels.RIM, 1] = own[kernels.RIM, 0] + spec.enhancement * (own[kernels.RIM, 1] - own[kernels.RIM, 0])
        figures = np.array([0.0, spec.rim, spec.edema, min(1.8, 0.12 * spec.radius)])
        shares = np.zeros((*image.shape[:3], 2), dtype=np.float32)
        kernels.tumor(lobes, figures, to_head, width, fields, NOISE_STEP, own, image, shares)
        parts[..., 2 * n : 2 * n + 2] = shares
    return parts, placed


def _place(spec: TumorSpec, placed: list[FloatArray], rng: np.random.Generator) -> FloatArray:
    """Return the lobes (n, 4) of a tumor at its site, clear of the others."""
    for _ in range(500):
        side = rng.choice((-1.0, 1.0))
        if spec.site == "midline":
            center = np.array([rng.uniform(-0.25, 0.25) * spec.radius, rng.uniform(10, 45), rng.uniform(16, 30)])
        else:
            direction = np.array([side * rng.uniform(0.5, 1.0), rng.uniform(-0.9, 0.9), rng.uniform(-0.15, 0.8)])
            if spec.site == "surface":
                center = anatomy.on_wall(direction, 0.75 * spec.radius)
            else:
                wall = float(np.linalg.norm(anatomy.on_wall(direction, 0.0)))
                low, high = max(0.4 * wall, 8.0 + 0.7 * spec.radius), wall - spec.radius - 5.0
                if high <= low:
                    continue
                center = direction / np.linalg.norm(direction) * rng.uniform(low, high)
        if all(np.linalg.norm(center - o[0, :3]) > 1.6 * (spec.radius + o[0, 3]) + 6.0 for o in placed):
            break
    else:
        raise ValueError(f"no room was found for a tumor of {spec.radius:g} mm at the site {spec.site!r}")
    count = int(rng.integers(2, 5))
    lobes = [[*center, 0.85 * spec.radius]]
    for _ in range(count):
        away = rng.normal(size=3)
        offset = 0.55 * spec.radius * away / np.linalg.norm(away)
        lobes.append([*(center + offset), spec.radius * rng.uniform(0.45, 0.7)])
    return np.array(lobes)


def _averaged(values: NDArray[np.float32], layers: NDArray[np.int_]) -> NDArray[np.float32]:
    if layers.max() == 1:
        return values
    a, b, c = (n // m for n, m in zip(values.shape[:3], layers, strict=True))
    blocks = values.reshape(a, layers[0], b, layers[1], c, layers[2], values.shape[3])
    return np.asarray(blocks.mean(axis=(1, 3, 5), dtype=np.float32))


def _drawn(
    parts: NDArray[np.float32], lobes: list[FloatArray], affine: FloatArray, turn: FloatArray, shift: FloatArray
) -> tuple[DrawnTumor, ...]:
    voxel = float(abs(np.linalg.det(affine[:3, :3])))
    drawn = []
    for n, own in enumerate(lobes):
        center = turn @ own[0, :3] + shift
        rim, core = (float(parts[..., 2 * n + m].sum(dtype=np.float64)) * voxel for m in range(2))
        drawn.append(DrawnTumor((float(center[0]), float(center[1]), float(center[2])), rim, rim + core))
    return tuple(drawn)


def _bias_field(
    shape: tuple[int, int, int], affine: FloatArray, rng: np.random.Generator, amount: float
) -> NDArray[np.float32]:
    """Return a smooth positive field around 1: a random polynomial of second order over the field of view."""
    c = (rng.normal(0.0, 1.0, 9) * amount).astype(np.float32)
    c[3:] *= 0.7
    extent = np.abs(affine[:3, :3]) @ np.array(shape) / 2
    u, v, w = (
        sum(
            (affine[axis, k] * np.arange(shape[k], dtype=np.float32)).reshape([-1 if m == k else 1 for m in range(3)])
            for k in range(3)
        )
        + np.float32(affine[axis, 3])
        for axis in range(3)
    )
    u, v, w = u / np.float32(extent[0]), v / np.float32(extent[1]), w / np.float32(extent[2])
    field = u * (c[0] + c[3] * v + c[6] * u) + v * (c[1] + c[4] * w + c[7] * v) + w * (c[2] + c[5] * u + c[8] * w)
    return np.asarray(np.exp(field), dtype=np.float32)


def _brain_voxels(
    affine: FloatArray, shape: tuple[int, int, int], turn: FloatArray, shift: FloatArray
) -> NDArray[np.bool_]:
    to_head = np.ascontiguousarray(np.hstack((turn.T @ affine[:3, :3], (turn.T @ (affine[:3, 3] - shift))[:, None])))
    inside = np.zeros(shape, dtype=np.bool_)
    kernels.within_cavity(to_head, 1.8, inside)
    return inside
