"""The ``segmentation`` job: a thin adapter from files and a job's context to `shapery_segmentation.segment`."""

from __future__ import annotations

import importlib
import time
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from shapery_contracts.errors import InvalidInput
from shapery_contracts.handler import JobContext
from shapery_contracts.segmentation import SegmentationParams, SegmentationResult, StageTime

READ, WORK = 0.1, 0.85
"""Fractions of a whole job: reading the volumes, and everything before the results are written."""


class SegmentationHandler:
    """Inputs ``post``, if given ``pre`` and ``vessels``; outputs as `shapery_segmentation.write_outputs` names them.

    Its preview is an evolution (``api_schema/evolution.md``) with one frame per object: each surface as it is just now.
    """

    kind: ClassVar[str] = "segmentation"

    def load(self) -> None:
        """Import the numerics; a worker does it once, before it forks a process for each job."""
        for module in ("shapery_geometry.volume_io", "shapery_segmentation.pipeline", "shapery_segmentation.report"):
            importlib.import_module(module)

    def run(self, params: SegmentationParams, inputs: Mapping[str, Path], context: JobContext) -> SegmentationResult:
        """See `shapery_contracts.handler.JobHandler.run`."""
        # Imported here: whoever only looks for the handler loads no numerics.
        from dataclasses import replace

        from shapery_geometry.concurrent import at_once
        from shapery_geometry.volume_io import read_volume
        from shapery_segmentation.evolution import evolution_bytes
        from shapery_segmentation.pipeline import segment
        from shapery_segmentation.report import write_outputs, write_report

        if "post" not in inputs:
            raise InvalidInput("missing_input", "The volume after contrast (post) is missing.")
        context.stage("read", 0.0)
        start = time.perf_counter()
        names = [name for name in ("post", "pre", "vessels") if name in inputs]
        read = at_once(lambda name: read_volume(inputs[name]), names)
        volumes = dict(zip(names, read, strict=True))
        context.check_cancelled()
        context.progress(READ)
        reading = StageTime(name="read", seconds=round(time.perf_counter() - start, 4))

        stage = ""

        def on_progress(name: str, fraction: float, message: str) -> None:
            nonlocal stage
            if name != stage:
                stage = name
                context.stage(name, READ + (WORK - READ) * fraction, message)
            else:
                context.progress(READ + (WORK - READ) * fraction, message)

        result = segment(
            volumes["post"],
            volumes.get("pre"),
            volumes.get("vessels"),
            params=params,
            on_progress=on_progress,
            check_cancelled=context.check_cancelled,
            on_surfaces=lambda frames: context.preview(lambda: evolution_bytes(frames)),
        )
        context.stage("write", WORK)
        start = time.perf_counter()
        result = replace(result, report=result.report.model_copy(update={"stages": [reading, *result.report.stages]}))
        write_outputs(result, context.output)
        writing = StageTime(name="write", seconds=round(time.perf_counter() - start, 4))
        # The report tells how long writing took, so it is written once more, last.
        report = result.report.model_copy(update={"stages": [*result.report.stages, writing]})
        write_report(replace(result, report=report), context.output)
        context.progress(1.0)
        return report
