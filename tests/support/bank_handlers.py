"""A plugin whose handlers index and search without numerics: a mesh is a number, told by its last vertex.

Named in ``SHAPERY_PLUGINS`` they take the place of the real ones. What a job is asked to do besides is told in its
parameters: ``metadata`` of an indexing job, ``parts`` of a search.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from shapery_contracts.errors import InvalidInput
from shapery_contracts.handler import JobContext
from shapery_contracts.retrieval import (
    INDEX_VERSION,
    Nearest,
    ShapeHit,
    ShapeIndexParams,
    ShapeIndexResult,
    ShapeSearchParams,
    ShapeSearchResult,
)
from shapery_worker.handlers import register_handler
from tests.support import shapes as fake
from tests.support.probe import claim_file

MODULE = "tests.support.bank_handlers"
SLEEP, KILL = 10, 20
"""As the first of a search's parts: sleep so many tenths of a second as the second one says, or kill the process."""


def seed_of_mesh(path: Path) -> int:
    """Return the number of a mesh made by `tests.support.gateway.triangle`."""
    (last,) = [line for line in path.read_text().splitlines() if line.startswith("v 0 1 ")]
    return int(last.split()[3])


class IndexHandler:
    """Makes a shape of a number."""

    kind: ClassVar[str] = "shape-index"

    def run(self, params: ShapeIndexParams, inputs: Mapping[str, Path], context: JobContext) -> ShapeIndexResult:
        context.stage("read", 0.1)
        seed = seed_of_mesh(inputs["mesh"])
        fake.leave(context.output, seed)
        once = params.metadata.get("kill_once")
        if once is not None and claim_file(Path(once)):
            victim = os.getppid() if params.metadata["victim"] == "watcher" else os.getpid()
            os.kill(victim, signal.SIGKILL)
            time.sleep(60)
        return fake.result(seed)


class SearchHandler:
    """Finds the numbers that differ in the fewest digits."""

    kind: ClassVar[str] = "shape-search"

    def run(self, params: ShapeSearchParams, inputs: Mapping[str, Path], context: JobContext) -> ShapeSearchResult:
        bank = context.bank
        assert bank is not None
        match params.parts:
            case [10, tenths]:
                for _ in range(tenths):
                    time.sleep(0.1)
                    context.check_cancelled()
            case [20]:
                os.kill(os.getpid(), signal.SIGKILL)
        if "mesh" in inputs:
            seed = seed_of_mesh(inputs["mesh"])
        else:
            graphs = bank.args([params.shape_id or ""])
            if not graphs:
                raise InvalidInput("not_found", f"There is no shape {params.shape_id}.")
            (graph,) = graphs.values()
            seed = fake.seed_of(graph)
        near = bank.candidates(Nearest(vector=fake.vector(seed), limit=params.limit + 1, only=params.filter))
        near = [candidate for candidate in near if candidate.shape_id != params.shape_id][: params.limit]
        known = bank.args(candidate.shape_id for candidate in near)
        hits = [
            ShapeHit(
                shape_id=candidate.shape_id,
                score=1 / (1 + fake.distance(seed, fake.seed_of(known[candidate.shape_id]))),
                level=0,
                level_scores=[1.0],
                matches=[],
            )
            for candidate in near
            if candidate.shape_id in known
        ]
        (context.output / "report.json").write_text("{}")
        return ShapeSearchResult(
            index_version=INDEX_VERSION, mode=params.mode, candidates=len(near), cues={}, hits=hits, stages=[]
        )


register_handler(IndexHandler())
register_handler(SearchHandler())
