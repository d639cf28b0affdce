"""Alembic's entry: runs the migrations over the connection that `Database.migrate` opened."""

from __future__ import annotations

from alembic import context

from shapery_platform.db.models import Base

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=Base.metadata,
    # SQLite, too, rolls back its DDL when a migration fails half way
    transactional_ddl=True,
    compare_type=True,
)
with context.begin_transaction():
    context.run_migrations()
