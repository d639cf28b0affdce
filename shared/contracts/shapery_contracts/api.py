"""The representations that the HTTP API sends and takes, shared by gateway and client."""

from __future__ import annotations

from datetime import datetime
from enum import StrEnum
from typing import Annotated, Any, Generic, Literal, TypeVar
from uuid import UUID

from pydantic import BaseModel, ConfigDict, Field

from shapery_contracts.formats import AssetKind
from shapery_contracts.states import JobState

T = TypeVar("T")


class Problem(BaseModel):
    """``application/problem+json`` (RFC 9457) with a stable ``code``."""

    model_config = ConfigDict(extra="allow")

    type: str
    title: str
    status: int
    detail: str
    code: str
    hint: str = ""
    instance: str = ""
    request_id: str = ""


class FieldProblem(BaseModel):
    """One place of a request that is not valid; ``errors`` of a `Problem` lists them."""

    location: str
    message: str


class Page(BaseModel, Generic[T]):
    """One page of a list; ``next_cursor`` is null on the last."""

    items: list[T]
    next_cursor: str | None = None


# What a list may be ordered by, upwards, or downwards with a minus.
AssetOrder = Literal["-created", "created", "name", "-name"]
BatchOrder = Literal["-created", "created"]
JobOrder = Literal["-created", "created", "name", "-name", "state", "-state", "took", "-took"]


class Scope(StrEnum):
    """What an API key may do."""

    READ = "read"
    WRITE = "write"
    ADMIN = "admin"


class AssetView(BaseModel):
    """An uploaded file, addressed by its content."""

    id: UUID
    sha256: str
    size: int
    kind: AssetKind
    format: str
    media_type: str
    filename: str
    details: dict[str, Any] = {}
    created_at: datetime
    content_url: str


class JobCreate(BaseModel):
    """A request for one job."""

    model_config = ConfigDict(extra="forbid")

    kind: str
    inputs: dict[str, UUID | Annotated[list[UUID], Field(min_length=1, max_length=5000)]]
    params: dict[str, Any] = {}


class JobErrorView(BaseModel):
    """Why a job failed or crashed."""

    code: str
    message: str
    hint: str = ""


class ArtifactView(BaseModel):
    """One file that a job made."""

    name: str
    size: int
    sha256: str
    media_type: str
    url: str


class JobView(BaseModel):
    """A job as it is now."""

    id: UUID
    name: str = ""
    """What the stored shape that it is asked about was called when it was made, or else the file name of the first
    asset of its first input; empty without either."""
    kind: str
    state: JobState
    inputs: dict[str, list[UUID]]
    params: dict[str, Any]
    stage: str = ""
    fraction: float = 0.0
    message: str = ""
    preview: int = 0
    """Number of the newest preview of a running job; 0: there is none."""
    event: int = 0
    """Number of the newest event that this view knows of: a stream opened after it tells what is new, and only that."""
    attempt: int = 0
    error: JobErrorView | None = None
    result: dict[str, Any] | None = None
    artifacts: list[ArtifactView] = []
    batch_id: UUID | None = None
    created_at: datetime
    started_at: datetime | None = None
    finished_at: datetime | None = None
    expires_at: datetime | None = None
    """When result and artifacts will be removed; null while the job has not ended."""
    expired: bool = False


class JobEvent(BaseModel):
    """One event of a job's stream; ``seq`` is the SSE id."""

    seq: int
    type: Literal["state", "progress"]
    job_id: UUID
    state: JobState
    stage: str = ""
    fraction: float = 0.0
    message: str = ""
    preview: int = 0
    """Number of the newest preview; 0: there is none."""
    at: datetime


class BatchItem(BaseModel):
    """One item of a batch."""

    model_config = ConfigDict(extra="forbid")

    inputs: dict[str, UUID | Annotated[list[UUID], Field(min_length=1, max_length=5000)]]
    params: dict[str, Any] = {}
    """Merged over the batch's parameters."""


class BatchHeader(BaseModel):
    """The first line of a batch sent as NDJSON; every further line is a `BatchItem`."""

    model_config = ConfigDict(extra="forbid")

    kind: str
    params: dict[str, Any] = {}


class BatchCreate(BatchHeader):
    """A request for many jobs of one kind."""

    items: Annotated[list[BatchItem], Field(min_length=1)]


class BatchView(BaseModel):
    """A batch as it is now."""

    id: UUID
    kind: str
    params: dict[str, Any]
    total: int
    counts: dict[JobState, int]
    finished: bool
    created_at: datetime
    finished_at: datetime | None = None


class BatchEvent(BaseModel):
    """One event of a batch's stream, sent when its counts change; ``seq`` is the SSE id."""

    seq: int
    batch_id: UUID
    counts: dict[JobState, int]
    finished: bool


class BatchResult(BaseModel):
    """One line of a batch's results."""

    index: int
    job: JobView


class KeyCreate(BaseModel):
    """A request for an API key."""

    model_config = ConfigDict(extra="forbid")

    name: Annotated[str, Field(min_length=1, max_length=100)]
    scopes: Annotated[list[Scope], Field(min_length=1)] = [Scope.READ, Scope.WRITE]
    expires_at: datetime | None = None


class KeyView(BaseModel):
    """An API key without its secret."""

    id: UUID
    name: str
    prefix: str
    scopes: list[Scope]
    created_at: datetime
    expires_at: datetime | None = None
    last_used_at: datetime | None = None


class KeyCreated(KeyView):
    """An API key just made, the only time its secret is shown."""

    secret: str


class JobKindView(BaseModel):
    """What ``GET /v1/kinds`` tells of a job kind."""

    name: str
    service: str
    summary: str
    inputs: dict[str, dict[str, Any]]
    params_schema: dict[str, Any]
    result_schema: dict[str, Any]
    stages: list[str]
    time_limit: float
    memory_limit: int
    workers: int
    """Live workers that serve this kind."""


class StoredView(BaseModel):
    """A number of files and how much they hold together."""

    files: int = 0
    bytes: int = 0


class UsageView(BaseModel):
    """What ``GET /v1/usage`` tells: how many jobs one has in which state, and how much one keeps on the server."""

    jobs: dict[JobState, int]
    """States in which there is none are missing."""
    assets: dict[AssetKind, StoredView]
    """Uploads by kind; one uploaded twice counts twice, though it is stored once."""
    results: StoredView
    """Files that jobs made and that have not expired."""


class ServerInfo(BaseModel):
    """What ``GET /v1/info`` tells of the server: version, how one signs in, and the limits."""

    version: str
    auth: Literal["local", "keys"]
    max_upload_bytes: int
    max_batch_items: int
    result_ttl_seconds: float
    upload_ttl_seconds: float
