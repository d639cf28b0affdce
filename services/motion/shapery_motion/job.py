"""The ``motion-encode`` and ``motion-decode`` jobs: thin adapters from files and a job's context to the codec."""

from __future__ import annotations

import importlib
import time
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from shapery_contracts.errors import InvalidInput
from shapery_contracts.handler import JobContext
from shapery_contracts.motion import (
    MotionDecodeParams,
    MotionDecodeResult,
    MotionEncodeParams,
    MotionEncodeResult,
)
from shapery_contracts.segmentation import StageTime


class MotionEncodeHandler:
    """Input ``sequence``; outputs the motion, a report with its pictures, and residuals (`report`, `residuals`)."""

    kind: ClassVar[str] = "motion-encode"

    def load(self) -> None:
        """Import the numerics; a worker does it once, before it forks a process for each job."""
        for module in ("shapery_motion.reading", "shapery_motion.report", "shapery_motion.trajectory.profile"):
            importlib.import_module(module)

    def run(self, params: MotionEncodeParams, inputs: Mapping[str, Path], context: JobContext) -> MotionEncodeResult:
        """See `shapery_contracts.handler.JobHandler.run`."""
        # Imported here: whoever only looks for the handler loads no numerics.
        from shapery_motion.codec import encode, shape_of
        from shapery_motion.playing import open_motion
        from shapery_motion.reading import open_motion_input
        from shapery_motion.report import (
            CLUSTERS_FILE,
            MOTION_FILE,
            describe,
            summary,
            write_clusters,
            write_pictures,
            write_report,
        )
        from shapery_motion.residuals import RESIDUALS_FILE, ResidualWriter

        if "sequence" not in inputs:
            raise InvalidInput("missing_input", "The sequence is missing.")
        stages = _Stages(context)
        stages.begin("read", 0.0)
        sequence = open_motion_input(inputs["sequence"])
        residuals = ResidualWriter(context.output / RESIDUALS_FILE, *shape_of(sequence))
        encoding = encode(
            sequence,
            params,
            on_progress=stages.begin,
            check_cancelled=context.check_cancelled,
            on_verified=residuals.add,
        )
        residuals.close()
        stages.begin("write", 0.98)
        (context.output / MOTION_FILE).write_bytes(encoding.data)
        motion = open_motion(encoding.data)
        write_clusters(context.output / CLUSTERS_FILE, motion.frame(0), motion.faces, encoding.labels)
        report = describe(encoding, params, stages.finished())
        write_report(report, context.output)
        write_pictures(report, motion.frame(0), motion.faces, encoding.labels, context.output)
        context.progress(1.0)
        return summary(report)


class MotionDecodeHandler:
    """Input ``motion``; output as `shapery_motion.exporting.FILE_NAMES` names it."""

    kind: ClassVar[str] = "motion-decode"

    def load(self) -> None:
        """Import the numerics; a worker does it once, before it forks a process for each job."""
        for module in ("shapery_motion.exporting", "shapery_motion.report", "shapery_motion.trajectory.profile"):
            importlib.import_module(module)

    def run(self, params: MotionDecodeParams, inputs: Mapping[str, Path], context: JobContext) -> MotionDecodeResult:
        """See `shapery_contracts.handler.JobHandler.run`."""
        from shapery_motion.exporting import FILE_NAMES, export
        from shapery_motion.playing import open_motion
        from shapery_motion.report import versions

        if "motion" not in inputs:
            raise InvalidInput("missing_input", "The motion file is missing.")
        stages = _Stages(context)
        stages.begin("read", 0.0)
        motion = open_motion(inputs["motion"])
        stages.begin("decode", 0.05)
        path = context.output / FILE_NAMES[params.format]

        def report(fraction: float) -> None:
            context.check_cancelled()
            context.progress(0.05 + 0.9 * fraction)

        export(
            motion,
            path,
            params.format,
            scratch=context.scratch,
            first=params.first,
            stop=params.stop,
            on_progress=report,
        )
        context.progress(1.0)
        return MotionDecodeResult(
            file=path.name,
            format=params.format,
            first=params.first,
            frames=(len(motion) if params.stop is None else min(params.stop, len(motion))) - params.first,
            vertices=motion.header.vertices,
            faces=motion.header.faces,
            bytes=path.stat().st_size,
            stages=stages.finished(),
            versions=versions(),
        )


class _Stages:
    """Tell the context of each stage as it begins, and keep how long each took."""

    def __init__(self, context: JobContext) -> None:
        self._context = context
        self._times: list[StageTime] = []
        self._name = ""
        self._start = time.perf_counter()

    def begin(self, name: str, fraction: float) -> None:
        """Say how far the work is, and that a stage begins if `name` is a new one."""
        if name == self._name:
            self._context.progress(fraction)
            return
        self._end()
        self._name, self._start = name, time.perf_counter()
        self._context.stage(name, fraction)

    def finished(self) -> list[StageTime]:
        """End the last stage and return the times of all."""
        self._end()
        self._name = ""
        return self._times

    def _end(self) -> None:
        if self._name:
            self._times.append(StageTime(name=self._name, seconds=round(time.perf_counter() - self._start, 4)))
