"""Questions that a resident process answers over Redis, and the cases in which the asker has to go another way."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from shapery_platform import asking
from shapery_platform.asking import Answer, Answerer, Asker, Question
from shapery_platform.queue import connect
from shapery_platform.settings import Settings, load_settings
from tests.support.redis import RedisServer

pytestmark = pytest.mark.server


@pytest.fixture
def settings(tmp_path: Path, redis: RedisServer) -> Settings:
    return load_settings(home=tmp_path, redis_url=redis.url)


@pytest.fixture
def asker(settings: Settings) -> Iterator[Asker]:
    asker = Asker(settings)
    yield asker
    asker.close()


@contextmanager
def answering(settings: Settings, *, delay: float = 0.0, service: str = "svc") -> Iterator[list[Question]]:
    """Answer with what was asked; gives the questions taken."""
    seen: list[Question] = []
    stop = threading.Event()
    answerer = Answerer(settings, service)

    def run() -> None:
        while not stop.is_set():
            question = answerer.next(0.05)
            if question is not None:
                seen.append(question)
                time.sleep(delay)
                answerer.answer(question, Answer(result={"asked": question.params, "owner": question.owner}))

    thread = threading.Thread(target=run)
    thread.start()
    with connect(settings) as client:
        while not client.exists(f"shapery.resident.{service}"):
            time.sleep(0.005)
    try:
        yield seen
    finally:
        stop.set()
        thread.join()
        answerer.leave()


def test_a_question_is_answered_to_whoever_asked(settings: Settings, asker: Asker) -> None:
    answers: dict[int, Answer | None] = {}

    def ask(number: int) -> None:
        answers[number] = asker.ask("svc", "kind", f"owner {number}", {"number": number}, 3.0)

    with answering(settings), answering(settings):
        threads = [threading.Thread(target=ask, args=(number,)) for number in range(12)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert answers == {
        number: Answer(result={"asked": {"number": number}, "owner": f"owner {number}"}) for number in range(12)
    }


def test_without_anybody_there_it_is_told_at_once(settings: Settings, asker: Asker) -> None:
    began = time.monotonic()
    assert asker.ask("svc", "kind", "ann", {}, 3.0) is None
    with answering(settings, service="another"):
        assert asker.ask("svc", "kind", "ann", {}, 3.0) is None
    assert time.monotonic() - began < 2.0
    with connect(settings) as client:
        assert client.keys("shapery.questions.*") == []


def test_who_left_is_not_asked(settings: Settings, asker: Asker) -> None:
    with answering(settings):
        assert asker.ask("svc", "kind", "ann", {}, 3.0) is not None
    assert asker.ask("svc", "kind", "ann", {}, 3.0) is None


def test_an_answer_that_comes_too_late_is_nobodys(settings: Settings, asker: Asker) -> None:
    with answering(settings, delay=0.4) as seen:
        assert asker.ask("svc", "kind", "ann", {"number": 1}, 0.1) is None
        # the next one gets its own answer
        answer = asker.ask("svc", "kind", "ann", {"number": 2}, 3.0)
        assert answer is not None
        assert answer.result == {"asked": {"number": 2}, "owner": "ann"}
        assert [question.params["number"] for question in seen] == [1, 2]


def test_a_question_whose_deadline_has_passed_is_dropped(settings: Settings, asker: Asker) -> None:
    answerer = Answerer(settings, "svc")
    assert answerer.next(0.01) is None  # now it counts as there
    assert asker.ask("svc", "kind", "ann", {}, 0.05) is None
    assert answerer.next(0.5) is None
    with connect(settings) as client:
        assert client.llen("shapery.questions.svc") == 0
    answerer.leave()


def test_a_long_queue_is_not_made_longer(settings: Settings, asker: Asker, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(asking, "_MOST_WAITING", 2)
    answerer = Answerer(settings, "svc")
    answerer.next(0.01)
    for _ in range(3):
        assert asker.ask("svc", "kind", "ann", {}, 0.02) is None
    began = time.monotonic()
    assert asker.ask("svc", "kind", "ann", {}, 3.0) is None
    assert time.monotonic() - began < 1.0
    answerer.leave()


def test_without_redis_there_is_no_answer(tmp_path: Path) -> None:
    asker = Asker(load_settings(home=tmp_path, redis_url="redis://127.0.0.1:1"))
    assert asker.ask("svc", "kind", "ann", {}, 1.0) is None
    asker.close()
