"""Runs the app under uvicorn: bounded headers, event streams that end when it stops, and a ready line."""

from __future__ import annotations

import asyncio
import json
import socket
import sys
from pathlib import Path
from typing import Any

import uvicorn
from fastapi import FastAPI
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from shapery_contracts.errors import ERROR_CODES
from shapery_gateway.app import create_app
from shapery_gateway.backend import Backend
from shapery_gateway.logs import configure
from shapery_gateway.problems import MEDIA_TYPE, TYPE_PREFIX
from shapery_platform.db import Database
from shapery_platform.settings import Settings

MAX_HEADER_BYTES = 64 << 10
HEADER_SECONDS = 20.0
"""How long a client may take to send the head of a request."""
READY = "shapery-gateway ready at"
"""Begins the line on standard output that says that the server is up, and where."""
LINGER_SECONDS = 2.0
"""How long a client that was refused may go on sending before the connection is cut."""
GRACE_SECONDS = 10
"""How long requests may take to end once the server was asked to stop; uploads keep what arrived."""


class _LingeringTransport:
    """The transport that a request's answer is written to, whose `close` lets the client read the answer first."""

    def __init__(self, protocol: BoundedProtocol) -> None:
        self._protocol = protocol
        self._transport = protocol.transport

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)

    def close(self) -> None:
        """Close at once where the whole request was read, else after the client had time to stop sending."""
        if self._protocol.cycle.more_body:
            self._protocol.linger()
        else:
            self._transport.close()


class BoundedProtocol(HttpToolsProtocol):
    """HTTP/1.1 with a bound on the size of a request's head and on the time it may take.

    httptools itself gathers headers without end, and waits for them for ever. And a socket that is closed while the
    client is still sending resets the connection, which takes the answer with it that said why: such a connection
    is closed a moment later.
    """

    _head_bytes = 0
    _in_head = True
    _discarding = False
    _head_timer: asyncio.TimerHandle | None = None
    _linger_timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for the head of the first request."""
        super().connection_made(transport)
        self._head_timer = self.loop.call_later(HEADER_SECONDS, self._head_is_late)

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop waiting."""
        self._stop_head_timer()
        if self._linger_timer is not None:
            self._linger_timer.cancel()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Take in data, counting what belongs to a head."""
        if self._discarding:
            return
        if self._in_head:
            self._head_bytes += len(data)
            if self._head_timer is None:
                self._head_timer = self.loop.call_later(HEADER_SECONDS, self._head_is_late)
        super().data_received(data)
        if self._in_head and self._head_bytes > MAX_HEADER_BYTES and not self.transport.is_closing():
            self._refuse("headers_too_large", f"The head of the request has more than {MAX_HEADER_BYTES} bytes.")

    def on_headers_complete(self) -> None:
        """Hand the request on."""
        self._in_head = False
        self._head_bytes = 0
        self._stop_head_timer()
        super().on_headers_complete()
        self.cycle.transport = _LingeringTransport(self)  # type: ignore[assignment]

    def on_message_complete(self) -> None:
        """Expect the next head on this connection."""
        super().on_message_complete()
        self._in_head = True

    def linger(self) -> None:
        """Say that nothing more will be sent, read over what still comes for a moment, then close."""
        if self._discarding or self.transport.is_closing():
            return
        self._discarding = True
        self.flow.resume_reading()
        if self.transport.can_write_eof():
            self.transport.write_eof()
        self._linger_timer = self.loop.call_later(LINGER_SECONDS, self.transport.close)

    def _stop_head_timer(self) -> None:
        if self._head_timer is not None:
            self._head_timer.cancel()
            self._head_timer = None

    def _head_is_late(self) -> None:
        self._head_timer = None
        if self.transport.is_closing():
            return
        if self._head_bytes:
            self._refuse("request_timeout", f"The head of the request took more than {HEADER_SECONDS:g} seconds.")
        else:
            self.transport.close()  # connected and never said a word

    def _refuse(self, code: str, detail: str) -> None:
        entry = ERROR_CODES[code]
        problem = {
            "type": TYPE_PREFIX + code,
            "title": entry.title,
            "status": entry.status,
            "detail": detail,
            "code": code,
        }
        body = json.dumps(problem).encode()
        head = (
            f"HTTP/1.1 {entry.status} Refused\r\nContent-Type: {MEDIA_TYPE}\r\n"
            f"Content-Length: {len(body)}\r\nConnection: close\r\n\r\n"
        )
        self.transport.write(head.encode() + body)
        self.linger()


class Server(uvicorn.Server):
    """Ends event streams before it waits for connections to close, since they would never close by themselves.

    Parameters
    ----------
    app
        The app to serve.
    settings
        Host and port; port 0 takes a free one.
    unix_socket
        Listen on this socket instead.
    """

    def __init__(self, app: FastAPI, settings: Settings, *, unix_socket: Path | None = None) -> None:
        where: dict[str, Any] = {"host": settings.host, "port": settings.port}
        super().__init__(
            uvicorn.Config(
                app,
                **({"uds": str(unix_socket)} if unix_socket else where),
                loop="asyncio",
                http=BoundedProtocol,
                ws="none",
                lifespan="on",
                # `middleware.context` writes the access log
                access_log=False,
                log_config=None,
                server_header=False,
                timeout_keep_alive=30,
                timeout_graceful_shutdown=GRACE_SECONDS,
            )
        )
        self._app = app
        self._unix_socket = unix_socket

    @property
    def address(self) -> str:
        """Where the started server listens: ``http://127.0.0.1:8000``, or ``unix:/path``."""
        if self._unix_socket is not None:
            return f"unix:{self._unix_socket}"
        host, port, *_ = self.servers[0].sockets[0].getsockname()
        return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End the streams, then stop."""
        backend: Backend | None = getattr(self._app.state, "backend", None)
        if backend is not None:
            await backend.end_streams()
        await super().shutdown(sockets)


class _AnnouncingServer(Server):
    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self.started:
            # Whoever started this process with port 0 learns the port here.
            sys.stdout.write(f"{READY} {self.address}\n")
            sys.stdout.flush()


def run(settings: Settings, *, unix_socket: Path | None = None, migrate: bool = False) -> None:
    """Serve until SIGINT or SIGTERM.

    Parameters
    ----------
    settings
        Host and port, among others.
    unix_socket
        Listen on this socket instead.
    migrate
        Bring the database to the newest version first.
    """
    configure()
    if migrate:
        database = Database(settings.database_url)
        database.migrate()
        database.dispose()
    _AnnouncingServer(create_app(settings), settings, unix_socket=unix_socket).run()
