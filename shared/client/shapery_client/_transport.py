"""One door to the server: retries what may be repeated, and turns answers into errors."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import httpx

from shapery_client._errors import ApiError, ConnectionFailed

RETRY_STATUS = frozenset({429, 502, 503, 504})
"""Answers that say "not now": the same request may succeed a moment later."""


class Transport:
    """An HTTP connection to one server.

    Parameters
    ----------
    server
        Address such as ``http://127.0.0.1:8000``.
    api_key
        Sent as a bearer token; None on a server in local mode.
    timeout
        Seconds to wait for an answer.
    attempts
        How often a request that may be repeated is tried.
    http
        A ready `httpx.Client` instead of one of our own (tests hand in the application itself).
    """

    def __init__(
        self,
        server: str,
        *,
        api_key: str | None,
        timeout: float,
        attempts: int,
        http: httpx.Client | None = None,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.server = server.rstrip("/")
        self.attempts = max(1, attempts)
        self._owned = http is None
        self._sleep = sleep
        self._jitter = random.Random()  # noqa: S311 - spreads retries, guards nothing
        self._http = http or httpx.Client(base_url=self.server, timeout=httpx.Timeout(timeout, connect=10.0))
        self._headers = {"Authorization": f"Bearer {api_key}"} if api_key else {}

    def close(self) -> None:
        """Close the connection."""
        if self._owned:
            self._http.close()

    def request(
        self,
        method: str,
        path: str,
        *,
        repeatable: bool | None = None,
        headers: Mapping[str, str] | None = None,
        **kwargs: Any,
    ) -> httpx.Response:
        """Send a request and return its answer.

        Parameters
        ----------
        repeatable
            Whether sending it twice does no harm; by default true for everything but POST and PATCH.

        Raises
        ------
        ApiError
            The server refused.
        ConnectionFailed
            It did not answer.
        """
        if repeatable is None:
            repeatable = method not in {"POST", "PATCH"}
        attempts = self.attempts if repeatable else 1
        for attempt in range(1, attempts + 1):
            try:
                response = self._http.request(method, path, headers={**self._headers, **(headers or {})}, **kwargs)
            except httpx.TransportError as error:
                if attempt == attempts:
                    raise self._failed(error) from error
                self._sleep(self._delay(attempt))
                continue
            if response.status_code in RETRY_STATUS and attempt < attempts:
                self._sleep(self._delay(attempt, response))
                continue
            if response.is_error:
                raise ApiError.from_response(response)
            return response
        raise AssertionError("unreachable: the last attempt returns or raises")

    @contextmanager
    def stream(
        self, method: str, path: str, *, headers: Mapping[str, str] | None = None, **kwargs: Any
    ) -> Iterator[httpx.Response]:
        """Send a request and hand out its answer before the body has arrived; never repeated by itself."""
        try:
            with self._http.stream(method, path, headers={**self._headers, **(headers or {})}, **kwargs) as response:
                if response.is_error:
                    response.read()
                    raise ApiError.from_response(response)
                yield response
        except httpx.TransportError as error:
            raise self._failed(error) from error

    def pause(self, attempt: int) -> None:
        """Wait as long as is polite before trying again."""
        self._sleep(self._delay(attempt))

    def _delay(self, attempt: int, response: httpx.Response | None = None) -> float:
        if response is not None:
            told = response.headers.get("Retry-After", "")
            if told.isdigit():
                return min(float(told), 60.0)
        return float(min(0.25 * 2**attempt, 8.0)) * (0.5 + 0.5 * self._jitter.random())

    def _failed(self, error: httpx.TransportError) -> ConnectionFailed:
        reason = str(error) or type(error).__name__
        return ConnectionFailed(f"{self.server} does not answer ({reason}). Is the platform running? Try `shapery up`.")
