"""Real heads as other scanners would have taken them: what thick slices, noise, coils and positions change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import mean

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial.transform import Rotation

from benchmarks.segmentation.cache import Cache
from benchmarks.segmentation.cases import Case
from benchmarks.segmentation.ours import agreement, is_false
from benchmarks.segmentation.tables import Row, shown, table
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume
from shapery_segmentation import segment

Scan = Callable[[Volume], Volume]


def as_taken(volume: Volume) -> Volume:
    """Leave a volume as it is."""
    return volume


def coarser(*factors: int) -> Scan:
    """Make voxels that are means of so many along each axis."""

    def scan(volume: Volume) -> Volume:
        counts = [n // f for n, f in zip(volume.shape, factors, strict=True)]
        data = volume.data[tuple(slice(n * f) for n, f in zip(counts, factors, strict=True))].astype(np.float32)
        for axis, (n, f) in enumerate(zip(counts, factors, strict=True)):
            data = data.reshape(*data.shape[:axis], n, f, *data.shape[axis + 1 :]).mean(axis=axis + 1)
        affine = volume.affine.copy()
        affine[:3, 3] += affine[:3, :3] @ ((np.array(factors) - 1) / 2)
        affine[:3, :3] *= factors
        return Volume(data, affine)

    return scan


def blurred(volume: Volume) -> Volume:
    """Lower the resolution to about 2.5 mm in voxels of 1 mm."""
    return volume.with_data(ndimage.gaussian_filter(volume.data.astype(np.float32), 1.0))


def noisier(share: float, seed: int) -> Scan:
    """Add Rician noise of a share of the median inside the head."""

    def scan(volume: Volume) -> Volume:
        head = volume.data > 0
        deviation = share * float(np.median(volume.data[head]))
        real, imaginary = np.random.default_rng(seed).normal(0.0, deviation, (2, *volume.shape))
        return volume.with_data(np.where(head, np.hypot(volume.data + real, imaginary), 0.0).astype(np.float32))

    return scan


def lit(x: float, y: float, z: float) -> Scan:
    """Let the brightness change through the head as the coil's sensitivity does, by factors of 1.6 to 1.8."""

    def scan(volume: Volume) -> Volume:
        i, j, k = np.meshgrid(
            *(np.linspace(-1, 1, n, dtype=np.float32) for n in volume.shape), indexing="ij", sparse=True
        )
        light: NDArray[np.float32] = np.exp(0.3 * (x * i + y * j + z * k * k))
        return volume.with_data((volume.data * light).astype(np.float32))

    return scan


def developed(power: float) -> Scan:
    """Let the intensities follow a power of what they were."""

    def scan(volume: Volume) -> Volume:
        data = np.maximum(volume.data, 0).astype(np.float32)
        return volume.with_data(data.max() * (data / data.max()) ** np.float32(power))

    return scan


def turned(degrees: tuple[float, float, float]) -> Scan:
    """Turn the head in its grid."""

    def scan(volume: Volume) -> Volume:
        turn = Rotation.from_euler("xyz", degrees, degrees=True).as_matrix()
        middle = (np.array(volume.shape) - 1) / 2
        data = ndimage.affine_transform(volume.data.astype(np.float32), turn, middle - turn @ middle, order=1)
        return volume.with_data(data)

    return scan


@dataclass(frozen=True)
class Variant:
    """How the volumes are taken, and where on the new grid the expert's labels lie."""

    post: Scan
    pre: Scan
    labels: Scan = as_taken


VARIANTS = {
    "as taken": Variant(as_taken, as_taken),
    "slices of 3 mm": Variant(coarser(1, 1, 3), coarser(1, 1, 3), coarser(1, 1, 3)),
    "voxels of 2 mm": Variant(coarser(2, 2, 2), coarser(2, 2, 2), coarser(2, 2, 2)),
    "blurred to 2.5 mm": Variant(blurred, blurred),
    "3 % more noise": Variant(noisier(0.03, 1), noisier(0.03, 2)),
    "8 % more noise": Variant(noisier(0.08, 1), noisier(0.08, 2)),
    "coils that differ": Variant(lit(0.5, 0.4, -0.3), lit(-0.3, 0.4, -0.3)),
    "after contrast, power 0.7": Variant(developed(0.7), as_taken),
    "after contrast, power 1.4": Variant(developed(1.4), as_taken),
    "before contrast turned by 10°": Variant(as_taken, turned((4.0, -6.0, 8.0))),
    "all turned by 17°": Variant(turned((8.0, -10.0, 12.0)), turned((8.0, -10.0, 12.0)), turned((8.0, -10.0, 12.0))),
}


def measure(case: Case, name: str) -> Row:
    """Return how a case is segmented as another scanner would have taken it."""
    variant = VARIANTS[name]
    assert case.pre is not None
    post, pre = variant.post(read_volume(case.post)), variant.pre(read_volume(case.pre))
    reference = read_volume(case.reference)

    def there(values: tuple[int, ...]) -> NDArray[np.bool_]:
        mask = reference.with_data(np.isin(reference.data, values).astype(np.float32))
        return np.asarray(variant.labels(mask).data > 0.5)

    found = segment(post, pre)
    labels, core = found.labels, there(case.core)
    return {
        "name": case.name,
        "weak": case.weak,
        "variant": name,
        "enhancing": agreement(labels.data == 1, there(case.enhancing), labels),
        "core": agreement(np.isin(labels.data, (1, 2)), core, labels),
        "false_objects": sum(is_false(item.centroid, item.volume_mm3, core, labels) for item in found.report.objects),
    }


def measured(cases: list[Case], cache: Cache, key: str) -> list[Row]:
    """Return what `section` shows."""
    rows = []
    for name in VARIANTS:
        for case in cases:
            if case.pre is not None:
                row = cache.get(f"variant {name} {case.name}", key, lambda c=case, n=name: measure(c, n))
                rows.append(row)
        print(f"{name}: {len(cases)} cases", flush=True)
    return rows


def section(rows: list[Row], least: float, visible: float) -> list[str]:
    """Return the lines of the page.

    Parameters
    ----------
    rows
        As `measured` returns them.
    least
        mm³ of enhancing tumor from which a case counts in the means.
    visible
        mm³ from which a tumor should be found.
    """
    lines = [
        "",
        "## As other scanners would have taken them",
        "",
        "The real cases with a volume before contrast, changed before they are segmented; the default setting. A tumor",
        f"of at least {visible:.0f} mm³ of which anything is overlapped is found.",
        "",
    ]
    cells = []
    for name in dict.fromkeys(row["variant"] for row in rows):
        of_variant = [row for row in rows if row["variant"] == name]
        counted = [row for row in of_variant if row["enhancing"]["reference_mm3"] >= least]
        clear = [row for row in counted if not row["weak"]]
        should = [row for row in of_variant if row["enhancing"]["reference_mm3"] >= visible]

        def over(chosen: list[Row], what: str) -> str:
            return shown(mean(float(row[what]["iou"]) for row in chosen)) if chosen else "–"

        cells.append(
            [
                name,
                over(clear, "enhancing"),
                over(counted, "enhancing"),
                over(clear, "core"),
                over(counted, "core"),
                over(should, "enhancing"),
                f"{sum(row['enhancing']['iou'] > 0 for row in should)} of {len(should)}",
                str(sum(row["false_objects"] for row in of_variant)),
            ]
        )
    head = (
        "variant", "IoU enh., clear", f"IoU enh., from {least / 1000:.0f} ml", "IoU core, clear", "IoU core",
        "IoU enh., all visible", "found", "false objects",
    )  # fmt: skip
    return [*lines, *table(head, cells)]
