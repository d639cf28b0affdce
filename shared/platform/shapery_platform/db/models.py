"""The tables. The same classes serve SQLite and PostgreSQL; `migrations` builds them, a test compares both.

Rows are the truth of the platform: what the queue or the object store hold beyond them is made good or swept away.
"""

from __future__ import annotations

from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import (
    DDL,
    JSON,
    BigInteger,
    CheckConstraint,
    Enum,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Text,
    UniqueConstraint,
    Uuid,
    event,
    text,
)
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column, relationship

from shapery_contracts.retrieval import VECTOR_DIMENSION
from shapery_contracts.states import JobState
from shapery_platform.db.types import UtcDateTime, Vector, new_id, utc_now

LIVE_STATES = (JobState.QUEUED, JobState.RUNNING, JobState.CANCELLING)
"""A job in one of these may still read its inputs."""
_LEASED = "('running', 'cancelling')"
_LIVE = "('queued', 'running', 'cancelling')"

# Conditions of partial indices. SQLite uses such an index only for a query that has the very same words in its own
# condition, so queries take them from here.
IS_LIVE = f"jobs.state IN {_LIVE}"
WILL_EXPIRE = "jobs.expires_at IS NOT NULL AND NOT jobs.expired"


class Base(DeclarativeBase):
    """Root of the models; constraint names follow one rule, so that migrations can name them."""

    metadata = MetaData(
        naming_convention={
            "ix": "ix_%(table_name)s_%(column_0_N_name)s",
            "uq": "uq_%(table_name)s_%(column_0_N_name)s",
            "ck": "ck_%(table_name)s_%(constraint_name)s",
            "fk": "fk_%(table_name)s_%(column_0_name)s_%(referred_table_name)s",
            "pk": "pk_%(table_name)s",
        }
    )
    type_annotation_map = {  # noqa: RUF012
        UUID: Uuid(),
        datetime: UtcDateTime(),
        # JSON and not JSONB: it keeps the order of keys and takes every string that JSON can hold
        dict[str, Any]: JSON(),
        list[str]: JSON(),
        JobState: Enum(
            JobState,
            native_enum=False,
            create_constraint=False,
            length=16,
            values_callable=lambda states: [state.value for state in states],
        ),
    }


class ApiKey(Base):
    """A key to the API. Of its secret only the hash is kept."""

    __tablename__ = "api_keys"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=new_id)
    owner: Mapped[str] = mapped_column(String(64), index=True)
    name: Mapped[str] = mapped_column(String(200))
    prefix: Mapped[str] = mapped_column(String(16))
    secret_hash: Mapped[str] = mapped_column(String(64), unique=True)
    scopes: Mapped[list[str]]
    created_at: Mapped[datetime] = mapped_column(default=utc_now)
    expires_at: Mapped[datetime | None]
    last_used_at: Mapped[datetime | None]
    revoked_at: Mapped[datetime | None]


class Blob(Base):
    """Bytes in the object store, addressed by their hash.

    Whether something refers to a blob is asked of the tables that do, never of a counter that might drift.
    """

    __tablename__ = "blobs"

    sha256: Mapped[str] = mapped_column(String(64), primary_key=True)
    size: Mapped[int] = mapped_column(BigInteger)
    created_at: Mapped[datetime] = mapped_column(default=utc_now)
    check_after: Mapped[datetime | None] = mapped_column(index=True)
    """When the sweep shall look whether anything refers to it; null: something does. An upload that is about to
    refer to it sets a time ahead, which keeps the blob until then."""


class Asset(Base):
    """An uploaded file of an owner."""

    __tablename__ = "assets"
    __table_args__ = (Index(None, "owner", "id"), Index(None, "owner", "filename", "id"), Index(None, "sha256"))

    id: Mapped[UUID] = mapped_column(primary_key=True, default=new_id)
    owner: Mapped[str] = mapped_column(String(64))
    sha256: Mapped[str] = mapped_column(String(64))
    size: Mapped[int] = mapped_column(BigInteger)
    kind: Mapped[str] = mapped_column(String(32))
    format: Mapped[str] = mapped_column(String(32))
    media_type: Mapped[str] = mapped_column(String(127))
    extension: Mapped[str] = mapped_column(String(32))
    filename: Mapped[str] = mapped_column(String(255))
    details: Mapped[dict[str, Any]]
    created_at: Mapped[datetime] = mapped_column(default=utc_now)
    deleted_at: Mapped[datetime | None]


