"""The gateway as a server: in a thread of the test's process, or as a process of its own that can be killed.

::

    with served(settings) as base_url:
        httpx.get(f"{base_url}/healthz")
"""

from __future__ import annotations

import asyncio
import base64
import gc
import io
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
from fastapi import FastAPI

from shapery_gateway.app import create_app
from shapery_gateway.server import GRACE_SECONDS, READY, Server
from shapery_platform.settings import Settings
from tests.support import processes

TUS = {"Tus-Resumable": "1.0.0"}
STOP_SECONDS = GRACE_SECONDS + 30
"""A gateway waits for its requests, then for its messages to the queue; on a machine that is busy otherwise."""
OFFSET_STREAM = "application/offset+octet-stream"


@contextmanager
def served(settings: Settings, app: FastAPI | None = None) -> Iterator[str]:
    """Serve in a thread, and give the address."""
    server = Server(app or create_app(settings), settings)
    thread = threading.Thread(target=server.run, name="gateway")
    thread.start()
    end = time.monotonic() + 20
    while not server.started and thread.is_alive() and time.monotonic() < end:
        time.sleep(0.005)
    try:
        assert server.started, "the gateway did not start"
        yield server.address
    finally:
        server.should_exit = True
        thread.join(STOP_SECONDS)
        assert not thread.is_alive(), f"the gateway did not stop:\n{_what_runs()}"


def _what_runs() -> str:
    """Return the stacks of all threads, and of the tasks of all event loops."""
    text = io.StringIO()
    for number, frame in sys._current_frames().items():
        print(f"thread {number}:", *traceback.format_stack(frame), file=text)
    for loop in [item for item in gc.get_objects() if isinstance(item, asyncio.AbstractEventLoop)]:
        for task in asyncio.all_tasks(loop):
            task.print_stack(file=text)
    return text.getvalue()


class GatewayProcess:
    """The gateway as it is run in earnest."""

    def __init__(self, folder: Path, environment: dict[str, str]) -> None:
        self.folder = folder
        self.environment = environment
        self.port = 0
        self._process: subprocess.Popen[bytes] | None = None
        self._starts = 0

    @property
    def base_url(self) -> str:
        """Where it listens."""
        return f"http://127.0.0.1:{self.port}"

    @property
    def log(self) -> Path:
        """What the present process writes."""
        return self.folder / f"gateway-{self._starts}.log"

    def start(self) -> None:
        """Start it, on the same port as before, and wait until it is ready."""
        self._starts += 1
        self.port = self.port or processes.free_port()
        self._process = processes.spawn(
            [sys.executable, "-m", "shapery_gateway", "--port", str(self.port), "--migrate"],
            self.log,
            environment=self.environment,
        )
        processes.wait_until(lambda: READY in self.log.read_text(errors="replace"), self._process, self.log)

    def stop(self) -> int:
        """Ask it to stop, and return its exit status."""
        assert self._process is not None
        processes.end(self._process, signal.SIGTERM, 20)
        return self._process.returncode

    def kill(self) -> None:
        """Kill it."""
        if self._process is not None:
            processes.end(self._process, signal.SIGKILL)

    def peak_memory(self) -> int:
        """Return the largest resident size so far, in bytes."""
        assert self._process is not None
        for line in Path(f"/proc/{self._process.pid}/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
        raise AssertionError("the kernel tells no peak")

    def threads(self) -> int:
        """Return how many threads it has."""
        assert self._process is not None
        return int(psutil.Process(self._process.pid).num_threads())


def nifti(shape: tuple[int, int, int] = (4, 3, 2), *, seed: int = 0, size: int | None = None) -> bytes:
    """Return a small valid NIfTI-1 volume of 8-bit voxels; with `size` at least that many bytes of voxels."""
    voxels = shape[0] * shape[1] * shape[2]
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *shape, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)
    struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352.0)
    struct.pack_into("<f", header, 112, 1.0)
    header[344:348] = b"n+1\0"
    data = bytes((seed + i) % 251 for i in range(min(voxels, 1 << 16)))
    data = (data * (voxels // len(data) + 1))[:voxels]
    return bytes(header) + data


def triangle(seed: int = 0) -> bytes:
    """Return a small OBJ."""
    return f"v 0 0 0\nv 1 0 0\nv 0 1 {seed}\nf 1 2 3\n".encode()


def metadata(filename: str) -> str:
    """Return ``Upload-Metadata`` with a file's name."""
    return f"filename {base64.b64encode(filename.encode()).decode()}"


def raw_request(base_url: str, data: bytes, *, read: bool = True, timeout: float = 5.0) -> bytes:
    """Send bytes as they are and return all that comes back until the server closes, or `timeout` passes."""
    host, port = base_url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=timeout) as connection:
        connection.sendall(data)
        if not read:
            return b""
        received = b""
        try:
            while chunk := connection.recv(65536):
                received += chunk
        except TimeoutError:
            return received
        return received
