"""The files in deploy/ agree with the code they deploy; no container engine is needed to know that."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from shapery_contracts.kinds import SERVICES
from shapery_platform.settings import Settings, SettingsError, load_settings
from tests.conftest import ROOT

DOCKERFILES = sorted((ROOT / "deploy" / "docker").glob("*.Dockerfile"))
COMPOSE_ONLY = {"POSTGRES_PASSWORD", "GATEWAY_PORT"}
"""Variables of env.example that compose itself uses."""
OURS = {"gateway", "migrate", "reaper", *SERVICES}


@pytest.fixture(scope="module")
def compose() -> dict[str, Any]:
    document: dict[str, Any] = yaml.safe_load((ROOT / "docker-compose.yml").read_text())
    return document


def variables() -> dict[str, str]:
    lines = (ROOT / "deploy" / "env.example").read_text().splitlines()
    return dict(line.split("=", 1) for line in lines if line and not line.startswith("#"))


def filled() -> dict[str, str]:
    """env.example as an administrator fills it in."""
    return {name: value or f"{index}f3a9c07be41d2856" * 3 for index, (name, value) in enumerate(variables().items())}


def environment(service: dict[str, Any]) -> dict[str, str]:
    """A service's environment as compose interpolates it."""

    def interpolate(match: re.Match[str]) -> str:
        name, operator, rest = match.group(1), match.group(2), match.group(3)
        value = filled().get(name, "")
        if value:
            return value
        assert operator != ":?", f"{name} is required and not in env.example"
        return rest or ""

    return {
        name: re.sub(r"\$\{(\w+)(?:(:[-?])([^}]*))?\}", interpolate, str(value))
        for name, value in service["environment"].items()
    }


@pytest.mark.parametrize("dockerfile", DOCKERFILES, ids=lambda path: path.name)
def test_the_dockerfiles_are_free_of_findings(dockerfile: Path) -> None:
    hadolint = shutil.which("hadolint", path=str(Path(sys.executable).parent))
    if hadolint is None:
        pytest.skip("hadolint is not installed (its wheel exists for Linux only)")
    done = subprocess.run([hadolint, "--no-color", dockerfile], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("dockerfile", DOCKERFILES, ids=lambda path: path.name)
@pytest.mark.parametrize("service", SERVICES)
def test_what_the_dockerfiles_copy_exists(dockerfile: Path, service: str) -> None:
    text = dockerfile.read_text().replace("${SERVICE}", service)
    copied = re.findall(r"^COPY (?!--from)(?:--\S+ )*(.+) \S+$", text, re.MULTILINE)
    assert copied
    for sources in copied:
        for source in sources.replace('"', "").split():
            assert (ROOT / source).exists(), source


@pytest.mark.parametrize("dockerfile", DOCKERFILES, ids=lambda path: path.name)
def test_images_run_without_root_and_tell_their_health(dockerfile: Path) -> None:
    final = dockerfile.read_text().rsplit("FROM ", 1)[1]
    assert "USER 10001" in final
    assert "HEALTHCHECK" in final
    assert "pip install" not in final


def test_every_lock_records_hashes_and_no_address() -> None:
    for lock in [ROOT / "requirements.lock", *(ROOT / "deploy" / "locks").glob("*.lock")]:
        text = lock.read_text()
        assert "://" not in text, lock
        pinned = re.findall(r"^[A-Za-z0-9].*==", text, re.MULTILINE)
        assert pinned, lock
        assert text.count("--hash=sha256:") >= len(pinned), lock


@pytest.mark.parametrize("image", ["gateway", *SERVICES])
def test_an_image_installs_the_versions_that_were_tested(image: str) -> None:
    def versions(path: Path) -> set[tuple[str, str]]:
        pinned = re.findall(r"^([A-Za-z0-9_.-]+)(?:\[[^]]*\])?==([^\s;\\]+)", path.read_text(), re.MULTILINE)
        return set(pinned)

    installed = versions(ROOT / "deploy" / "locks" / f"{image}.lock")
    assert installed
    assert installed <= versions(ROOT / "requirements.lock")


def test_the_gateway_image_holds_no_numerics() -> None:
    text = (ROOT / "deploy" / "locks" / "gateway.lock").read_text()
    for name in ("numpy", "scipy", "numba", "trimesh", "nibabel", "simpleitk"):
        assert not re.search(rf"^{name}==", text, re.MULTILINE)


def test_every_variable_is_a_setting_or_composes_own(compose: dict[str, Any]) -> None:
    known = {f"SHAPERY_{name.upper()}" for name in Settings.model_fields} | {"SHAPERY_SERVICE"}
    for name in variables():
        assert name in known | COMPOSE_ONLY, f"{name} in env.example is no setting"
    for name in OURS:
        for variable in compose["services"][name]["environment"]:
            assert variable in known, f"{variable} of {name} is no setting"


def test_the_defaults_shown_are_the_defaults() -> None:
    shown = {name.removeprefix("SHAPERY_").lower(): value for name, value in variables().items() if value}
    for name in ("max_upload_bytes", "rate_limit_per_minute", "result_ttl", "upload_ttl", "s3_region"):
        assert shown[name] == str(Settings.model_fields[name].default).removesuffix(".0")


def test_images_are_pinned(compose: dict[str, Any]) -> None:
    for name, service in compose["services"].items():
        if name not in OURS:
            assert re.search(r":.*\d", service["image"]), name
            assert "latest" not in service["image"]


def test_our_containers_are_read_only_and_without_capabilities(compose: dict[str, Any]) -> None:
    assert set(SERVICES) <= set(compose["services"])
    for name in OURS:
        service = compose["services"][name]
        assert service["read_only"] is True, name
        assert service["cap_drop"] == ["ALL"], name
        assert "/tmp" in service["tmpfs"], name
        assert "no-new-privileges:true" in service["security_opt"], name


def test_the_filled_in_example_is_accepted_by_the_platform(
    compose: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in sorted(OURS):
        with monkeypatch.context() as patch:
            for variable, value in environment(compose["services"][name]).items():
                patch.setenv(variable, value)
            settings = load_settings(**({"host": "0.0.0.0"} if name == "gateway" else {}))
        assert settings.profile == "production"
        assert settings.auth == "keys"
        assert settings.database_kind == "postgresql"


def test_an_example_that_was_not_filled_in_is_refused(compose: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    empty = {**environment(compose["services"]["gateway"]), "SHAPERY_S3_SECRET_KEY": "changeme"}
    for variable, value in empty.items():
        monkeypatch.setenv(variable, value)
    with pytest.raises(SettingsError, match="SHAPERY_S3_SECRET_KEY"):
        load_settings()


def test_compose_starts_nothing_before_what_it_needs(compose: dict[str, Any]) -> None:
    services = compose["services"]
    for name, service in services.items():
        for needed, condition in (service.get("depends_on") or {}).items():
            assert needed in services, f"{name} needs {needed}"
            if condition["condition"] == "service_healthy":
                assert "healthcheck" in services[needed], f"{needed} cannot become healthy"
