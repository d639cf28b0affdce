"""What is seen of a segmentation, and where it should be seen."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from shapery_geometry.volume import Volume


def wait_for_pictures(page: Any) -> None:
    """Wait for both viewers to be ready; their first pictures come a little later."""
    for name in ("Volume", "Surface"):
        page.locator(f"section[aria-label={name}][data-status=ready]").wait_for()


def tumor_colored(pixels: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Where pixels have a hue that gray slices have not: the orange of label 1, the blue of label 2."""
    red, green, blue = (pixels[..., channel].astype(int) for channel in range(3))
    orange = (red > blue + 40) & (red > green + 12) & (green > blue)
    azure = (blue > red + 35) & (blue > green + 10)
    return orange | azure


def box(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """First and last row and column of what is set, ignoring single pixels: ((top, bottom), (left, right))."""
    edges = []
    assert mask.any(), "nothing is drawn"
    for axis in (1, 0):
        along = np.flatnonzero(mask.sum(axis=axis) > 2)
        edges.append((along[0], along[-1] + 1))
    return np.array(edges, dtype=float)


def crosshair(page: Any) -> list[float]:
    """Where the crosshair is, RAS mm, as the page tells it."""
    signs = {"R": 1, "L": -1, "A": 1, "P": -1, "S": 1, "I": -1}
    found = re.findall(r"([RLAPSI])\s(\d+\.\d)", page.get_by_test_id("place").text_content())
    return [signs[side] * float(value) for side, value in found]


def check_slice(pixels: NDArray[np.uint8], labels: Volume, point: list[float], across: int, up: int) -> None:
    """Compare colored pixels with the labels of the slice through `point`, the patient's left on the right."""
    # The phantom's axes are R, A and S with one spacing, so the slice fills the canvas at one scale.
    assert np.array_equal(labels.affine[:3, :3], np.eye(3) * labels.spacing[0])
    through = 3 - across - up
    index = round(labels.to_index(point)[through])
    there = np.nonzero(np.take(labels.data, index, axis=through))
    (height, width), extent = pixels.shape[:2], np.array(labels.shape)[[across, up]]
    scale = min(width / extent[0], height / extent[1])
    towards_right = -1 if across == 0 else 1
    ends = [extent[0] / 2 - there[0].min(), extent[0] / 2 - there[0].max() - 1]
    sides = sorted(width / 2 - towards_right * scale * np.array(ends))
    levels = [height / 2 + scale * (extent[1] / 2 - level) for level in (there[1].max() + 1, there[1].min())]
    drawn = tumor_colored(pixels)
    # The crosshair hides a little: a voxel at the tip, a line through the middle.
    np.testing.assert_allclose(box(drawn), [levels, sides], atol=1.2 * scale)
    assert drawn.sum() == pytest.approx(there[0].size * scale**2, rel=0.25)


def silhouette(points: NDArray[np.float64], looked_at: NDArray[np.float64], shape: tuple[int, ...]) -> NDArray[Any]:
    """Where points are seen, as `box` tells it, when one looks at others from the front, a little from the right and
    above."""
    height, width = shape[:2]
    low, high = looked_at.min(axis=0), looked_at.max(axis=0)
    towards = np.array([0.45, 1.0, 0.4]) / np.linalg.norm([0.45, 1.0, 0.4])
    half = np.radians(16)
    distance = 1.1 * np.linalg.norm(high - low) / 2 / np.sin(half) / min(1, width / height)
    right = np.cross(-towards, [0, 0, 1])
    right /= np.linalg.norm(right)
    above = np.cross(right, -towards)
    seen = points - (low + high) / 2
    depth = (distance - seen @ towards) * np.tan(half)
    columns = width / 2 + seen @ right / depth * height / 2
    rows = height / 2 - seen @ above / depth * height / 2
    return np.array([[rows.min(), rows.max()], [columns.min(), columns.max()]])


def vertices_of(ply: bytes) -> NDArray[np.float64]:
    header, _, data = ply.partition(b"end_header\n")
    assert b"format binary_little_endian" in header
    assert re.findall(rb"property (\w+) [xyz]\n", header) == [b"double"] * 3
    count = int(re.search(rb"element vertex (\d+)", header)[1])  # type: ignore[index]
    return np.frombuffer(data, dtype="<f8", count=3 * count).reshape(-1, 3)


def to_border(points: NDArray[np.float64], mask: Volume) -> NDArray[np.float64]:
    """How far points are from the border of a mask, in mm, negative inside: the nearest voxel of the other side."""
    inside = np.pad(mask.data > 0, 2)
    at = mask.to_index(points) + 2
    here = inside[tuple(np.rint(at).astype(int).T)]
    found = np.empty(len(at))
    for side in (False, True):
        other = np.argwhere(ndimage.binary_dilation(inside == side) & (inside != side))
        _, near = cKDTree(other * mask.spacing).query(at[here == side] * mask.spacing, k=40)
        beyond = np.maximum(np.abs(at[here == side][:, None] - other[near]) - 0.5, 0) * mask.spacing
        found[here == side] = np.linalg.norm(beyond, axis=2).min(axis=1) * (-1 if side else 1)
    return found
