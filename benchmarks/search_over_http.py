"""``python -m benchmarks.search_over_http``: what a search costs whoever asks over HTTP.

Starts the platform as ``shapery up`` does, in a folder of its own, indexes the meshes of a folder as one batch, and
then searches by stored shapes, by uploaded meshes, and by stored shapes while others are indexed. Writes
``benchmarks/results/search_over_http.json`` and ``.md``.

    python -m benchmarks.search_over_http ../shared/data/meshes/watertight --shapes 100

With ``--home FOLDER`` the platform's folder stays, and a run that was stopped while it indexed goes on there.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from uuid import UUID

import psutil

from shapery_client import Client
from shapery_client._uploads import UploadJournal
from shapery_contracts.api import BatchItem, BatchView
from shapery_contracts.states import JobState

RESULTS = Path(__file__).resolve().parent / "results"
MESHES = Path(__file__).resolve().parents[2] / "shared" / "data" / "meshes" / "watertight"
READY = re.compile(r"ready at (http://\S+)")


@contextmanager
def platform(home: Path) -> Iterator[tuple[str, psutil.Process]]:
    """Run everything in `home`, and give its address and the process above all others."""
    log = home / "up.log"
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    with log.open("wb") as output:
        process = subprocess.Popen(
            [sys.executable, "-m", "shapery_worker", "up", "--home", str(home), "--port", "0"],
            stdout=output,
            stderr=subprocess.STDOUT,
            env=environment,
        )
    try:
        deadline = time.monotonic() + 120
        while (found := READY.search(log.read_text())) is None:
            if process.poll() is not None or time.monotonic() > deadline:
                raise RuntimeError(log.read_text())
            time.sleep(0.1)
        yield found[1], psutil.Process(process.pid)
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(30)


def percentiles(times: Sequence[float]) -> dict[str, float]:
    """Return middle, 95th percentile and largest of some seconds, in milliseconds."""
    ordered = sorted(times)
    return {
        "searches": len(ordered),
        "median_ms": round(1000 * statistics.median(ordered), 1),
        "p95_ms": round(1000 * ordered[min(len(ordered) - 1, int(0.95 * len(ordered)))], 1),
        "max_ms": round(1000 * ordered[-1], 1),
    }


def timed(searches: int, ask: Callable[[int], Any]) -> list[float]:
    """Return the seconds that each of some searches took."""
    times = []
    for number in range(searches):
        began = time.perf_counter()
        ask(number)
        times.append(time.perf_counter() - began)
    return times


def resident(top: psutil.Process) -> psutil.Process | None:
    """Return the process that answers searches at once."""
    found = [child for child in top.children(recursive=True) if "shapery_worker.resident" in " ".join(child.cmdline())]
    return found[0] if found else None


def spent(processes: Sequence[psutil.Process]) -> float:
    """Return the seconds of processor time that processes have used so far."""
    return float(sum(sum(process.cpu_times()[:2]) for process in processes))


def indexed(client: Client, files: Sequence[Path], notes: Path) -> tuple[list[UUID], BatchView]:
    """Index files as one batch, or wait for the one that a former run has noted, and return its assets and its end."""
    if notes.exists():
        noted = json.loads(notes.read_text())
        assets, batch = [UUID(asset) for asset in noted["assets"]], UUID(noted["batch"])
    else:
        assets = [client.upload(path).id for path in files]
        batch = client.submit_batch("shape-index", [BatchItem(inputs={"mesh": asset}) for asset in assets]).id
        notes.write_text(json.dumps({"assets": [str(asset) for asset in assets], "batch": str(batch)}))
    return assets, client.wait_batch(batch)


def measure(folder: Path, shapes: int, searches: int, home: Path) -> dict[str, Any]:
    """Run the benchmark."""
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() in {".ply", ".obj", ".off", ".stl", ".glb"})
    step = max(1, len(files) // shapes)
    files = files[::step][:shapes]
    with (
        platform(home) as (address, top),
        Client(address, journal=UploadJournal(home / "journal.json")) as client,
    ):
        assets, batch = indexed(client, files, home / "batch.json")
        indexing = statistics.mean(
            (job.finished_at - job.started_at).total_seconds()
            for job in client.jobs(batch_id=str(batch.id))
            if job.started_at is not None and job.finished_at is not None
        )
        ids = [shape.id for shape in client.shapes()]
        while (process := resident(top)) is None:
            time.sleep(0.2)
        client.search(shape=ids[0])  # reads the bank into memory

        answered_by_jobs: list[UUID] = []

        def by_shape(number: int) -> None:
            answer = client.search(shape=ids[number % len(ids)], limit=20)
            if answer.job_id is not None:
                answered_by_jobs.append(answer.job_id)

        timed(3, by_shape)
        answered_by_jobs.clear()
        everyone = [top, *top.children(recursive=True)]
        cpu, all_cpu = spent([process]), spent(everyone)
        stored = timed(searches, by_shape)
        cpu, all_cpu = spent([process]) - cpu, spent(everyone) - all_cpu
        jobs = len(answered_by_jobs)
        partial = timed(
            min(20, searches), lambda number: client.search(shape=ids[number % len(ids)], mode="partial", limit=20)
        )
        meshes = timed(min(10, len(assets)), lambda number: client.search(asset=assets[number], limit=20))
        again = client.submit_batch("shape-index", [BatchItem(inputs={"mesh": asset}) for asset in assets])
        beside = timed(min(20, searches), by_shape)
        client.cancel_batch(again.id)
        memory = process.memory_info().rss
    return {
        "shapes": len(ids),
        "refused": batch.counts.get(JobState.FAILED, 0),
        "processors": os.cpu_count(),
        "load": round(os.getloadavg()[0], 1),
        "indexing_s_per_mesh": round(indexing, 3),
        "by stored shape": percentiles(stored),
        "by stored shape, partial": percentiles(partial),
        "by stored shape, while others are indexed": percentiles(beside),
        "by uploaded mesh": percentiles(meshes),
        "cpu_ms_per_search": round(1000 * cpu / len(stored), 1),
        "cpu_ms_of_all_per_search": round(1000 * all_cpu / len(stored), 1),
        "resident_mib": round(memory / 2**20),
        "answered_by_jobs": jobs,
        "answered_by_jobs_while_indexing": len(answered_by_jobs) - jobs,
    }


def table(found: dict[str, Any]) -> str:
    """Return the figures as Markdown."""
    setting = (
        f"{found['shapes']} shapes on the embedded profile, {found['processors']} processors, load {found['load']}. "
        f"The job of a mesh took {found['indexing_s_per_mesh']} s; a search took {found['cpu_ms_per_search']} ms of "
        f"processor time in the resident process, which held {found['resident_mib']} MiB, and "
        f"{found['cpu_ms_of_all_per_search']} ms in all processes of the platform together. With two processors and a "
        "load above 2 a search waits for its turn, and times tell of the load.\n"
    )
    lines = [
        "# Searches over HTTP\n",
        setting,
        "| query | searches | median ms | p95 ms | largest ms |",
        "|---|---|---|---|---|",
    ]
    for name, row in found.items():
        if isinstance(row, dict):
            lines.append(f"| {name} | {row['searches']} | {row['median_ms']} | {row['p95_ms']} | {row['max_ms']} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure and write down."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=MESHES, help="where meshes are")
    parser.add_argument("--shapes", type=int, default=100, help="how many of them, spread over the folder")
    parser.add_argument("--searches", type=int, default=100)
    parser.add_argument("--home", type=Path, help="where the platform's files stay; by default nowhere")
    options = parser.parse_args()
    if not options.folder.is_dir():
        parser.exit(0, f"There is no folder {options.folder}, so nothing was measured.\n")
    with tempfile.TemporaryDirectory() as passing:
        found = measure(options.folder, options.shapes, options.searches, options.home or Path(passing))
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / "search_over_http.json").write_text(json.dumps(found, indent=1) + "\n")
    (RESULTS / "search_over_http.md").write_text(table(found))
    print(table(found))


if __name__ == "__main__":
    main()
