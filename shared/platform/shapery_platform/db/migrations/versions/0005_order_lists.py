"""What lists are ordered by: names and durations of jobs, and indices over these and the names of files and shapes."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None

_NAMES = """
    UPDATE jobs SET name = coalesce((
        SELECT assets.filename FROM job_inputs JOIN assets ON assets.id = job_inputs.asset_id
        WHERE job_inputs.job_id = jobs.id
        ORDER BY CASE job_inputs.name WHEN 'post' THEN 0 ELSE 1 END, job_inputs.name, job_inputs.position
        LIMIT 1
    ), '')
"""
_TOOK = {
    "sqlite": "UPDATE jobs SET took = (julianday(finished_at) - julianday(started_at)) * 86400",
    "postgresql": "UPDATE jobs SET took = EXTRACT(EPOCH FROM finished_at - started_at)",
}


def upgrade() -> None:
    """Add the columns, fill them for the jobs that are there, and make the indices."""
    op.add_column("jobs", sa.Column("name", sa.String(length=255), server_default=sa.text("''"), nullable=False))
    op.add_column("jobs", sa.Column("took", sa.Float(), server_default=sa.text("-1"), nullable=False))
    op.execute(_NAMES)
    op.execute(f"{_TOOK[op.get_bind().dialect.name]} WHERE finished_at IS NOT NULL AND started_at IS NOT NULL")
    op.create_index("ix_jobs_owner_name_id", "jobs", ["owner", "name", "id"])
    op.create_index("ix_jobs_owner_took_id", "jobs", ["owner", "took", "id"])
    op.create_index(op.f("ix_assets_owner_filename_id"), "assets", ["owner", "filename", "id"])
    op.create_index(op.f("ix_shapes_owner_name_id"), "shapes", ["owner", "name", "id"])
