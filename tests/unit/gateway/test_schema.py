"""The interface as it is recorded in ``api_schema/``."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from shapery_contracts.errors import ERROR_CODES
from shapery_contracts.formats import sniff
from shapery_contracts.formats.table import KNOWN_FORMATS
from shapery_gateway import schema
from tests.conftest import ROOT
from tests.support.gateway import nifti, triangle

RECORDED = ROOT / "api_schema"


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((RECORDED / "openapi.json").read_text("utf-8"))
    return loaded


def operations(document: dict[str, Any]) -> list[tuple[str, str, dict[str, Any]]]:
    return [(path, method, op) for path, methods in document["paths"].items() for method, op in methods.items()]


def test_nothing_drifted() -> None:
    # in a process of its own: tests may have registered job kinds in this one
    result = subprocess.run(
        [sys.executable, "-m", "shapery_gateway.schema", "--check", str(RECORDED)], capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr


def test_drift_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(schema, "documents", lambda: {"a.json": "1\n", "jobs/b.json": "2\n"})
    assert schema.write(tmp_path) == ["a.json", "jobs/b.json"]
    assert schema.write(tmp_path) == []
    assert schema.check(tmp_path) == []
    (tmp_path / "a.json").write_text("0\n")
    (tmp_path / "jobs" / "old.json").write_text("{}")
    (tmp_path / "jobs" / "b.json").unlink()
    lines = schema.check(tmp_path)
    assert "-0" in lines
    assert "+1" in lines
    assert "+2" in lines
    assert "recorded/jobs/old.json belongs to nothing" in lines
    assert schema.write(tmp_path) == ["a.json", "jobs/b.json", "jobs/old.json"]
    assert schema.check(tmp_path) == []


def test_every_operation_is_described(document: dict[str, Any]) -> None:
    seen = set()
    for path, method, op in operations(document):
        where = f"{method} {path}"
        assert op["operationId"].isalnum(), where
        assert op["operationId"] not in seen, where
        seen.add(op["operationId"])
        assert op["tags"], where
        assert op["summary"], where
        assert op["description"], where
        assert "application/problem+json" in op["responses"]["default"]["content"], where


def test_every_operation_of_the_interface_asks_for_a_key_but_one(document: dict[str, Any]) -> None:
    open_ = {
        op["operationId"] for path, _, op in operations(document) if path.startswith("/v1/") and "security" not in op
    }
    assert open_ == {"getInfo", "getUploadCapabilities"}


def test_codes_in_the_document_are_registered(document: dict[str, Any]) -> None:
    assert document["components"]["schemas"]["Problem"]["properties"]["code"]["enum"] == sorted(ERROR_CODES)
    for path, _, op in operations(document):
        for status, response in op["responses"].items():
            example = response.get("content", {}).get("application/problem+json", {}).get("example")
            if example is not None and status != "default":
                assert ERROR_CODES[example["code"]].status == int(status), path


def test_references_resolve(document: dict[str, Any]) -> None:
    def walk(value: Any) -> None:
        if isinstance(value, dict):
            if "$ref" in value:
                kind, name = value["$ref"].removeprefix("#/components/").split("/")
                assert name in document["components"][kind]
            for part in value.values():
                walk(part)
        elif isinstance(value, list):
            for part in value:
                walk(part)

    walk(document)


def test_the_document_is_openapi(document: dict[str, Any]) -> None:
    assert document["openapi"] == "3.1.0"
    for name, model in document["components"]["schemas"].items():
        jsonschema.Draft202012Validator.check_schema(model), name


def test_job_schemas_are_schemas() -> None:
    files = sorted((RECORDED / "jobs").glob("*.json"))
    assert files
    for file in files:
        described = json.loads(file.read_text("utf-8"))
        jsonschema.Draft202012Validator.check_schema(described["params"])
        jsonschema.Draft202012Validator.check_schema(described["result"])
        assert described["inputs"]


def test_formats_are_those_that_are_recognised() -> None:
    known = {entry.format: entry for entry in KNOWN_FORMATS}
    for data in (nifti(), triangle(), b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", b"SMC1" + bytes(60)):
        found = sniff(io.BytesIO(data), len(data))
        entry = known[found.format]
        assert entry.kind is found.kind
        assert found.extension in entry.extensions
        assert found.media_type in entry.media_types


def test_the_recorded_errors_are_the_registry() -> None:
    recorded = json.loads((RECORDED / "errors.json").read_text("utf-8"))
    assert {entry["code"]: entry["status"] for entry in recorded} == {c: e.status for c, e in ERROR_CODES.items()}
