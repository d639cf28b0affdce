"""The tables and figures of chapter 5 on sequences at hand: Tables 5.1 and 5.2, Figs 5.1, 5.2, 5.3 and 5.8."""

from __future__ import annotations

import json
import math
import time
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.motion.case import RESULTS, Case, load
from benchmarks.motion.ours import as_in_the_text, sampled
from benchmarks.motion.pictures import side_by_side
from shapery_geometry.mesh import TriangleMesh
from shapery_motion.baselines.affine import predict_affine
from shapery_motion.baselines.spectral import TEXT_COEFFICIENTS, spectral_basis
from shapery_motion.errors import dissertation_bits, sequence_errors
from shapery_motion.gradient.encoder import EncodedFrames
from shapery_motion.gradient.group import PredictedFrame

FloatArray = NDArray[np.float64]

KEPT = RESULTS / "motion" / "figures.json"
CLUSTERS = (16, 64, 256, 1024)
"""Of Fig. 5.8."""
TEXT_TABLE = {
    "bouncing": 5.1e-5, "crane": 1.7e-5, "jumping": 1.45e-4, "march": 2.2e-5, "samba": 1.1e-5,
    "squad": 2.1e-5, "swing": 1.4e-5, "handstand": 2.15e-4, "face": 0.01,
}  # fmt: skip
"""Table 5.1."""


@dataclass(frozen=True, eq=False)
class _Setting:
    """One way to run the text's method."""

    clusters: int
    representative: Literal["least_squares", "member"] = "least_squares"
    adjacent: bool = False
    """Whether each frame is predicted from the one before it in place of the first."""


def text_points(case: Case) -> list[dict[str, Any]]:
    """Rate, errors and times of the text's method, on a sample of frames that are predicted from the first."""
    settings = [_Setting(clusters) for clusters in CLUSTERS if clusters < len(case.faces)]
    settings += [_Setting(256, representative="member"), _Setting(256, adjacent=True)]
    return [_text_point(case, setting) for setting in settings]


def _text_point(case: Case, setting: _Setting) -> dict[str, Any]:
    numbers = sampled(case, 12)
    originals, decoded, bytes_used = [], [], 0
    encode_seconds = decode_seconds = 0.0
    for number in numbers:
        key = number - 1 if setting.adjacent else 0
        pair = Case(case.name, case.frames[[key, number]], case.faces)
        start = time.process_time()
        encoded = as_in_the_text(pair, setting.clusters, representative=setting.representative)
        encode_seconds += time.process_time() - start
        start = time.process_time()
        decoded.append(encoded.group.frame(1))
        decode_seconds += time.process_time() - start
        originals.append(pair.frames[1])
        bytes_used += _predicted_bytes(encoded)
    errors = sequence_errors(originals, decoded, case.faces)
    vertices = case.frames.shape[1]
    return {
        "clusters": setting.clusters,
        "representative": setting.representative,
        "key_frame": "the one before" if setting.adjacent else "the first",
        "frames": len(numbers),
        "bits": 8 * bytes_used / (len(numbers) * vertices),
        "bits_of_eq_5_11": dissertation_bits(setting.clusters, len(case.faces), vertices),
        "encode_cpu_seconds_per_frame": encode_seconds / len(numbers),
        "decode_cpu_seconds_per_frame": decode_seconds / len(numbers),
        **errors.summary(),
    }


def _predicted_bytes(encoded: EncodedFrames) -> int:
    """Return the bytes of labels, matrices and anchors: all that a predicted frame takes."""
    assert isinstance(encoded.group.frames[1], PredictedFrame)
    return sum(len(payload) for tag, payload in encoded.sections if tag in ("GLAB", "GMAT", "GANC")) + 8


def complete() -> bool:
    """Whether all of `measure` is kept already."""
    return KEPT.exists() and "spectral" in json.loads(KEPT.read_text())


def measure() -> None:
    """Make the pictures of Figs 5.1 to 5.3 from crane, and keep the figures that go with them."""
    case = load("crane")
    key, near, far = (TriangleMesh(case.frames[number], case.faces) for number in (0, 1, len(case.frames) // 2))
    edge = float(key.edge_lengths.mean())

    def error(found: FloatArray, wanted: TriangleMesh) -> float:
        return math.sqrt(float(((found - wanted.vertices) ** 2).sum(axis=1).mean())) / edge

    affine = predict_affine(key.vertices, near.vertices, 256, np.random.default_rng(0))
    affine_far = predict_affine(key.vertices, far.vertices, 256, np.random.default_rng(0))
    text = as_in_the_text(Case(case.name, np.stack((key.vertices, near.vertices)), case.faces), 256).group.frame(1)
    text_far = as_in_the_text(Case(case.name, np.stack((key.vertices, far.vertices)), case.faces), 256).group.frame(1)
    side_by_side(
        RESULTS / "motion-figure-5-3.png",
        [
            ("another frame", far),
            (f"256 affine clusters ({error(affine_far.vertices, far):.3f})", far.with_vertices(affine_far.vertices)),
            (f"256 gradient clusters ({error(text_far, far):.3f})", far.with_vertices(text_far)),
        ],
    )
    found: dict[str, Any] = {
        "sequence": case.name,
        "frames": [1, len(case.frames) // 2],
        "affine_256": [error(affine.vertices, near), error(affine_far.vertices, far)],
        "gradient_256": [error(text, near), error(text_far, far)],
    }
    _keep(found)
    start = time.process_time()
    basis = spectral_basis(key, TEXT_COEFFICIENTS)
    found["basis_cpu_seconds"] = time.process_time() - start
    recovered = {
        "key_positions": (basis.from_positions(key.vertices), key),
        "near_positions": (basis.from_positions(near.vertices), near),
        "far_positions": (basis.from_positions(far.vertices), far),
        "near_differences": (basis.from_differences(near.vertices), near),
        "far_differences": (basis.from_differences(far.vertices), far),
    }
    found["coefficients"] = basis.count
    found["spectral"] = {name: error(*pair) for name, pair in recovered.items()}
    side_by_side(
        RESULTS / "motion-figure-5-1.png",
        [
            ("key frame", key),
            ("next frame", near),
            ("key frame, recovered", key.with_vertices(recovered["key_positions"][0])),
            ("next frame, recovered", near.with_vertices(recovered["near_positions"][0])),
        ],
    )
    side_by_side(
        RESULTS / "motion-figure-5-2.png",
        [("another frame", far), ("its differences, recovered", far.with_vertices(recovered["far_differences"][0]))],
    )
    _keep(found)


def _keep(found: dict[str, Any]) -> None:
    KEPT.parent.mkdir(parents=True, exist_ok=True)
    KEPT.write_text(json.dumps(found, indent=1) + "\n")
