"""Messages, their lengths, and their loss, on a real Redis."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from uuid import UUID

import pytest
from sqlalchemy import func, select, update

from shapery_contracts.api import BatchHeader, BatchItem
from shapery_contracts.errors import Unavailable
from shapery_contracts.states import JobState
from shapery_platform import batches, dispatch, jobs, queue
from shapery_platform.db import Database, new_id
from shapery_platform.db.models import Job
from shapery_platform.settings import Settings, load_settings
from tests.support.redis import RedisServer, redis_server

pytestmark = pytest.mark.server


@pytest.fixture
def settings(tmp_path: Path, database_url: str, redis: RedisServer) -> Settings:
    return load_settings(
        home=tmp_path, database_url=database_url, redis_url=redis.url, min_free_bytes=0, dispatch_window=10
    )


@pytest.fixture
def celery(settings: Settings) -> queue.Celery:
    return queue.make_celery(settings)


def messages(redis: RedisServer, name: str = "segmentation") -> list[UUID]:
    """Return the jobs that the messages of a queue name, the next one first."""
    with redis.connect() as client:
        raw = [json.loads(entry) for entry in client.lrange(name, 0, -1)]
    return [UUID(entry["headers"]["argsrepr"][2:-2]) for entry in raw[::-1]]


def unsent(database: Database) -> int:
    with database.session(readonly=True) as session:
        return (
            session.scalar(
                select(func.count()).select_from(Job).where(Job.state == JobState.QUEUED, Job.enqueued_at.is_(None))
            )
            or 0
        )


def test_a_message_is_json_and_names_the_job(redis: RedisServer, settings: Settings, celery: queue.Celery) -> None:
    job_id = new_id()
    queue.enqueue(celery, job_id, "segmentation")
    with redis.connect() as client:
        assert client.type("segmentation") == b"list"
        message = json.loads(client.lindex("segmentation", 0))
    assert message["content-type"] == "application/json"
    assert message["headers"]["task"] == queue.TASK_NAME
    assert messages(redis) == [job_id]


def test_lengths_count_every_priority_and_nothing_else(
    redis: RedisServer, settings: Settings, celery: queue.Celery
) -> None:
    # kinds that another test registered have queues too, and nothing in them
    assert set(queue.queue_lengths(settings).values()) == {0}
    for priority in (None, 0, 3, 6, 9):
        celery.send_task(queue.TASK_NAME, args=[str(new_id())], queue="segmentation", priority=priority)
    queue.send(celery, [(new_id(), "motion")])
    waiting = {service: length for service, length in queue.queue_lengths(settings).items() if length}
    assert waiting == {"segmentation": 5, "motion": 1}
    # what a worker holds does not wait
    with celery.connection_for_read() as connection:
        channel = connection.default_channel
        assert channel.basic_get("motion") is not None
        assert queue.queue_lengths(settings)["motion"] == 0


def test_a_redis_that_is_gone_is_told_at_once(database: Database, settings: Settings, redis: RedisServer) -> None:
    with redis_server() as other:
        gone = settings.model_copy(update={"redis_url": other.url})
    celery = queue.make_celery(gone)
    with pytest.raises(Unavailable) as error:
        queue.enqueue(celery, new_id(), "segmentation")
    assert error.value.code == "service_unavailable"
    with pytest.raises(Unavailable):
        queue.queue_lengths(gone)
    with pytest.raises(Exception, match=r"onnect|No such file"):
        queue.ping(gone)
    queue.ping(settings)


def test_a_job_is_kept_while_redis_is_gone_and_sent_when_it_is_back(
    database: Database, settings: Settings, new_job: Callable[..., UUID]
) -> None:
    with redis_server() as own:
        settings = settings.model_copy(update={"redis_url": own.url})
        celery = queue.make_celery(settings)
        first = new_job()
        assert dispatch.submit(database, celery, first, "segmentation")
        own.kill()
        second = new_job()
        assert not dispatch.submit(database, celery, second, "segmentation")
        with pytest.raises(Unavailable):
            dispatch.dispatch_pending(database, celery, settings)
        assert unsent(database) == 1
        own.start()
        assert dispatch.dispatch_pending(database, celery, settings) == 1
        assert unsent(database) == 0
        assert messages(own)[-1] == second


def test_a_submitted_job_is_not_sent_twice(
    database: Database, settings: Settings, celery: queue.Celery, redis: RedisServer, new_job: Callable[..., UUID]
) -> None:
    job_id = new_job()
    assert dispatch.submit(database, celery, job_id, "segmentation")
    assert dispatch.dispatch_pending(database, celery, settings) == 0
    assert messages(redis) == [job_id]


def test_a_batch_waits_in_rows_and_not_in_redis(
    database: Database,
    settings: Settings,
    celery: queue.Celery,
    redis: RedisServer,
    new_asset: Callable[..., UUID],
    new_job: Callable[..., UUID],
) -> None:
    asset_id = new_asset()
    with database.session() as session:
        header = BatchHeader(kind="segmentation")
        items = (BatchItem(inputs={"post": asset_id}) for _ in range(25))
        batch_id = batches.create(session, settings, "ann", header, items)[0].id
    with database.session(readonly=True) as session:
        in_order = [result.job.id for result in batches.results(session, "ann", batch_id)]
    assert dispatch.dispatch_pending(database, celery, settings) == 10
    assert dispatch.dispatch_pending(database, celery, settings) == 0
    assert messages(redis) == in_order[:10]
    # somebody else's single job does not wait behind the other 15
    single = new_job("bob")
    assert dispatch.submit(database, celery, single, "segmentation")
    assert messages(redis)[-1] == single
    sent = messages(redis)
    while waiting := messages(redis):
        with redis.connect() as client:
            for _ in range(4):
                client.rpop("segmentation")
        for job_id in waiting[:4]:
            with database.session() as session:
                assert jobs.claim(session, job_id, "worker") is not None
        before = len(waiting) - len(waiting[:4])
        dispatch.dispatch_pending(database, celery, settings)
        sent += messages(redis)[before:]
    assert sorted(sent) == sorted([*in_order, single])


def test_lost_messages_are_sent_again_when_their_queue_is_empty(
    database: Database, settings: Settings, celery: queue.Celery, redis: RedisServer, new_job: Callable[..., UUID]
) -> None:
    made = [new_job() for _ in range(3)]
    assert dispatch.dispatch_pending(database, celery, settings) == 3
    with database.session() as session:
        past = datetime.now(UTC) - timedelta(seconds=60)
        session.execute(update(Job).values(enqueued_at=past))
    # they wait for long, but they are there
    assert dispatch.dispatch_pending(database, celery, settings) == 0
    redis.clear()
    assert dispatch.dispatch_pending(database, celery, settings) == 3
    assert messages(redis) == made
    redis.clear()
    assert dispatch.dispatch_pending(database, celery, settings) == 0, "sent a moment ago"


def test_a_lost_worker_s_job_is_sent_again(
    database: Database, settings: Settings, celery: queue.Celery, redis: RedisServer, new_job: Callable[..., UUID]
) -> None:
    job_id = new_job()
    with database.session() as session:
        assert jobs.claim(session, job_id, "worker") is not None
        session.execute(update(Job).values(heartbeat_at=datetime.now(UTC) - timedelta(seconds=60)))
    with database.session() as session:
        lost = jobs.recover_lost(session, settings)
    # dies here: the row says that no message was sent, so the next round sends it
    assert unsent(database) == 1
    assert dispatch.dispatch_pending(database, celery, settings) == 1
    assert dispatch.send(database, celery, lost) == 1
    assert messages(redis) == [job_id, job_id], "twice does no harm: the claim decides"


def test_the_broker_is_told_what_the_platform_needs(settings: Settings, celery: queue.Celery) -> None:
    conf = celery.conf
    assert conf.task_acks_late
    assert conf.task_reject_on_worker_lost
    assert conf.worker_prefetch_multiplier == 1
    assert conf.accept_content == ["json"]
    assert conf.result_backend is None
    options = conf.broker_transport_options
    assert options["visibility_timeout"] >= 1800 + 600
    assert (options["unacked_restore_interval"], options["unacked_restore_throttle"]) == (2, 1)
    longer = settings.model_copy(update={"job_time_limit": {"segmentation": 86_400.0}})
    assert queue.visibility_timeout(longer) == 87_000


def test_addresses_of_the_broker(settings: Settings) -> None:
    for url, expected in (
        ("unix:///run/redis.sock", "redis+socket:///run/redis.sock"),
        ("redis://:secret@redis:6379/2", "redis://:secret@redis:6379/2"),
        ("rediss://redis:6380/0", "rediss://redis:6380/0"),
    ):
        assert queue.broker_url(settings.model_copy(update={"redis_url": url})) == expected


@pytest.mark.parametrize("tcp", [False, True])
def test_messages_survive_a_killed_redis(tmp_path: Path, tcp: bool) -> None:
    with redis_server(tcp=tcp) as own:
        settings = load_settings(home=tmp_path, redis_url=own.url)
        celery = queue.make_celery(settings)
        sent = [new_id() for _ in range(20)]
        queue.send(celery, [(job_id, "segmentation") for job_id in sent])
        # what reached the system before the kill is in the append-only file
        own.kill()
        own.start()
        assert messages(own) == sent
        queue.send(celery, [(new_id(), "segmentation")])
        assert queue.queue_lengths(settings)["segmentation"] == 21
