"""Processes that do not outlive their parents."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil

from shapery_worker import leash, lifeline
from shapery_worker.lifeline import alive, kill_tree, resident_memory, resident_memory_of_descendants
from tests.support.processes import wait_for

SLEEPER = [sys.executable, "-c", "import time; time.sleep(100)"]


def test_a_program_on_the_leash_is_the_program_itself(tmp_path: Path) -> None:
    done = subprocess.run(
        leash.command([sys.executable, "-c", "import sys, os; print(os.getppid(), sys.argv[1:]); sys.exit(7)", "a b"]),
        capture_output=True,
        text=True,
    )
    assert done.stderr == ""
    assert done.stdout == f"{os.getpid()} ['a b']\n"
    assert done.returncode == 7


def under_a_parent(tmp_path: Path, program: str) -> tuple[subprocess.Popen[bytes], int]:
    """Start a parent that starts a program by the Python expression `program`; return it and the program's id."""
    told = tmp_path / "pid"
    code = (
        "import os, subprocess, sys, time\n"
        "from pathlib import Path\n"
        "from shapery_worker import leash\n"
        f"child = subprocess.Popen({program}).pid\n"
        f"Path({str(tmp_path / 'part')!r}).write_text(str(child))\n"
        f"os.rename({str(tmp_path / 'part')!r}, {str(told)!r})\n"
        "time.sleep(100)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", code])
    wait_for(told.exists)
    return parent, int(told.read_text())


def test_a_program_on_the_leash_dies_with_its_parent(tmp_path: Path) -> None:
    parent, child = under_a_parent(tmp_path, f"leash.command({SLEEPER!r})")
    wait_for(lambda: psutil.Process(child).cmdline() == SLEEPER)  # once the leash is on
    parent.kill()
    parent.wait()
    wait_for(lambda: not alive(child))


def test_where_the_kernel_knows_no_leash_a_guard_stays(tmp_path: Path) -> None:
    """What other systems get: the guard is the child, and the program is the guard's."""
    code = f"import os, sys; from shapery_worker import leash; sys.exit(leash.guard(os.getppid(), {SLEEPER!r}))"
    parent, guard = under_a_parent(tmp_path, f"[sys.executable, '-c', {code!r}]")
    wait_for(lambda: bool(psutil.Process(guard).children()))
    sleeper = psutil.Process(guard).children()[0].pid
    parent.kill()
    parent.wait()
    wait_for(lambda: not alive(sleeper) and not alive(guard))


def test_a_guard_passes_signals_and_exit_codes_on() -> None:
    program = "import os, sys; from shapery_worker import leash; sys.exit(leash.guard(os.getppid(), {!r}))"
    done = subprocess.run([sys.executable, "-c", program.format([sys.executable, "-c", "import sys; sys.exit(5)"])])
    assert done.returncode == 5
    guard = subprocess.Popen([sys.executable, "-c", program.format(SLEEPER)])
    wait_for(lambda: bool(psutil.Process(guard.pid).children()))
    guard.send_signal(signal.SIGTERM)
    assert guard.wait(20) == 128 + signal.SIGTERM


def test_a_process_whose_parent_has_gone_already_does_not_begin() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from shapery_worker.lifeline import tie_to_parent; tie_to_parent(1 << 22); print('!')"],
        capture_output=True,
    )
    assert done.returncode == -signal.SIGKILL
    assert done.stdout == b""


def test_a_tree_is_killed_with_all_its_branches() -> None:
    program = f"import subprocess; subprocess.Popen({SLEEPER!r}, start_new_session=True); subprocess.run({SLEEPER!r})"
    root = subprocess.Popen([sys.executable, "-c", program], start_new_session=True)
    wait_for(lambda: len(psutil.Process(root.pid).children()) == 2)
    branches = [process.pid for process in psutil.Process(root.pid).children()]
    kill_tree(root.pid)
    assert root.wait(20) == -signal.SIGKILL
    wait_for(lambda: not any(alive(pid) for pid in branches))
    kill_tree(root.pid)  # what is not there is no error


def test_memory_is_that_of_the_process_and_of_its_descendants() -> None:
    hoarder = "import time; hoard = b'x' * (100 << 20); print(1, flush=True); time.sleep(100)"
    child = subprocess.Popen([sys.executable, "-c", hoarder], stdout=subprocess.PIPE)
    with child:
        assert child.stdout is not None
        child.stdout.read(1)
        resident = resident_memory(child.pid)
        assert 100 << 20 < resident < 200 << 20
        assert resident == psutil.Process(child.pid).memory_info().rss
        assert resident_memory_of_descendants(os.getpid()) >= resident
        child.kill()
    assert resident_memory(child.pid) == 0
    assert resident_memory_of_descendants(child.pid) == 0


def test_a_zombie_is_not_alive() -> None:
    child = subprocess.Popen([sys.executable, "-c", ""])
    os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)
    assert not alive(child.pid)
    child.wait()
    assert not alive(child.pid)
    assert lifeline.alive(os.getpid())
