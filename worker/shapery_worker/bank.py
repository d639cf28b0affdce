"""The shape database as a search reads it: `shapery_contracts.retrieval.ShapeBank` over the rows.

On SQLite the vectors of an owner are kept in memory, those of parts once they are asked for, and compared exactly; on
PostgreSQL the database finds the nearest ones by its index. Graphs are kept in memory on both, within bounds: under its
id and version a graph never changes. What is kept is brought up to date before each search by asking for the number of
the owner's last change, and reading what has changed since.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from uuid import UUID

import numpy as np
import numpy.typing as npt
from sqlalchemy.orm import Session

from shapery_contracts.retrieval import INDEX_VERSION, VECTOR_DIMENSION, By, Candidate, Nearest, ShapeBank, ShapeFilter
from shapery_platform.db import Database
from shapery_platform.db.repositories import bank as repository

DEFAULT_ROOM = 512 << 20
"""Bytes that are kept in memory, beyond those of the owner who searches."""
_MOST_FILTERS = 64
"""Of so many filters it is kept what they let through."""
_MARGIN = 64
"""So many more than are wanted are measured again in 64 bits, so that rounding does not decide who is among them."""


class VectorTable:
    """Vectors of one index version by the ids of their shapes."""

    def __init__(self) -> None:
        self.ids: list[UUID] = []
        self._texts: list[str] = []
        """The same, as candidates name them."""
        self._rows: dict[UUID, int] = {}
        self._vectors: npt.NDArray[np.float32] = np.empty((0, VECTOR_DIMENSION), np.float32)
        self._lengths: npt.NDArray[np.float32] = np.empty(0, np.float32)
        """Their squares."""

    @property
    def size(self) -> int:
        """Bytes in memory."""
        return self._vectors.nbytes + self._lengths.nbytes + 300 * len(self.ids)

    def put(self, shape_id: UUID, vector: bytes) -> None:
        """Add a vector, or replace the one that the shape has."""
        row = self._rows.get(shape_id)
        if row is None:
            row = self._rows[shape_id] = len(self.ids)
            self.ids.append(shape_id)
            self._texts.append(str(shape_id))
            if row == len(self._vectors):
                room = max(64, row + row // 2)
                vectors, lengths = np.empty((room, VECTOR_DIMENSION), np.float32), np.empty(room, np.float32)
                vectors[:row], lengths[:row] = self._vectors, self._lengths
                self._vectors, self._lengths = vectors, lengths
        self._vectors[row] = np.frombuffer(vector, "<f4")
        self._lengths[row] = np.square(self._vectors[row]).sum()

    def drop(self, shape_id: UUID) -> None:
        """Remove a vector; the last one takes its place."""
        row = self._rows.pop(shape_id, None)
        if row is None:
            return
        last, text = self.ids.pop(), self._texts.pop()
        if last != shape_id:
            self.ids[row], self._texts[row] = last, text
            self._rows[last] = row
            self._vectors[row] = self._vectors[len(self.ids)]
            self._lengths[row] = self._lengths[len(self.ids)]

    def rows(self, ids: Iterable[UUID]) -> npt.NDArray[np.intp]:
        """Return the rows of those of some shapes that are here."""
        return np.array(sorted(self._rows[shape_id] for shape_id in ids if shape_id in self._rows), np.intp)

    def nearest(
        self, vector: npt.NDArray[np.float64], limit: int, rows: npt.NDArray[np.intp] | None
    ) -> list[Candidate]:
        """Return the shapes of the nearest vectors, among `rows` only where they are given."""
        count = len(self.ids) if rows is None else len(rows)
        query = vector.astype(np.float32)
        known = self._vectors[:count] if rows is None else self._vectors[rows]
        lengths = self._lengths[:count] if rows is None else self._lengths[rows]
        # |v|² − 2 v·q orders as the distance does. No BLAS: processes are forked from here, and its threads would not
        # come along.
        squares = lengths - 2 * np.einsum("ij,j->i", known, query)
        wide = min(count, limit + _MARGIN)
        chosen = np.argpartition(squares, wide - 1)[:wide] if wide < count else np.arange(count)
        measured = self._vectors[chosen if rows is None else rows[chosen]].astype(np.float64)
        exact = np.sqrt(np.square(measured - vector).sum(axis=1))
        places = chosen if rows is None else rows[chosen]
        order = sorted(
            (distance, self._texts[place], place)
            for distance, place in zip(exact.tolist(), places.tolist(), strict=True)
        )
        return [Candidate(text, distance, self._vectors[place].tobytes()) for distance, text, place in order[:limit]]


class _Vectors:
    """One owner's vectors of one kind, by their index versions, as they were at a revision."""

    def __init__(self) -> None:
        self.revision = 0
        self.removals = 0
        self.tables: dict[int, VectorTable] = {}

    def refresh(self, session: Session, owner: str, by: By, revision: int, removals: int) -> None:
        """Read what has changed."""
        # a change committed after the look at the number is read now, and once more next time
        for row in repository.vectors_after(session, owner, self.revision, by):
            for version, table in self.tables.items():
                if version != row.index_version or row.vector is None:
                    table.drop(row.id)
            if row.vector is not None:
                self.tables.setdefault(row.index_version, VectorTable()).put(row.id, row.vector)
        if removals != self.removals:
            for version, table in self.tables.items():
                there = set(repository.ids(session, owner, version, None, {}))
                for shape_id in [shape_id for shape_id in table.ids if shape_id not in there]:
                    table.drop(shape_id)
        self.revision, self.removals = revision, removals


