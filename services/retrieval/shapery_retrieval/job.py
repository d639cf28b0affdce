"""The ``shape-index`` and ``shape-search`` jobs: thin adapters from files and a job's context to the algorithms."""

from __future__ import annotations

import importlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from shapery_contracts.errors import InvalidInput, Unavailable
from shapery_contracts.handler import JobContext
from shapery_contracts.retrieval import (
    By,
    IndexStage,
    Nearest,
    ShapeBank,
    ShapeIndexParams,
    ShapeIndexResult,
    ShapeSearchParams,
    ShapeSearchResult,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from shapery_retrieval.arg import Arg
    from shapery_retrieval.laid_out import Searchers
    from shapery_retrieval.patches import Patches
    from shapery_retrieval.search import Hit

    PartNumbers = Sequence[NDArray[np.int64]]

_FRACTIONS = {"normalise": 0.05, "describe": 0.15, "decompose": 0.6, "views": 0.75, "patches": 0.82}
WRITE = 0.85

CANDIDATES = 600
"""So many shapes, nearest by their vectors, are compared by all cues: a `shapery_retrieval.ranking.NEIGHBOURHOOD`."""
PARTIAL_CANDIDATES = 1200
"""So many shapes, nearest by the vectors of their parts, are compared with a part by all patches; these vectors are
coarser than those of wholes."""


@dataclass(frozen=True, eq=False)
class Query:
    """What is searched with.

    Attributes
    ----------
    arg
        Its graph.
    numbers
        For each level what its parts are called in the hits; by default by their place.
    hypotheses
        Of a part; see `shapery_retrieval.search.Searcher.search`.
    vector
        Its vector, where it is known.
    """

    arg: Arg
    numbers: PartNumbers | None = None
    hypotheses: Sequence[Patches] = ()
    vector: NDArray[np.float64] | None = None


class ShapeIndexHandler:
    """Input ``mesh``; artifacts as `shapery_contracts.retrieval.ShapeIndexResult` names them."""

    kind: ClassVar[str] = "shape-index"

    def load(self) -> None:
        """Import the numerics; a worker does it once, before it forks a process for each job."""
        for module in ("shapery_geometry.mesh_io", "shapery_retrieval.describe", "shapery_retrieval.report"):
            importlib.import_module(module)

    def run(self, params: ShapeIndexParams, inputs: Mapping[str, Path], context: JobContext) -> ShapeIndexResult:
        """See `shapery_contracts.handler.JobHandler.run`."""
        # Imported here: whoever only looks for the handler loads no numerics.
        from shapery_geometry.mesh_io import read_mesh
        from shapery_retrieval.describe import describe
        from shapery_retrieval.report import write_outputs, write_report

        if "mesh" not in inputs:
            raise InvalidInput("missing_input", "The mesh is missing.")
        context.stage("read", 0.0)
        start = time.perf_counter()
        mesh = read_mesh(inputs["mesh"])
        reading = IndexStage(name="read", seconds=round(time.perf_counter() - start, 4))

        def on_stage(name: str) -> None:
            context.check_cancelled()
            context.stage(name, _FRACTIONS[name])

        found = describe(mesh, on_stage=on_stage)
        context.check_cancelled()
        context.stage("write", WRITE)
        start = time.perf_counter()
        result = write_outputs(mesh, found, context.output, params.preview_size)
        writing = IndexStage(name="write", seconds=round(time.perf_counter() - start, 4))
        # the report tells how long writing took, so it is written once more, last
        result = result.model_copy(update={"stages": [reading, *result.stages, writing]})
        write_report(result, context.output)
        context.progress(1.0)
        return result


class ShapeSearchHandler:
    """Input ``mesh``, or a stored shape named in the parameters; the bank comes with the context.

    Artifacts: ``results.json``; of a mesh also ``mesh.glb`` and ``components.json``, as `ShapeIndexHandler` leaves
    them, so that a viewer can show what was matched with what.
    """

    kind: ClassVar[str] = "shape-search"

    def __init__(self) -> None:
        self._searchers: Searchers | None = None

    def load(self) -> None:
        """Import the numerics; a worker does it once, before it forks a process for each job."""
        for module in ("shapery_geometry.mesh_io", "shapery_retrieval.describe", "shapery_retrieval.laid_out"):
            importlib.import_module(module)

    def run(self, params: ShapeSearchParams, inputs: Mapping[str, Path], context: JobContext) -> ShapeSearchResult:
        """See `shapery_contracts.handler.JobHandler.run`."""
        bank = context.bank
        if bank is None:
            raise Unavailable("service_unavailable", "There is no shape database here to search in.")
        seconds: dict[str, float] = {}
        start = time.perf_counter()
        context.stage("read", 0.0)
        if self._searchers is None:
            from shapery_retrieval.laid_out import Searchers

            self._searchers = Searchers()  # a process that answers many queries asks this very handler
        query = query_for(params, inputs.get("mesh"), bank, context, self._searchers)
        seconds["index"] = time.perf_counter() - start
        result = search_bank(query, params, bank, context, seconds, self._searchers)
        context.stage("write", 0.98)
        (context.output / "results.json").write_text(result.model_dump_json(indent=2))
        context.progress(1.0)
        return result


def query_for(
    params: ShapeSearchParams,
    mesh_file: Path | None,
    bank: ShapeBank,
    context: JobContext | None,
    searchers: Searchers,
) -> Query:
    """Return what is searched with: a mesh or a stored shape, whole or a region of it.

    Parameters
    ----------
    params
        What is asked.
    mesh_file
        The mesh to query by, or that of the stored shape where faces of it are; None for a stored shape.
    bank
        Where a stored shape is.
    context
        For progress, and for what viewers need of a mesh; may be None.
    searchers
        What earlier queries have read.

    Raises
    ------
    InvalidInput
        ``missing_input`` with neither mesh nor shape, ``not_found`` for a shape that is not there, ``invalid_params``
        for faces or parts that are not there, and what `shapery_retrieval.describe.describe` refuses.
    """
    from shapery_geometry.mesh_io import read_mesh
    from shapery_retrieval.describe import describe
    from shapery_retrieval.report import write_views
    from shapery_retrieval.search import parts_in, region_of

    shares: list[NDArray[np.float64]] | None = None
    hypotheses: Sequence[Patches] = ()
    vector: NDArray[np.float64] | None = None
    if params.shape_id is not None and not (params.region is not None and mesh_file is not None):
        if params.region is not None:
            raise InvalidInput(
                "invalid_params",
                "A region is of the faces of a mesh, which was not given.",
                "Give the mesh itself, or name parts of the shape.",
            )
        stored = searchers.stored(bank, params.shape_id)
        if stored is None:
            raise InvalidInput("not_found", f"There is no shape {params.shape_id!r} in the bank.")
        query, vector = stored.arg, stored.vector
    elif mesh_file is not None:
        mesh = read_mesh(mesh_file)
        if context is not None:
            context.check_cancelled()
            context.stage("index", 0.05)
        found = describe(mesh)
        if context is not None:
            write_views(mesh, found, context.output)
        query = found.arg
        if params.region is not None:
            shares = found.region_shares(mesh, params.region)
        elif params.mode == "partial" and params.parts is None:
            hypotheses = found.hypotheses()
    else:
        raise InvalidInput("missing_input", "Give a mesh, or name a stored shape.")
    if params.parts is not None:
        shares = _shares_of_parts(query, params.parts)
    if shares is None:
        return Query(query, hypotheses=hypotheses, vector=vector)
    return Query(region_of(query, shares), parts_in(query, shares))


def search_bank(
    query: Query,
    params: ShapeSearchParams,
    bank: ShapeBank,
    context: JobContext | None,
    seconds: dict[str, float],
    searchers: Searchers | None = None,
) -> ShapeSearchResult:
    """Search a bank.

    Parameters
    ----------
    query
        Whole, or cut down to a region.
    params
        What is asked; the query is not looked for again.
    bank
        Where.
    context
        For progress; may be None.
    seconds
        Time of earlier stages.
    searchers
        What earlier queries have read; none where the ids of the bank may come to mean other graphs.
    """
    from shapery_retrieval.coverage import asked_of
    from shapery_retrieval.laid_out import GoneError, Searchers
    from shapery_retrieval.patches import patches_of
    from shapery_retrieval.vector import vector_of

    partial = params.mode == "partial" or params.region is not None or params.parts is not None

    def stage(name: str, fraction: float) -> float:
        if context is not None:
            context.check_cancelled()
            context.stage(name, fraction)
        return time.perf_counter()

    start = stage("candidates", 0.6)
    version = query.arg.index_version
    by: By = "parts" if partial else "whole"
    hypotheses = query.hypotheses or [patches_of(query.arg)]
    known = vector_of(query.arg) if query.vector is None and not partial else query.vector
    vector = asked_of(hypotheses) if known is None or partial else known
    limit = max(PARTIAL_CANDIDATES if partial else CANDIDATES, 2 * params.limit)
    near = bank.candidates(Nearest(vector=vector.tolist(), limit=limit, by=by, only=params.filter, version=version))
    seconds["candidates"] = time.perf_counter() - start
    start = stage("match", 0.7)
    searchers = searchers or Searchers()
    while True:
        searcher = searchers.over(bank, near, version)
        try:
            answer = searcher.search(
                query.arg,
                limit=params.limit,
                exclude=params.shape_id,
                partial=partial,
                rerank=params.rerank,
                hypotheses=hypotheses,
                vector=None if partial else vector,
            )
            break
        except GoneError as error:
            near = [candidate for candidate in near if candidate.shape_id not in error.ids]
    seconds["match"] = time.perf_counter() - start
    # validated all at once: models made one by one would cost more than the matching
    return ShapeSearchResult.model_validate(
        {
            "index_version": version,
            "mode": "partial" if partial else "global",
            "candidates": answer.compared,
            "cues": {name: round(weight, 4) for name, weight in answer.cues.items()},
            "hits": [_told(hit, query.numbers) for hit in answer.hits],
            "stages": [{"name": name, "seconds": round(value, 4)} for name, value in seconds.items()],
        }
    )


def _told(hit: Hit, numbers: PartNumbers | None) -> dict[str, Any]:
    """Return a `ShapeHit`, to be validated."""
    best = next(level for level in hit.match.levels if level.level == hit.match.best_level)
    called = None if numbers is None else numbers[best.level].tolist()
    return {
        "shape_id": hit.shape_id,
        "score": min(max(hit.score, 0.0), 1.0),
        "level": best.level,
        "level_scores": [round(level.score, 6) for level in hit.match.levels],
        "matches": [
            {"query": i if called is None else called[i], "found": j, "weight": round(w, 6)} for i, j, w in best.pairs()
        ],
        "cells": _called(hit.match.overlaid, None if numbers is None else numbers[-1]),
    }


def _called(parts: NDArray[np.int64], numbers: NDArray[np.int64] | None) -> list[int]:
    """Return what parts are called; −1, which is of no part, stays."""
    found: list[int] = parts.tolist()
    if numbers is None:
        return found
    names = [*numbers.tolist(), -1]
    return [names[part] for part in found]


def _shares_of_parts(arg: Arg, parts: list[int]) -> list[NDArray[np.float64]]:
    """For each level the share of every part that the given parts of the finest level make up."""
    import numpy as np

    finest = arg.levels[-1]
    if max(parts) >= finest.parts:
        raise InvalidInput("invalid_params", f"The query has {finest.parts} parts, numbered from 0.")
    share = np.zeros(finest.parts)
    share[parts] = 1.0
    shares = [share]
    masses = finest.masses.astype(np.float64)
    for below, above in zip(arg.levels[:0:-1], arg.levels[-2::-1], strict=True):
        covered = np.bincount(below.parents, weights=masses * share, minlength=above.parts)
        share = covered / np.maximum(np.bincount(below.parents, weights=masses, minlength=above.parts), 1e-12)
        masses = above.masses.astype(np.float64)
        shares.insert(0, share)
    return shares
