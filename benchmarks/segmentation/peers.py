"""The usual untrained methods, each with a small grid of settings, run on one array from one seed.

    python -m benchmarks.segmentation.peers FOLDER NAME:NUMBER …

Reads ``FOLDER/input.npz`` (field, seed, allowed, spacing), runs the settings of these methods one after the other,
writes each mask as ``FOLDER/NAME-<number>.npy`` and prints one line of JSON for each. A process of its own, so that
the time of each can be limited and no memory of ours counts.

Every method gets one thread. What stands for its input in all of them: `field`, zero in normal tissue, in units of the
normal tissue's deviation; `seed`, voxels inside the object; `allowed`, where the object may be at all.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from benchmarks.segmentation.ours import forget_peak, peak_mib

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]
Setting = dict[str, Any]

LIMITS = (-6.0, 12.0)
"""The field is cut to these: far values stop or speed up a level set for nothing."""


def _itk() -> Any:
    import SimpleITK as sitk  # noqa: N813

    sitk.ProcessObject.SetGlobalDefaultNumberOfThreads(1)
    return sitk


def _image(array: NDArray[Any], spacing: float) -> Any:
    image = _itk().GetImageFromArray(np.ascontiguousarray(array))
    image.SetSpacing((spacing,) * 3)
    return image


def _inside_negative(seed: BoolArray, spacing: float) -> Any:
    """Return the signed distance to the seed, negative inside, as ITK's level sets begin with."""
    sitk = _itk()
    return sitk.Cast(
        sitk.SignedMaurerDistanceMap(
            _image(seed.astype(np.uint8), spacing), insideIsPositive=False, squaredDistance=False, useImageSpacing=True
        ),
        sitk.sitkFloat32,
    )


def _gated(field: FloatArray, allowed: BoolArray) -> FloatArray:
    """Return the field cut to its limits, and as dark as can be where the object may not be."""
    return np.where(allowed, np.clip(field, *LIMITS), np.float32(LIMITS[0])).astype(np.float32)


def _reached(mask: BoolArray, seed: BoolArray) -> BoolArray:
    """Return the parts of a mask, connected through faces, that the seed lies in."""
    labels, count = ndimage.label(mask)
    hit = np.zeros(count + 1, dtype=np.bool_)
    hit[labels[seed & mask]] = True
    hit[0] = False
    return np.asarray(hit[labels])


def threshold_level_set(field: FloatArray, seed: BoolArray, allowed: BoolArray, spacing: float, s: Setting) -> Any:
    """ITK's ThresholdSegmentationLevelSet: out where the intensity lies between two thresholds."""
    sitk = _itk()
    level_set = sitk.ThresholdSegmentationLevelSetImageFilter()
    level_set.SetLowerThreshold(s["lower"])
    level_set.SetUpperThreshold(1e3)
    level_set.SetPropagationScaling(1.0)
    level_set.SetCurvatureScaling(s["curvature"])
    level_set.SetMaximumRMSError(s["rms"])
    level_set.SetNumberOfIterations(s["iterations"])
    end = level_set.Execute(_inside_negative(seed, spacing), _image(_gated(field, allowed), spacing))
    return (sitk.GetArrayFromImage(end) < 0), level_set.GetElapsedIterations()


def geodesic_active_contour(field: FloatArray, seed: BoolArray, allowed: BoolArray, spacing: float, s: Setting) -> Any:
    """ITK's GeodesicActiveContourLevelSet on a sigmoid of the gradient."""
    sitk = _itk()
    image = _image(_gated(field, allowed), spacing)
    gradient = sitk.GradientMagnitudeRecursiveGaussian(image, s["sigma"])
    edge = sitk.Sigmoid(gradient, -s["edge"] / 4.0, s["edge"], 1.0, 0.0)
    contour = sitk.GeodesicActiveContourLevelSetImageFilter()
    contour.SetPropagationScaling(s["propagation"])
    contour.SetCurvatureScaling(s["curvature"])
    contour.SetAdvectionScaling(s["advection"])
    contour.SetMaximumRMSError(0.01)
    contour.SetNumberOfIterations(s["iterations"])
    end = contour.Execute(_inside_negative(seed, spacing), sitk.Cast(edge, sitk.sitkFloat32))
    return (sitk.GetArrayFromImage(end) < 0), contour.GetElapsedIterations()


def fast_marching(field: FloatArray, seed: BoolArray, allowed: BoolArray, spacing: float, s: Setting) -> Any:
    """ITK's fast marching with a sigmoid of the intensity as its speed, up to a time of arrival."""
    sitk = _itk()
    speed = 1.0 / (1.0 + np.exp(-(np.clip(field, *LIMITS) - s["middle"]) / s["width"]))
    speed = np.where(allowed, speed, 0.0).astype(np.float32)
    border = seed & ~ndimage.binary_erosion(seed)
    march = sitk.FastMarchingImageFilter()
    march.SetTrialPoints([[int(i) for i in point[::-1]] for point in np.argwhere(border)])
    march.SetStoppingValue(s["time"] * 1.5)
    arrival = sitk.GetArrayFromImage(march.Execute(_image(speed, spacing)))
    return ((arrival < s["time"]) | seed), 0


