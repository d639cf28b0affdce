"""What a running job shows of its result: numbered by its events, its owner's, and gone with the lease."""

from __future__ import annotations

from collections.abc import Callable
from uuid import UUID, uuid4

import pytest
from sqlalchemy import func, select

from shapery_contracts.api import JobEvent, JobView
from shapery_contracts.errors import UserError
from shapery_contracts.states import JobState
from shapery_platform import jobs
from shapery_platform.db import Database
from shapery_platform.db.models import JobPreview
from shapery_platform.jobs import ClaimedJob, Preview
from shapery_platform.settings import Settings
from tests.integration.platform.test_job_work import fall_silent


def show(database: Database, job: ClaimedJob, data: bytes | None, fraction: float = 0.5) -> JobState | None:
    with database.session() as session:
        return jobs.report_progress(session, job.job_id, job.lease, "evolve", fraction, "", data)


def look(database: Database, job_id: UUID, after: int = 0, owner: str = "ann") -> Preview | None:
    with database.session(readonly=True) as session:
        return jobs.preview(session, owner, job_id, after)


def kept(database: Database) -> int:
    with database.session(readonly=True) as session:
        return session.scalar(select(func.count()).select_from(JobPreview)) or 0


def test_the_newest_preview_is_shown_and_told_of(
    database: Database,
    claimed: Callable[..., ClaimedJob],
    view: Callable[..., JobView],
    events: Callable[..., list[JobEvent]],
) -> None:
    job = claimed()
    assert look(database, job.job_id) is None
    for number, data in enumerate((b"one", None, b"three\0"), start=1):
        show(database, job, data, number / 10)
    found = look(database, job.job_id)
    assert found is not None
    assert found.data == b"three\0"
    last = events(job.job_id)[-1]
    assert last.seq == last.preview == found.number == view(job.job_id).preview
    assert look(database, job.job_id, found.number) is None
    show(database, job, None)
    told = events(job.job_id)[-1]
    assert (told.seq, told.preview) == (found.number + 1, found.number)
    assert kept(database) == 1


def test_others_see_nothing(database: Database, claimed: Callable[..., ClaimedJob]) -> None:
    job = claimed()
    show(database, job, b"mine")
    with pytest.raises(UserError) as caught:
        look(database, job.job_id, owner="somebody else")
    assert caught.value.code == "not_found"
    with pytest.raises(UserError):
        look(database, uuid4())


def test_nothing_is_shown_without_the_lease(database: Database, claimed: Callable[..., ClaimedJob]) -> None:
    job = claimed()
    with database.session() as session:
        assert jobs.report_progress(session, job.job_id, uuid4(), "evolve", 0.5, "", b"wrong") is None
    assert look(database, job.job_id) is None
    assert kept(database) == 0


@pytest.mark.parametrize("end", ["succeed", "fail", "stop", "release", "crash", "lost"])
def test_it_goes_with_the_attempt(
    database: Database,
    settings: Settings,
    claimed: Callable[..., ClaimedJob],
    view: Callable[..., JobView],
    events: Callable[..., list[JobEvent]],
    end: str,
) -> None:
    job = claimed()
    show(database, job, b"how it looks")
    job_id, lease = job.job_id, job.lease
    with database.session() as session:
        if end == "stop":
            jobs.cancel(session, "ann", job_id)
    if end == "stop":
        assert look(database, job_id) is not None, "the work goes on until its worker notices"
        assert view(job_id).preview > 0
    if end == "lost":
        fall_silent(database, job)
    with database.session() as session:
        match end:
            case "succeed":
                assert jobs.succeed(session, job_id, lease, {}, [])
            case "fail":
                assert jobs.fail(session, job_id, lease, "no_object_found", "")
            case "stop":
                assert jobs.stop(session, job_id, lease)
            case "release":
                assert jobs.release(session, job_id, lease) is JobState.QUEUED
            case "crash":
                assert jobs.crash_or_requeue(session, job_id, lease, "") is JobState.QUEUED
            case "lost":
                assert [one.job_id for one in jobs.recover_lost(session, settings)] == [job_id]
    assert look(database, job_id) is None
    assert kept(database) == 0
    assert view(job_id).preview == events(job_id)[-1].preview == 0
    assert show(database, job, b"too late") is None
    assert kept(database) == 0


def test_numbers_go_on_in_the_next_attempt(database: Database, claimed: Callable[..., ClaimedJob]) -> None:
    """Whoever has seen the first attempt's is shown the second one's."""
    job = claimed()
    show(database, job, b"first")
    first = look(database, job.job_id)
    assert first is not None
    with database.session() as session:
        jobs.crash_or_requeue(session, job.job_id, job.lease, "")
    with database.session() as session:
        again = jobs.claim(session, job.job_id, "another")
    assert again is not None
    assert look(database, job.job_id, first.number) is None
    show(database, again, b"second")
    second = look(database, job.job_id, first.number)
    assert second is not None
    assert (second.data, second.number > first.number) == (b"second", True)
