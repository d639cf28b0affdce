"""How a handler's process reads the shape database, to which it has no connection: it asks its watcher, over a socket.

The watcher answers for the owner of the job and nobody else, so that whatever a handler suffers, it reaches no other
shapes. A message is a line of JSON; graphs and vectors follow an answer as bytes; the line tells their
lengths or their number.
"""

from __future__ import annotations

import contextlib
import json
import logging
import socket
import threading
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from shapery_contracts.retrieval import VECTOR_DIMENSION, Candidate, Nearest, ShapeBank

logger = logging.getLogger(__name__)


class BankClient:
    """`shapery_contracts.retrieval.ShapeBank` in the handler's process.

    What goes wrong on the other side raises `ConnectionError`: it is nothing that the user could mend.

    Parameters
    ----------
    descriptor
        The handler's end of the socket.
    """

    def __init__(self, descriptor: int) -> None:
        self._socket = socket.socket(fileno=descriptor)
        self._stream = self._socket.makefile("rwb")

    def candidates(self, asked: Nearest) -> Sequence[Candidate]:
        """Return the nearest shapes."""
        answer = self._ask({"nearest": asked.model_dump(mode="json")})
        size = 4 * VECTOR_DIMENSION
        return [Candidate(shape_id, distance, self._stream.read(size)) for shape_id, distance in answer["found"]]

    def args(self, ids: Iterable[str]) -> Mapping[str, bytes]:
        """Return graphs by id."""
        answer = self._ask({"ids": list(ids)})
        return {shape_id: self._stream.read(size) for shape_id, size in answer["sizes"]}

    def close(self) -> None:
        """Leave the line."""
        with contextlib.suppress(OSError):  # what it still would have said
            self._stream.close()
        self._socket.close()

    def _ask(self, question: dict[str, Any]) -> dict[str, Any]:
        self._stream.write(json.dumps(question).encode() + b"\n")
        self._stream.flush()
        line = self._stream.readline()
        if not line:
            raise ConnectionError("the watcher has left the line to the shape database")
        answer: dict[str, Any] = json.loads(line)
        if "fault" in answer:
            raise ConnectionError(f"the shape database cannot be read: {answer['fault']}")
        return answer


class BankServer:
    """The thread in the watcher that answers one handler; a context manager, to be entered after the fork.

    Parameters
    ----------
    line
        The watcher's end of the socket, which is closed at the end.
    bank
        What is asked.
    """

    def __init__(self, line: socket.socket, bank: ShapeBank) -> None:
        self._line = line
        self._bank = bank
        self._thread = threading.Thread(target=self._run, name="bank", daemon=True)

    def __enter__(self) -> BankServer:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        # The handler has ended, or is killed next: a thread that still waits for it wakes up.
        try:
            self._line.shutdown(socket.SHUT_RDWR)
        except OSError:
            logger.debug("the handler has left the line already")
        self._thread.join()
        self._line.close()

    def _run(self) -> None:
        try:
            with self._line.makefile("rwb") as stream:
                for line in stream:
                    head, graphs = self._answer(json.loads(line))
                    stream.write(json.dumps(head).encode() + b"\n")
                    for graph in graphs:
                        stream.write(graph)
                    stream.flush()
        except OSError as error:
            logger.debug("the handler left the line: %s", error)

    def _answer(self, question: dict[str, Any]) -> tuple[dict[str, Any], Iterable[bytes]]:
        try:
            if "ids" in question:
                graphs = self._bank.args(question["ids"])
                return {"sizes": [(shape_id, len(graph)) for shape_id, graph in graphs.items()]}, graphs.values()
            found = self._bank.candidates(Nearest.model_validate(question["nearest"]))
            return {"found": [candidate[:2] for candidate in found]}, (candidate.vector for candidate in found)
        except Exception as error:
            logger.exception("the shape database could not be read")
            return {"fault": type(error).__name__}, ()
