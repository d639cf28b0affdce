"""Watching work on a server until it ends, and saying so where nobody does it."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from shapery_client._errors import ApiError, ConnectionFailed
from shapery_client.cli._output import StageBar, stage_bar

if TYPE_CHECKING:
    from shapery_client._sdk import Client
    from shapery_contracts.api import JobEvent, JobView

LOOK_EVERY = 10.0
"""Seconds between two looks whether the kind has a worker; a platform that has just started gets its workers sooner."""
_LAST_ANSWER = 2.0
"""Seconds that the end waits at most for a look under way."""


def follow(client: Client, job: JobView, title: str) -> JobView:
    """Show a job's progress until it has ended, and return it; raises `JobEndedBadly` where it did not succeed."""
    with stage_bar(title) as bar, missing_workers_told(client, job.kind, bar):

        def tell(event: JobEvent) -> None:
            stage = "" if event.state.terminal else event.stage  # an ended job keeps the last stage it told of
            bar.update(stage, event.fraction, event.message)

        return client.wait(job.id, on_event=tell)


@contextmanager
def missing_workers_told(client: Client, kind: str, bar: StageBar) -> Iterator[None]:
    """Meanwhile, say beside the bar when no worker serves `kind`: it may be starting, or unable to."""
    ended = threading.Event()

    def look() -> None:
        while not ended.wait(LOOK_EVERY):
            try:
                served = {view.name: view for view in client.kinds()}
            except (ApiError, ConnectionFailed):
                continue  # the main thread asks the same server, and reports what is wrong with it
            except RuntimeError:
                if ended.is_set():
                    return  # the client was closed meanwhile
                raise
            if kind in served and served[kind].workers == 0:
                service = served[kind].service
                bar.note(f"waits: no {service} worker is running (on its server, see the log of worker-{service})")

    thread = threading.Thread(target=look, name="missing-workers", daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join(_LAST_ANSWER)
