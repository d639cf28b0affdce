"""A real S3 API from a server process (moto, see `s3_process`).

::

    with s3_server() as server:
        settings = load_settings(**server.settings())      # a fresh bucket
"""

from __future__ import annotations

import itertools
import shutil
import subprocess
import sys
import tempfile
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support import processes

ACCESS_KEY = "test-access-key"
SECRET_KEY = "u7Tq2xV9mK4sWc8Z"


class S3Server:
    """A running server with its buckets."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.port = 0
        self._process: subprocess.Popen[bytes] | None = None
        self._numbers = itertools.count(1)

    @property
    def endpoint(self) -> str:
        """The server's address."""
        return f"http://127.0.0.1:{self.port}"

    def create_bucket(self) -> str:
        """Create an empty bucket and return its name."""
        name = f"test-{next(self._numbers)}"
        request = urllib.request.Request(f"{self.endpoint}/{name}", method="PUT")
        urllib.request.urlopen(request, timeout=30).close()
        return name

    def settings(self) -> dict[str, str]:
        """Return the settings of a platform whose objects are in a fresh bucket."""
        return {
            "storage_url": f"s3://{self.create_bucket()}/some/prefix",
            "s3_endpoint": self.endpoint,
            "s3_access_key": ACCESS_KEY,
            "s3_secret_key": SECRET_KEY,
        }

    def start(self) -> None:
        """Start the server and wait until it answers."""
        self.port = self.port or processes.free_port()
        log = self.folder / "server.log"
        self._process = processes.spawn(
            [sys.executable, "-P", str(Path(__file__).with_name("s3_process.py")), str(self.port)],
            log,
            # no credentials of the machine are looked for
            environment={"MOTO_ENABLE_ISO_REGIONS": "false", "TMPDIR": str(self.folder), "PYTHONWARNINGS": "ignore"},
        )
        processes.wait_until(lambda: processes.listens(self.port), self._process, log)

    def stop(self) -> None:
        """Stop the server; its buckets are gone."""
        if self._process is not None:
            processes.end(self._process)
            self._process = None


@contextmanager
def s3_server() -> Iterator[S3Server]:
    """Run a server."""
    folder = Path(tempfile.mkdtemp(prefix="shapery-s3-"))
    server = S3Server(folder)
    try:
        server.start()
        yield server
    finally:
        server.stop()
        shutil.rmtree(folder, ignore_errors=True)
