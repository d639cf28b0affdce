"""`Client`: everything the HTTP API offers, with types."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path, PurePosixPath
from types import TracebackType
from typing import Any, Literal, Self
from uuid import UUID, uuid4

import httpx
from httpx_sse import EventSource

from shapery_client._bank import BankCalls, Id
from shapery_client._errors import ApiError, ConnectionFailed, JobEndedBadly, TransferError
from shapery_client._transport import Transport
from shapery_client._uploads import CHUNK, Progress, UploadJournal, upload_file
from shapery_contracts.api import (
    ArtifactView,
    AssetView,
    BatchEvent,
    BatchItem,
    BatchResult,
    BatchView,
    JobEvent,
    JobKindView,
    JobView,
    KeyCreated,
    KeyView,
    Scope,
    ServerInfo,
    UsageView,
)
from shapery_contracts.shapes import SearchAnswer, SearchRequest
from shapery_contracts.states import JobState

Inputs = Mapping[str, UUID | str | Sequence[UUID | str]]


@dataclass(frozen=True)
class Preview:
    """How a running job's result looks so far: its number, and its bytes."""

    number: int
    data: bytes


class Client(BankCalls):
    """A connection to a Shapery server.

    Parameters
    ----------
    server
        Address of the server.
    api_key
        Secret of an API key; not needed on a server in local mode.
    timeout
        Seconds to wait for an answer.
    attempts
        How often a request is tried while the server is away or says "not now". Jobs are created with an idempotency
        key, so a repeated request never makes a second job.
    http
        A ready `httpx.Client` instead of one of our own.
    journal
        Where unfinished uploads are remembered; by default a file in the user's cache folder.
    """

    def __init__(
        self,
        server: str = "http://127.0.0.1:8000",
        *,
        api_key: str | None = None,
        timeout: float = 60.0,
        attempts: int = 5,
        http: httpx.Client | None = None,
        journal: UploadJournal | None = None,
    ) -> None:
        self._transport = Transport(server, api_key=api_key, timeout=timeout, attempts=attempts, http=http)
        self._journal = journal or UploadJournal()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection."""
        self._transport.close()

    @property
    def server(self) -> str:
        """The server's address."""
        return self._transport.server

    # the server

    def info(self) -> ServerInfo:
        """Return the server's version, how one signs in, and its limits."""
        return self._get("/v1/info", ServerInfo)

    def kinds(self) -> list[JobKindView]:
        """Return the job kinds the server knows."""
        response = self._transport.request("GET", "/v1/kinds")
        return [JobKindView.model_validate(item) for item in response.json()]

    def usage(self) -> UsageView:
        """Return how many jobs you have in which state, and what your uploads and results take."""
        return self._get("/v1/usage", UsageView)

    # assets

    def upload(
        self,
        path: str | Path,
        *,
        filename: str | None = None,
        progress: Progress | None = None,
        chunk_size: int = CHUNK,
    ) -> AssetView:
        """Send a file, resuming where an earlier try was cut off, and return the asset.

        Raises
        ------
        ApiError
            The server refused the file, e.g. with ``unknown_format``.
        """
        asset = upload_file(
            self._transport,
            Path(path),
            filename=filename,
            chunk_size=chunk_size,
            progress=progress,
            journal=self._journal,
        )
        return self.asset(asset)

    def asset(self, asset_id: UUID | str) -> AssetView:
        """Return an asset."""
        return self._get(f"/v1/assets/{asset_id}", AssetView)

    def assets(self, **filters: str) -> Iterator[AssetView]:
        """Iterate over all assets, newest first; filter by ``kind``; another ``order`` is ``name`` or ``-name``."""
        return self._pages("/v1/assets", AssetView, filters)

    def delete_asset(self, asset_id: UUID | str) -> None:
        """Delete an asset."""
        self._transport.request("DELETE", f"/v1/assets/{asset_id}")

    def download_asset(self, asset: AssetView, path: str | Path, *, progress: Progress | None = None) -> Path:
        """Write an asset's content to `path`, checked against its hash."""
        return self._download(asset.content_url, Path(path), asset.sha256, asset.size, progress)

    # jobs

    def submit(
        self,
        kind: str,
        inputs: Inputs,
        params: Mapping[str, Any] | None = None,
        *,
        idempotency_key: str | None = None,
    ) -> JobView:
        """Ask for a job and return it at once; `wait` waits for its end."""
        response = self._transport.request(
            "POST",
            "/v1/jobs",
            repeatable=True,  # the idempotency key makes it so
            headers={"Idempotency-Key": idempotency_key or str(uuid4())},
            json={"kind": kind, "inputs": _plain(inputs), "params": dict(params or {})},
        )
        return JobView.model_validate(response.json())

    def job(self, job_id: UUID | str) -> JobView:
        """Return a job as it is now."""
        return self._get(f"/v1/jobs/{job_id}", JobView)

    def jobs(self, **filters: str) -> Iterator[JobView]:
        """Iterate over all jobs, newest first; filter by ``state``, ``kind``, ``batch_id`` or ``name``.

        Another ``order`` is ``created``, ``name``, ``state`` or ``took``, downwards with a minus.
        """
        return self._pages("/v1/jobs", JobView, filters)

    def cancel(self, job_id: UUID | str) -> JobView:
        """Cancel a job."""
        return self._post(f"/v1/jobs/{job_id}/cancel", JobView, repeatable=True)

    def retry(self, job_id: UUID | str) -> JobView:
        """Run a failed, crashed or cancelled job again."""
        return self._post(f"/v1/jobs/{job_id}/retry", JobView)

    def events(self, job_id: UUID | str, *, after: int = 0) -> Iterator[JobEvent]:
        """Iterate over a job's events after number `after` until it has ended, reconnecting where that is needed.

        The events of a job that was run again tell of each run; start after `JobView.event` for what is new.
        """
        while True:
            for text in self._events(f"/v1/jobs/{job_id}/events", after, self._transport.attempts):
                event = JobEvent.model_validate_json(text)
                after = event.seq
                yield event
            job = self.job(job_id)  # a stream ends after some time, too, and where a former run ended
            if job.state.terminal and after >= job.event:
                return

    def preview(self, job_id: UUID | str, *, after: int = 0) -> Preview | None:
        """Return how a running job's result looks so far; None where that is not newer than number `after`.

        The bytes of a segmentation are an ``evolution.bin`` with one frame per object, as
        `shapery_segmentation.evolution` reads it.
        """
        response = self._transport.request("GET", f"/v1/jobs/{job_id}/preview", params={"after": after})
        if response.status_code == 204:
            return None
        return Preview(int(response.headers["Shapery-Preview"]), response.content)

    def wait(
        self,
        job_id: UUID | str,
        *,
        on_event: Callable[[JobEvent], None] | None = None,
        timeout: float | None = None,
        check: bool = True,
    ) -> JobView:
        """Wait until a job has ended and return it.

        Parameters
        ----------
        on_event
            Called for each event, for a progress bar.
        timeout
            Seconds after which `TimeoutError` is raised; the job goes on.
        check
            Whether a job that did not succeed raises `JobEndedBadly`.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        job = self.job(job_id)
        while not job.state.terminal:
            for event in self.events(job_id, after=job.event):
                if on_event:
                    on_event(event)
                if deadline is not None and time.monotonic() > deadline:
                    raise TimeoutError(f"job {job_id} has not ended within {timeout:g} s; it goes on")
            job = self.job(job_id)
        if check and job.state is not JobState.SUCCEEDED:
            raise JobEndedBadly(job)
        return job

    def download(
        self,
        job: JobView,
        folder: str | Path,
        *,
        names: Iterable[str] | None = None,
        progress: Callable[[ArtifactView], None] | None = None,
    ) -> list[Path]:
        """Write a job's artifacts (or those called `names`) into `folder`, each checked against its hash."""
        wanted = None if names is None else set(names)
        root = Path(folder)
        paths = []
        for artifact in job.artifacts:
            if wanted is not None and artifact.name not in wanted:
                continue
            relative = PurePosixPath(artifact.name)
            if relative.is_absolute() or ".." in relative.parts:
                raise TransferError(f"The server names an artifact {artifact.name!r}, which would leave the folder.")
            target = root.joinpath(*relative.parts)
            target.parent.mkdir(parents=True, exist_ok=True)
            paths.append(self._download(artifact.url, target, artifact.sha256, artifact.size, None))
            if progress:
                progress(artifact)
        return paths

    # batches

    def submit_batch(
        self,
        kind: str,
        items: Iterable[BatchItem],
        params: Mapping[str, Any] | None = None,
        *,
        idempotency_key: str | None = None,
    ) -> BatchView:
        """Ask for many jobs of one kind at once; sent as NDJSON, line by line."""
        header = json.dumps({"kind": kind, "params": dict(params or {})})
        lines = [header, *(item.model_dump_json() for item in items)]
        response = self._transport.request(
            "POST",
            "/v1/batches",
            repeatable=True,
            headers={"Content-Type": "application/x-ndjson", "Idempotency-Key": idempotency_key or str(uuid4())},
            content="\n".join(lines) + "\n",
        )
        return BatchView.model_validate(response.json())

    def batch(self, batch_id: UUID | str) -> BatchView:
        """Return a batch as it is now."""
        return self._get(f"/v1/batches/{batch_id}", BatchView)

    def batch_events(self, batch_id: UUID | str) -> Iterator[BatchEvent]:
        """Iterate over the changes of a batch's counts until all its jobs have ended."""
        for text in self._events(f"/v1/batches/{batch_id}/events", 0, self._transport.attempts):
            event = BatchEvent.model_validate_json(text)
            yield event
            if event.finished:
                return

    def wait_batch(self, batch_id: UUID | str, *, on_event: Callable[[BatchEvent], None] | None = None) -> BatchView:
        """Wait until every job of a batch has ended."""
        batch = self.batch(batch_id)
        while not batch.finished:
            for event in self.batch_events(batch_id):
                if on_event:
                    on_event(event)
            batch = self.batch(batch_id)
        return batch

    def batch_results(self, batch_id: UUID | str) -> Iterator[BatchResult]:
        """Iterate over a batch's jobs in the order of its items, as they are streamed."""
        with self._transport.stream("GET", f"/v1/batches/{batch_id}/results") as response:
            for line in response.iter_lines():
                if line.strip():
                    yield BatchResult.model_validate_json(line)

    def cancel_batch(self, batch_id: UUID | str) -> BatchView:
        """Cancel what has not ended of a batch."""
        return self._post(f"/v1/batches/{batch_id}/cancel", BatchView, repeatable=True)

    def retry_batch(self, batch_id: UUID | str) -> BatchView:
        """Run the failed and crashed jobs of a batch again, and only those."""
        return self._post(f"/v1/batches/{batch_id}/retry", BatchView)

    # searches; collections and shapes are in `BankCalls`

    def search(
        self,
        *,
        shape: Id | None = None,
        asset: Id | None = None,
        region: Sequence[int] | None = None,
        parts: Sequence[int] | None = None,
        mode: Literal["global", "partial"] = "global",
        collection: str | None = None,
        labels: Mapping[str, str] | None = None,
        limit: int = 20,
        rerank: bool = False,
    ) -> SearchAnswer:
        """Find shapes like a stored shape or an uploaded mesh, and wait for the answer.

        Raises
        ------
        JobEndedBadly
            It took a job, which did not succeed.
        """
        request = SearchRequest(
            shape_id=None if shape is None else UUID(str(shape)),
            asset_id=None if asset is None else UUID(str(asset)),
            region=None if region is None else list(region),
            parts=None if parts is None else list(parts),
            mode=mode,
            collection=collection,
            labels=dict(labels or {}),
            limit=limit,
            rerank=rerank,
        )
        response = self._transport.request(
            "POST",
            "/v1/search",
            repeatable=True,
            headers={"Idempotency-Key": str(uuid4())},
            json=request.model_dump(mode="json", exclude_none=True),
        )
        if response.status_code == 200:
            return SearchAnswer.model_validate(response.json())
        job = self.wait(JobView.model_validate(response.json()).id)
        return self._get(f"/v1/search/{job.id}", SearchAnswer)

    # API keys

    def create_key(
        self, name: str, scopes: Sequence[Scope] = (Scope.READ, Scope.WRITE), expires_at: datetime | None = None
    ) -> KeyCreated:
        """Make an API key; its secret is shown this once."""
        body = {"name": name, "scopes": list(scopes), "expires_at": expires_at.isoformat() if expires_at else None}
        return KeyCreated.model_validate(self._transport.request("POST", "/v1/keys", json=body).json())

    def keys(self) -> Iterator[KeyView]:
        """Iterate over the API keys."""
        return self._pages("/v1/keys", KeyView, {})

    def revoke_key(self, key_id: UUID | str) -> None:
        """Revoke an API key at once."""
        self._transport.request("DELETE", f"/v1/keys/{key_id}")

    # plumbing

    def _events(self, path: str, after: int, attempts: int) -> Iterator[str]:
        """Yield the data of server-sent events, resuming after the last one seen."""
        last = str(after) if after else ""
        failures = 0
        while True:
            headers = {"Accept": "text/event-stream", **({"Last-Event-ID": last} if last else {})}
            try:
                with self._transport.stream("GET", path, headers=headers) as response:
                    for event in EventSource(response).iter_sse():
                        failures = 0
                        last = event.id or last
                        if event.data:  # an id or a retry time may come without
                            yield event.data
                return
            except (ConnectionFailed, ApiError) as error:
                if isinstance(error, ApiError) and error.status not in {429, 502, 503, 504}:
                    raise
                failures += 1
                if failures >= attempts:
                    raise
                self._transport.pause(failures)

    def _download(self, url: str, path: Path, sha256: str, size: int, progress: Progress | None) -> Path:
        """Download with resume: a dropped connection goes on where it stopped, and the hash is checked at the end."""
        partial = path.with_name(path.name + ".part")
        digest = hashlib.sha256()
        done = 0
        failures = 0
        with partial.open("wb") as stream:
            while True:
                headers = {"Range": f"bytes={done}-", "If-Range": f'"{sha256}"'} if done else {}
                try:
                    with self._transport.stream("GET", url, headers=headers) as response:
                        if done and response.status_code != 206:
                            stream.seek(0)
                            stream.truncate()
                            digest, done = hashlib.sha256(), 0
                        for chunk in response.iter_bytes():
                            stream.write(chunk)
                            digest.update(chunk)
                            done += len(chunk)
                            if progress:
                                progress(done, size)
                    break
                except ConnectionFailed:
                    failures += 1
                    if failures >= self._transport.attempts:
                        raise
                    self._transport.pause(failures)
        if digest.hexdigest() != sha256:
            partial.unlink()
            raise TransferError(f"{path.name} arrived damaged: its hash is not the one the server told. Try again.")
        partial.replace(path)
        return path


def _plain(inputs: Inputs) -> dict[str, str | list[str]]:
    """Return `inputs` with ids as text, as the API takes them."""
    return {
        name: str(value) if isinstance(value, UUID | str) else [str(item) for item in value]
        for name, value in inputs.items()
    }
