"""What a service offers to the runtime, and what the runtime offers to a service.

A handler is a pure function with a name: inputs and parameters in, files and a result out. It knows neither the
database nor the queue; the same handler runs in a worker and in ``shapery segment`` without a server.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

from pydantic import BaseModel

from shapery_contracts.retrieval import ShapeBank

MAX_PREVIEW = 512 << 10
"""Bytes of one preview at the most; a larger one is not shown."""

P_contra = TypeVar("P_contra", bound=BaseModel, contravariant=True)
R_co = TypeVar("R_co", bound=BaseModel, covariant=True)


class JobContext(Protocol):
    """What a running handler may ask of its surroundings."""

    @property
    def output(self) -> Path:
        """A folder; every file that the handler leaves in it becomes an artifact named by its relative path."""

    @property
    def scratch(self) -> Path:
        """A folder for temporary files; it is removed afterwards."""

    @property
    def bank(self) -> ShapeBank | None:
        """The shape database, for handlers that search it."""

    def stage(self, name: str, fraction: float, message: str = "") -> None:
        """Say which stage begins, and which fraction in [0, 1] of the whole work is done."""

    def progress(self, fraction: float, message: str = "") -> None:
        """Say which fraction in [0, 1] of the whole work is done. Cheap: call it as often as you like."""

    def preview(self, make: Callable[[], bytes]) -> None:
        """Show how the result looks so far, in the place of what was shown before.

        Cheap: call it as often as you like; `make` is called now and then, and gives at most `MAX_PREVIEW` bytes in a
        format that the kind's results have.
        """

    def check_cancelled(self) -> None:
        """Raise `shapery_contracts.errors.JobCancelled` if the job was cancelled. Cheap: call it in loops."""


class JobHandler(Protocol[P_contra, R_co]):
    """One kind of job. Found through the entry-point group ``shapery.jobs``."""

    kind: ClassVar[str]
    """A key of `shapery_contracts.kinds.JOB_KINDS`."""

    def run(self, params: P_contra, inputs: Mapping[str, Path], context: JobContext) -> R_co:
        """Do the work.

        Parameters
        ----------
        params
            The validated parameters of the kind.
        inputs
            For each input its file; a folder where the input consists of several files (a DICOM series). Files carry
            the usual extension of what they were found to be.
        context
            Progress, cancellation and the output folder.

        Returns
        -------
        The result, as it is stored in the job's row and shown by the API.

        Raises
        ------
        UserError
            What the user can mend: the job becomes ``failed``.
        JobCancelled
            From ``context.check_cancelled``: the job becomes ``cancelled``.
        Exception
            Anything else is ours: the job is tried again and then becomes ``crashed``.
        """


AnyHandler = JobHandler[Any, Any]
