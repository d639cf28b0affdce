"""Section CONN: the faces, once for all frames. Vertices keep their order; faces are sorted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import IntArray
from shapery_motion.container import _connectivity_kernels as kernels
from shapery_motion.container.sections import CONNECTIVITY, damaged
from shapery_motion.entropy.stream import Stream


def sorted_faces(faces: IntArray) -> IntArray:
    """Return the faces as a decoder gives them: each turned to the least of its three rotations, and ascending."""
    turned = np.array(faces, dtype=np.int64).reshape(-1, 3)
    for shift in (1, 2):
        other = np.roll(faces, shift, axis=1)
        # the first corner in which the two differ decides
        differs = (other != turned).argmax(axis=1)[:, None]
        less = (np.take_along_axis(other, differs, 1) < np.take_along_axis(turned, differs, 1))[:, 0]
        turned[less] = other[less]
    order = np.lexsort((turned[:, 2], turned[:, 1], turned[:, 0]))
    return np.ascontiguousarray(turned[order], dtype=np.int32)


def pack_connectivity(vertices: int, faces: IntArray) -> bytes:
    """Return the payload of the section for `sorted_faces`."""
    given = faces.astype(np.int64)
    ends: NDArray[np.int64] = np.roll(given, -1, axis=1).reshape(-1)
    keys = given.reshape(-1) * vertices + ends
    owners = np.argsort(keys, kind="stable")
    # a face takes a few decisions, and an index at most 64 bits
    stream = Stream(kernels.CONNECTIVITY_SLOTS, room=64 + 40 * len(faces))
    coded = np.zeros_like(given)
    kernels.code_faces(*stream.parts, vertices, coded, given, keys[owners], owners)
    return stream.finished()


def unpack_connectivity(payload: memoryview, vertices: int, faces: int) -> IntArray:
    """Read the section.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` naming the section.
    """
    stream = Stream(kernels.CONNECTIVITY_SLOTS, data=payload)
    coded = np.zeros((faces, 3), dtype=np.int64)
    nothing = np.zeros(0, dtype=np.int64)
    if not kernels.code_faces(*stream.parts, vertices, coded, np.zeros((0, 3), dtype=np.int64), nothing, nothing):
        raise damaged(CONNECTIVITY, "leads to vertices that are not there")
    stream.check_end(CONNECTIVITY)
    return sorted_faces(coded.astype(np.int32))
