"""``python -m shapery_gateway.schema``: the interfaces as files, and whether the recorded ones still hold.

Writes ``openapi.json``, one schema per job kind under ``jobs/``, ``errors.json`` and ``formats.json``. What is written
depends on nothing but the code: neither on the environment nor on plugins.
"""

from __future__ import annotations

import argparse
import difflib
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from shapery_contracts.errors import ERROR_CODES
from shapery_contracts.formats.table import KNOWN_FORMATS
from shapery_contracts.kinds import JOB_KINDS, JobKind
from shapery_gateway.app import create_app
from shapery_gateway.kinds.service import describe_input
from shapery_platform.settings import Settings

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def job_schema(kind: JobKind) -> dict[str, Any]:
    """Return what a job kind takes and gives."""
    return {
        "name": kind.name,
        "service": kind.service,
        "summary": kind.summary,
        "inputs": {name: describe_input(spec) for name, spec in kind.inputs.items()},
        "params": {"$schema": DIALECT, **kind.params.model_json_schema()},
        "result": {"$schema": DIALECT, **kind.result.model_json_schema(mode="serialization")},
        "stages": list(kind.stages),
        "time_limit": kind.time_limit,
        "memory_limit": kind.memory_limit,
    }


def errors() -> list[dict[str, Any]]:
    """Return the registry of error codes."""
    return [
        {"code": entry.code, "status": entry.status, "title": entry.title}
        for entry in sorted(ERROR_CODES.values(), key=lambda entry: entry.code)
    ]


def formats() -> list[dict[str, Any]]:
    """Return the file formats that are recognised."""
    return [
        {
            "format": known.format,
            "kind": known.kind.value,
            "summary": known.summary,
            "extensions": list(known.extensions),
            "media_types": list(known.media_types),
        }
        for known in KNOWN_FORMATS
    ]


def documents() -> dict[str, str]:
    """Return all files by name, as they are written."""
    with tempfile.TemporaryDirectory() as home:
        app = create_app(Settings(home=Path(home), plugins=[], auth="keys"))
    found: dict[str, Any] = {"openapi.json": app.openapi(), "errors.json": errors(), "formats.json": formats()}
    for kind in JOB_KINDS.values():
        found[f"jobs/{kind.name}.json"] = job_schema(kind)
    return {name: json.dumps(content, indent=2, ensure_ascii=False) + "\n" for name, content in sorted(found.items())}


def write(folder: Path) -> list[str]:
    """Write all files, remove those that no longer belong there, and return the names of what changed."""
    wanted = documents()
    changed = []
    for name, text in wanted.items():
        path = folder / name
        if not path.exists() or path.read_text("utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, "utf-8")
            changed.append(name)
    for name in _surplus(folder, wanted):
        (folder / name).unlink()
        changed.append(name)
    return changed


def check(folder: Path) -> list[str]:
    """Return what differs between the files and the code, as lines of a unified diff; nothing where all is well."""
    wanted = documents()
    lines: list[str] = []
    for name, text in wanted.items():
        path = folder / name
        recorded = path.read_text("utf-8") if path.exists() else ""
        if recorded != text:
            lines += difflib.unified_diff(
                recorded.splitlines(), text.splitlines(), f"recorded/{name}", f"code/{name}", lineterm="", n=2
            )
    lines += [f"recorded/{name} belongs to nothing" for name in _surplus(folder, wanted)]
    return lines


def _surplus(folder: Path, wanted: dict[str, str]) -> list[str]:
    return sorted(
        name for path in folder.rglob("*.json") if (name := path.relative_to(folder).as_posix()) not in wanted
    )


def main() -> int:
    """Write, or check with ``--check``."""
    parser = argparse.ArgumentParser(prog="python -m shapery_gateway.schema", description="Write the API schema.")
    parser.add_argument("folder", type=Path, nargs="?", default=Path("api_schema"), help="where the files are")
    parser.add_argument("--check", action="store_true", help="fail where the files are not what the code says")
    options = parser.parse_args()
    if not options.check:
        for name in write(options.folder):
            sys.stdout.write(f"{options.folder / name}\n")
        return 0
    difference = check(options.folder)
    if difference:
        sys.stderr.write("\n".join(difference[:200]) + "\n\nRun `python -m shapery_gateway.schema` and commit.\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
