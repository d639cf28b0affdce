"""Shapes without numerics: what a handler of ``shape-index`` leaves, made of a number, for tests of the bank."""

from __future__ import annotations

import hashlib
import json
import math
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from shapery_contracts.formats import AssetKind, FileFormat
from shapery_contracts.retrieval import INDEX_VERSION, VECTOR_DIMENSION, LevelSummary, ShapeIndexResult
from shapery_contracts.states import JobState
from shapery_platform import publication
from shapery_platform.db import Database
from shapery_platform.jobs import ClaimedJob, NewArtifact
from shapery_platform.storage import ObjectStore
from shapery_worker.publishing import media_type

MESH = FileFormat(kind=AssetKind.MESH, format="obj", media_type="model/obj", extension=".obj")


def vector(seed: int) -> list[float]:
    """Return a vector that 16 bits hold exactly: the binary digits of `seed`, then ones."""
    return [float(seed >> bit & 1) for bit in range(24)] + [1.0] * (VECTOR_DIMENSION - 24)


def part_vector(seed: int) -> list[float]:
    """Return the vector of parts, likewise: its digits are those of `seed` with the lowest one turned over."""
    return vector(seed ^ 1)


def distance(one: int, two: int) -> float:
    """Return how far apart the vectors of two seeds are."""
    return math.sqrt((one ^ two).bit_count())


def graph(seed: int) -> bytes:
    """Return bytes in the place of a graph."""
    return struct.pack("<I", seed) + hashlib.shake_256(str(seed).encode()).digest(2000)


def files(seed: int) -> dict[str, bytes]:
    """Return what the handler leaves, by name."""
    return {
        "shape.arg": graph(seed),
        "mesh.glb": b"glTF" + struct.pack("<I", seed),
        "preview.png": b"\x89PNG" + struct.pack("<I", seed),
        "components.json": json.dumps({"levels": [[0, seed]]}).encode(),
    }


def result(seed: int, **changed: Any) -> ShapeIndexResult:
    """Return what the handler says."""
    values: dict[str, Any] = {
        "index_version": INDEX_VERSION,
        "vector": vector(seed),
        "part_vector": part_vector(seed),
        "arg_bytes": len(graph(seed)),
        "vertices": 3,
        "faces": 1,
        "components": 1,
        "closed": False,
        "oriented": True,
        "genus": 0,
        "area": 0.5 + seed,
        "bounding_box": [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]],
        "changes": [],
        "levels": [LevelSummary(level=0, parts=1, masses=[1.0], parents=[], edges=[])],
        "stages": [],
    }
    return ShapeIndexResult.model_validate({**values, **changed})


def leave(folder: Path, seed: int) -> None:
    """Write the files into an output folder."""
    for name, data in files(seed).items():
        (folder / name).write_bytes(data)


def publish(
    database: Database, store: ObjectStore, job: ClaimedJob, folder: Path, seed: int, **changed: Any
) -> JobState | None:
    """End a claimed ``shape-index`` job as a worker does."""
    folder.mkdir(parents=True, exist_ok=True)
    leave(folder, seed)
    said: Mapping[str, Any] = result(seed, **changed).model_dump(mode="json")
    shape = publication.read_shape(job, said, folder)
    artifacts = []
    for name, data in files(seed).items():
        blob = store.put_bytes(data)
        artifacts.append(NewArtifact(name, blob.sha256, blob.size, media_type(name)))
    with database.session() as session:
        return publication.succeed(session, job, said, artifacts, shape)


def seed_of(graph_: bytes) -> int:
    """Return the number that a graph was made of."""
    return int(struct.unpack_from("<I", graph_)[0])
