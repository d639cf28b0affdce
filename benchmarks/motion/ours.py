"""Motion files as a user makes them, and the methods of the dissertation."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.motion.case import Case, Coded
from shapery_contracts.motion import MotionEncodeParams
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.sequence import MeshSequence
from shapery_motion import encode, open_motion
from shapery_motion.baselines.affine import predict_affine
from shapery_motion.baselines.spectral import SpectralBasis, spectral_basis
from shapery_motion.gradient.encoder import EncodedFrames, GradientOptions, encode_frames
from shapery_motion.gradient.streams import IntegerStream
from shapery_motion.gradient.traversal import traverse
from shapery_motion.profiles import GroupTask


def file(
    case: Case,
    kg: float,
    *,
    profile: Literal["trajectory", "gradient"],
    preset: Literal["default", "fast"] = "default",
    keep: Path | None = None,
) -> Coded:
    """Make a motion file with one bound and nothing else set; its size is that on disk, the container included.

    It is written to `keep`, if that is given.
    """
    sequence = MeshSequence(case.frames.astype(np.float32), case.faces)
    encoding = encode(sequence, MotionEncodeParams(kg=kg, profile=profile, preset=preset))
    if keep:
        keep.write_bytes(encoding.data)
    start = time.process_time()
    motion = open_motion(encoding.data)
    first = motion.frame(0)
    opened = time.process_time() - start
    decoded = np.empty(case.frames.shape)
    decoded[0] = first
    for number in range(1, len(motion)):
        decoded[number] = motion.frame(number)
    seconds = time.process_time() - start
    again = time.process_time()
    for number in range(0, len(motion), 7):
        motion.frame(number)
    jump = (time.process_time() - again) / len(range(0, len(motion), 7))
    connectivity = encoding.parts["connectivity"]
    return Coded(
        len(encoding.data) - connectivity,
        decoded,
        seconds,
        connectivity,
        {
            "clusters": encoding.clusters,
            "groups": len(motion.groups),
            "parts": encoding.parts,
            "open_seconds": opened,
            "frame_seconds_open": jump,
        },
    )


def text_task(case: Case, clusters: int, step: int = 1) -> GroupTask:
    """Return the task of the whole sequence, or of every so many frames of it, without a bound."""
    return GroupTask(case.frames[::step], case.faces, math.inf, clusters=clusters)


def as_in_the_text(
    case: Case, clusters: int, *, step: int = 1, representative: Literal["least_squares", "member"] = "least_squares"
) -> EncodedFrames:
    """One key frame, one number of clusters, one anchor for a part (and eight along a boundary)."""
    options = GradientOptions(representative=representative, spreads=(0,), predict_only=True)
    return encode_frames(text_task(case, clusters, step), options)


def sampled(case: Case, wanted: int = 24) -> NDArray[np.int64]:
    """Numbers of some frames, evenly over the sequence; not the first, which is the key frame."""
    count = min(wanted, len(case.frames) - 1)
    return np.unique(np.linspace(1, len(case.frames) - 1, count).astype(np.int64)) if count > 0 else np.zeros(0, int)


def key_bytes(case: Case, step: float) -> tuple[int, NDArray[np.float64]]:
    """Return the bytes of the first frame on a grid, and what it decodes to."""
    low = case.frames[0].min(axis=0)
    whole = np.rint((case.frames[0] - low) / step).astype(np.int64)
    stream = IntegerStream(3)
    stream.write(traverse(case.faces, len(whole)).residuals(whole))
    return len(stream.finish()) + 32, low + step * whole


def predicted_alone(
    case: Case, predict: Callable[[NDArray[np.float64], NDArray[np.int64]], tuple[int, NDArray[np.float64]]]
) -> dict[str, Any]:
    """Measure a method that predicts frames from the first: bits and errors of a sample of frames, key frame apart."""
    numbers = sampled(case)
    start = time.process_time()
    used, decoded = predict(case.frames[0], numbers)
    seconds = time.process_time() - start
    wanted = case.frames[numbers]
    spread = math.sqrt(float(((wanted - wanted.mean(axis=1, keepdims=True)) ** 2).sum(axis=2).mean()))
    return {
        "bits": 8 * used / (len(numbers) * case.frames.shape[1]),
        "kg_percent": 100 * math.sqrt(float(((decoded - wanted) ** 2).sum(axis=2).mean())) / spread,
        "frames": len(numbers),
        "seconds_per_frame": seconds / len(numbers),
    }


def spectral_points(case: Case, counts: tuple[int, ...], kind: Literal["positions", "differences"]) -> list[Any]:
    """Rate and error of the spectral baseline for numbers of coefficients."""
    start = time.process_time()
    basis = spectral_basis(TriangleMesh(case.frames[0], case.faces), max(counts))
    basis_seconds = time.process_time() - start
    points = []
    for count in counts:
        part = SpectralBasis(basis.key, basis.functions[:, :count], basis.eigenvalues[:count], basis.masses)

        def predict(
            key: NDArray[np.float64], numbers: NDArray[np.int64], part: SpectralBasis = part
        ) -> tuple[int, NDArray[np.float64]]:
            # a thousandth of the size of the body, times the root of its area, as the functions are normalised
            step = 1e-3 * case.spread * math.sqrt(float(part.masses.sum()))
            stream = IntegerStream(3)
            decoded = np.empty((len(numbers), *key.shape))
            for k, number in enumerate(numbers):
                target = case.frames[number] if kind == "positions" else case.frames[number] - key
                whole = np.rint(part.coefficients(target) / step).astype(np.int64)
                stream.write(whole)
                decoded[k] = part.functions @ (whole * step) + (0 if kind == "positions" else key)
            return len(stream.finish()), decoded

        found = predicted_alone(case, predict)
        points.append({**found, "coefficients": count, "basis_seconds": basis_seconds})
    return points


def affine_points(case: Case, counts: tuple[int, ...]) -> list[Any]:
    """Rate and error of the vertex-cluster baseline for numbers of clusters; matrices in single precision."""
    points = []
    for count in counts:

        def predict(
            key: NDArray[np.float64], numbers: NDArray[np.int64], count: int = count
        ) -> tuple[int, NDArray[np.float64]]:
            walk = traverse(case.faces, len(key))
            stream = IntegerStream(1)
            decoded = np.empty((len(numbers), *key.shape))
            matrices = 0
            for k, number in enumerate(numbers):
                found = predict_affine(key, case.frames[number], count, np.random.default_rng(0), iterations=8)
                stream.write(np.diff(found.labels[walk.vertex_order].astype(np.int64), prepend=0).reshape(-1, 1))
                matrices += 4 * found.transforms.size
                decoded[k] = found.vertices
            return len(stream.finish()) + matrices, decoded

        points.append({**predicted_alone(case, predict), "clusters": count})
    return points
