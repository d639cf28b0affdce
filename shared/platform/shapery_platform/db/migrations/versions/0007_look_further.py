"""The index of neighbours joins groups of hundreds of like shapes, which nothing led to before."""

from __future__ import annotations

from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the index over the vectors of wholes anew, where each shape looks further; PostgreSQL alone has it."""
    if op.get_context().dialect.name != "postgresql":
        return
    op.drop_index("ix_shapes_vector", "shapes")
    op.create_index(
        "ix_shapes_vector",
        "shapes",
        ["vector"],
        unique=False,
        postgresql_using="hnsw",
        postgresql_with={"m": 24, "ef_construction": 400},
        postgresql_ops={"vector": "halfvec_l2_ops"},
    )
