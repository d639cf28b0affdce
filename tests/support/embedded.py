"""The whole platform as ``shapery up`` starts it, on a port and in a folder of its own."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.conftest import ROOT
from tests.support import processes


class Embedded:
    """A running platform."""

    def __init__(self, home: Path, process: subprocess.Popen[bytes], url: str) -> None:
        self.home = home
        self.process = process
        self.url = url
        self.port = int(url.rsplit(":", 1)[1])


@contextmanager
def embedded_platform(home: Path, **settings: str) -> Iterator[Embedded]:
    """Start everything, wait until it is ready, and stop it; `settings` go into the environment as SHAPERY_*."""
    home.mkdir(parents=True, exist_ok=True)
    log = home / "up.log"
    environment = {f"SHAPERY_{name.upper()}": value for name, value in settings.items()}
    process = processes.spawn(
        [sys.executable, "-m", "shapery_worker", "up", "--home", home, "--port", "0"],
        log,
        environment={"PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1", **environment},
    )

    def address() -> str | None:
        found = re.search(r"ready at (http://\S+)", log.read_text(errors="replace"))
        return found[1] if found else None

    try:
        processes.wait_until(lambda: address() is not None, process, log, seconds=120)
        url = address()
        assert url is not None
        yield Embedded(home, process, url)
    finally:
        processes.end(process, seconds=30)
