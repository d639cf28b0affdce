"""What is told of an encoding: ``report.json``, pictures, and a mesh whose colours show the clusters."""

from __future__ import annotations

import json
import math
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from shapery_contracts.motion import (
    MotionEncodeParams,
    MotionEncodeResult,
    MotionErrors,
    MotionReport,
    RatePoint,
)
from shapery_contracts.segmentation import StageTime
from shapery_geometry.mesh import IntArray
from shapery_motion.codec import Encoding
from shapery_motion.pictures import cluster_colours, clusters_png, rate_svg
from shapery_motion.playing import FrameArray

MOTION_FILE, REPORT_FILE, CLUSTERS_FILE = "motion.smc", "report.json", "clusters.ply"


def describe(encoding: Encoding, params: MotionEncodeParams, stages: list[StageTime]) -> MotionReport:
    """Return the report of an encoding."""
    header, errors = encoding.header, encoding.errors
    pairs = header.vertices * header.frames
    connectivity = encoding.parts["connectivity"]
    asked = header.asked
    bounds = {"kg": asked.kg_percent, "rmse": asked.rmse_edges, "max_error": asked.largest_fraction}
    return MotionReport(
        file=MOTION_FILE,
        profile=params.profile,
        preset=params.preset,
        frames=header.frames,
        vertices=header.vertices,
        faces=header.faces,
        groups=header.groups,
        clusters=encoding.clusters,
        bytes=len(encoding.data),
        parts=encoding.parts,
        bits_per_vertex_frame=8.0 * len(encoding.data) / pairs,
        motion_bits_per_vertex_frame=8.0 * (len(encoding.data) - connectivity) / pairs,
        connectivity_bits_per_vertex=8.0 * connectivity / header.vertices,
        bounds={name: value for name, value in bounds.items() if math.isfinite(value)},
        errors=MotionErrors(
            kg_percent=_finite(errors.kg_percent),
            rmse_edges=_finite(errors.rmse_edges),
            prediction=_finite(errors.prediction),
            largest_fraction=_finite(errors.largest_fraction),
        ),
        stages=stages,
        versions=versions(),
        warnings=list(encoding.warnings),
        frame_rmse=errors.frame_rmse.tolist(),
        frame_largest=errors.frame_largest.tolist(),
        vertex_clusters=encoding.labels.tolist(),
        rate_distortion=[
            RatePoint(kg_percent=kg, motion_bits_per_vertex_frame=8.0 * size / pairs)
            for kg, size in sorted(encoding.points)
        ],
    )


def summary(report: MotionReport) -> MotionEncodeResult:
    """Return the part of the report that the API gives."""
    return MotionEncodeResult.model_validate({name: getattr(report, name) for name in MotionEncodeResult.model_fields})


def write_report(report: MotionReport, folder: Path) -> None:
    """Write ``report.json``."""
    text = json.dumps(report.model_dump(mode="json"), indent=1, ensure_ascii=False)
    (folder / REPORT_FILE).write_text(text + "\n", encoding="utf-8")


def write_pictures(report: MotionReport, vertices: FrameArray, faces: IntArray, labels: IntArray, folder: Path) -> None:
    """Write ``clusters.png`` and ``rate.svg``."""
    (folder / "clusters.png").write_bytes(clusters_png(vertices, faces, labels))
    points = [(point.kg_percent, point.motion_bits_per_vertex_frame) for point in report.rate_distortion]
    (folder / "rate.svg").write_text(rate_svg(points, report.errors.kg_percent), encoding="utf-8")


def write_clusters(path: Path, vertices: FrameArray, faces: IntArray, labels: IntArray) -> None:
    """Write a binary PLY of the first frame whose vertices bear the colours of their clusters."""
    rows = np.empty(len(vertices), dtype=np.dtype([("at", "<f4", 3), ("colour", "u1", 3)]))
    rows["at"] = vertices
    rows["colour"] = cluster_colours(int(labels.max()) + 1)[labels]
    corners = np.empty(len(faces), dtype=np.dtype([("count", "u1"), ("indices", "<i4", 3)]))
    corners["count"] = 3
    corners["indices"] = faces
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(vertices)}",
        *(f"property float {axis}" for axis in "xyz"),
        *(f"property uchar {channel}" for channel in ("red", "green", "blue")),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
        "",
    ]
    path.write_bytes("\n".join(header).encode() + rows.tobytes() + corners.tobytes())


def versions() -> dict[str, str]:
    """Return the versions of what a result depends on."""
    found = {}
    for package in ("shapery-motion", "shapery-geometry", "numpy", "scipy", "numba"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:  # run from a tree that is not installed
            found[package] = "unknown"
    return found


def _finite(value: float) -> float:
    return float(value) if np.isfinite(value) else 0.0
