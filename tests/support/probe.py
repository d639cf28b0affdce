"""A plugin with job kinds that do on request what real ones only do by accident.

Named in ``SHAPERY_PLUGINS`` it registers ``probe`` and two kinds with tight limits, with a service of their own, whose
worker starts quickly because it loads no numerics.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import os
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar, Literal

from pydantic import BaseModel, ConfigDict

from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats import AssetKind
from shapery_contracts.handler import JobContext
from shapery_contracts.kinds import InputSpec, JobKind, register_kind
from shapery_worker.handlers import register_handler

SERVICE = "probe"
MODULE = "tests.support.probe"
MIB = 1 << 20


class ProbeParams(BaseModel):
    """What a probe shall do; without anything else it leaves its artifacts and succeeds."""

    model_config = ConfigDict(extra="forbid")

    action: Literal[
        "finish",
        "user_error",
        "raise",
        "exit",
        "memory_error",
        "wrong_result",
        "link",
        "eat_memory",
        "hold_interpreter",
        "kill",
        "spawn",
        "spawn_and_wait",
        "print",
        "see_context",
    ] = "finish"
    victim: Literal["self", "watcher", "main", "group"] = "self"
    """Whom ``kill`` kills: the handler's process, the Celery child, the Celery main process, the worker's group."""
    steps: int = 0
    step_seconds: float = 0.0
    listen: bool = True
    """Whether it looks for a cancel between the steps."""
    mebibytes: int = 0
    previews: bool = False
    """Whether it shows a surface before each step, which grows, and tells which process it is."""
    seed: int = 0
    artifacts: dict[str, int] = {}
    """Sizes by name."""
    once: str | None = None
    """A file that the first attempt makes; only that attempt carries out the action, or the steps where it is none."""
    started: str | None = None
    """A folder in which each run leaves a file when it starts."""


class ProbeResult(BaseModel):
    """What a probe saw."""

    inputs: dict[str, dict[str, str]] = {}
    """For each input the SHA-256 of its files by name."""
    seen: dict[str, str] = {}


def artifact_bytes(seed: int, name: str, size: int) -> bytes:
    """Return what a probe with this seed writes into an artifact."""
    return hashlib.shake_256(f"{seed}:{name}".encode()).digest(size)


class ProbeHandler:
    """The handler of all probe kinds."""

    kind: ClassVar[str] = "probe"

    def run(self, params: ProbeParams, inputs: Mapping[str, Path], context: JobContext) -> ProbeResult:
        if params.started is not None:
            (Path(params.started) / f"{params.seed}.{os.getpid()}.{time.time_ns()}").touch()
        for name, size in params.artifacts.items():
            path = context.output / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(artifact_bytes(params.seed, name, size))
        first = params.once is None or claim_file(Path(params.once))
        for step in range(params.steps if first or params.action != "finish" else 0):
            context.stage(f"step {step + 1}", step / params.steps, f"step {step + 1} of {params.steps}")
            if params.previews:
                context.preview(lambda step=step: octahedron(step + 1))
            time.sleep(params.step_seconds)
            if params.listen:
                context.check_cancelled()
        seen = self._act(params, context) if first else {}
        found = {name: digests(path) for name, path in inputs.items()}
        if params.action == "wrong_result":
            return {"inputs": 1}  # type: ignore[return-value]
        return ProbeResult(inputs=found, seen=seen)

    def _act(self, params: ProbeParams, context: JobContext) -> dict[str, str]:
        match params.action:
            case "user_error":
                raise InvalidInput("no_object_found", "There are 0 objects in 3 voxels.", "Send more voxels.")
            case "raise":
                raise RuntimeError("the probe was asked to raise")
            case "exit":
                sys.exit("the probe was asked to exit")
            case "memory_error":
                raise MemoryError
            case "link":
                (context.output / "link").symlink_to("/etc/hostname")
            case "eat_memory":
                hoard = []
                for part in range(params.mebibytes // 16):
                    hoard.append(os.urandom(16 * MIB))
                    context.progress(part / (params.mebibytes / 16))
                time.sleep(60)
            case "hold_interpreter":
                # PyDLL keeps the interpreter's lock during the call: no other thread of this process runs
                ctypes.PyDLL(None).sleep(60)
            case "kill":
                kill(params.victim)
            case "spawn":
                child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(300)"])
                return {"child": str(child.pid)}
            case "spawn_and_wait":
                subprocess.run([sys.executable, "-c", "import time; time.sleep(300)"], check=True)
            case "print":
                print("the probe prints to standard output")
                sys.stderr.buffer.write(b"\xff not text \x00\n" + b"x" * 100_000 + b"\n")
                os.write(1, b"native output without an end of line")
            case "see_context":
                return see_context(context)
            case _:
                pass
        return {}


def octahedron(size: int) -> bytes:
    """Return an octahedron with corners `size` mm from its middle as api_schema/evolution.md describes."""
    frame = {"object": 1, "stage": 0, "iteration": size, "vertices": 6, "faces": 8, "offset": 0}
    told = {"origin": [-size, -size, -size], "step": size, "frames": [frame], "process": os.getpid()}
    header = json.dumps(told).encode()
    header += b" " * (-len(header) % 4)
    places = [(2, 1, 1), (0, 1, 1), (1, 2, 1), (1, 0, 1), (1, 1, 2), (1, 1, 0)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    body = struct.pack("<18H", *(x for place in places for x in place))
    return b"SHPEVO1\0" + struct.pack("<I", len(header)) + header + body + struct.pack("<24I", *sum(faces, ()))


def claim_file(path: Path) -> bool:
    """Make a file, and tell whether it did not exist."""
    try:
        path.touch(exist_ok=False)
    except FileExistsError:
        return False
    return True


def kill(victim: str) -> None:
    """Kill a process of the worker that runs this, and wait for the consequences."""
    watcher = os.getppid()
    match victim:
        case "self":
            os.kill(os.getpid(), signal.SIGKILL)
        case "watcher":
            os.kill(watcher, signal.SIGKILL)
        case "main":
            import psutil

            os.kill(psutil.Process(watcher).ppid(), signal.SIGKILL)
        case "group":
            os.killpg(os.getpgid(watcher), signal.SIGKILL)
    time.sleep(60)


def see_context(context: JobContext) -> dict[str, str]:
    """Return what a handler finds around itself."""
    import tempfile

    descriptors = {}
    for entry in Path("/proc/self/fd").iterdir():
        try:
            descriptors[entry.name] = str(entry.readlink())
        except OSError:
            continue
    connections = [d for d in descriptors.values() if d.startswith("socket:")]
    return {
        "sockets": str(len(connections)),
        "database": str(sum("shapery.db" in d for d in descriptors.values())),
        "folder": str(Path.cwd()),
        "scratch": str(context.scratch),
        "temporary": tempfile.gettempdir(),
        "leader": str(os.getsid(0) == os.getpid()),
        "threads": os.environ.get("OMP_NUM_THREADS", ""),
        "numba": os.environ.get("NUMBA_THREADING_LAYER", ""),
        "nice": str(os.nice(0)),
        "handler": str(signal.getsignal(signal.SIGTERM)),
    }


def digests(path: Path) -> dict[str, str]:
    """Return the SHA-256 of an input's files by their names."""
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    return {str(file.relative_to(path.parent)): hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


_INPUTS = {
    "data": InputSpec(frozenset({AssetKind.MESH}), "Anything.", required=False, many=True),
    "other": InputSpec(frozenset({AssetKind.MESH}), "Anything else.", required=False),
}


def _register(name: str, *, time_limit: float, memory_limit: int) -> None:
    register_kind(
        JobKind(
            name=name,
            service=SERVICE,
            summary="Does what a test asks for.",
            inputs=_INPUTS,
            params=ProbeParams,
            result=ProbeResult,
            time_limit=time_limit,
            memory_limit=memory_limit,
        )
    )
    handler = ProbeHandler()
    handler.kind = name  # type: ignore[misc]
    register_handler(handler)


_register("probe", time_limit=120.0, memory_limit=4 << 30)
_register("probe-brief", time_limit=1.0, memory_limit=4 << 30)
_register("probe-lean", time_limit=120.0, memory_limit=600 * MIB)
