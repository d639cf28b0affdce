"""The pictures of a job's report: the clusters on the first frame, and rate over distortion."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import IntArray
from shapery_motion._picture_kernels import nearest_faces
from shapery_motion.playing import FrameArray

SIDE: Final = 480
SAMPLES: Final = 2
"""A pixel is the average of so many rows and columns of finer ones."""


def cluster_colours(count: int) -> NDArray[np.uint8]:
    """Return a colour (count, 3) for each cluster: hues a golden ratio apart stay distinct however many there are."""
    hue = (np.arange(count)[:, None] * 0.618034 + np.array([0.0, 1 / 3, 2 / 3])) % 1.0
    return np.asarray(95 + 160 * np.abs(2.0 * hue - 1.0), dtype=np.uint8)


def clusters_png(vertices: FrameArray, faces: IntArray, labels: IntArray) -> bytes:
    """Draw a frame in the colours of its clusters, y upwards, seen across its wider side; on a clear ground."""
    points = np.asarray(vertices, dtype=np.float64)
    used = np.unique(faces) if len(faces) else np.arange(len(points))
    points = points - points[used].mean(axis=0)
    ground = points[used][:, [0, 2]]
    narrow = np.linalg.eigh(ground.T @ ground)[1][:, 0]
    narrow *= np.sign(narrow[np.abs(narrow).argmax()])
    up, eye = np.array([0.0, 1.0, 0.0]), np.array([narrow[0], 0.0, narrow[1]])
    # everything is turned and tilted a little, so that depth is seen
    turned = points @ np.stack((np.cross(up, eye), up, eye), axis=1)
    for first, second, angle in ((0, 2, 0.45), (2, 1, 0.25)):
        c, s = math.cos(angle), math.sin(angle)
        a, b = turned[:, first].copy(), turned[:, second].copy()
        turned[:, first], turned[:, second] = c * a + s * b, c * b - s * a
    low, high = turned[used].min(axis=0), turned[used].max(axis=0)
    fine = SIDE * SAMPLES
    scale = 0.92 * fine / max(float((high - low)[:2].max()), 1e-300)
    placed = (turned - (low + high) / 2) * scale
    placed[:, 0] += fine / 2
    placed[:, 1] = fine / 2 - placed[:, 1]
    seen = nearest_faces(placed, faces, fine, fine)
    corners = turned[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    light = 0.35 + 0.65 * np.abs(normals @ np.array([0.3, 0.45, 0.84]))
    colours = cluster_colours(int(labels.max()) + 1)[labels[faces[:, 0]]] * light[:, None]
    picture = np.zeros((fine, fine, 4))
    covered = seen >= 0
    picture[covered, :3] = colours[seen[covered]]
    picture[covered, 3] = 255.0
    blocks = picture.reshape(SIDE, SAMPLES, SIDE, SAMPLES, 4).mean(axis=(1, 3))
    blocks[..., :3] /= np.maximum(blocks[..., 3:] / 255.0, 1e-9)
    return _png(np.rint(blocks).astype(np.uint8))


def _png(picture: NDArray[np.uint8]) -> bytes:
    rows, columns, _ = picture.shape
    lines = np.concatenate((np.zeros((rows, 1), np.uint8), picture.reshape(rows, -1)), axis=1).tobytes()

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", columns, rows, 8, 6, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines, 9)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def rate_svg(points: Sequence[tuple[float, float]], chosen: float) -> str:
    """Draw bits per vertex and frame over the KG error in percent, both logarithmic.

    Parameters
    ----------
    points
        KG errors and bits, at least one, in any order.
    chosen
        The error of the file itself, which is marked.
    """
    width, height, left, bottom, right, top = 520, 340, 62, 48, 16, 34
    drawable = sorted((kg, bits) for kg, bits in points if kg > 0.0 and bits > 0.0)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">',
        '<g font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        '<text x="16" y="20" font-weight="bold">Rate and distortion</text>',
    ]
    if drawable:
        xs, ys = _limits([kg for kg, _ in drawable]), _limits([bits for _, bits in drawable])

        def place(kg: float, bits: float) -> tuple[float, float]:
            x = left + (width - left - right) * math.log(kg / xs[0]) / math.log(xs[1] / xs[0])
            y = height - bottom - (height - bottom - top) * math.log(bits / ys[0]) / math.log(ys[1] / ys[0])
            return round(x, 1), round(y, 1)

        for kg in _ticks(*xs):
            x, _ = place(kg, ys[0])
            parts.append(f'<path d="M{x} {top}V{height - bottom}" stroke="#dddddd"/>')
            parts.append(f'<text x="{x}" y="{height - bottom + 16}" text-anchor="middle">{kg:g}</text>')
        for bits in _ticks(*ys):
            _, y = place(xs[0], bits)
            parts.append(f'<path d="M{left} {y}H{width - right}" stroke="#dddddd"/>')
            parts.append(f'<text x="{left - 6}" y="{y + 4}" text-anchor="end">{bits:g}</text>')
        line = " ".join("{},{}".format(*place(*point)) for point in drawable)
        parts.append(f'<polyline points="{line}" fill="none" stroke="#0b7a75" stroke-width="2"/>')
        # rounding to single precision and corrections move a file's error a little from that of its motion
        nearest = min(drawable, key=lambda point: abs(point[0] - chosen))
        for point in drawable:
            x, y = place(*point)
            here = point == nearest
            parts.append(
                f'<circle cx="{x}" cy="{y}" r="{5 if here else 3}" fill="{"#d1495b" if here else "#0b7a75"}"/>'
            )
    x, y = (left + width - right) / 2, (top + height - bottom) / 2
    rate = "bits per vertex and frame"
    parts += [
        f'<text x="{x}" y="{height - 10}" text-anchor="middle">KG error, % (red: this file)</text>',
        f'<text transform="translate(16 {y}) rotate(-90)" text-anchor="middle">{rate}</text>',
        "</g></svg>",
    ]
    return "\n".join(parts) + "\n"


def _limits(values: list[float]) -> tuple[float, float]:
    """Return what lies a little below and above all values."""
    return min(values) / 1.25, max(values) * 1.25


def _ticks(low: float, high: float) -> list[float]:
    """Return the numbers 1, 2 and 5 times a power of ten in between, and more of them where those are few."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for multiples in ((1, 2, 5), (1, 1.5, 2, 3, 4, 5, 6, 8)):
        found = [m * 10.0**p for p in powers for m in multiples if low <= m * 10.0**p <= high]
        if len(found) > 2:
            break
    return found
