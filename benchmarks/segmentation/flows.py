"""What the normal flow is given and what it takes, seen from outside while `segment` runs."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_segmentation import objects
from shapery_segmentation.flow.params import NormalFlowParams


@dataclass(frozen=True)
class FlowCall:
    """One flow: its input, its CPU seconds without and with the frames kept to be watched, and how it ended."""

    field: NDArray[np.float32]
    allowed: NDArray[np.bool_]
    affine: NDArray[np.float64]
    seed: TriangleMesh
    threshold: float
    params: NormalFlowParams
    cpu_seconds: float
    watched_seconds: float
    iterations: int
    vertices: int


@contextmanager
def recorded(**changes: Any) -> Iterator[list[FlowCall]]:
    """Record every call of the normal flow that `segment` makes within, with some of its parameters changed."""
    calls: list[FlowCall] = []
    flow = objects.normal_flow

    def timed(field: Any, allowed: Any, affine: Any, seed: Any, params: Any, **options: Any) -> Any:
        told, watched = options.pop("on_iteration", None), 0.0

        def on_iteration(state: Any) -> None:
            nonlocal watched
            begin = time.process_time()
            if told is not None:
                told(state)
            watched += time.process_time() - begin

        start = time.process_time()
        result = flow(field, allowed, affine, seed, replace(params, **changes), on_iteration=on_iteration, **options)
        spent = time.process_time() - start
        calls.append(
            FlowCall(
                field=field,
                allowed=allowed,
                affine=affine,
                seed=seed,
                threshold=options["threshold"],
                params=replace(params, **changes),
                # Keeping frames to be watched is no part of the flow.
                cpu_seconds=spent - watched,
                watched_seconds=spent,
                iterations=result.iterations,
                vertices=len(result.mesh.vertices),
            )
        )
        return result

    with mock.patch.object(objects, "normal_flow", timed):
        yield calls
