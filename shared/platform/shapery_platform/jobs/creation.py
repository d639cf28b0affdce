"""From a request to rows: validation, idempotency, insertion."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from pydantic import ValidationError
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from shapery_contracts.api import JobCreate
from shapery_contracts.errors import InvalidInput
from shapery_contracts.formats import AssetKind
from shapery_contracts.kinds import JobKind, get_kind
from shapery_contracts.states import JobState
from shapery_platform.db import new_id, utc_now
from shapery_platform.db.models import Job
from shapery_platform.db.repositories import assets as asset_repository
from shapery_platform.db.repositories import jobs as repository
from shapery_platform.db.repositories import shapes as shape_repository
from shapery_platform.db.text import canonical_json
from shapery_platform.settings import Settings

Inputs = Mapping[str, UUID | Sequence[UUID]]

_LONGEST_KEY = 255


def create(
    session: Session,
    settings: Settings,
    owner: str,
    request: JobCreate,
    idempotency_key: str | None = None,
    batch_id: UUID | None = None,
    index: int | None = None,
) -> tuple[Job, bool]:
    """Create a job, or return the one that was created with the same key, and tell whether it is new.

    Raises
    ------
    InvalidInput
        ``unknown_job_kind``, ``invalid_params``, ``missing_input``, ``wrong_input_kind``, ``validation_failed``,
        ``not_found`` (an input), or ``idempotency_conflict``.
    """
    key = checked_idempotency_key(idempotency_key)
    print_ = fingerprint(request.model_dump(mode="json"))
    if key is not None and (known := _known(session, owner, key, print_)) is not None:
        return known, False
    kind = get_kind(request.kind)
    params = validated_params(kind, request.params)
    inputs = checked_names(kind, request.inputs)
    names = check_assets(session, owner, kind, [inputs])
    now = utc_now()
    row = job_row(settings, owner, kind, params, print_, now)
    row["name"] = job_name(inputs, names, params, shapes_asked_by(session, owner, [params]))
    row.update(idempotency_key=key, batch_id=batch_id, batch_index=index)
    try:
        with session.begin_nested():
            repository.add_all(session, [row], input_rows(row["id"], inputs))
    except IntegrityError:
        # the same key was used a moment ago by another request, which has committed meanwhile
        if key is not None and (known := _known(session, owner, key, print_)) is not None:
            return known, False
        raise
    job = repository.find(session, owner, row["id"])
    assert job is not None
    return job, True


def checked_idempotency_key(key: str | None) -> str | None:
    """Return the key if it can be stored."""
    if key is None:
        return None
    if not key or len(key) > _LONGEST_KEY or not key.isprintable():
        raise InvalidInput(
            "validation_failed", f"The Idempotency-Key must have 1 to {_LONGEST_KEY} printable characters."
        )
    return key


def fingerprint(request: Any) -> str:
    """Return a hash that is equal for equal requests.

    Raises
    ------
    InvalidInput
        ``invalid_params`` where the request holds NaN or infinity.
    """
    try:
        return hashlib.sha256(canonical_json(request).encode("utf-8", "surrogatepass")).hexdigest()
    except ValueError:
        raise InvalidInput("invalid_params", "The request holds a number that is not finite.") from None


def conflict(key: str) -> InvalidInput:
    """Return the error for a key that comes again with another request."""
    return InvalidInput(
        "idempotency_conflict",
        f"The Idempotency-Key {key!r} was used before with another request.",
        "Use a new key for a new request.",
    )


def _known(session: Session, owner: str, key: str, print_: str) -> Job | None:
    job = repository.find_by_idempotency_key(session, owner, key)
    if job is not None and job.fingerprint != print_:
        raise conflict(key)
    return job


def validated_params(kind: JobKind, params: Mapping[str, Any], where: str = "") -> dict[str, Any]:
    """Return the parameters with their defaults, as they are stored.

    Raises
    ------
    InvalidInput
        ``invalid_params`` with each place and reason.
    """
    try:
        dumped: dict[str, Any] = kind.params.model_validate(dict(params)).model_dump(mode="json")
        canonical_json(dumped)
    except ValidationError as error:
        reasons = [
            f"{'.'.join(['params', *(str(part) for part in fault['loc'])])}: {fault['msg']}"
            for fault in error.errors(include_url=False, include_input=False, include_context=False)
        ]
        shown = "; ".join(reasons[:5]) + (f"; and {len(reasons) - 5} more" if len(reasons) > 5 else "")
        raise InvalidInput(
            "invalid_params", f"{where}{shown}.", f"The schema of {kind.name!r} is shown at /v1/kinds."
        ) from None
    except ValueError:
        raise InvalidInput("invalid_params", f"{where}A parameter holds a number that is not finite.") from None
    return dumped


def checked_names(kind: JobKind, inputs: Inputs, where: str = "") -> dict[str, list[UUID]]:
    """Return the inputs as lists, after checking their names and numbers against the kind."""
    for name in inputs:
        if name not in kind.inputs:
            known = ", ".join(kind.inputs)
            raise InvalidInput(
                "validation_failed", f"{where}A {kind.name} job has no input {name!r}.", f"Its inputs are {known}."
            )
    listed: dict[str, list[UUID]] = {}
    for name, spec in kind.inputs.items():
        given = inputs.get(name)
        if given is None:
            if spec.required:
                raise InvalidInput("missing_input", f"{where}The input {name!r} is missing: {spec.description}")
            continue
        ids = list(given) if isinstance(given, Sequence) else [given]
        if len(ids) > 1 and not spec.many:
            raise InvalidInput("validation_failed", f"{where}The input {name!r} takes one asset, not {len(ids)}.")
        if len(set(ids)) != len(ids):
            raise InvalidInput("validation_failed", f"{where}The input {name!r} names an asset twice.")
        listed[name] = ids
    return listed


def check_assets(
    session: Session, owner: str, kind: JobKind, items: Collection[Mapping[str, Sequence[UUID]]]
) -> dict[UUID, str]:
    """Check that all inputs exist, belong to the owner and are of the right kind; keep them until the commit.

    Returns their file names.
    """
    wanted = {asset_id for inputs in items for ids in inputs.values() for asset_id in ids}
    assets = asset_repository.for_use(session, owner, wanted)
    for index, inputs in enumerate(items):
        where = f"Item {index}: " if len(items) > 1 else ""
        for name, ids in inputs.items():
            for asset_id in ids:
                if asset_id not in assets:
                    raise InvalidInput("not_found", f"{where}Input {name!r}: there is no asset {asset_id}.")
                found = assets[asset_id].kind
                if AssetKind(found) not in kind.inputs[name].kinds:
                    allowed = " or ".join(sorted(kind.inputs[name].kinds))
                    raise InvalidInput(
                        "wrong_input_kind",
                        f"{where}Input {name!r}: the asset {asset_id} is a {found}, and a {allowed} is needed.",
                    )
    return {asset_id: asset.filename for asset_id, asset in assets.items()}


def shapes_asked_by(session: Session, owner: str, params: Iterable[Mapping[str, Any]]) -> dict[str, str]:
    """Return the names, by id, of the stored shapes that jobs with these parameters are asked about."""
    asked = {found for one in params if (found := _shape_id(one)) is not None}
    return {str(shape.id): shape.name for shape in shape_repository.find_all(session, owner, asked)} if asked else {}


def job_name(
    inputs: Mapping[str, Sequence[UUID]],
    files: Mapping[UUID, str],
    params: Mapping[str, Any],
    shapes: Mapping[str, str],
) -> str:
    """Return what people know a job by.

    That is the stored shape that it is asked about, or the file name of the first asset of its first input, or nothing.
    """
    shape = _shape_id(params)
    if shape is not None and (name := shapes.get(str(shape))):
        return name
    return next((files[ids[0]] for ids in inputs.values()), "")


def _shape_id(params: Mapping[str, Any]) -> UUID | None:
    try:
        return UUID(params["shape_id"]) if params.get("shape_id") else None
    except (TypeError, ValueError):
        return None  # an id of another kind of bank, or another kind's parameter of this name


def job_row(
    settings: Settings, owner: str, kind: JobKind, params: dict[str, Any], print_: str, now: datetime
) -> dict[str, Any]:
    """Return the columns of a new job."""
    return {
        "id": new_id(),
        "owner": owner,
        "kind": kind.name,
        "service": kind.service,
        "params": params,
        "fingerprint": print_,
        "state": JobState.QUEUED,
        "event_seq": 1,
        "max_attempts": settings.max_attempts,
        "result_ttl": settings.result_ttl,
        "created_at": now,
    }


def input_rows(job_id: UUID, inputs: Mapping[str, Sequence[UUID]]) -> list[dict[str, Any]]:
    """Return the columns of a job's inputs."""
    return [
        {"job_id": job_id, "name": name, "position": position, "asset_id": asset_id}
        for name, ids in inputs.items()
        for position, asset_id in enumerate(ids)
    ]
