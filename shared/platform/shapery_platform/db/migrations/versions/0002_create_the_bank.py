"""Create the tables of the shape database."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from shapery_platform.db.types import Vector

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the tables, on PostgreSQL with the extension pgvector and an index of neighbours."""
    on_postgresql = op.get_context().dialect.name == "postgresql"
    if on_postgresql:
        op.execute("CREATE EXTENSION IF NOT EXISTS vector")
    op.create_table(
        "banks",
        sa.Column("owner", sa.String(length=64), nullable=False),
        sa.Column("revision", sa.BigInteger(), nullable=False),
        sa.Column("removals", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("owner", name=op.f("pk_banks")),
    )
    op.create_table(
        "collections",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("owner", sa.String(length=64), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("description", sa.Text(), nullable=False),
        sa.Column("metadata", sa.JSON(), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_collections")),
        sa.UniqueConstraint("owner", "name", name=op.f("uq_collections_owner_name")),
    )
    op.create_index(op.f("ix_collections_owner_id"), "collections", ["owner", "id"], unique=False)
    op.create_table(
        "shapes",
        sa.Column("id", sa.Uuid(), nullable=False),
        sa.Column("owner", sa.String(length=64), nullable=False),
        sa.Column("collection_id", sa.Uuid(), nullable=False),
        sa.Column("asset_id", sa.Uuid(), nullable=False),
        sa.Column("job_id", sa.Uuid(), nullable=False),
        sa.Column("name", sa.String(length=255), nullable=False),
        sa.Column("metadata", sa.JSON(), nullable=False),
        sa.Column("index_version", sa.Integer(), nullable=False),
        sa.Column("revision", sa.BigInteger(), nullable=False),
        sa.Column("vector", Vector(256), nullable=False),
        sa.Column("report", sa.JSON(), nullable=False),
        sa.Column("arg_sha256", sa.String(length=64), nullable=False),
        sa.Column("arg_size", sa.Integer(), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("indexed_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(["asset_id"], ["assets.id"], name=op.f("fk_shapes_asset_id_assets")),
        sa.ForeignKeyConstraint(
            ["collection_id"], ["collections.id"], name=op.f("fk_shapes_collection_id_collections")
        ),
        sa.ForeignKeyConstraint(["job_id"], ["jobs.id"], name=op.f("fk_shapes_job_id_jobs")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_shapes")),
        sa.UniqueConstraint("job_id", name=op.f("uq_shapes_job_id")),
    )
    op.create_index(op.f("ix_shapes_asset_id"), "shapes", ["asset_id"], unique=False)
    op.create_index(op.f("ix_shapes_collection_id_id"), "shapes", ["collection_id", "id"], unique=False)
    op.create_index(
        op.f("ix_shapes_collection_id_index_version"), "shapes", ["collection_id", "index_version"], unique=False
    )
    op.create_index(op.f("ix_shapes_owner_id"), "shapes", ["owner", "id"], unique=False)
    op.create_index(op.f("ix_shapes_owner_revision"), "shapes", ["owner", "revision"], unique=False)
    if on_postgresql:
        op.create_index(
            "ix_shapes_vector",
            "shapes",
            ["vector"],
            unique=False,
            postgresql_using="hnsw",
            postgresql_ops={"vector": "halfvec_l2_ops"},
        )
    op.create_table(
        "shape_files",
        sa.Column("shape_id", sa.Uuid(), nullable=False),
        sa.Column("name", sa.String(length=64), nullable=False),
        sa.Column("sha256", sa.String(length=64), nullable=False),
        sa.Column("size", sa.BigInteger(), nullable=False),
        sa.Column("media_type", sa.String(length=127), nullable=False),
        sa.ForeignKeyConstraint(["sha256"], ["blobs.sha256"], name=op.f("fk_shape_files_sha256_blobs")),
        sa.ForeignKeyConstraint(
            ["shape_id"], ["shapes.id"], name=op.f("fk_shape_files_shape_id_shapes"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("shape_id", "name", name=op.f("pk_shape_files")),
    )
    op.create_index(op.f("ix_shape_files_sha256"), "shape_files", ["sha256"], unique=False)
    op.create_table(
        "shape_graphs",
        sa.Column("shape_id", sa.Uuid(), nullable=False),
        sa.Column("data", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(
            ["shape_id"], ["shapes.id"], name=op.f("fk_shape_graphs_shape_id_shapes"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("shape_id", name=op.f("pk_shape_graphs")),
    )
    op.create_table(
        "shape_labels",
        sa.Column("shape_id", sa.Uuid(), nullable=False),
        sa.Column("name", sa.String(length=64), nullable=False),
        sa.Column("value", sa.String(length=256), nullable=False),
        sa.ForeignKeyConstraint(
            ["shape_id"], ["shapes.id"], name=op.f("fk_shape_labels_shape_id_shapes"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("shape_id", "name", name=op.f("pk_shape_labels")),
    )
    op.create_index(
        op.f("ix_shape_labels_name_value_shape_id"), "shape_labels", ["name", "value", "shape_id"], unique=False
    )
