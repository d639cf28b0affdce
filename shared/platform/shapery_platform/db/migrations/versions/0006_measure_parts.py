"""All shapes are measured for a part, of which an index of neighbours lost half; wholes are found by a finer one."""

from __future__ import annotations

from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Drop the index over the vectors of parts, and make that over those of wholes anew; PostgreSQL alone has them."""
    if op.get_context().dialect.name != "postgresql":
        return
    op.drop_index("ix_shapes_part_vector", "shapes")
    op.drop_index("ix_shapes_vector", "shapes")
    op.create_index(
        "ix_shapes_vector",
        "shapes",
        ["vector"],
        unique=False,
        postgresql_using="hnsw",
        postgresql_with={"m": 24, "ef_construction": 128},
        postgresql_ops={"vector": "halfvec_l2_ops"},
    )