class Upload(Base):
    """A resumable upload. `offset` is the truth; what staging holds beyond it never happened."""

    __tablename__ = "uploads"
    __table_args__ = (Index(None, "owner", "id"), CheckConstraint('"offset" >= 0', name="offset"))

    id: Mapped[UUID] = mapped_column(primary_key=True, default=new_id)
    owner: Mapped[str] = mapped_column(String(64))
    length: Mapped[int | None] = mapped_column(BigInteger)
    """Null while the length is deferred."""
    offset: Mapped[int] = mapped_column(BigInteger, default=0)
    details: Mapped[dict[str, Any]] = mapped_column("metadata")
    """The key-value pairs of ``Upload-Metadata``."""
    created_at: Mapped[datetime] = mapped_column(default=utc_now)
    expires_at: Mapped[datetime] = mapped_column(index=True)
    lease: Mapped[UUID | None]
    """Token of the request that is writing."""
    lease_until: Mapped[datetime | None]
    asset_id: Mapped[UUID | None] = mapped_column(ForeignKey("assets.id"))
    """What became of it."""


class UploadPart(Base):
    """One piece of an upload that is staged as objects of their own (S3)."""

    __tablename__ = "upload_parts"

    upload_id: Mapped[UUID] = mapped_column(ForeignKey("uploads.id", ondelete="CASCADE"), primary_key=True)
    offset: Mapped[int] = mapped_column(BigInteger, primary_key=True, autoincrement=False)
    size: Mapped[int] = mapped_column(BigInteger)
    key: Mapped[str] = mapped_column(String(255))


class Batch(Base):
    """Many jobs of one kind, asked for in one request."""

    __tablename__ = "batches"
    __table_args__ = (Index(None, "owner", "id"), UniqueConstraint("owner", "idempotency_key"))

    id: Mapped[UUID] = mapped_column(primary_key=True, default=new_id)
    owner: Mapped[str] = mapped_column(String(64))
    kind: Mapped[str] = mapped_column(String(64))
    params: Mapped[dict[str, Any]]
    total: Mapped[int] = mapped_column(Integer)
    idempotency_key: Mapped[str | None] = mapped_column(String(255))
    fingerprint: Mapped[str] = mapped_column(String(64))
    created_at: Mapped[datetime] = mapped_column(default=utc_now)


class Job(Base):
    """A job. Only `shapery_platform.jobs` writes its state, and only by the table of transitions."""

    __tablename__ = "jobs"
    __table_args__ = (
        UniqueConstraint("owner", "idempotency_key"),
        UniqueConstraint("batch_id", "batch_index"),
        Index("ix_jobs_owner_id", "owner", "id"),
        Index("ix_jobs_owner_state_id", "owner", "state", "id"),
        Index("ix_jobs_owner_kind_id", "owner", "kind", "id"),
        Index("ix_jobs_owner_name_id", "owner", "name", "id"),
        Index("ix_jobs_owner_took_id", "owner", "took", "id"),
        Index("ix_jobs_batch_id_state", "batch_id", "state"),
        # what the reaper and the dispatcher ask every second stays small however many jobs have ended
        Index(
            "ix_jobs_live",
            "state",
            "service",
            "id",
            sqlite_where=text(IS_LIVE.replace("jobs.", "")),
            postgresql_where=text(IS_LIVE.replace("jobs.", "")),
        ),
        Index(
            "ix_jobs_expires_at",
            "expires_at",
            sqlite_where=text(WILL_EXPIRE.replace("jobs.", "")),
            postgresql_where=text(WILL_EXPIRE.replace("jobs.", "")),
        ),
        CheckConstraint(f"(lease IS NOT NULL) = (state IN {_LEASED})", name="lease"),
        CheckConstraint(f"(finished_at IS NULL) = (state IN {_LIVE})", name="finished"),
    )

    id: Mapped[UUID] = mapped_column(primary_key=True, default=new_id)
    owner: Mapped[str] = mapped_column(String(64))
    kind: Mapped[str] = mapped_column(String(64))
    service: Mapped[str] = mapped_column(String(64))
    """The service whose workers run it, which is also its queue."""
    params: Mapped[dict[str, Any]]
    batch_id: Mapped[UUID | None] = mapped_column(ForeignKey("batches.id"))
    batch_index: Mapped[int | None] = mapped_column(Integer)
    idempotency_key: Mapped[str | None] = mapped_column(String(255))
    fingerprint: Mapped[str] = mapped_column(String(64))

    state: Mapped[JobState] = mapped_column(default=JobState.QUEUED)
    attempt: Mapped[int] = mapped_column(Integer, default=0)
    """How often it was claimed since it was created or retried."""
    max_attempts: Mapped[int] = mapped_column(Integer)
    result_ttl: Mapped[float] = mapped_column(Float)
    """Seconds that result and artifacts stay; as was promised when the job was created."""
    lease: Mapped[UUID | None]
    """Token of the worker that has it; whoever holds another may not write."""
    worker_id: Mapped[str | None] = mapped_column(String(200))
    heartbeat_at: Mapped[datetime | None]
    enqueued_at: Mapped[datetime | None]
    """When its message was last given to the queue; null: not yet."""

    stage: Mapped[str] = mapped_column(String(64), default="")
    fraction: Mapped[float] = mapped_column(Float, default=0.0)
    message: Mapped[str] = mapped_column(Text, default="")
    error_code: Mapped[str | None] = mapped_column(String(64))
    error_message: Mapped[str | None] = mapped_column(Text)
    error_hint: Mapped[str | None] = mapped_column(Text)
    result: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    event_seq: Mapped[int] = mapped_column(Integer, default=0)
    """Number of the last event."""

    created_at: Mapped[datetime] = mapped_column(default=utc_now)
    started_at: Mapped[datetime | None]
    finished_at: Mapped[datetime | None]
    expires_at: Mapped[datetime | None]
    expired: Mapped[bool] = mapped_column(default=False)
    preview: Mapped[int] = mapped_column(Integer, default=0, server_default=text("0"))
    """Number of its preview, which is that of the event that told of it; 0: there is none."""
    name: Mapped[str] = mapped_column(String(255), default="", server_default=text("''"))
    """What people know it by, see `jobs.creation.job_name`; also after what it is named by was deleted or renamed."""
    took: Mapped[float] = mapped_column(Float, default=-1.0, server_default=text("-1"))
    """Seconds from its start to its end; -1 while it has not ended, and where it never began."""

    inputs: Mapped[list[JobInput]] = relationship(
        lazy="selectin", order_by="(JobInput.name, JobInput.position)", viewonly=True
    )
    artifacts: Mapped[list[JobArtifact]] = relationship(lazy="selectin", order_by="JobArtifact.name", viewonly=True)


