"""Pictures of meshes, coloured by mean curvature as in the dissertation, and plots."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.ticker import NullFormatter

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators.curvature import mean_curvature

mpl.use("Agg")

from matplotlib import pyplot as plt

DOTS = 110
COLOURS = ("#1f5fa8", "#c0504d", "#2e8b57", "#8064a2", "#b8860b", "#444444")
MARKS = ("o", "s", "^", "D", "v", "P")
STYLES = {
    "trajectory": ("#1f5fa8", "o", "ours"),
    "trajectory-fast": ("#6aa9e0", "o", "ours, fast"),
    "gradient": ("#c0504d", "s", "dissertation's profile"),
    "text": ("#e39a98", "s", "dissertation's, as written"),
    "affine-clusters": ("#d9772b", "v", "affine vertex clusters"),
    "spectral-positions": ("#a0522d", "<", "spectral, positions"),
    "spectral-differences": ("#d2a679", ">", "spectral, differences"),
    "clustered-pca": ("#2e8b57", "^", "clustered PCA, as published"),
    "clustered-pca-strong": ("#74b58d", "^", "clustered PCA, strengthened"),
    "trajectory-pca": ("#8064a2", "D", "trajectory PCA"),
    "shape-pca": ("#b39ad0", "D", "shape PCA"),
    "delta-parallelogram": ("#b8860b", "P", "delta + parallelogram"),
    "delta-lzma": ("#808080", "x", "delta + lzma"),
    "delta-zstd": ("#b0b0b0", "+", "delta + zstd"),
    "draco": ("#333333", "*", "Draco"),
}
"""Colour, mark and name of each method, the same in every panel and run."""


def side_by_side(path: Path, panels: list[tuple[str, TriangleMesh]]) -> None:
    """Draw meshes next to each other, seen along the axis of their least extent but upright."""
    figure, axes = plt.subplots(1, len(panels), figsize=(3.4 * len(panels), 4.6), squeeze=False)
    first = panels[0][1]
    limit = max(float(np.percentile(np.abs(mean_curvature(first)), 92)), 1e-30)
    size = np.ptp(first.vertices, axis=0)
    up = int(size.argmax())
    depth = min((axis for axis in range(3) if axis != up), key=lambda axis: size[axis])
    across = 3 - up - depth
    for axis, (title, mesh) in zip(axes[0], panels, strict=True):
        order = np.argsort(mesh.corners[:, :, depth].mean(axis=1))
        front = order[mesh.face_normals[order, depth] > -0.05]
        curvature = np.clip(mean_curvature(mesh), -limit, limit)[mesh.faces].mean(axis=1) / (2 * limit) + 0.5
        light = 0.35 + 0.65 * np.clip(mesh.face_normals[:, depth], 0, 1)
        colours = plt.get_cmap("coolwarm")(curvature)[:, :3] * light[:, None]
        axis.add_collection(
            PolyCollection(
                mesh.corners[front][:, :, [across, up]],
                facecolors=colours[front],
                edgecolors=colours[front],
                linewidths=0.2,
            )
        )
        low, high = mesh.bounding_box
        axis.set_xlim(low[across], high[across])
        axis.set_ylim(low[up], high[up])
        axis.set_aspect("equal")
        axis.set_axis_off()
        axis.set_title(title, fontsize=9)
    figure.tight_layout()
    figure.savefig(path, dpi=DOTS)
    plt.close(figure)


def rate_distortion(path: Path, curves: dict[str, dict[str, list[tuple[float, float]]]]) -> None:
    """Plot KG error over bits for each sequence: one panel a sequence, one line a method."""
    names = list(curves)
    columns = min(3, max(len(names), 1))
    rows = -(-len(names) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(4.6 * columns, 3.8 * rows), squeeze=False)
    lines: dict[str, Any] = {}
    for place, axis in enumerate(axes.ravel()):
        if place >= len(names):
            axis.set_axis_off()
            continue
        for method, points in curves[names[place]].items():
            ordered = sorted(points)
            colour, mark, name = STYLES[method]
            [lines[name]] = axis.plot(
                [bits for _, bits in ordered], [kg for kg, _ in ordered],
                color=colour, marker=mark, markersize=4, linewidth=2.0 if method == "trajectory" else 1.1,
            )  # fmt: skip
        _logarithmic(axis, "bits per vertex and frame", "KG error, %")
        axis.set_ylim(0.015, 12)
        axis.set_title(names[place], fontsize=10)
    told = [name for _, _, name in STYLES.values() if name in lines]
    figure.legend([lines[name] for name in told], told, loc="lower center", ncols=5, fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0.08 if rows > 1 else 0.14, 1, 1))
    figure.savefig(path, dpi=DOTS)
    plt.close(figure)


def errors_over_clusters(path: Path, curves: dict[str, list[tuple[float, float]]]) -> None:
    """Plot Eq. 5.12 over the number of clusters (Fig. 5.8)."""
    figure, axis = plt.subplots(figsize=(5.2, 3.8))
    for k, (name, points) in enumerate(curves.items()):
        ordered = sorted(points)
        axis.plot(*zip(*ordered, strict=True), color=COLOURS[k], marker=MARKS[k], markersize=4, label=name)
    _logarithmic(axis, "clusters", "Eq. 5.12, mean edge lengths")
    axis.set_xticks(sorted({count for points in curves.values() for count, _ in points}))
    axis.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=DOTS)
    plt.close(figure)


def _logarithmic(axis: Any, x: str, y: str) -> None:
    axis.set_xscale("log")
    axis.set_yscale("log")
    for direction in (axis.xaxis, axis.yaxis):
        direction.set_major_formatter("{x:g}")
        direction.set_minor_formatter(NullFormatter())
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    axis.grid(visible=True, which="both", alpha=0.25)
