"""Who waits for whom."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

from shapery_worker.turns import Turns


def never() -> bool:
    return False


def at_once() -> bool:
    return True


def in_a_child(action: Callable[[], bool]) -> bool:
    child = os.fork()
    if child == 0:
        os._exit(int(action()))
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 1


def gets_a_turn(turns: Turns, *, alone: bool) -> bool:
    def attempt() -> bool:
        with turns.take(alone=alone, give_up=at_once) as turn:
            return turn is not None

    return in_a_child(attempt)


def test_many_share_and_one_alone_excludes_all(tmp_path: Path) -> None:
    turns = Turns(tmp_path)
    with turns.take(alone=False, give_up=never) as turn:
        assert turn is not None
        assert gets_a_turn(turns, alone=False)
        assert not gets_a_turn(turns, alone=True)
    with turns.take(alone=True, give_up=never):
        assert not gets_a_turn(turns, alone=False)
        assert not gets_a_turn(turns, alone=True)
    assert gets_a_turn(turns, alone=True)


def test_nobody_overtakes_who_waits_to_be_alone(tmp_path: Path) -> None:
    turns = Turns(tmp_path)
    with turns.take(alone=False, give_up=never) as turn:
        waiting = os.fork()
        if waiting == 0:
            assert turn is not None
            os.close(turn)  # a forked process shares it
            with turns.take(alone=True, give_up=never):
                os._exit(0)
        deadline = time.monotonic() + 10
        while gets_a_turn(turns, alone=False):  # until it stands in the gate
            assert time.monotonic() < deadline
            time.sleep(0.01)
        assert os.waitpid(waiting, os.WNOHANG) == (0, 0)
    assert os.waitstatus_to_exitcode(os.waitpid(waiting, 0)[1]) == 0
    assert gets_a_turn(turns, alone=False)


def test_a_turn_ends_with_its_process(tmp_path: Path) -> None:
    turns = Turns(tmp_path)

    def die_inside() -> bool:
        with turns.take(alone=True, give_up=never):
            os._exit(1)

    assert in_a_child(die_inside)
    assert gets_a_turn(turns, alone=True)
