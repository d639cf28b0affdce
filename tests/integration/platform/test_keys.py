"""API keys on both databases."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from uuid import uuid4

import pytest
from sqlalchemy import func, select

from shapery_contracts.api import Scope
from shapery_contracts.errors import UserError
from shapery_platform import keys
from shapery_platform.db import Database
from shapery_platform.db.models import ApiKey
from shapery_platform.settings import Settings


def test_a_key_opens_what_its_owner_has(database: Database) -> None:
    with database.session() as session:
        key, secret = keys.create(session, "laptop", [Scope.READ, Scope.WRITE], owner="ann")
    with database.session(readonly=True) as session:
        principal = keys.authenticate(session, secret)
    assert principal is not None
    assert (principal.owner, principal.key_id) == ("ann", key.id)
    assert principal.scopes == {Scope.READ, Scope.WRITE}
    assert secret.startswith(key.prefix)
    assert len(key.prefix) == 12


def test_only_the_hash_is_kept(database: Database) -> None:
    with database.session() as session:
        _, secret = keys.create(session, "laptop", [Scope.READ])
    with database.session(readonly=True) as session:
        row = session.scalars(select(ApiKey)).one()
        stored = " ".join(str(getattr(row, column.key)) for column in ApiKey.__table__.columns)
    assert secret not in stored
    assert secret[12:] not in stored


def test_keys_that_open_nothing(database: Database) -> None:
    with database.session() as session:
        key, secret = keys.create(session, "laptop", [Scope.READ], owner="ann")
        soon = datetime.now(UTC) + timedelta(hours=1)
        _, passing = keys.create(session, "guest", [Scope.READ], expires_at=soon, owner="ann")
    with database.session() as session:
        assert keys.authenticate(session, passing) is not None
        assert keys.authenticate(session, passing, now=soon) is None
        for wrong in (
            "",
            "shp_",
            secret[:-1],
            secret + "x",
            secret.upper(),
            key.prefix,
            key.secret_hash,
            "\ud800",
            "\0",
        ):
            assert keys.authenticate(session, wrong) is None
        keys.revoke(session, "ann", key.id)
    with database.session() as session:
        assert keys.authenticate(session, secret) is None
        assert [entry.name for entry in keys.list_keys(session, "ann")] == ["guest"]
        with pytest.raises(UserError) as error:
            keys.revoke(session, "ann", key.id)
        assert error.value.code == "not_found"
        with pytest.raises(UserError):
            keys.revoke(session, "ann", uuid4())


def test_a_key_without_an_owner_makes_one(database: Database) -> None:
    with database.session() as session:
        owners = {keys.create(session, "key", [Scope.READ])[0].owner for _ in range(3)}
    assert len(owners) == 3


@pytest.mark.parametrize("name", ["", " \n", "\0"])
def test_a_key_needs_a_name(database: Database, name: str) -> None:
    with database.session() as session, pytest.raises(UserError) as error:
        keys.create(session, name, [Scope.READ])
    assert error.value.code == "validation_failed"


@pytest.mark.parametrize("expires_at", [datetime(2020, 1, 1, tzinfo=UTC), datetime(2999, 1, 1)])  # noqa: DTZ001
def test_an_expiry_lies_ahead_and_has_a_zone(database: Database, expires_at: datetime) -> None:
    with database.session() as session, pytest.raises(UserError) as error:
        keys.create(session, "key", [Scope.READ], expires_at=expires_at)
    assert error.value.code == "validation_failed"


def test_names_are_kept_readable(database: Database) -> None:
    with database.session() as session:
        key, _ = keys.create(session, "  Ann's\tlaptop\0 " + "x" * 300, [Scope.READ])
    assert key.name.startswith("Ann's laptop x")
    assert len(key.name) == 200


def test_the_last_use_is_noted_at_most_once_a_minute(database: Database) -> None:
    with database.session() as session:
        _, secret = keys.create(session, "laptop", [Scope.READ], owner="ann")
    with database.session() as session:
        principal = keys.authenticate(session, secret)
        assert principal is not None
        assert principal.use_is_due
        assert principal.key_id is not None
        keys.note_use(session, principal.key_id)
    with database.session() as session:
        principal = keys.authenticate(session, secret)
        assert principal is not None
        assert not principal.use_is_due
        later = keys.authenticate(session, secret, now=datetime.now(UTC) + timedelta(seconds=61))
        assert later is not None
        assert later.use_is_due
        assert keys.view(keys.list_keys(session, "ann")[0]).last_used_at is not None


def test_the_first_administrator_is_admitted_once(database: Database, settings: Settings) -> None:
    with database.session() as session:
        assert not keys.ensure_bootstrap(session, settings), "none is set"
    chosen = settings.model_copy(update={"bootstrap_admin_key": _Secret("k" * 20 + "0123456789abcdef")})
    for expected in (True, False):
        with database.session() as session:
            assert keys.ensure_bootstrap(session, chosen) is expected
    with database.session() as session:
        principal = keys.authenticate(session, chosen.bootstrap_admin_key.get_secret_value())  # type: ignore[union-attr]
        assert principal is not None
        assert principal.may(Scope.ADMIN)
        assert principal.key_id is not None
        keys.revoke(session, principal.owner, principal.key_id)
    with database.session() as session:
        assert not keys.ensure_bootstrap(session, chosen), "a key that was revoked stays so"
        assert session.scalar(select(func.count()).select_from(ApiKey)) == 1


class _Secret:
    def __init__(self, value: str) -> None:
        self._value = value

    def get_secret_value(self) -> str:
        return self._value


@pytest.mark.parametrize(
    ("scopes", "allowed"),
    [
        ({Scope.READ}, {Scope.READ}),
        ({Scope.WRITE}, {Scope.READ, Scope.WRITE}),
        ({Scope.ADMIN}, {Scope.READ, Scope.WRITE, Scope.ADMIN}),
        (set(), set()),
    ],
)
def test_scopes(scopes: set[Scope], allowed: set[Scope]) -> None:
    principal = keys.Principal("ann", frozenset(scopes))
    assert {scope for scope in Scope if principal.may(scope)} == allowed


def test_the_local_owner_may_everything() -> None:
    principal = keys.Principal.local()
    assert all(principal.may(scope) for scope in Scope)
    assert principal.owner == "local"
