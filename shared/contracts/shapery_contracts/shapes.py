"""The representations of the shape database that the HTTP API sends and takes, shared by gateway and client."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal, Self
from uuid import UUID

from pydantic import BaseModel, ConfigDict, Field, model_validator

from shapery_contracts.retrieval import (
    CollectionName,
    FilterLabels,
    Labels,
    LevelSummary,
    MeshChange,
    Region,
    ShapeHit,
    ShapeName,
)

Description = Annotated[str, Field(max_length=4000)]


class CollectionCreate(BaseModel):
    """A request for a collection."""

    model_config = ConfigDict(extra="forbid")

    name: CollectionName
    description: Description = ""
    metadata: dict[str, Any] = {}


class CollectionUpdate(BaseModel):
    """What shall change of a collection; what is left out stays."""

    model_config = ConfigDict(extra="forbid")

    name: CollectionName | None = None
    description: Description | None = None
    metadata: dict[str, Any] | None = None


class CollectionView(BaseModel):
    """Shapes that belong together."""

    id: UUID
    name: str
    description: str
    metadata: dict[str, Any]
    shapes: int
    outdated: int
    """How many of them were indexed by an older version, and so are not found until they are indexed again."""
    created_at: datetime


class ShapeView(BaseModel):
    """A shape of the bank."""

    id: UUID
    collection: str
    """Name of its collection."""
    collection_id: UUID
    name: str
    labels: dict[str, str]
    metadata: dict[str, Any]
    asset_id: UUID
    """The mesh as it was uploaded; it may have been deleted since."""
    job_id: UUID
    """The job that indexed it last."""
    index_version: int
    outdated: bool
    """Whether it was indexed by an older version, and so is not found until it is indexed again."""
    vertices: int
    faces: int
    components: int
    closed: bool
    oriented: bool
    genus: int | None
    area: float
    bounding_box: list[list[float]]
    created_at: datetime
    indexed_at: datetime
    arg_url: str
    mesh_url: str
    preview_url: str
    components_url: str


class ShapeDetail(ShapeView):
    """A shape with what indexing told of it."""

    changes: list[MeshChange]
    """What was done to the mesh before it was analysed."""
    levels: list[LevelSummary]
    warnings: list[str]


ShapeOrder = Literal["-created", "created", "name", "-name"]
"""What a list of shapes may be ordered by, upwards, or downwards with a minus."""


class LabelCount(BaseModel):
    """A label, and how many shapes carry it."""

    name: str
    value: str
    shapes: int


class ShapeUpdate(BaseModel):
    """What shall change of a shape; what is left out stays."""

    model_config = ConfigDict(extra="forbid")

    name: ShapeName | None = None
    collection: CollectionName | None = None
    """Name of the collection that it shall belong to from now on; it must exist."""
    labels: Labels | None = None
    metadata: dict[str, Any] | None = None


class SearchRequest(BaseModel):
    """A query by example: a stored shape, or an uploaded mesh."""

    model_config = ConfigDict(extra="forbid")

    shape_id: UUID | None = None
    asset_id: UUID | None = None
    region: Region | None = None
    """Faces of the query's mesh, as uploaded, to search with instead of the whole; implies ``partial``."""
    parts: Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1, max_length=64)] | None = None
    """Parts of the query's finest level to search with; implies ``partial``."""
    mode: Literal["global", "partial"] = "global"
    collection: CollectionName | None = None
    labels: FilterLabels = {}
    limit: Annotated[int, Field(ge=1, le=200)] = 20
    rerank: bool = False

    @model_validator(mode="after")
    def _one_query(self) -> Self:
        if (self.shape_id is None) == (self.asset_id is None):
            raise ValueError("give either shape_id or asset_id")
        if self.region is not None and self.parts is not None:
            raise ValueError("give either region or parts, not both")
        return self


class SearchHit(ShapeHit):
    """One shape that was found, with what a viewer shows of it."""

    shape: ShapeView


class SearchAnswer(BaseModel):
    """What a search found."""

    index_version: int
    mode: Literal["global", "partial"]
    candidates: int
    cues: dict[str, float]
    hits: list[SearchHit]
    """Best first."""
    warnings: list[str] = []
    job_id: UUID | None = None
    """The job that computed it, where the query had to be indexed first."""
