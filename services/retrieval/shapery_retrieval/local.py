"""A bank in one SQLite file, for work without a server."""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from shapery_contracts.errors import InvalidInput
from shapery_contracts.retrieval import INDEX_VERSION, Candidate, Nearest, ShapeFilter
from shapery_retrieval.arg import Arg
from shapery_retrieval.coverage import coverage_of
from shapery_retrieval.vector import vector_of

_SCHEMA = """
CREATE TABLE IF NOT EXISTS shapes (
    name TEXT PRIMARY KEY,
    sha256 TEXT NOT NULL,
    index_version INTEGER NOT NULL,
    vector BLOB NOT NULL,
    part_vector BLOB,
    arg BLOB NOT NULL
) WITHOUT ROWID
"""
_APPLICATION = 0x53485042
"""Marks the file as ours ("SHPB"), so that no other database is taken for a bank."""


class LocalBank:
    """The shapes in a file: a `shapery_contracts.retrieval.ShapeBank`.

    Parameters
    ----------
    path
        Created where it does not exist, unless `must_exist`.

    Raises
    ------
    InvalidInput
        ``not_found`` or ``corrupt_file``.
    """

    def __init__(self, path: Path | str, *, must_exist: bool = False) -> None:
        self.path = Path(path)
        if must_exist and not self.path.is_file():
            raise InvalidInput("not_found", f"There is no bank at {self.path}.", "Make one with: shapery index MESH…")
        try:
            self._database = sqlite3.connect(self.path, timeout=60)
            application = self._database.execute("PRAGMA application_id").fetchone()[0]
            tables = self._database.execute("SELECT count(*) FROM sqlite_schema").fetchone()[0]
            if tables and application != _APPLICATION:
                raise InvalidInput("corrupt_file", f"{self.path} is a database, but no bank of shapes.")
            if not tables:
                self._database.execute(f"PRAGMA application_id = {_APPLICATION}")
                self._database.execute(_SCHEMA)
                self._database.commit()
            elif "part_vector" not in {row[1] for row in self._database.execute("PRAGMA table_info(shapes)")}:
                # of an index version before there were any
                self._database.execute("ALTER TABLE shapes ADD COLUMN part_vector BLOB")
        except sqlite3.DatabaseError as error:
            raise InvalidInput("corrupt_file", f"{self.path} is no bank of shapes: {error}.") from error

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def __enter__(self) -> LocalBank:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __len__(self) -> int:
        return int(self._database.execute("SELECT count(*) FROM shapes").fetchone()[0])

    def names(self) -> list[str]:
        """Return the names of all shapes of this index version, sorted."""
        rows = self._database.execute("SELECT name FROM shapes WHERE index_version = ? ORDER BY name", (INDEX_VERSION,))
        return [row[0] for row in rows]

    def outdated(self) -> int:
        """Return how many shapes were indexed by another version and take no part in anything."""
        query = "SELECT count(*) FROM shapes WHERE index_version <> ?"
        return int(self._database.execute(query, (INDEX_VERSION,)).fetchone()[0])

    def holds(self, name: str, content: bytes) -> bool:
        """Whether this very content is indexed under this name already."""
        row = self._database.execute("SELECT sha256, index_version FROM shapes WHERE name = ?", (name,)).fetchone()
        return bool(row == (hashlib.sha256(content).hexdigest(), INDEX_VERSION))

    def put(self, name: str, content: bytes, arg: Arg) -> None:
        """Store a shape; one of the same name is replaced."""
        vectors = (vector_of(arg).astype("<f4").tobytes(), coverage_of(arg).astype("<f4").tobytes())
        row = (name, hashlib.sha256(content).hexdigest(), arg.index_version, *vectors, arg.to_bytes())
        with self._database:
            self._database.execute(
                "INSERT OR REPLACE INTO shapes (name, sha256, index_version, vector, part_vector, arg) "
                "VALUES (?, ?, ?, ?, ?, ?)",
                row,
            )

    def remove(self, name: str) -> bool:
        """Remove a shape; say whether it was there."""
        with self._database:
            return self._database.execute("DELETE FROM shapes WHERE name = ?", (name,)).rowcount > 0

    def candidates(self, asked: Nearest) -> Sequence[Candidate]:
        """See `ShapeBank.candidates`; there are neither collections nor labels here."""
        if asked.only != ShapeFilter():
            raise InvalidInput("invalid_params", "A bank in a file has neither collections nor labels.")
        rows = self._database.execute(
            "SELECT name, CASE ? WHEN 'parts' THEN part_vector ELSE vector END AS compared FROM shapes "
            "WHERE index_version = ? AND compared IS NOT NULL ORDER BY name",
            (asked.by, asked.version),
        ).fetchall()
        if not rows:
            return []
        stored = np.frombuffer(b"".join(row[1] for row in rows), dtype="<f4").reshape(len(rows), -1)
        distances = np.linalg.norm(stored - np.asarray(asked.vector, dtype=np.float32), axis=1)
        order = np.argsort(distances, kind="stable")[: asked.limit]
        return [Candidate(rows[i][0], float(distances[i]), rows[i][1]) for i in order.tolist()]

    def args(self, ids: Iterable[str]) -> Mapping[str, bytes]:
        """See `ShapeBank.args`."""
        found = {}
        for name in ids:
            row = self._database.execute(
                "SELECT arg FROM shapes WHERE name = ? AND index_version = ?", (name, INDEX_VERSION)
            ).fetchone()
            if row is not None:
                found[name] = row[0]
        return found


@contextmanager
def open_bank(path: Path | str, *, must_exist: bool = False) -> Iterator[LocalBank]:
    """Open a bank and close it afterwards."""
    bank = LocalBank(path, must_exist=must_exist)
    try:
        yield bank
    finally:
        bank.close()