def chan_vese(field: FloatArray, seed: BoolArray, allowed: BoolArray, spacing: float, s: Setting) -> Any:  # noqa: ARG001
    """scikit-image's morphological Chan–Vese."""
    from skimage.segmentation import morphological_chan_vese

    end = morphological_chan_vese(
        _gated(field, allowed), s["iterations"], init_level_set=seed.astype(np.int8), smoothing=s["smoothing"],
        lambda1=s["lambda1"],
    )  # fmt: skip
    return _reached(end > 0, seed), s["iterations"]


def fixed_threshold(field: FloatArray, seed: BoolArray, allowed: BoolArray, spacing: float, s: Setting) -> Any:  # noqa: ARG001
    """Everything above a threshold that is connected to the seed."""
    return _reached((field > s["threshold"]) & allowed, seed), 0


def otsu(field: FloatArray, seed: BoolArray, allowed: BoolArray, spacing: float, s: Setting) -> Any:  # noqa: ARG001
    """Otsu's threshold with two, three or four classes: the highest class, connected to the seed."""
    from skimage.filters import threshold_multiotsu

    values = np.clip(field[allowed], *LIMITS)
    return _reached((field > threshold_multiotsu(values, s["classes"])[-1]) & allowed, seed), 0


def two_gaussians(field: FloatArray, seed: BoolArray, allowed: BoolArray, spacing: float, s: Setting) -> Any:  # noqa: ARG001
    """Two normal distributions fitted by expectation and maximisation: where the brighter one is likelier."""
    values = np.clip(field[allowed], *LIMITS).astype(np.float64)[:: max(1, int(allowed.sum()) // 200_000)]
    mean = np.percentile(values, (50.0, s["start"]))
    deviation, share = np.full(2, values.std()), np.array([0.9, 0.1])
    for _ in range(100):
        density = share * np.exp(-0.5 * ((values[:, None] - mean) / deviation) ** 2) / deviation
        part = density / np.maximum(density.sum(axis=1, keepdims=True), 1e-300)
        weight = part.sum(axis=0)
        mean = (part * values[:, None]).sum(axis=0) / weight
        deviation = np.maximum(np.sqrt((part * (values[:, None] - mean) ** 2).sum(axis=0) / weight), 1e-3)
        share = weight / weight.sum()
    at = np.linspace(mean.min(), LIMITS[1], 2000)
    density = share * np.exp(-0.5 * ((at[:, None] - mean) / deviation) ** 2) / deviation
    brighter = int(mean.argmax())
    likelier = at[density[:, brighter] / density.sum(axis=1) > s["posterior"]]
    level = float(likelier[0]) if len(likelier) else LIMITS[1]
    return _reached((field > level) & allowed, seed), 0


def _grid(**choices: tuple[Any, ...]) -> list[Setting]:
    settings: list[Setting] = [{}]
    for name, values in choices.items():
        settings = [setting | {name: value} for setting in settings for value in values]
    return settings


PEERS: dict[str, tuple[str, Callable[..., Any], list[Setting]]] = {
    "threshold_level_set": (
        "ITK ThresholdSegmentationLevelSet",
        threshold_level_set,
        # Stopped early, and let to come to rest: the latter is often the better one, and slower.
        _grid(lower=(1.5, 2.0, 2.5), curvature=(0.3, 1.0), rms=(0.01,), iterations=(600,))
        + _grid(lower=(1.5, 2.0, 2.5), curvature=(0.3, 1.0), rms=(0.002,), iterations=(1500,)),
    ),
    "geodesic_active_contour": (
        "ITK GeodesicActiveContour",
        geodesic_active_contour,
        _grid(
            sigma=(0.8,),
            edge=(1.0, 2.0),
            propagation=(0.3, 1.0),
            curvature=(0.5,),
            advection=(1.0, 3.0),
            iterations=(300,),
        ),
    ),
    "fast_marching": (
        "ITK fast marching",
        fast_marching,
        _grid(middle=(2.0, 2.5, 3.0), width=(0.25, 0.5), time=(8.0, 15.0, 30.0)),
    ),
    "chan_vese": (
        "morphological Chan–Vese (scikit-image)",
        chan_vese,
        _grid(iterations=(15, 40), smoothing=(1, 2), lambda1=(1.0, 2.0)),
    ),
    "fixed_threshold": (
        "threshold and component",
        fixed_threshold,
        _grid(threshold=(1.5, 2.0, 2.5, 3.0)),
    ),
    "otsu": ("Otsu and component", otsu, _grid(classes=(2, 3, 4))),
    "two_gaussians": (
        "two Gaussians and component",
        two_gaussians,
        _grid(start=(95.0, 99.0), posterior=(0.5, 0.9)),
    ),
}
"""Title, method and settings by name."""


def main(folder: Path, asked: list[str]) -> None:
    """Run some settings of some methods."""
    with np.load(folder / "input.npz") as given:
        field, seed, allowed, spacing = given["field"], given["seed"], given["allowed"], float(given["spacing"])
    for text in asked:
        name, _, number = text.partition(":")
        _, method, settings = PEERS[name]
        forget_peak()
        start = time.process_time()
        mask, iterations = method(field, seed, allowed, spacing, settings[int(number)])
        spent = time.process_time() - start
        np.save(folder / f"{name}-{number}.npy", np.asarray(mask, dtype=np.bool_) & allowed)
        told = {"cpu_seconds": spent, "iterations": int(iterations), "peak_mib": peak_mib(), "late": False}
        print(json.dumps(told), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
