"""A small real HTTP server that fails on demand: connections dropped midway, refusals, damaged bytes."""

from __future__ import annotations

import base64
import hashlib
import json
import socket
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from uuid import UUID

import pytest

from shapery_client import Client
from shapery_client._uploads import UploadJournal

ASSET = UUID("01900000-0000-7000-8000-000000000001")
JOB = UUID("01900000-0000-7000-8000-000000000002")


@dataclass
class FlakyServer:
    """State of the server; tests script its faults and read what arrived."""

    address: str = ""
    received: bytearray = field(default_factory=bytearray)
    length: int = -1
    uploads_made: int = 0
    known: bool = True
    faults: list[Callable[[BaseHTTPRequestHandler, bytes], bool]] = field(default_factory=list)
    """Each is asked once, in order, for the next PATCH; true: it has dealt with the request."""
    requests: list[tuple[str, str, dict[str, str]]] = field(default_factory=list)
    routes: dict[tuple[str, str], Callable[[BaseHTTPRequestHandler], None]] = field(default_factory=dict)


def drop(handler: BaseHTTPRequestHandler) -> None:
    """Cut the connection without an answer."""
    handler.close_connection = True
    handler.connection.shutdown(socket.SHUT_RDWR)


def answer(handler: BaseHTTPRequestHandler, status: int, body: Any = None, **headers: str) -> None:
    """Send a whole answer."""
    data = b"" if body is None else body if isinstance(body, bytes) else json.dumps(body).encode()
    handler.send_response(status)
    handler.send_header("Content-Length", str(len(data)))
    for name, value in headers.items():
        handler.send_header(name.replace("_", "-"), value)
    handler.end_headers()
    if handler.command != "HEAD":
        handler.wfile.write(data)


def problem(handler: BaseHTTPRequestHandler, status: int, code: str, **headers: str) -> None:
    """Send a problem document."""
    body = {"type": "about:blank", "title": code, "status": status, "detail": f"This is {code}.", "code": code}
    answer(handler, status, body, Content_Type="application/problem+json", **headers)


@pytest.fixture
def server() -> Iterator[FlakyServer]:
    state = FlakyServer()

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def log_message(self, *_: object) -> None:
            pass

        def _any(self) -> None:
            path = self.path.split("?")[0]
            state.requests.append((self.command, self.path, {k.lower(): v for k, v in self.headers.items()}))
            if (self.command, path) in state.routes:
                state.routes[self.command, path](self)
            elif path.startswith("/v1/uploads"):
                self._tus()
            elif path == f"/v1/assets/{ASSET}":
                digest = hashlib.sha256(state.received).hexdigest()
                answer(self, 200, _asset(digest, len(state.received)))
            else:
                problem(self, 404, "not_found")

        do_GET = do_HEAD = do_POST = do_PATCH = do_DELETE = _any  # noqa: N815 - names http.server asks for

        def _tus(self) -> None:
            if self.command == "POST":
                state.uploads_made += 1
                state.known = True
                state.received.clear()
                state.length = int(self.headers["Upload-Length"])
                answer(self, 201, Location=f"{state.address}/v1/uploads/one", Upload_Offset="0")
                return
            if not state.known:
                problem(self, 404, "not_found")
                return
            if self.command == "PATCH":
                size = int(self.headers["Content-Length"])
                fault = state.faults.pop(0) if state.faults else None
                body = self.rfile.read(size)
                if fault and fault(self, body):
                    return
                if int(self.headers["Upload-Offset"]) != len(state.received):
                    problem(self, 409, "upload_offset_mismatch")
                    return
                algorithm, digest = self.headers["Upload-Checksum"].split()
                if base64.b64decode(digest) != hashlib.new(algorithm, body).digest():
                    problem(self, 460, "checksum_mismatch")
                    return
                state.received += body
            done = {"Upload_Asset_Id": str(ASSET)} if len(state.received) == state.length else {}
            answer(self, 204 if self.command == "PATCH" else 200, Upload_Offset=str(len(state.received)), **done)

    class Server(ThreadingHTTPServer):
        daemon_threads = True

        def handle_error(self, request: Any, client_address: Any) -> None:
            """Connections that tests cut are no errors."""

    httpd = Server(("127.0.0.1", 0), Handler)
    state.address = f"http://127.0.0.1:{httpd.server_port}"
    thread = threading.Thread(target=httpd.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True)
    thread.start()
    yield state
    httpd.shutdown()
    httpd.server_close()
    thread.join()


@pytest.fixture
def client(server: FlakyServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Client]:
    monkeypatch.setattr("shapery_client._transport.Transport._delay", lambda *_: 0.0)
    with Client(server.address, journal=UploadJournal(tmp_path / "journal.json")) as connected:
        yield connected


def _asset(digest: str, size: int) -> dict[str, Any]:
    return {
        "id": str(ASSET),
        "sha256": digest,
        "size": size,
        "kind": "volume",
        "format": "nifti1",
        "media_type": "application/octet-stream",
        "filename": "t1c.nii.gz",
        "created_at": "2026-01-01T00:00:00Z",
        "content_url": f"/v1/assets/{ASSET}/content",
    }
