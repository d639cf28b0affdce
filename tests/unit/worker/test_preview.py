"""How a handler shows its result so far, and how its watcher sees that."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from shapery_contracts.handler import MAX_PREVIEW
from shapery_worker import context as context_module
from shapery_worker.board import Board
from shapery_worker.context import HandlerContext
from shapery_worker.preview import PreviewFile


@pytest.fixture
def context(tmp_path: Path, board: Board) -> HandlerContext:
    return HandlerContext(board, tmp_path / "output", tmp_path / "work", tmp_path / "preview")


def test_what_is_shown_is_seen_once(tmp_path: Path, context: HandlerContext, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(context_module, "PREVIEW_EVERY", 0.0)
    seen = PreviewFile(tmp_path / "preview")
    assert seen.read() is None
    context.preview(lambda: b"one")
    assert seen.read() == b"one"
    assert seen.read() == b"one", "the database did not take it"
    seen.taken()
    assert seen.read() is None
    seen.taken()
    context.preview(lambda: b"two")
    assert seen.read() == b"two"


def test_previews_are_made_at_a_bounded_rate(
    tmp_path: Path, context: HandlerContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter(100.0 + 0.25 * step for step in range(100))
    monkeypatch.setattr(context_module.time, "monotonic", lambda: next(clock))
    made = []

    def make() -> bytes:
        made.append(len(made))
        return b"x"

    # The clock is read once where it is too early, and twice where it is not.
    for _ in range(21):
        context.preview(make)
    assert len(made) == 11


def test_one_that_is_too_large_is_not_shown(tmp_path: Path, context: HandlerContext) -> None:
    context.preview(lambda: bytes(MAX_PREVIEW + 1))
    assert not (tmp_path / "preview").exists()


@pytest.mark.parametrize("what", ["link", "folder", "pipe", "large", "empty"])
def test_nothing_but_a_small_file_is_read(tmp_path: Path, what: str) -> None:
    path = tmp_path / "preview"
    match what:
        case "link":
            (tmp_path / "secret").write_bytes(b"secret")
            path.symlink_to(tmp_path / "secret")
        case "folder":
            path.mkdir()
        case "pipe":
            os.mkfifo(path)
        case "large":
            path.write_bytes(bytes(MAX_PREVIEW + 1))
        case _:
            path.touch()
    assert PreviewFile(path).read() is None
