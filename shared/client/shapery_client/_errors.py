"""What can go wrong between a client and a server.

::

    ShaperyError
    ├── ApiError          the server answered with a problem: code, sentence, hint
    ├── ConnectionFailed  the server did not answer, after retries
    ├── TransferError     bytes that arrived are not the bytes that were sent
    └── JobEndedBadly     a job that was waited for failed, crashed or was cancelled
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from shapery_contracts.errors import ShaperyError

if TYPE_CHECKING:
    import httpx

    from shapery_contracts.api import JobView, Problem


class ApiError(ShaperyError):
    """The server answered with ``application/problem+json``."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(f"{problem.detail} {problem.hint}".strip())
        self.problem = problem

    @property
    def code(self) -> str:
        """The stable error code."""
        return self.problem.code

    @property
    def status(self) -> int:
        """The HTTP status."""
        return self.problem.status

    @classmethod
    def from_response(cls, response: httpx.Response) -> ApiError:
        """Read the problem in `response`; an answer without one (from a proxy, say) is described as it is."""
        from shapery_contracts.api import Problem

        try:
            body: Any = response.json()
            return cls(Problem.model_validate(body))
        except ValueError:
            return cls(
                Problem(
                    type="about:blank",
                    title=response.reason_phrase,
                    status=response.status_code,
                    detail=f"The server answered {response.status_code} {response.reason_phrase} and did not say why.",
                    code="internal_error" if response.status_code >= 500 else "bad_request",
                    hint="Is this address really a Shapery server?",
                )
            )


class ConnectionFailed(ShaperyError):
    """The server did not answer."""


class TransferError(ShaperyError):
    """A download or an upload arrived damaged, or a file changed while it was sent."""


class JobEndedBadly(ShaperyError):
    """A job that was waited for did not succeed; `job` tells why."""

    def __init__(self, job: JobView) -> None:
        self.job = job
        if job.error is not None:
            text = f"The job {job.state}: {job.error.message} {job.error.hint}".strip()
        else:
            text = f"The job was {job.state}."
        super().__init__(text)
