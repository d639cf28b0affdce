"""Settings, stop signals, metrics, the broker's watch, the reaper's patience, and health."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from datetime import timedelta
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from uuid import UUID

import pytest
from pydantic import ValidationError
from sqlalchemy import update

from shapery_contracts.api import JobCreate
from shapery_contracts.errors import Unavailable
from shapery_contracts.formats import AssetKind, FileFormat
from shapery_platform import assets, jobs, workers
from shapery_platform.db import Database, utc_now
from shapery_platform.db.models import Job
from shapery_platform.settings import load_settings
from shapery_platform.storage.opening import open_store
from shapery_worker import cli
from shapery_worker.broker import DeliveryWatch, PatientConnection, state
from shapery_worker.health import check_health
from shapery_worker.metrics import MetricsServer
from shapery_worker.reaper import Reaper, alive_file
from shapery_worker.settings import THREAD_VARIABLES, WorkerSettings, processor_count, scratch_root
from shapery_worker.stop_signal import StopSignal
from tests.support.databases import migrated


def test_threads_are_bounded_unless_the_operator_says_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (*THREAD_VARIABLES, "NUMBA_THREADING_LAYER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    variables = WorkerSettings(threads=3).thread_environment()
    assert variables["OMP_NUM_THREADS"] == "7"
    assert variables["NUMBA_NUM_THREADS"] == variables["OPENBLAS_NUM_THREADS"] == "3"
    assert variables["NUMBA_THREADING_LAYER"] == "workqueue"
    several = WorkerSettings(concurrency=2 * processor_count()).thread_environment()
    assert several["MKL_NUM_THREADS"] == "1"


def test_settings_come_from_the_environment_and_are_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHAPERY_WORKER_CONCURRENCY", "4")
    monkeypatch.setenv("SHAPERY_WORKER_METRICS_PORT", "")
    assert WorkerSettings().concurrency == 4
    assert WorkerSettings().metrics_port is None
    monkeypatch.setenv("SHAPERY_WORKER_CONCURRENCY", "0")
    with pytest.raises(ValidationError):
        WorkerSettings()


def test_scratch_lies_where_it_was_put(tmp_path: Path) -> None:
    assert scratch_root(load_settings(home=tmp_path), "motion") == tmp_path / "scratch" / "jobs" / "motion"
    settings = load_settings(home=tmp_path, scratch=tmp_path / "fast")
    assert scratch_root(settings, "motion") == tmp_path / "fast" / "jobs" / "motion"


def test_a_stop_signal_ends_the_sleep_and_is_counted() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with StopSignal() as stop:
        assert not stop.wait(0.0)
        os.kill(os.getpid(), signal.SIGTERM)
        assert stop.wait(60.0)
        os.kill(os.getpid(), signal.SIGINT)
        assert stop.asked == 2
        stop.clear()
        assert stop.wait(60.0)
    assert signal.getsignal(signal.SIGTERM) is before


def test_metrics_add_up_over_processes_also_those_that_were_killed(tmp_path: Path) -> None:
    program = (
        "import os, signal\n"
        "from shapery_worker.metrics import JobMetrics\n"
        "JobMetrics('probe').attempt_ended('kind-a', 'succeeded', 0.5, 1 << 30)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    stale = tmp_path / ".metrics-probe-4000000"
    stale.mkdir()
    with MetricsServer(WorkerSettings(metrics_port=0), tmp_path / "probe") as server:
        assert not stale.exists()
        for _ in range(2):
            subprocess.run([sys.executable, "-c", program], check=False)
        with urllib.request.urlopen(f"http://127.0.0.1:{server.port}/metrics") as answer:
            text = answer.read().decode()
    assert 'shapery_worker_attempts_total{end="succeeded",kind="kind-a",service="probe"} 2.0' in text
    assert 'shapery_worker_attempt_seconds_sum{kind="kind-a",service="probe"} 1.0' in text
    assert not list(tmp_path.glob(".metrics-*"))


def test_without_a_port_nothing_is_collected(tmp_path: Path) -> None:
    with MetricsServer(WorkerSettings(metrics_port=None), tmp_path / "probe") as server:
        assert server.port is None
        assert "PROMETHEUS_MULTIPROC_DIR" not in os.environ


def consumer(delivered: int, dirty: int) -> Any:
    qos = SimpleNamespace(_delivered=dict.fromkeys(range(delivered)), _dirty=set(range(dirty)))
    return SimpleNamespace(task_consumer=SimpleNamespace(channel=SimpleNamespace(qos=qos)), steps=[])


class Request:
    """Something that can be referred to weakly, as Celery does."""


def test_deliveries_that_nobody_works_on_end_the_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(state, "reserved_requests", {Request()})
    watch = DeliveryWatch(consumer(0, 0))
    for _ in range(10):
        watch.look(consumer(2, 1))  # one is held and one is known
    watch.look(consumer(2, 0))
    watch.look(consumer(2, 0))
    watch.look(consumer(1, 0))  # it was only on its way
    watch.look(consumer(2, 0))
    watch.look(consumer(2, 0))
    with pytest.raises(ConnectionError, match="2 deliveries are held, and 1 tasks are known"):
        watch.look(consumer(2, 0))
    watch.look(SimpleNamespace(task_consumer=None))


def test_a_lost_broker_is_tried_again_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}
    monkeypatch.setattr("kombu.Connection.ensure_connection", lambda _self, *_args, **kwargs: seen.update(kwargs))
    PatientConnection("memory://").ensure_connection(None, max_retries=None)
    assert seen["interval_max"] <= 2.0
    assert seen["max_retries"] is None


@pytest.fixture
def settings(tmp_path: Path) -> Any:
    made = load_settings(home=tmp_path, redis_url=f"unix://{tmp_path}/nobody.sock", min_free_bytes=0)
    migrated(made.database_url)
    return made


def test_the_reaper_goes_on_whatever_fails_and_says_it_once(
    settings: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    reaper = Reaper(settings)
    recovered = []
    monkeypatch.setattr(jobs, "recover_lost", lambda *_: recovered.append(1) or [])

    def away(*_: Any) -> int:
        raise Unavailable("service_unavailable", "The queue does not answer.")

    monkeypatch.setattr("shapery_platform.dispatch.dispatch_pending", away)
    assert not reaper.turn()
    assert not reaper.turn()
    assert len(recovered) == 2
    assert caplog.text.count("dispatch has to wait: The queue does not answer.") == 1
    monkeypatch.setattr("shapery_platform.dispatch.dispatch_pending", lambda *_: 3)
    assert reaper.turn()
    assert "dispatch works again" in caplog.text

    def broken(*_: Any) -> int:
        raise ZeroDivisionError

    monkeypatch.setattr("shapery_platform.dispatch.dispatch_pending", broken)
    assert not reaper.turn()
    assert len(recovered) == 4
    assert "ZeroDivisionError" in caplog.text
    assert reaper.expire()


def test_a_reaper_without_redis_says_so_in_one_line(settings: Any, caplog: pytest.LogCaptureFixture) -> None:
    reaper = Reaper(settings)
    for _ in range(3):
        assert not reaper.turn()
    assert "Traceback" not in caplog.text
    assert caplog.text.count("dispatch has to wait") == 1


def test_a_message_lost_in_a_queue_that_never_drains_is_sent_again(
    settings: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    database = Database(settings.database_url)
    asset = open_store(settings, database).put_bytes(b"volume")
    with database.session() as session:
        volume = FileFormat(kind=AssetKind.VOLUME, format="nifti1", media_type="", extension=".nii")
        store = open_store(settings, database)
        post = assets.create_from_upload(session, store, settings, "ann", asset.sha256, asset.size, "x", volume).id
    old, new, running = (create_job(database, settings, post) for _ in range(3))
    with database.session() as session:
        jobs.mark_enqueued(session, [old, new, running])
        assert jobs.claim(session, running, "worker") is not None
        session.execute(
            update(Job).where(Job.id.in_([old, running])).values(enqueued_at=utc_now() - timedelta(seconds=400))
        )
    sent: list[Any] = []
    lengths = {"segmentation": 3}
    monkeypatch.setattr("shapery_platform.queue.queue_lengths", lambda _settings: lengths)
    monkeypatch.setattr("shapery_platform.queue.send", lambda _celery, listed: sent.extend(listed) or len(listed))
    reaper = Reaper(settings)
    reaper.resend()
    assert sent == [(old, "segmentation")]
    reaper.resend()
    assert len(sent) == 1  # not again so soon
    lengths["segmentation"] = 2 * settings.dispatch_window
    with database.session() as session:
        session.execute(update(Job).where(Job.id == old).values(enqueued_at=utc_now() - timedelta(seconds=400)))
    reaper.resend()
    assert len(sent) == 1  # nor into a queue that is long enough
    database.dispose()


def create_job(database: Database, settings: Any, post: UUID) -> UUID:
    with database.session() as session:
        return jobs.create(session, settings, "ann", JobCreate(kind="segmentation", inputs={"post": post}))[0].id


def test_health_says_what_is_missing(settings: Any) -> None:
    faults = check_health(settings, "probe")
    assert any("Redis does not answer" in fault for fault in faults)
    assert any("No worker of probe" in fault for fault in faults)
    database = Database(settings.database_url)
    with database.session() as session:
        workers.register(session, "probe@here", "probe", [], socket.gethostname(), 1)
    database.dispose()
    assert not any("No worker" in fault for fault in check_health(settings, "probe"))
    assert any("No reaper" in fault for fault in check_health(settings, None, reaper=True))
    alive_file(settings).parent.mkdir(parents=True)
    alive_file(settings).touch()
    assert not any("reaper" in fault for fault in check_health(settings, None, reaper=True))
    os.utime(alive_file(settings), (time.time() - 100, time.time() - 100))
    assert any("no turn for 100 s" in fault for fault in check_health(settings, None, reaper=True))


def test_the_command_explains_itself(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("SHAPERY_SERVICE", raising=False)
    with pytest.raises(SystemExit) as exited:
        cli.main(["run"])
    assert exited.value.code == 2
    assert "--service" in capsys.readouterr().err
    monkeypatch.setenv("SHAPERY_AUTH", "local")
    assert cli.main(["up", "--home", str(tmp_path), "--host", "0.0.0.0"]) == 1
    assert "loopback" in capsys.readouterr().err
    monkeypatch.delenv("SHAPERY_AUTH")
    assert cli.main(["up", "--home", str(tmp_path), "--service", "nonsense"]) == 1
    assert "no service 'nonsense'" in capsys.readouterr().err
    monkeypatch.setenv("SHAPERY_REDIS_URL", f"unix://{tmp_path}/nobody.sock")
    monkeypatch.setenv("SHAPERY_HOME", str(tmp_path))
    assert cli.main(["health"]) == 1
    assert "Redis does not answer" in capsys.readouterr().err
