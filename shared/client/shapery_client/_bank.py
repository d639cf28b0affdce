"""The part of `shapery_client.Client` that speaks of collections and shapes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal
from uuid import UUID

from shapery_client._calls import Calls
from shapery_contracts.api import BatchView, JobView
from shapery_contracts.shapes import (
    CollectionCreate,
    CollectionUpdate,
    CollectionView,
    ShapeDetail,
    ShapeOrder,
    ShapeUpdate,
    ShapeView,
)

Id = UUID | str
ShapeFileName = Literal["arg", "mesh.glb", "preview.png", "components"]


class BankCalls(Calls):
    """The shape database."""

    def collections(self) -> Iterator[CollectionView]:
        """Iterate over all collections, newest first."""
        return self._pages("/v1/collections", CollectionView, {})

    def collection(self, collection_id: Id) -> CollectionView:
        """Return a collection."""
        return self._get(f"/v1/collections/{collection_id}", CollectionView)

    def create_collection(
        self, name: str, description: str = "", metadata: Mapping[str, Any] | None = None
    ) -> CollectionView:
        """Make a collection; the first shape that names one which does not exist makes it, too."""
        request = CollectionCreate(name=name, description=description, metadata=dict(metadata or {}))
        response = self._transport.request("POST", "/v1/collections", json=request.model_dump(mode="json"))
        return CollectionView.model_validate(response.json())

    def update_collection(self, collection_id: Id, **changes: Any) -> CollectionView:
        """Change ``name``, ``description`` or ``metadata`` of a collection."""
        body = CollectionUpdate(**changes).model_dump(mode="json", exclude_unset=True)
        response = self._transport.request("PATCH", f"/v1/collections/{collection_id}", repeatable=True, json=body)
        return CollectionView.model_validate(response.json())

    def delete_collection(self, collection_id: Id, *, shapes: bool = False) -> None:
        """Delete a collection, with `shapes` those in it, too; without, it must be empty."""
        self._transport.request("DELETE", f"/v1/collections/{collection_id}", params={"shapes": shapes})

    def reindex_collection(self, collection_id: Id) -> BatchView:
        """Index the shapes again that an older version has indexed."""
        return self._post(f"/v1/collections/{collection_id}/reindex", BatchView)

    def shapes(
        self,
        *,
        collection: str | None = None,
        labels: Mapping[str, str] | None = None,
        name: str | None = None,
        outdated: bool = False,
        order: ShapeOrder = "-created",
    ) -> Iterator[ShapeView]:
        """Iterate over all shapes in an order; only those of a collection, with all labels, with a text in the name.

        `outdated` leaves those that an older version has indexed, which searches do not see.
        """
        filters: dict[str, Any] = {"label": [f"{key}:{value}" for key, value in (labels or {}).items()], "limit": 200}
        filters["order"] = order
        if collection is not None:
            filters["collection"] = collection
        if name is not None:
            filters["name"] = name
        if outdated:
            filters["outdated"] = True
        return self._pages("/v1/shapes", ShapeView, filters)

    def shape(self, shape_id: Id) -> ShapeDetail:
        """Return a shape with its levels of parts."""
        return self._get(f"/v1/shapes/{shape_id}", ShapeDetail)

    def shape_file(self, shape_id: Id, name: ShapeFileName) -> bytes:
        """Return a file of a shape: its graph, web mesh, picture, or parts by level."""
        return self._transport.request("GET", f"/v1/shapes/{shape_id}/{name}").content

    def update_shape(self, shape_id: Id, **changes: Any) -> ShapeDetail:
        """Change ``name``, ``collection``, ``labels`` or ``metadata`` of a shape."""
        body = ShapeUpdate(**changes).model_dump(mode="json", exclude_unset=True)
        response = self._transport.request("PATCH", f"/v1/shapes/{shape_id}", repeatable=True, json=body)
        return ShapeDetail.model_validate(response.json())

    def delete_shape(self, shape_id: Id) -> None:
        """Delete a shape; the mesh that it was made of stays."""
        self._transport.request("DELETE", f"/v1/shapes/{shape_id}")

    def reindex_shape(self, shape_id: Id) -> JobView:
        """Index a shape again; it is replaced at the end of the job."""
        return self._post(f"/v1/shapes/{shape_id}/reindex", JobView)
