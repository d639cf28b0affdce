"""What the environment may say, and what is refused with a sentence that helps."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from shapery_platform.settings import Settings, SettingsError, is_loopback, load_plugins, load_settings

PRODUCTION: dict[str, Any] = {
    "profile": "production",
    "database_url": "postgresql://shapery:V7kQ2mX9pL@db/shapery",
    "redis_url": "redis://:V7kQ2mX9pL@redis:6379/0",
    "storage_url": "s3://bucket/prefix",
    "s3_access_key": "shapery",
    "s3_secret_key": "V7kQ2mX9pLw3",
    "host": "0.0.0.0",
}


@pytest.fixture(autouse=True)
def clean_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in list(os.environ):
        if name.startswith("SHAPERY_"):
            monkeypatch.delenv(name)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))


def test_the_embedded_profile_needs_nothing_but_a_folder(tmp_path: Path) -> None:
    settings = load_settings()
    home = tmp_path / "shapery"
    assert settings.home == home
    assert settings.database_url == f"sqlite:///{home}/shapery.db"
    assert settings.storage_url == f"file://{home}/objects"
    assert settings.auth == "local"
    assert settings.redis_url == f"unix://{settings.redis_socket}"


def test_the_environment_is_read(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name, value in {
        "HOME": str(tmp_path / "elsewhere"),
        "PORT": "9000",
        "PLUGINS": " one, two.three ,",
        "JOB_TIME_LIMIT": '{"segmentation": 60}',
        "MAX_UPLOAD_BYTES": "1000",
        # compose files pass empty variables for those that are not set
        "REDIS_URL": "",
        "BOOTSTRAP_ADMIN_KEY": "",
        "SCRATCH": "",
    }.items():
        monkeypatch.setenv(f"SHAPERY_{name}", value)
    settings = load_settings()
    assert settings.home == tmp_path / "elsewhere"
    assert settings.port == 9000
    assert settings.plugins == ["one", "two.three"]
    assert settings.job_time_limit == {"segmentation": 60}
    assert settings.max_upload_bytes == 1000
    assert settings.redis_url.startswith("unix://")
    assert settings.bootstrap_admin_key is None
    assert settings.scratch is None


def test_a_home_too_deep_for_a_socket_gets_one_elsewhere(tmp_path: Path) -> None:
    deep = tmp_path / ("x" * 60) / ("y" * 60)
    one, again, other = (load_settings(home=home).redis_socket for home in (deep, deep, deep / "z"))
    assert one is not None
    assert len(os.fsencode(one)) <= 100
    assert one == again
    assert one != other


def test_production_as_it_should_be() -> None:
    settings = load_settings(**PRODUCTION)
    assert settings.auth == "keys"
    assert settings.database_kind == "postgresql"
    assert settings.redis_socket is None


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"database_url": ""}, "SHAPERY_DATABASE_URL must be set"),
        ({"redis_url": ""}, "SHAPERY_REDIS_URL must be set"),
        ({"storage_url": ""}, "SHAPERY_STORAGE_URL must be set"),
        ({"database_url": "sqlite:////data/shapery.db"}, "names SQLite"),
        ({"database_url": "mysql://db/shapery"}, "must begin with sqlite"),
        ({"database_url": "postgresql://shapery:shapery@db/shapery"}, "well-known default"),
        ({"auth": "local", "host": "127.0.0.1"}, "one machine only"),
        ({"s3_secret_key": "minioadmin"}, "SHAPERY_S3_SECRET_KEY"),
        ({"s3_secret_key": ""}, "must be set together"),
        ({"s3_access_key": None}, "must be set together"),
        ({"bootstrap_admin_key": "changeme"}, "has 8 characters and needs 32"),
        ({"bootstrap_admin_key": "a" * 40}, "needs 32 random ones"),
        ({"storage_url": "ftp://bucket"}, "must begin with file:/// or s3://"),
        ({"redis_url": "amqp://queue"}, "must begin with redis://"),
    ],
)
def test_production_refuses(change: dict[str, Any], reason: str) -> None:
    with pytest.raises(SettingsError, match=reason):
        load_settings(**{**PRODUCTION, **change})


def test_every_reason_is_told_at_once() -> None:
    with pytest.raises(SettingsError) as error:
        load_settings(profile="production", auth="local", host="127.0.0.1")
    assert str(error.value).count("must be set in production") == 3
    assert "auth" in str(error.value).lower()


def test_a_secret_is_not_told_in_the_error() -> None:
    with pytest.raises(SettingsError) as error:
        load_settings(**{**PRODUCTION, "bootstrap_admin_key": "too-short-secret", "s3_secret_key": "swordfish"[:7]})
    assert "too-short-secret" not in str(error.value)
    assert "swordfi" not in str(error.value)


def test_machines_with_a_role_need_no_keys_for_s3() -> None:
    settings = load_settings(**{**PRODUCTION, "s3_access_key": None, "s3_secret_key": None})
    assert settings.s3_secret_key is None


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.4", "example.org"])
def test_the_local_mode_is_refused_where_others_can_come(host: str) -> None:
    with pytest.raises(SettingsError, match="loopback"):
        load_settings(host=host, auth="local")
    assert load_settings(host=host).auth == "keys"


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "::1", "[::1]", "127.8.8.8"])
def test_the_local_mode_on_loopback(host: str) -> None:
    assert is_loopback(host)
    assert load_settings(host=host).auth == "local"


def test_a_lease_outlives_a_missed_heartbeat() -> None:
    with pytest.raises(SettingsError, match="twice"):
        load_settings(heartbeat_interval=4.0, lease_seconds=6.0)


@pytest.mark.parametrize(
    ("name", "value"), [("port", 70_000), ("result_ttl", 0), ("max_attempts", 0), ("profile", "cloud")]
)
def test_values_out_of_range_are_named(name: str, value: object) -> None:
    with pytest.raises(SettingsError, match=f"SHAPERY_{name.upper()}"):
        load_settings(**{name: value})


@pytest.mark.parametrize(
    ("url", "kind"),
    [
        ("sqlite:////x.db", "sqlite"),
        ("postgresql://db/x", "postgresql"),
        ("postgresql+psycopg://db/x", "postgresql"),
        ("postgres://db/x", "postgresql"),
    ],
)
def test_kinds_of_databases(url: str, kind: str) -> None:
    assert load_settings(database_url=url).database_kind == kind


def test_settings_do_not_change_and_do_not_show_secrets() -> None:
    settings = load_settings(**PRODUCTION)
    with pytest.raises(ValueError, match="frozen"):
        settings.port = 1
    assert "V7kQ2mX9pLw3" not in repr(settings)


def test_plugins_are_imported(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "shapery_test_plugin.py").write_text("LOADED = True\n")
    monkeypatch.syspath_prepend(tmp_path)
    load_plugins(load_settings(plugins="shapery_test_plugin"))
    with pytest.raises(SettingsError, match="no_such_plugin"):
        load_plugins(load_settings(plugins=["no_such_plugin"]))


def test_every_setting_has_a_default() -> None:
    assert all(not field.is_required() for field in Settings.model_fields.values())
