"""Residuals: what an encoding changed, vertex by vertex, so that viewers can show the original and the error.

``residuals.bin.gz`` is a gzip stream: the magic ``SMR1``, frames and vertices (uint32), the step (float32), all
little-endian, then for each frame and vertex three int8: the original less the decoded position, in steps. The largest
error of the sequence is 127 steps, so that an original is known to half a 127th of it.
"""

from __future__ import annotations

import gzip
import struct
from pathlib import Path
from typing import Final

import numpy as np

from shapery_motion.errors import SequenceErrors
from shapery_motion.playing import FrameArray

RESIDUALS_FILE: Final = "residuals.bin.gz"
MOST_BYTES: Final = 192 << 20
"""Without compression; longer sequences get no residuals."""


class ResidualWriter:
    """Writes the residuals of one frame after the other, in memory that does not grow."""

    def __init__(self, path: Path, frames: int, vertices: int) -> None:
        self.wanted = 3 * frames * vertices <= MOST_BYTES
        self._frames, self._vertices = frames, vertices
        self._file = gzip.GzipFile(path, "wb", compresslevel=4, mtime=0) if self.wanted else None
        self._step = 0.0

    def add(self, errors: SequenceErrors, original: FrameArray, decoded: FrameArray) -> None:
        """Write a frame; `errors` are those of the whole sequence."""
        if self._file is None:
            return
        if not self._step:
            self._step = max(float(errors.frame_largest.max()) / 127.0, 1e-30)
            self._file.write(struct.pack("<4s2If", b"SMR1", self._frames, self._vertices, self._step))
        difference = np.asarray(original, dtype=np.float64) - decoded
        self._file.write(np.rint(np.clip(difference / self._step, -127, 127)).astype(np.int8).tobytes())

    def close(self) -> None:
        """End the file."""
        if self._file is not None:
            self._file.close()
