"""Sequences as the codec takes them: whole, and without a gap in the numbering of their files."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from pathlib import Path

from shapery_contracts.errors import InvalidInput
from shapery_geometry.sequence import SequenceFile, SequenceLimits, open_sequence


def open_motion_input(path: Path | str, *, limits: SequenceLimits | None = None) -> SequenceFile:
    """Open a sequence; see `shapery_geometry.sequence.open_sequence`.

    Raises
    ------
    InvalidInput
        Also ``inconsistent_sequence`` where a number is missing among the files' names.
    """
    sequence = open_sequence(path, limits=limits)
    check_numbering(sequence.names)
    return sequence


def check_numbering(names: Sequence[str]) -> None:
    """Refuse names that count frames and leave one out.

    Names count if they differ in one number only; the step from frame to frame may be any, the same throughout.

    Raises
    ------
    InvalidInput
        ``inconsistent_sequence``, naming the first frame that is missing.
    """
    parts = [re.split(r"([0-9]+)", name) for name in names]
    if len(parts) < 3 or len({len(p) for p in parts}) > 1:
        return
    varying = [k for k, values in enumerate(zip(*parts, strict=True)) if len(set(values)) > 1]
    if len(varying) != 1 or varying[0] % 2 == 0:
        return
    at = varying[0]
    numbers = [int(p[at]) for p in parts]
    steps = [after - before for before, after in itertools.pairwise(numbers)]
    # of equally frequent steps the smaller: one frame of three that is missing leaves a step of 1 and one of 2
    step = min(set(steps), key=lambda s: (-steps.count(s), s))
    for before, gap, left, right in zip(numbers, steps, names[:-1], names[1:], strict=False):
        if gap > step > 0:
            digits = len(parts[0][at]) if parts[0][at].startswith("0") else 0
            missing = "".join([*parts[0][:at], str(before + step).zfill(digits), *parts[0][at + 1 :]])
            raise InvalidInput(
                "inconsistent_sequence",
                f"A frame is missing from the numbering: after {left!r} comes {right!r}, and {missing!r} is not there.",
                "Add the missing frames, or number the files without gaps.",
            )