class _Kept:
    """What is kept of one owner's shapes."""

    def __init__(self) -> None:
        self.revision = 0
        self.removals = 0
        self.vectors: dict[By, _Vectors] = {}
        """Of the kinds that were asked for."""
        self.graphs: OrderedDict[tuple[int, UUID], bytes] = OrderedDict()
        self.graph_bytes = 0
        self.rows: OrderedDict[tuple[By, int, str], npt.NDArray[np.intp]] = OrderedDict()
        """Of filters asked for since the last change."""

    @property
    def size(self) -> int:
        tables = (table for vectors in self.vectors.values() for table in vectors.tables.values())
        return self.graph_bytes + sum(table.size for table in tables) + sum(rows.nbytes for rows in self.rows.values())

    def keep_graph(self, version: int, shape_id: UUID, graph: bytes, room: int) -> None:
        self.graphs[version, shape_id] = graph
        self.graph_bytes += len(graph)
        while self.graph_bytes > room and len(self.graphs) > 1:
            _, oldest = self.graphs.popitem(last=False)
            self.graph_bytes -= len(oldest)

    def forget_graphs(self) -> None:
        self.graphs.clear()
        self.graph_bytes = 0


class Banks:
    """The banks of all owners, as one process reads them; not for several threads at once.

    Parameters
    ----------
    database
        Where the shapes are.
    room
        Bytes of memory for what was read.
    """

    def __init__(self, database: Database, room: int = DEFAULT_ROOM) -> None:
        self._database = database
        self._room = room
        self._kept: OrderedDict[str, _Kept] = OrderedDict()

    def of(self, owner: str) -> ShapeBank:
        """Return an owner's bank as it is now; it stays so until the next call."""
        kept = self._kept.setdefault(owner, _Kept())
        self._kept.move_to_end(owner)
        self._refresh(owner, kept)
        while len(self._kept) > 1 and sum(other.size for other in self._kept.values()) > self._room:
            self._kept.popitem(last=False)
        if self._database.dialect == "postgresql":
            return PostgresBank(self._database, owner, kept, self._room)
        return MemoryBank(self._database, owner, kept, self._room)

    def _refresh(self, owner: str, kept: _Kept) -> None:
        with self._database.session(readonly=True) as session:
            revision, removals = repository.state(session, owner)
            if revision == kept.revision:
                return
            kept.rows.clear()
            if removals != kept.removals:
                kept.forget_graphs()
            for by, vectors in kept.vectors.items():
                vectors.refresh(session, owner, by, revision, removals)
        kept.revision, kept.removals = revision, removals


class _Bank:
    """What both banks do alike: graphs."""

    def __init__(self, database: Database, owner: str, kept: _Kept, room: int) -> None:
        self._database = database
        self._owner = owner
        self._kept = kept
        self._room = room

    def args(self, ids: Iterable[str]) -> Mapping[str, bytes]:
        """Return graphs of the present index version by id."""
        wanted = dict.fromkeys(shape_id for text in ids if (shape_id := _id(text)) is not None)
        found: dict[UUID, bytes] = {}
        for shape_id in wanted:
            if (INDEX_VERSION, shape_id) in self._kept.graphs:
                self._kept.graphs.move_to_end((INDEX_VERSION, shape_id))
                found[shape_id] = self._kept.graphs[INDEX_VERSION, shape_id]
        missing = [shape_id for shape_id in wanted if shape_id not in found]
        if missing:
            with self._database.session(readonly=True) as session:
                for shape_id, graph in repository.graphs(session, self._owner, INDEX_VERSION, missing):
                    found[shape_id] = graph
                    self._kept.keep_graph(INDEX_VERSION, shape_id, graph, self._room)
        return {str(shape_id): found[shape_id] for shape_id in wanted if shape_id in found}


class MemoryBank(_Bank):
    """Compares the vectors in memory, exactly."""

    def candidates(self, asked: Nearest) -> Sequence[Candidate]:
        """Return the nearest shapes."""
        table = self._table(asked.by, asked.version)
        if table is None:
            return []
        rows = None if asked.only == ShapeFilter() else self._rows(table, asked)
        return table.nearest(np.asarray(asked.vector, np.float64), asked.limit, rows)

    def _table(self, by: By, version: int) -> VectorTable | None:
        vectors = self._kept.vectors.get(by)
        if vectors is None:
            vectors = self._kept.vectors[by] = _Vectors()
            with self._database.session(readonly=True) as session:
                vectors.refresh(session, self._owner, by, self._kept.revision, self._kept.removals)
        return vectors.tables.get(version)

    def _rows(self, table: VectorTable, asked: Nearest) -> npt.NDArray[np.intp]:
        key = asked.by, asked.version, asked.only.model_dump_json()
        if key not in self._kept.rows:
            only = asked.only
            with self._database.session(readonly=True) as session:
                ids = repository.ids(session, self._owner, asked.version, only.collection, only.labels)
            self._kept.rows[key] = table.rows(ids)
            if len(self._kept.rows) > _MOST_FILTERS:
                self._kept.rows.popitem(last=False)
        return self._kept.rows[key]


class PostgresBank(_Bank):
    """Asks PostgreSQL, which finds nearly all of the nearest of many shapes by its index, in numbers of 16 bits."""

    def candidates(self, asked: Nearest) -> Sequence[Candidate]:
        """Return the nearest shapes."""
        with self._database.session(readonly=True) as session:
            rows = repository.nearest(session, self._owner, asked)
        found = (Candidate(str(row.id), row.distance, row.vector) for row in rows)
        return sorted(found, key=lambda candidate: (candidate.distance, candidate.shape_id))


def _id(text: str) -> UUID | None:
    """Return the id that a text is, or None: a job may have been asked for any text."""
    try:
        return UUID(text)
    except ValueError:
        return None
