"""A small picture of a shape, rendered here: no graphics library, the same pixels on every machine."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_retrieval import _view_kernels as kernels
from shapery_retrieval.pose import Pose, pose_of

SAMPLES = 3
"""Pixels are averaged from so many rows and columns of finer ones."""
BASE = np.array([0.42, 0.58, 0.74])
PALETTE = (
    (0.30, 0.47, 0.66), (0.95, 0.56, 0.17), (0.88, 0.34, 0.35), (0.46, 0.72, 0.70), (0.35, 0.63, 0.31),
    (0.93, 0.79, 0.28), (0.69, 0.48, 0.63), (1.00, 0.62, 0.65), (0.61, 0.46, 0.37), (0.73, 0.69, 0.67),
)  # fmt: skip
"""Colours of parts, one after another."""


def preview(
    mesh: TriangleMesh, size: int = 256, labels: NDArray[np.integer] | None = None, pose: Pose | None = None
) -> NDArray[np.uint8]:
    """Return a (size, size, 4) picture: red, green, blue and opacity.

    Parameters
    ----------
    mesh
        With some area.
    size
        Side in pixels.
    labels : (n,)
        Part of each vertex, to colour parts.
    pose
        How it stands; by default as `shapery_retrieval.pose.pose_of` finds.
    """
    fine = size * SAMPLES
    pose = pose_of(mesh) if pose is None else pose
    right = np.cross((0.0, 1.0, 0.0), pose.towards)
    right /= np.linalg.norm(right)
    camera = np.stack((right, np.cross(pose.towards, right), pose.towards))
    seen = (mesh.vertices - mesh.centroid) @ (camera @ pose.frame).T
    low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
    scale = 0.9 * fine / max(float((high - low).max()), 1e-12)
    seen = (seen - np.append((low + high) / 2, 0)) * scale
    seen[:, 0] += fine / 2
    seen[:, 1] = fine / 2 - seen[:, 1]
    depth = np.full((fine, fine), -np.inf)
    ids = np.full((fine, fine), -1, dtype=np.int32)
    kernels.render(seen, mesh.faces, fine, depth, ids)
    flipped = seen * [1, -1, 1]
    smooth = TriangleMesh(flipped, mesh.faces)
    normals = smooth.vertex_normals[mesh.faces].mean(axis=1) + 0.6 * smooth.face_normals
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    # either side of a face is lit
    normals *= np.where(normals[:, 2:] < 0, -1.0, 1.0)
    key, fill = np.array([-0.45, 0.65, 0.62]), np.array([0.7, -0.1, 0.5])
    light = 0.28 + 0.62 * np.clip(normals @ key, 0, 1) + 0.2 * np.clip(normals @ fill, 0, 1)
    colour = np.tile(BASE, (len(mesh.faces), 1))
    if labels is not None:
        colour = np.asarray(PALETTE)[np.asarray(labels)[mesh.faces[:, 0]] % len(PALETTE)]
    shaded = np.clip(colour * light[:, None] + 0.25 * np.clip(normals @ key, 0, 1)[:, None] ** 24, 0, 1)
    covered = ids >= 0
    picture = np.zeros((fine, fine, 4))
    picture[covered, :3] = shaded[ids[covered]]
    picture[covered, 3] = 1.0
    blocks = picture.reshape(size, SAMPLES, size, SAMPLES, 4).mean(axis=(1, 3))
    opacity = np.maximum(blocks[..., 3:], 1e-9)
    blocks[..., :3] = np.sqrt(blocks[..., :3] / opacity)
    return np.asarray(np.rint(blocks * 255), dtype=np.uint8)


def png_bytes(picture: NDArray[np.uint8]) -> bytes:
    """Return a (rows, columns, 4) picture as a PNG file."""
    rows, columns, _ = picture.shape
    raw = np.concatenate((np.zeros((rows, 1), np.uint8), picture.reshape(rows, -1)), axis=1).tobytes()

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", columns, rows, 8, 6, 0, 0, 0)
    parts = (chunk(b"IHDR", header), chunk(b"IDAT", zlib.compress(raw, 9)), chunk(b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)