class JobInput(Base):
    """One asset that a job reads."""

    __tablename__ = "job_inputs"
    __table_args__ = (Index(None, "asset_id"),)

    job_id: Mapped[UUID] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    name: Mapped[str] = mapped_column(String(64), primary_key=True)
    position: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=False)
    asset_id: Mapped[UUID] = mapped_column(ForeignKey("assets.id"))


class JobArtifact(Base):
    """One file that a job made."""

    __tablename__ = "job_artifacts"
    __table_args__ = (Index(None, "sha256"),)

    job_id: Mapped[UUID] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    name: Mapped[str] = mapped_column(String(255), primary_key=True)
    sha256: Mapped[str] = mapped_column(ForeignKey("blobs.sha256"))
    size: Mapped[int] = mapped_column(BigInteger)
    media_type: Mapped[str] = mapped_column(String(127))


class JobPreview(Base):
    """How the result of a running job looks so far. Apart from the job, so that nothing else reads over it."""

    __tablename__ = "job_previews"

    job_id: Mapped[UUID] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    number: Mapped[int] = mapped_column(Integer)
    data: Mapped[bytes] = mapped_column(LargeBinary)


class JobEvent(Base):
    """One event of a job, numbered by `seq` within it."""

    __tablename__ = "job_events"

    job_id: Mapped[UUID] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    seq: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=False)
    type: Mapped[str] = mapped_column(String(16))
    """``state`` or ``progress``."""
    state: Mapped[JobState]
    stage: Mapped[str] = mapped_column(String(64), default="")
    fraction: Mapped[float] = mapped_column(Float, default=0.0)
    message: Mapped[str] = mapped_column(Text, default="")
    at: Mapped[datetime] = mapped_column(default=utc_now)
    preview: Mapped[int] = mapped_column(Integer, default=0, server_default=text("0"))


class Collection(Base):
    """Shapes of an owner that belong together."""

    __tablename__ = "collections"
    __table_args__ = (UniqueConstraint("owner", "name"), Index(None, "owner", "id"))

    id: Mapped[UUID] = mapped_column(primary_key=True, default=new_id)
    owner: Mapped[str] = mapped_column(String(64))
    name: Mapped[str] = mapped_column(String(200))
    description: Mapped[str] = mapped_column(Text, default="")
    details: Mapped[dict[str, Any]] = mapped_column("metadata", default=dict)
    created_at: Mapped[datetime] = mapped_column(default=utc_now)


class Bank(Base):
    """How often the shapes of an owner have changed, so that whoever keeps them in memory knows what to read anew.

    Its row is locked by whoever changes shapes, before anything else: revisions are committed in their order.
    """

    __tablename__ = "banks"

    owner: Mapped[str] = mapped_column(String(64), primary_key=True)
    revision: Mapped[int] = mapped_column(BigInteger)
    """Number of the last change; each shape has that of its own last one."""
    removals: Mapped[int] = mapped_column(BigInteger)
    """How often shapes were taken away."""


