"""The page that a handler and its watcher share."""

from __future__ import annotations

import math
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shapery_worker.board import Board, Progress


def test_a_new_board_says_nothing() -> None:
    board = Board()
    assert board.read() is None
    assert not board.stop_asked


@given(st.text(max_size=2000), st.floats(), st.text(max_size=20_000))
def test_whatever_is_written_is_read_within_its_bounds(stage: str, fraction: float, message: str) -> None:
    board = Board()
    board.write(Progress("before", 0.5, "something longer that was there before"))
    board.write(Progress(stage, fraction, message))
    read = board.read()
    assert read is not None
    assert stage.startswith(read.stage)
    assert message.startswith(read.message)
    assert read.stage == stage[:64]
    assert 0.0 <= read.fraction <= 1.0
    if 0.0 <= fraction <= 1.0:
        assert read.fraction == fraction


@pytest.mark.parametrize(("given", "read"), [(math.nan, 0.0), (math.inf, 0.0), (-3.0, 0.0), (7.0, 1.0)])
def test_a_fraction_is_one(given: float, read: float) -> None:
    board = Board()
    board.write(Progress("s", given))
    assert board.read() == Progress("s", read)


def test_a_page_that_is_being_written_is_not_read() -> None:
    board = Board()
    board.write(Progress("s", 0.5, "whole"))
    board._page[30] ^= 0xFF  # as if half of the text were another one's
    assert board.read() is None
    board.write(Progress("s", 0.6, "whole again"))
    assert board.read() == Progress("s", 0.6, "whole again")


def test_both_sides_of_a_fork_share_it() -> None:
    board = Board()
    child = os.fork()
    if child == 0:
        while not board.stop_asked:
            pass
        board.write(Progress("child", 1.0, "asked to stop"))
        os._exit(0)
    board.ask_to_stop()
    os.waitpid(child, 0)
    assert board.read() == Progress("child", 1.0, "asked to stop")
