"""A network between a browser and a server that can be slow, and can break.

::

    with unreliable(port) as network:
        network.upload_rate = 2_000_000         # bytes per second
        network.down = True                     # what is under way is cut off, what comes is refused
"""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

PIECE = 16_384


class Network:
    """Forwards connections to a port of this machine, and counts what goes up."""

    def __init__(self, target: int) -> None:
        self.target = target
        self.upload_rate: float | None = None
        """Bytes per second that each connection may send; None: as many as it likes."""
        self.uploaded = 0
        """Bytes sent to the server so far."""
        self._down = False
        self._open: set[socket.socket] = set()
        self._lock = threading.Lock()
        self._listener = socket.socket()
        # What lies in buffers would still arrive long after the sender has gone, as on no real network.
        self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 * PIECE)
        self._listener.bind(("127.0.0.1", 0))
        self._listener.listen()
        self.port: int = self._listener.getsockname()[1]
        threading.Thread(target=self._accept, name="network", daemon=True).start()

    @property
    def url(self) -> str:
        """The server's address by way of this network."""
        return f"http://127.0.0.1:{self.port}"

    @property
    def down(self) -> bool:
        """Whether the network is broken."""
        return self._down

    @down.setter
    def down(self, down: bool) -> None:
        self._down = down
        if down:
            self.cut()

    def cut(self) -> None:
        """Break every connection that is open now."""
        with self._lock:
            broken = list(self._open)
        for end in broken:
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Stop listening, and break what is open."""
        self._listener.close()
        self.cut()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            if self._down:
                client.close()
                continue
            try:
                server = socket.create_connection(("127.0.0.1", self.target))
            except OSError:
                client.close()
                continue
            with self._lock:
                self._open |= {client, server}
            for source, sink, up in ((client, server, True), (server, client, False)):
                threading.Thread(target=self._pump, args=(source, sink, up), daemon=True).start()

    def _pump(self, source: socket.socket, sink: socket.socket, up: bool) -> None:
        with contextlib.suppress(OSError):
            while piece := source.recv(PIECE):
                sink.sendall(piece)
                if up:
                    with self._lock:
                        self.uploaded += len(piece)
                    if self.upload_rate is not None:
                        time.sleep(len(piece) / self.upload_rate)
        for end in (source, sink):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
        if up:
            return
        with self._lock:
            self._open -= {source, sink}
        source.close()
        sink.close()


@contextmanager
def unreliable(target: int) -> Iterator[Network]:
    """Stand between whoever comes and the server on a port of this machine."""
    network = Network(target)
    try:
        yield network
    finally:
        network.close()
