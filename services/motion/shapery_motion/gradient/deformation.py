"""Local transformations: what the motion from one frame to another does to every face (section 5.4, Eq. 5.1–5.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import IntArray
from shapery_motion.gradient import _deformation_kernels as kernels

FloatArray = NDArray[np.float64]

DEGENERATE: Final = 1e-6
"""A face is degenerate where twice its area is at most this times the square of its longest side.

Coordinates in single precision of a mesh of a thousand edges across are exact to about 1e-4 of an edge, so such a face
is a needle by rounding, whose direction across says nothing."""


@dataclass(frozen=True, eq=False)
class FaceFrames:
    """The faces of a key frame, ready to measure the motion to other frames."""

    faces: IntArray
    """(m, 3)"""
    columns: FloatArray
    """(m, 3, 3) V of Eq. 5.3."""
    inverse: FloatArray
    """(m, 3, 3) V⁻¹; zero where the face is degenerate."""
    solid: NDArray[np.bool_]
    """(m,) whether a face has an area, so that a transformation is defined on it."""


def face_frames(vertices: NDArray[Any], faces: IntArray) -> FaceFrames:
    """Return V and its inverse for all faces of a frame.

    Parameters
    ----------
    vertices : (n, 3) float32 or float64
    faces : (m, 3) int32

    Notes
    -----
    The fourth vertex is v₁ + c/√|c| with c = (v₂ − v₁) × (v₃ − v₁) (Eq. 5.1), so det V = |c|^1.5 and the inverse has a
    closed form: its rows are the dual basis.
    """
    columns: FloatArray = kernels.edge_frames(vertices, faces)
    inverse = np.empty_like(columns)
    solid = np.empty(len(faces), dtype=np.bool_)
    kernels.inverses(columns, DEGENERATE, inverse, solid)
    return FaceFrames(faces, columns, inverse, solid)


def deformation_gradients(source: FaceFrames, target: NDArray[Any]) -> FloatArray:
    """Return Q of Eq. 5.4 for every face: the linear part of its motion.

    Parameters
    ----------
    source
        The faces of the key frame.
    target : (n, 3) float32 or float64
        The vertices of the intermediate frame.

    Returns
    -------
    (m, 3, 3) float64
        Where the face of the key frame is degenerate, which determines no transformation, the identity. A face that
        degenerates in the target has a singular Q, which is right: it is what happens to it.
    """
    frames: FloatArray = kernels.edge_frames(target, source.faces)
    result = np.empty_like(frames)
    kernels.products(frames, source.inverse, source.solid, result)
    return result
