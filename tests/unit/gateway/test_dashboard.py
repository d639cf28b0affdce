from __future__ import annotations

from pathlib import Path

import pytest

from shapery_gateway.dashboard.service import find


@pytest.fixture
def root(tmp_path: Path) -> Path:
    root = tmp_path / "static"
    (root / "assets").mkdir(parents=True)
    (root / "index.html").write_text("<!doctype html>")
    (root / ".secret").write_text("x")
    (root / "assets" / "index-B2xY9_a-.js").write_text("1")
    (root / "assets" / "viewer.wasm").write_bytes(b"\0asm")
    (tmp_path / "outside.txt").write_text("x")
    (root / "link.txt").symlink_to(tmp_path / "outside.txt")
    return root


def test_files_are_found(root: Path) -> None:
    page = find(root, "index.html")
    assert page is not None
    assert (page.media_type, page.immutable) == ("text/html", False)
    script = find(root, "assets/index-B2xY9_a-.js")
    assert script is not None
    assert (script.media_type, script.immutable) == ("text/javascript", True)
    module = find(root, "assets/viewer.wasm")
    assert module is not None
    assert (module.media_type, module.immutable) == ("application/wasm", False)


def test_the_tag_follows_the_content(root: Path) -> None:
    before = find(root, "index.html")
    (root / "index.html").write_text("<!doctype html><p>new")
    after = find(root, "index.html")
    assert before is not None
    assert after is not None
    assert before.etag != after.etag


@pytest.mark.parametrize(
    "path",
    [
        "",
        ".",
        "..",
        "../outside.txt",
        "assets/../../outside.txt",
        "/etc/passwd",
        "//etc/passwd",
        ".secret",
        "assets",
        "assets/",
        "link.txt",
        "index.html\0",
        "missing.js",
        "index.html/x",
        "a" * 5000,
    ],
)
def test_nothing_else_is(root: Path, path: str) -> None:
    if path == "assets/":
        assert find(root, path) is None
        return
    assert find(root, path) is None


def test_without_a_build(tmp_path: Path) -> None:
    assert find(tmp_path / "static", "index.html") is None