class Shape(Base):
    """An indexed mesh."""

    __tablename__ = "shapes"
    __table_args__ = (
        Index(None, "owner", "id"),
        Index(None, "owner", "name", "id"),
        Index(None, "owner", "revision"),
        Index(None, "collection_id", "id"),
        Index(None, "collection_id", "index_version"),  # holds all that counting needs
        UniqueConstraint("job_id"),
        Index(
            "ix_shapes_vector",
            "vector",
            postgresql_using="hnsw",
            # a shape among hundreds that are nearly alike has to see beyond them, or no way leads there
            postgresql_with={"m": 24, "ef_construction": 400},
            postgresql_ops={"vector": "halfvec_l2_ops"},
        ).ddl_if(dialect="postgresql"),
    )

    id: Mapped[UUID] = mapped_column(primary_key=True, default=new_id)
    owner: Mapped[str] = mapped_column(String(64))
    collection_id: Mapped[UUID] = mapped_column(ForeignKey("collections.id"))
    asset_id: Mapped[UUID] = mapped_column(ForeignKey("assets.id"), index=True)
    """The mesh as it was uploaded; it may have been deleted since."""
    job_id: Mapped[UUID] = mapped_column(ForeignKey("jobs.id"))
    """What indexed it last. Unique: a job gives one shape, however often it is tried."""
    name: Mapped[str] = mapped_column(String(255))
    details: Mapped[dict[str, Any]] = mapped_column("metadata", default=dict)
    index_version: Mapped[int] = mapped_column(Integer)
    revision: Mapped[int] = mapped_column(BigInteger)
    """The bank's, when it changed last."""
    vector: Mapped[bytes] = mapped_column(Vector(VECTOR_DIMENSION), deferred=True)
    report: Mapped[dict[str, Any]]
    """What indexing told of the mesh."""
    arg_sha256: Mapped[str] = mapped_column(String(64))
    arg_size: Mapped[int] = mapped_column(Integer)
    created_at: Mapped[datetime] = mapped_column(default=utc_now)
    indexed_at: Mapped[datetime] = mapped_column(default=utc_now)
    part_vector: Mapped[bytes | None] = mapped_column(Vector(VECTOR_DIMENSION), deferred=True)
    """None for shapes of index versions that had none."""

    collection: Mapped[Collection] = relationship(lazy="joined", innerjoin=True, viewonly=True)
    labels: Mapped[list[ShapeLabel]] = relationship(lazy="selectin", order_by="ShapeLabel.name", viewonly=True)


class ShapeGraph(Base):
    """The attributed relational graph of a shape. Apart from the shape, so that lists do not read over it."""

    __tablename__ = "shape_graphs"

    shape_id: Mapped[UUID] = mapped_column(ForeignKey("shapes.id", ondelete="CASCADE"), primary_key=True)
    data: Mapped[bytes] = mapped_column(LargeBinary)


class ShapeFile(Base):
    """A file of a shape for viewers: its web mesh, its picture, its parts."""

    __tablename__ = "shape_files"
    __table_args__ = (Index(None, "sha256"),)

    shape_id: Mapped[UUID] = mapped_column(ForeignKey("shapes.id", ondelete="CASCADE"), primary_key=True)
    name: Mapped[str] = mapped_column(String(64), primary_key=True)
    sha256: Mapped[str] = mapped_column(ForeignKey("blobs.sha256"))
    size: Mapped[int] = mapped_column(BigInteger)
    media_type: Mapped[str] = mapped_column(String(127))


class ShapeLabel(Base):
    """One label of a shape, by which lists and searches are narrowed."""

    __tablename__ = "shape_labels"
    __table_args__ = (Index(None, "name", "value", "shape_id"),)

    shape_id: Mapped[UUID] = mapped_column(ForeignKey("shapes.id", ondelete="CASCADE"), primary_key=True)
    name: Mapped[str] = mapped_column(String(64), primary_key=True)
    value: Mapped[str] = mapped_column(String(256))


class Worker(Base):
    """A worker process that announced itself."""

    __tablename__ = "workers"

    id: Mapped[str] = mapped_column(String(200), primary_key=True)
    service: Mapped[str] = mapped_column(String(64))
    kinds: Mapped[list[str]]
    host: Mapped[str] = mapped_column(String(255))
    pid: Mapped[int] = mapped_column(Integer)
    started_at: Mapped[datetime] = mapped_column(default=utc_now)
    seen_at: Mapped[datetime] = mapped_column(default=utc_now, index=True)


# Before the tables: the type of a column is the extension's.
event.listen(
    Base.metadata,
    "before_create",
    DDL("CREATE EXTENSION IF NOT EXISTS vector").execute_if(dialect="postgresql"),  # type: ignore[no-untyped-call]
)
