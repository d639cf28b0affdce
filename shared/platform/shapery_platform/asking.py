"""Questions to a service that are answered at once, over Redis and without a job: for work of milliseconds.

A job costs rows, a message and a process, which is much beside a search of 20 ms. So a service may have resident
processes (`shapery_worker.resident`): whoever asks puts a question on the service's list and waits at a list of its
own for the answer. Nothing is promised: a question that nobody takes before its deadline is dropped, its asker goes
another way, and that way is a job. So neither questions nor answers need to survive anything.
"""

from __future__ import annotations

import time
from typing import Any
from uuid import UUID, uuid4

import redis
from pydantic import BaseModel, ConfigDict

from shapery_platform.queue import connect
from shapery_platform.settings import Settings

PRESENCE_SECONDS = 5
"""How long a resident process counts as there after it said so."""
_LONGEST_WAIT = 4.0
"""Seconds, below those after which the connection gives up."""
_ANSWER_SECONDS = 30
"""After so long an answer that nobody took is dropped."""
_MOST_WAITING = 100
"""Questions that may wait for one service; beyond, a job is the better way."""


class Question(BaseModel):
    """What is asked: the parameters of a job kind, on behalf of an owner."""

    model_config = ConfigDict(frozen=True)

    id: UUID
    kind: str
    owner: str
    params: dict[str, Any]
    deadline: float
    """Unix time after which nobody waits for the answer."""


class Answer(BaseModel):
    """What came of a question: a result, or what the user can mend; with neither, it takes longer than that."""

    model_config = ConfigDict(frozen=True)

    result: dict[str, Any] | None = None
    code: str | None = None
    message: str = ""
    hint: str = ""


class Asker:
    """The side that asks; may be used by several threads.

    Parameters
    ----------
    settings
        Where Redis is.
    """

    def __init__(self, settings: Settings) -> None:
        self._client = connect(settings)

    def ask(self, service: str, kind: str, owner: str, params: dict[str, Any], seconds: float) -> Answer | None:
        """Ask a service and return its answer.

        None where no resident process is there, or none answers in time, or Redis does not.
        """
        seconds = min(seconds, _LONGEST_WAIT)
        question = Question(id=uuid4(), kind=kind, owner=owner, params=params, deadline=time.time() + seconds)
        try:
            with self._client.pipeline(transaction=False) as pipe:
                pipe.exists(_presence(service))
                pipe.llen(_questions(service))
                present, waiting = pipe.execute()
            if not present or waiting > _MOST_WAITING:
                return None
            self._client.rpush(_questions(service), question.model_dump_json())
            taken: Any = self._client.blpop([_answer(question.id)], timeout=seconds)
        except redis.RedisError:
            return None
        return None if taken is None else Answer.model_validate_json(taken[1])

    def close(self) -> None:
        """Close the connections."""
        self._client.close()


class Answerer:
    """The side of a resident process."""

    def __init__(self, settings: Settings, service: str) -> None:
        self._client = connect(settings)
        self._service = service

    def next(self, seconds: float) -> Question | None:
        """Say that this process is there, and return the next question that somebody still waits for.

        Raises
        ------
        redis.RedisError
            Redis does not answer.
        """
        self._client.set(_presence(self._service), 1, ex=PRESENCE_SECONDS)
        taken: Any = self._client.blpop([_questions(self._service)], timeout=seconds)
        if taken is None:
            return None
        question = Question.model_validate_json(taken[1])
        return question if question.deadline > time.time() else None

    def answer(self, question: Question, answer: Answer) -> None:
        """Give the answer to whoever waits for it; raises as `next`."""
        with self._client.pipeline(transaction=True) as pipe:
            pipe.rpush(_answer(question.id), answer.model_dump_json())
            pipe.expire(_answer(question.id), _ANSWER_SECONDS)
            pipe.execute()

    def leave(self) -> None:
        """Say that this process goes; others that are there say within a second that they are."""
        try:
            self._client.delete(_presence(self._service))
        except redis.RedisError:
            return
        finally:
            self._client.close()


def _presence(service: str) -> str:
    return f"shapery.resident.{service}"


def _questions(service: str) -> str:
    return f"shapery.questions.{service}"


def _answer(question_id: UUID) -> str:
    return f"shapery.answer.{question_id}"
