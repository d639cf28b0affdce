"""Parameters and results of ``shape-index`` and ``shape-search``, and what a search reads of the bank (chapter 4)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any, Literal, NamedTuple, Protocol
from uuid import UUID

from pydantic import BaseModel, ConfigDict, Field

INDEX_VERSION = 6
"""Version of everything that is computed from a mesh. Shapes of different versions are never compared: a bank answers
with those of the version asked for, and a new version means indexing the stored meshes again."""

VECTOR_DIMENSION = 256
"""Length of the vectors by which candidates are found; nearness is their Euclidean distance."""

By = Literal["whole", "parts"]
"""Which of a shape's two vectors is meant: that of the whole, or that of the parts it holds."""

DEFAULT_COLLECTION = "default"

Labels = dict[
    Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[^:]+$")], Annotated[str, Field(max_length=256)]
]
"""Names and values; a name has no colon, so that ``name:value`` is a label in an address or on a command line."""
FilterLabels = Annotated[Labels, Field(max_length=16)]
"""Each is a condition that every shape is asked for."""
CollectionName = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^\S(.*\S)?$")]
ShapeName = Annotated[str, Field(max_length=255)]
Region = Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1, max_length=5_000_000)]


class ShapeIndexParams(BaseModel):
    """How to index one mesh, and where the bank shall keep it.

    What is compared later has no settings, so that all shapes of a bank are comparable.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    preview_size: Annotated[int, Field(ge=32, le=1024)] = 256
    """Side of the preview picture in pixels."""
    collection: CollectionName = DEFAULT_COLLECTION
    """Name of the collection that the shape shall belong to; it is made where there is none of this name."""
    name: ShapeName = ""
    """What the shape is called; by default like the file, without its extension."""
    labels: Labels = {}
    metadata: dict[str, Any] = {}
    """Anything that shall be kept with the shape."""
    replaces: UUID | None = None
    """A shape of the bank to index again: it keeps its id, name, collection, labels and metadata."""


class MeshChange(BaseModel):
    """One step of the normalisation and how many elements it touched."""

    name: str
    count: int


class LevelSummary(BaseModel):
    """One level of the hierarchy; level 0 is the whole shape."""

    level: int
    parts: int
    masses: list[float]
    """Share of the surface's area of each part; they sum to 1."""
    parents: list[int]
    """For each part the part of the level above that holds it; empty at level 0."""
    edges: list[tuple[int, int]]
    """Pairs of adjacent parts."""


class IndexStage(BaseModel):
    """How long one stage took, in wall time."""

    name: str
    seconds: float


class ShapeIndexResult(BaseModel):
    """What ``report.json`` holds and the API returns.

    Artifacts: ``shape.arg`` (the attributed relational graph), ``mesh.glb`` (for viewers), ``components.json`` (for
    each level the part of every vertex of ``mesh.glb``, the cell of each, of which parts consist, and how the shape
    stands: the axes to the right, up and to the front, and, along them, the direction to whoever looks),
    ``preview.png``, ``report.json``.
    """

    index_version: int
    vector: Annotated[list[float], Field(min_length=VECTOR_DIMENSION, max_length=VECTOR_DIMENSION)]
    """By which candidates are found for a whole."""
    part_vector: Annotated[list[float], Field(min_length=VECTOR_DIMENSION, max_length=VECTOR_DIMENSION)]
    """By which candidates are found for a part."""
    arg: str = "shape.arg"
    """Name of the artifact with the graph."""
    arg_bytes: int
    vertices: int
    """As given in the file."""
    faces: int
    components: int
    """Connected parts after welding."""
    closed: bool
    oriented: bool
    genus: int | None
    """Handles; None where the welded mesh is not manifold or not oriented."""
    area: float
    """In the square of the file's unit."""
    bounding_box: list[list[float]]
    """(2, 3) least and largest coordinates."""
    changes: list[MeshChange]
    """What was done to the mesh before it was analysed; the stored mesh itself stays as it was uploaded."""
    levels: list[LevelSummary]
    stages: list[IndexStage]
    warnings: list[str] = []


class ShapeFilter(BaseModel):
    """Which shapes of the bank are asked for. The owner is no part of it: a bank shows one owner's shapes only."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    collection: str | None = None
    """Only shapes of this collection."""
    labels: FilterLabels = {}
    """Only shapes that carry all of these labels with these values."""


class ShapeSearchParams(BaseModel):
    """What to look for: a mesh (the input ``mesh``) or a stored shape, whole or a region of it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    shape_id: str | None = None
    """A stored shape to query by; it is left out of the results. Without it the input ``mesh`` is the query."""
    mode: Literal["global", "partial"] = "global"
    """``global`` sums the scores of all levels; ``partial`` takes the best level and allows parts without partner."""
    region: Region | None = None
    """Faces of the query mesh to search with instead of the whole; implies ``partial``. Needs the input ``mesh``."""
    parts: Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1, max_length=64)] | None = None
    """Parts of the finest level of the query to search with; implies ``partial``."""
    limit: Annotated[int, Field(ge=1, le=200)] = 20
    filter: ShapeFilter = ShapeFilter()
    rerank: bool = False
    """Whether the order follows how the found shapes resemble each other, too."""


class PartMatch(BaseModel):
    """Two parts that the matching put together."""

    query: int
    """Part of the query, at the hit's level; of the whole one's, where a region of it was searched with."""
    found: int
    """Part of the found shape, at the same level."""
    weight: float
    """Share of the query's area that the matching carries between the two."""


class ShapeHit(BaseModel):
    """One shape that was found."""

    shape_id: str
    score: float
    """In [0, 1]; 1 for the query itself."""
    level: int
    """The level that fits best; `matches` are of this level."""
    level_scores: list[float]
    """Score of each level, from the coarsest."""
    matches: list[PartMatch]
    cells: list[int] = []
    """For each cell of the found shape, as its ``components.json`` numbers them, the part of the query's finest level
    that lies there, or -1. Borders of parts move with the pose; cells show the query's parts with their own borders on
    the found shape. Empty in results of earlier versions."""


class ShapeSearchResult(BaseModel):
    """What a search answers.

    Artifacts: ``results.json``; where a mesh was searched with, also its ``mesh.glb`` and ``components.json``.
    """

    index_version: int
    mode: Literal["global", "partial"]
    candidates: int
    """How many shapes of the bank were compared by their graphs."""
    cues: dict[str, float]
    """How much each group of cues counted for this query; they sum to 1."""
    hits: list[ShapeHit]
    """Best first."""
    stages: list[IndexStage]
    warnings: list[str] = []


class Candidate(NamedTuple):
    """A shape near the query's vector."""

    shape_id: str
    distance: float
    vector: bytes
    """Its vector by which it was found: `VECTOR_DIMENSION` little-endian 32-bit numbers."""


class Nearest(BaseModel):
    """Which candidates a search asks a bank for."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    vector: Annotated[list[float], Field(min_length=VECTOR_DIMENSION, max_length=VECTOR_DIMENSION)]
    limit: Annotated[int, Field(ge=1)]
    by: By = "whole"
    only: ShapeFilter = ShapeFilter()
    version: int = INDEX_VERSION


class ShapeBank(Protocol):
    """What a search reads of the shape database. It shows one owner's shapes only."""

    def candidates(self, asked: Nearest) -> Sequence[Candidate]:
        """Return the nearest shapes of the index version, nearest first, ties by id."""

    def args(self, ids: Iterable[str]) -> Mapping[str, bytes]:
        """Return the serialised graphs of shapes by id; ids that are not there are left out.

        A graph never changes under its id: whoever keeps it may do so under the id.
        """
