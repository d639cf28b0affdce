"""A second vector of each shape, by which wholes are found for a part."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from shapery_platform.db.types import Vector

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column, which shapes have once they are indexed again, and on PostgreSQL an index of neighbours."""
    op.add_column("shapes", sa.Column("part_vector", Vector(256), nullable=True))
    if op.get_context().dialect.name == "postgresql":
        op.create_index(
            "ix_shapes_part_vector",
            "shapes",
            ["part_vector"],
            unique=False,
            postgresql_using="hnsw",
            postgresql_ops={"part_vector": "halfvec_l2_ops"},
        )
