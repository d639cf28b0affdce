"""How the work of a job becomes what the platform keeps: its end, and with a ``shape-index`` job its shape, at once.

Both are written in one transaction under the job's lease, and a job ends once: however often a worker was killed in
between, a job gives one shape, and a shape of a job that did not end well is never seen.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import Any

from sqlalchemy.orm import Session

from shapery_contracts.retrieval import ShapeIndexParams, ShapeIndexResult
from shapery_contracts.states import JobState
from shapery_platform import assets, jobs
from shapery_platform.db import new_id, utc_now
from shapery_platform.db.repositories import blobs as blob_repository
from shapery_platform.db.repositories import collections as collection_repository
from shapery_platform.db.repositories import shapes as repository
from shapery_platform.db.text import storable
from shapery_platform.db.types import pack_vector
from shapery_platform.jobs import ClaimedJob, NewArtifact
from shapery_platform.shapes import FILES

LARGEST_GRAPH = 16 << 20
"""Bytes of a graph that the bank takes; usual ones have some tens of kilobytes."""
_LARGEST_NUMBER = 65504.0
"""The largest number of 16 bits, in which PostgreSQL keeps vectors."""
_NOT_TOLD = {"vector", "part_vector", "arg", "arg_bytes", "index_version", "stages"}
"""Parts of a result that a shape has in columns of its own, or that are about the job."""


@dataclass(frozen=True, slots=True)
class NewShape:
    """A shape that waits to be written together with the end of its job."""

    params: ShapeIndexParams
    result: ShapeIndexResult
    graph: bytes


def read_shape(job: ClaimedJob, result: Mapping[str, Any], output: Path) -> NewShape | None:
    """Return the shape that a job has left in its output folder, or None where its kind makes none.

    Raises
    ------
    ValueError
        There is no graph, one that is too large, or a vector that says nothing: a defect of the handler.
    """
    if job.kind != "shape-index":
        return None
    checked = ShapeIndexResult.model_validate(result)
    for vector in (checked.vector, checked.part_vector):
        if not any(vector) or not all(math.isfinite(x) and abs(x) <= _LARGEST_NUMBER for x in vector):
            raise ValueError("the vectors of a shape must have finite numbers, not all of them zero")
    missing = [name for name in (checked.arg, *FILES) if not (output / name).is_file()]
    if missing:
        raise ValueError(f"the shape lacks its {', '.join(missing)}")
    size = (output / checked.arg).stat().st_size
    if not 0 < size <= LARGEST_GRAPH:
        raise ValueError(f"the graph has {size} bytes")
    return NewShape(ShapeIndexParams.model_validate(job.params), checked, (output / checked.arg).read_bytes())


def succeed(
    session: Session,
    job: ClaimedJob,
    result: Mapping[str, Any],
    artifacts: Sequence[NewArtifact],
    shape: NewShape | None,
) -> JobState | None:
    """End a job with its result and artifacts, and put its shape into the bank; see `jobs.succeed`.

    A shape that the job was to index again and that was deleted meanwhile does not come back. One that was made of
    another mesh stays as it is, and the job fails: under its id a shape is always of the same mesh, so that whoever
    keeps a graph need not ask whether it still holds.

    Returns
    -------
    The state in which the job ends, or None as `jobs.succeed` is False.
    """
    if shape is None:
        done = jobs.succeed(session, job.job_id, job.lease, result, artifacts)
        return JobState.SUCCEEDED if done else None
    # The bank's row first, as all do who change shapes.
    revision = repository.change_bank(session, job.owner)
    replaced = shape.params.replaces
    known = None if replaced is None else repository.find(session, job.owner, replaced)
    if known is not None and not assets.have_same_content(session, [known.asset_id, job.inputs["mesh"][0].asset_id]):
        message = f"The shape {known.id} was made of another mesh."
        hint = "Index this mesh as a new shape, and delete the other one."
        done = jobs.fail(session, job.job_id, job.lease, "conflict", message, hint)
        return JobState.FAILED if done else None
    if not jobs.succeed(session, job.job_id, job.lease, result, artifacts):
        return None
    values = {
        "job_id": job.job_id,
        "asset_id": job.inputs["mesh"][0].asset_id,
        "index_version": shape.result.index_version,
        "revision": revision,
        "vector": pack_vector(shape.result.vector),
        "part_vector": pack_vector(shape.result.part_vector),
        "report": shape.result.model_dump(mode="json", exclude=_NOT_TOLD),
        "arg_sha256": hashlib.sha256(shape.graph).hexdigest(),
        "arg_size": len(shape.graph),
        "indexed_at": utc_now(),
    }
    if replaced is None:
        shape_id = _add(session, job, shape, values)
    elif known is None or known.index_version > shape.result.index_version:
        return JobState.SUCCEEDED
    else:
        shape_id = known.id
        repository.replace(session, shape_id, values, shape.graph)
    files = [
        {"name": file.name, "sha256": file.sha256, "size": file.size, "media_type": file.media_type}
        for file in artifacts
        if file.name in FILES
    ]
    blob_repository.mark(session, repository.put_files(session, shape_id, files), utc_now())
    return JobState.SUCCEEDED


def _add(session: Session, job: ClaimedJob, shape: NewShape, values: Mapping[str, Any]) -> Any:
    params = shape.params
    file = job.inputs["mesh"][0]
    name = params.name or storable(PurePath(file.filename).name.removesuffix(file.extension), 255) or "shape"
    row = {
        **values,
        "id": new_id(),
        "owner": job.owner,
        "collection_id": collection_repository.ensure(session, job.owner, params.collection),
        "name": name,
        "details": params.metadata,
        "created_at": values["indexed_at"],
    }
    repository.add(session, row, shape.graph)
    repository.put_labels(session, row["id"], params.labels)
    return row["id"]
