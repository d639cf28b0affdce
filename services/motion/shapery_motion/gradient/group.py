"""A group of frames as it is stored: key frames in whole numbers, predicted frames as labels, matrices and anchors.

The encoder fills it and predicts from it, the decoder reads it and predicts from it: what both see is the same.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import IntArray
from shapery_motion.gradient.deformation import FaceFrames, FloatArray, face_frames
from shapery_motion.gradient.gluing import Gluing
from shapery_motion.gradient.traversal import Integers

FACTORS_KEPT: Final = 4
"""Factorised systems that a reader keeps: stepping through a group needs one, jumping between key frames more."""
SOLVER_BYTES: Final = 3000
"""What a factorised system takes for each vertex at most, as the memory of a group is declared."""


@dataclass(frozen=True, eq=False)
class KeyFrame:
    """A frame that is stored as it is, on a grid."""

    positions: Integers
    """(n, 3) whole multiples of the step."""
    anchors: IntArray
    """(a,) the vertices that predicted frames hold, the most needed first."""


@dataclass(frozen=True, eq=False)
class PredictedFrame:
    """A frame that is predicted from the key frame before it."""

    labels: NDArray[np.int32]
    """(m,) the cluster of each face."""
    matrices: Integers
    """(k, 9) the transformation of each cluster less the identity, in units of 2^-precision."""
    precision: int
    """How many binary digits behind the point the matrices have."""
    anchors: Integers
    """(a',) × 3 the positions of the first a' anchors of the key frame, in whole multiples of the step."""

    @property
    def transformations(self) -> FloatArray:
        """(k, 3, 3) the matrices."""
        return np.ldexp(self.matrices.astype(np.float64), -self.precision).reshape(-1, 3, 3) + np.eye(3)


@dataclass(eq=False)
class Group:
    """A run of frames of one connectivity; the first is a key frame.

    Parameters
    ----------
    faces : (m, 3) int32
    origin : (3,)
        The point of which whole multiples are counted.
    step
        The length of one multiple, in model units.
    """

    faces: IntArray
    origin: FloatArray
    step: float
    frames: list[KeyFrame | PredictedFrame] = field(default_factory=list)
    _factors: OrderedDict[tuple[int, int], Gluing] = field(default_factory=OrderedDict)
    _sources: dict[int, FaceFrames] = field(default_factory=dict)
    """The faces of the key frame that was used last, by its number."""

    def snapped(self, points: FloatArray) -> Integers:
        """Return the nearest whole multiples (…, 3) of the step."""
        return np.rint((points - self.origin) / self.step).astype(np.int64)

    def placed(self, multiples: Integers) -> FloatArray:
        """Return the points (…, 3) that whole multiples stand for."""
        return np.asarray(self.origin + self.step * multiples)

    def frame(self, index: int) -> FloatArray:
        """Return the vertices (n, 3) of a frame."""
        found = self.frames[index]
        if isinstance(found, KeyFrame):
            return self.placed(found.positions)
        return self.predicted(found, self.key_of(index))

    def key_of(self, index: int) -> int:
        """Return the number of the key frame that a frame is predicted from, or its own."""
        while not isinstance(self.frames[index], KeyFrame):
            index -= 1
        return index

    def predicted(self, frame: PredictedFrame, key: int) -> FloatArray:
        """Return the vertices (n, 3) of a frame that is predicted from key frame `key`."""
        system = self.system(key, len(frame.anchors))
        return system.solve(frame.labels, frame.transformations, self.placed(frame.anchors))

    def system(self, key: int, anchors: int) -> Gluing:
        """Return the factorised system of key frame `key` with its first anchors held."""
        name = (key, anchors)
        if name not in self._factors:
            stored = self.frames[key]
            assert isinstance(stored, KeyFrame)
            source = self._source(key, stored)
            self._factors[name] = Gluing(source, len(stored.positions), stored.anchors[:anchors]).factorise()
            while len(self._factors) > FACTORS_KEPT:
                self._factors.popitem(last=False)
        self._factors.move_to_end(name)
        return self._factors[name]

    def _source(self, key: int, stored: KeyFrame) -> FaceFrames:
        if key not in self._sources:
            self._sources = {key: face_frames(self.placed(stored.positions), self.faces)}
        return self._sources[key]
