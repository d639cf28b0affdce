"""The error tree and the registry of stable error codes.

::

    ShaperyError
    ├── UserError        what the user can mend: a code, a sentence and a hint
    │   ├── InvalidInput     a file or a value is not what it has to be
    │   ├── LimitExceeded    it is, but larger than allowed here
    │   └── Unavailable      what was asked for needs something this machine does not have
    └── JobCancelled     raised inside a handler's loop when its job was cancelled

Everything else that escapes is a defect of ours: it is logged with its traceback and shown as ``internal_error``.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Final


@dataclass(frozen=True, slots=True)
class ErrorCode:
    """One entry of the registry: a stable code, the HTTP status it is shown with, and what it means."""

    code: str
    status: int
    title: str


def _registry(*codes: ErrorCode) -> MappingProxyType[str, ErrorCode]:
    table = {entry.code: entry for entry in codes}
    if len(table) != len(codes):
        raise ValueError("an error code is registered twice")
    return MappingProxyType(table)


ERROR_CODES: Final = _registry(
    # requests
    ErrorCode("validation_failed", 422, "The request does not have the form it must have."),
    ErrorCode("bad_request", 400, "The request cannot be understood."),
    ErrorCode("not_found", 404, "There is no such resource, or it is not yours."),
    ErrorCode("method_not_allowed", 405, "The resource does not know this method."),
    ErrorCode("not_acceptable", 406, "The resource is not available in the asked representation."),
    ErrorCode("request_timeout", 408, "The client stayed silent for too long within its request."),
    ErrorCode("conflict", 409, "The resource is not in a state in which this can be done."),
    ErrorCode("gone", 410, "The resource existed and has expired or was deleted."),
    ErrorCode("length_required", 411, "The length of the body must be declared."),
    ErrorCode("precondition_failed", 412, "A precondition given in the request's headers does not hold."),
    ErrorCode("request_too_large", 413, "The body is larger than this server accepts."),
    ErrorCode("unsupported_media_type", 415, "The body has a content type that this resource does not take."),
    ErrorCode("range_not_satisfiable", 416, "The asked range lies outside the content."),
    ErrorCode("unauthenticated", 401, "An API key is needed, and none or an unknown one was given."),
    ErrorCode("forbidden", 403, "The API key has no scope that allows this."),
    ErrorCode("untrusted_host", 421, "The server does not answer to the name that it was addressed by."),
    ErrorCode("untrusted_origin", 403, "A web page of another origin may not do this."),
    ErrorCode("rate_limited", 429, "Too many requests in a short time."),
    ErrorCode("headers_too_large", 431, "The request's headers are larger than this server accepts."),
    ErrorCode("internal_error", 500, "The fault is ours; it was logged under the given request id."),
    ErrorCode("service_unavailable", 503, "A part of the platform that this needs does not answer."),
    ErrorCode("storage_full", 507, "The server's storage has no room for this."),
    # uploads
    ErrorCode("upload_offset_mismatch", 409, "The upload continues at another offset than the one given."),
    ErrorCode("upload_locked", 423, "Another request is writing to this upload."),
    ErrorCode("upload_expired", 410, "The upload was not finished in time and has been removed."),
    ErrorCode("checksum_mismatch", 460, "The bytes that arrived do not have the checksum that was sent with them."),
    # jobs
    ErrorCode("unknown_job_kind", 422, "There is no job of this kind."),
    ErrorCode("invalid_params", 422, "The job's parameters are not valid."),
    ErrorCode("missing_input", 422, "The job needs an input that was not given."),
    ErrorCode("wrong_input_kind", 422, "An input is of another kind than the job takes."),
    ErrorCode("idempotency_conflict", 409, "The idempotency key was used before with another request."),
    ErrorCode("invalid_transition", 409, "The job is in a state that does not allow this."),
    ErrorCode("time_limit_exceeded", 422, "The job ran longer than its kind may."),
    ErrorCode("memory_limit_exceeded", 422, "The job used more memory than its kind may."),
    ErrorCode("worker_lost", 500, "The worker died while it ran the job, more often than is tolerated."),
    ErrorCode("input_expired", 410, "An input of the job has been deleted."),
    # files
    ErrorCode("unknown_format", 422, "The file is of no format that is known here."),
    ErrorCode("corrupt_file", 422, "The file is damaged, truncated, or contradicts itself."),
    ErrorCode("unsupported_format", 422, "The file's format is known, but not this variant of it."),
    ErrorCode("too_large", 413, "The content is larger than the limit."),
    ErrorCode("unsafe_archive", 422, "The archive holds entries that no honest archive holds."),
    ErrorCode("empty_content", 422, "There is nothing in it to work on."),
    # volumes and meshes
    ErrorCode("invalid_volume", 422, "The volume cannot be used as it is."),
    ErrorCode("irregular_series", 422, "The DICOM slices do not form one regular volume."),
    ErrorCode("mixed_series", 422, "The DICOM files belong to more than one series."),
    ErrorCode("invalid_mesh", 422, "The mesh cannot be used as it is."),
    ErrorCode("inconsistent_sequence", 422, "The frames of the sequence do not share their connectivity."),
    ErrorCode("grid_mismatch", 422, "Two volumes that belong together do not lie on the same grid."),
    ErrorCode("different_subjects", 422, "Two volumes that belong together do not show the same anatomy."),
    ErrorCode("no_object_found", 422, "Nothing was found that the method could segment."),
    ErrorCode("missing_dependency", 501, "This needs a system library that is not installed here."),
)


class ShaperyError(Exception):
    """Root of all errors that Shapery raises on purpose."""


class UserError(ShaperyError):
    """What the user can mend.

    Parameters
    ----------
    code
        A key of `ERROR_CODES`.
    message
        One sentence that says what is wrong, with the figures that show it.
    hint
        One sentence that says how to mend it; may be empty where the message says so already.
    """

    def __init__(self, code: str, message: str, hint: str = "") -> None:
        if code not in ERROR_CODES:
            raise ValueError(f"unregistered error code {code!r}")
        super().__init__(message)
        self.code = code
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        return f"{self.message} {self.hint}".strip()

    def __reduce__(self) -> tuple[type[UserError], tuple[str, str, str]]:
        return type(self), (self.code, self.message, self.hint)


class InvalidInput(UserError):
    """A file or a value is not what it has to be."""


class LimitExceeded(UserError):
    """The content is sound, but larger than allowed here."""


class Unavailable(UserError):
    """What was asked for needs something this machine does not have."""


class JobCancelled(ShaperyError):
    """Raised by `JobContext.check_cancelled` when the job was cancelled."""
