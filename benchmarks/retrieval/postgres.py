"""The first stage of a search on PostgreSQL: candidates by the HNSW indexes of pgvector, in a bank of grown vectors."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any
from uuid import UUID

import numpy as np
import psutil
import psycopg

from benchmarks.retrieval.growth import CHUNK, Grown, _over
from benchmarks.retrieval.parts_growth import Joined, Query
from shapery_contracts.retrieval import INDEX_VERSION, VECTOR_DIMENSION, Nearest
from shapery_platform.db import Database, new_id
from shapery_retrieval.arg import Arg
from shapery_retrieval.coverage import asked_of
from shapery_retrieval.job import CANDIDATES, PARTIAL_CANDIDATES
from shapery_retrieval.packing import pack_levels, whole_arrays
from shapery_retrieval.vector import vectors_of
from shapery_worker.bank import Banks, VectorTable
from tests.support.postgres import PostgresServer, postgres_server

OWNER = "bench"
COLUMNS = (
    "id, owner, collection_id, asset_id, job_id, name, metadata, index_version, revision, vector, report, arg_sha256, "
    "arg_size, created_at, indexed_at, part_vector"
)


def on_postgres(args: Sequence[Arg], parts: Sequence[Query], size: int, queries: int = 100) -> dict[str, Any]:
    """Return wall time of asking for candidates, how many of the exact ones come, and how many of the twenty best.

    For `parts`, which are queries too, the former alone.

    The server is the one of the tests: 32 MB of shared buffers, no settings for speed of reading.
    """
    bank = Grown(args, size)
    covered = Joined(args, size).covered
    table, part_table = VectorTable(), VectorTable()
    ids = [new_id() for _ in range(size)]
    place_of = {str(shape): place for place, shape in enumerate(ids)}
    with postgres_server() as server:
        url = server.create_database()
        database = Database(url)
        database.migrate()
        began = time.perf_counter()
        with psycopg.connect(url) as connection:
            connection.execute("SET session_replication_role = replica")  # rows that others refer to are not needed
            connection.execute("SET maintenance_work_mem = '1GB'")
            connection.execute("SET max_parallel_maintenance_workers = 0")
            connection.execute("INSERT INTO banks VALUES (%s, %s, 0)", (OWNER, size))
            built = connection.execute(
                "SELECT indexdef FROM pg_indexes WHERE indexname = 'ix_shapes_vector'"
            ).fetchall()
            connection.execute("DROP INDEX ix_shapes_vector")
            with connection.cursor().copy(f"COPY shapes ({COLUMNS}) FROM STDIN") as copy:
                for begin in range(0, size, CHUNK):
                    for place, vector in enumerate(bank.vectors(begin, min(begin + CHUNK, size)), start=begin):
                        shape = ids[place]
                        copy.write_row(
                            (
                                shape, OWNER, ids[0], shape, shape, str(place), "{}", INDEX_VERSION, place + 1,
                                str(vector.tolist()), "{}", "0" * 64, 1, "2026-01-01", "2026-01-01",
                                str(covered[place].tolist()),
                            )
                        )  # fmt: skip
                        part_table.put(shape, covered[place].tobytes())
                        table.put(shape, vector.tobytes())
            copied = time.perf_counter()
            connection.execute(built[0][0])
            indexed = time.perf_counter()
            size_of_index = connection.execute("SELECT pg_relation_size('ix_shapes_vector')").fetchone()
            assert size_of_index is not None
        with psycopg.connect(url, autocommit=True) as connection:
            connection.execute("VACUUM ANALYZE shapes")
        times, recall, kept = [], [], []
        own, of_server, warm_up = 0.0, 0.0, 3
        asked = args[:: max(1, len(args) // queries)][:queries]
        for number, query in enumerate((*asked[:warm_up], *asked)):
            if number == warm_up:
                own, of_server = 0.0, _processor_seconds(server)
            vector = vectors_of(pack_levels([query]), whole_arrays([query]))[0].astype(np.float64)
            start, at = time.perf_counter(), time.process_time()
            found = Banks(database).of(OWNER).candidates(Nearest(vector=vector.tolist(), limit=CANDIDATES))
            times.append(time.perf_counter() - start)
            own += time.process_time() - at
            exact = table.nearest(vector, CANDIDATES, None)
            recall.append(len({c.shape_id for c in found} & {c.shape_id for c in exact}) / len(exact))
            best = []
            for near in (found, exact):
                known = sorted(near)
                vectors = np.frombuffer(b"".join(c.vector for c in known), dtype="<f4").reshape(-1, VECTOR_DIMENSION)
                places = np.array([place_of[str(UUID(c.shape_id))] for c in known])
                answer = _over(bank, places, vectors).search(query, vector=vector)
                best.append({hit.shape_id for hit in answer.hits})
            kept.append(len(best[0] & best[1]) / len(best[1]))
        processor = (own + _processor_seconds(server) - of_server) / len(asked)
        part_times, part_recall = [], []
        for _, hypotheses in (*parts[:3], *parts):
            asked_for = asked_of(hypotheses)
            start = time.perf_counter()
            found = (
                Banks(database)
                .of(OWNER)
                .candidates(Nearest(vector=asked_for.tolist(), limit=PARTIAL_CANDIDATES, by="parts"))
            )
            part_times.append(time.perf_counter() - start)
            exact = part_table.nearest(asked_for, PARTIAL_CANDIDATES, None)
            part_recall.append(len({c.shape_id for c in found} & {c.shape_id for c in exact}) / len(exact))
        database.dispose()
    part_times, part_recall = part_times[3:], part_recall[3:]
    times, recall, kept = times[3:], recall[3:], kept[3:]
    return {
        "size": size,
        "queries": len(times),
        "index": "m 24, ef_construction 400; parts by a scan",
        "copy_s": copied - began,
        "index_s": indexed - copied,
        "index_megabytes": size_of_index[0] / 2**20,
        "processor_ms": 1000 * processor,
        "median_ms": 1000 * float(np.median(times)),
        "p95_ms": 1000 * float(np.quantile(times, 0.95)),
        "recall": float(np.mean(recall)),
        "twenty_best": float(np.mean(kept)),
        "parts_median_ms": 1000 * float(np.median(part_times)),
        "parts_recall": float(np.mean(part_recall)),
    }


def _processor_seconds(server: PostgresServer) -> float:
    """Return what all processes of a server have used so far."""
    (listening,) = {
        one.pid for one in psutil.net_connections() if one.status == "LISTEN" and one.laddr.port == server.port
    }
    main = psutil.Process(listening)
    return float(sum(sum(one.cpu_times()[:2]) for one in (main, *main.children(recursive=True))))
