"""The migrations give what the models say, on both databases."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import inspect, text

from shapery_platform.db import Database
from shapery_platform.db.models import Base


def without_objects(index: Any) -> dict[str, Any]:
    """Return an index whose conditions are text, so that two can be compared."""
    options = {key: str(value) for key, value in index.get("dialect_options", {}).items()}
    return {**index, "dialect_options": options}


def shape(database: Database) -> dict[str, Any]:
    """Return everything that can be read back about the tables."""
    inspector = inspect(database.engine)
    found: dict[str, Any] = {}
    for table in sorted(inspector.get_table_names()):
        if table == "alembic_version":
            continue
        found[table] = {
            "columns": [
                (column["name"], str(column["type"]), column["nullable"], str(column.get("default")))
                for column in inspector.get_columns(table)
            ],
            "primary key": inspector.get_pk_constraint(table),
            "foreign keys": sorted(map(str, inspector.get_foreign_keys(table))),
            "indexes": sorted(str(without_objects(index)) for index in inspector.get_indexes(table)),
            "unique": sorted(map(str, inspector.get_unique_constraints(table))),
            "checks": sorted(map(str, inspector.get_check_constraints(table))),
        }
    return found


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.server)])
def empty_urls(request: pytest.FixtureRequest, tmp_path: Any) -> tuple[str, str]:
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path}/one.db", f"sqlite:///{tmp_path}/two.db"
    server = request.getfixturevalue("postgres")
    return server.create_database(), server.create_database()


def test_models_equal_migrations(empty_urls: tuple[str, str]) -> None:
    migrated, created = (Database(url) for url in empty_urls)
    migrated.migrate()
    Base.metadata.create_all(created.engine)
    assert shape(migrated) == shape(created)
    assert len(shape(migrated)) == len(Base.metadata.tables)
    with migrated.engine.connect() as connection:
        # Alembic takes no notice of what an index says about its dialect
        elsewhere = {"ix_shapes_vector"} if migrated.dialect == "sqlite" else set()
        options = {"compare_type": True, "include_object": lambda _, name, *__: name not in elsewhere}
        context = MigrationContext.configure(connection, opts=options)
        assert compare_metadata(context, Base.metadata) == []
    migrated.dispose()
    created.dispose()


def test_processes_that_migrate_at_the_same_time_wait_for_each_other(empty_urls: tuple[str, str]) -> None:
    faults: list[BaseException] = []
    barrier = threading.Barrier(3)

    def migrate() -> None:
        database = Database(empty_urls[0])
        try:
            barrier.wait()
            database.migrate()
        except BaseException as error:
            faults.append(error)
        finally:
            database.dispose()

    threads = [threading.Thread(target=migrate) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert faults == []
    database = Database(empty_urls[0])
    with database.session(readonly=True) as session:
        assert session.execute(text("SELECT count(*) FROM alembic_version")).scalar_one() == 1
    database.dispose()
