"""The profile ``gradient``: the dissertation's codec in groups of a motion file."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import IntArray
from shapery_motion.container.sections import damaged
from shapery_motion.gradient.deformation import FloatArray
from shapery_motion.gradient.encoder import encode_frames
from shapery_motion.gradient.group import Group, PredictedFrame
from shapery_motion.gradient.sections import FRAMES, LABELS, PART_NAMES, declared_memory, read_group, table_of
from shapery_motion.gradient.traversal import traverse
from shapery_motion.profiles import EncodedGroup, GroupTask


def encode_group(task: GroupTask) -> EncodedGroup:
    """Encode a group of frames so that its bounds hold for what `open_group` gives."""
    encoded = encode_frames(task)
    table = table_of(dict(encoded.sections)[FRAMES], len(task.frames))
    return EncodedGroup(
        sections=encoded.sections,
        memory=declared_memory(task.frames.shape[1], len(task.faces), table),
        labels=_vertex_labels(encoded.group, task.frames.shape[1]),
        points=((float(encoded.squared.sum()), encoded.size),),
        part_names=PART_NAMES,
    )


def open_group(
    sections: Mapping[str, memoryview], frames: int, vertices: int, faces: IntArray, memory: int
) -> OpenGradientGroup:
    """Decode the streams of a group; its frames are predicted when they are asked for.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` naming the section.
    """
    group = read_group(sections, frames, vertices, faces, memory, traverse(faces, vertices))
    return OpenGradientGroup(group)


class OpenGradientGroup:
    """A group whose streams were decoded."""

    def __init__(self, group: Group) -> None:
        self._group = group

    def frame(self, index: int) -> FloatArray:
        """Return the vertices (n, 3) of a frame by its number within the group.

        Raises
        ------
        InvalidInput
            ``corrupt_file`` where the frame's equations have no solution.
        """
        try:
            return self._group.frame(index)
        except (InvalidInput, RuntimeError) as error:
            # a part without an anchor, or a matrix that is singular: no encoder writes that
            raise damaged(LABELS, f"does not determine frame {index}: {error}") from error


def _vertex_labels(group: Group, vertices: int) -> IntArray:
    """(n,) the cluster of one of each vertex's faces in the first frame that is predicted."""
    result = np.zeros(vertices, dtype=np.int32)
    for frame in group.frames:
        if isinstance(frame, PredictedFrame):
            result[group.faces] = frame.labels[:, None]
            break
    return result
