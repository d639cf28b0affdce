"""Finds the dashboard's files: a page for every path of its own, and assets that browsers may keep for ever."""

from __future__ import annotations

import hashlib
import mimetypes
import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path, PurePosixPath

STATIC = Path(__file__).resolve().parent.parent / "static"

_POLICY = (
    "default-src 'self'",
    # WebAssembly is compiled by the viewers; nothing else may be made from text
    "script-src 'self' 'wasm-unsafe-eval'",
    # viewers put style elements of their own beside their canvas
    "style-src 'self' 'unsafe-inline'",
    "img-src 'self' blob: data:",
    "font-src 'self' data:",
    "media-src 'self' blob:",
    # viewers fetch what they have just made, or carry with them
    "connect-src 'self' blob: data:",
    "worker-src 'self' blob:",
    "object-src 'none'",
    "base-uri 'none'",
    "form-action 'self'",
    "frame-ancestors 'none'",
)
CONTENT_SECURITY_POLICY = "; ".join(_POLICY)

_TYPES = {
    ".js": "text/javascript",
    ".mjs": "text/javascript",
    ".css": "text/css",
    ".html": "text/html",
    ".json": "application/json",
    ".map": "application/json",
    ".wasm": "application/wasm",
    ".svg": "image/svg+xml",
    ".webmanifest": "application/manifest+json",
    ".woff2": "font/woff2",
}
"""By the ending: the system's own table differs from machine to machine, and browsers refuse scripts of another."""

_HASHED = re.compile(r"[.-][A-Za-z0-9_-]{8,}\.[a-z0-9]+$")


@dataclass(frozen=True, slots=True)
class StaticFile:
    """A file of the dashboard."""

    path: Path
    media_type: str
    etag: str
    immutable: bool
    """Whether its name holds a hash of its content, so that it never changes."""
    compressed: Path | None
    """The same, compressed with gzip when it was built."""


def find(root: Path, path: str) -> StaticFile | None:
    """Return the file at `path` below `root`, None where there is none; nothing outside `root` is ever found."""
    parts = PurePosixPath(path).parts
    if not parts or "\0" in path or any(part in {"..", "."} or part.startswith((".", "/")) for part in parts):
        return None
    target = root.joinpath(*parts)
    try:
        real = target.resolve(strict=True)
    except (OSError, RuntimeError):
        return None
    if not real.is_file() or not real.is_relative_to(root.resolve()):
        return None
    compressed = real.with_name(f"{real.name}.gz")
    return StaticFile(
        path=real,
        media_type=_TYPES.get(real.suffix) or mimetypes.guess_type(real.name)[0] or "application/octet-stream",
        etag=_etag(real, real.stat().st_mtime_ns, real.stat().st_size),
        immutable=parts[0] == "assets" and _HASHED.search(real.name) is not None,
        compressed=compressed if compressed.is_file() else None,
    )


@lru_cache(maxsize=1024)
def _etag(path: Path, modified_ns: int, size: int) -> str:  # noqa: ARG001 - the key of the cache
    with path.open("rb") as file:
        return f'"{hashlib.file_digest(file, "sha256").hexdigest()[:32]}"'


NOT_BUILT = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Shapery</title>
<style>body{font:16px/1.5 system-ui,sans-serif;max-width:40rem;margin:4rem auto;padding:0 1rem}
code{background:#8882;padding:.1em .3em;border-radius:.2em}</style>
<h1>Shapery</h1>
<p>The server runs. The dashboard is not built into this installation.</p>
<p>From a checkout, <code>make setup</code> builds it; reload this page afterwards.</p>
<p>The HTTP interface is described at <a href="/docs">/docs</a>.</p>
</html>
"""
