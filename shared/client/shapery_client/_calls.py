"""Requests whose answers are models, and lists that come page by page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from pydantic import BaseModel

from shapery_client._transport import Transport
from shapery_contracts.api import Page

M = TypeVar("M", bound=BaseModel)


class Calls:
    """What the parts of `shapery_client.Client` have in common."""

    _transport: Transport

    def _get(self, path: str, model: type[M]) -> M:
        return model.model_validate(self._transport.request("GET", path).json())

    def _post(self, path: str, model: type[M], *, repeatable: bool = False) -> M:
        return model.model_validate(self._transport.request("POST", path, repeatable=repeatable).json())

    def _pages(self, path: str, model: type[M], filters: Mapping[str, Any]) -> Iterator[M]:
        cursor: str | None = None
        while True:
            query = dict(filters) if cursor is None else {**filters, "cursor": cursor}
            body = self._transport.request("GET", path, params=query).json()
            page = Page[model].model_validate(body)  # type: ignore[valid-type]  # a run-time parameter, by design
            yield from page.items
            cursor = page.next_cursor
            if cursor is None:
                return
