"""Inputs on their way from the store into a job's folder, checked against their hashes."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path, PurePath

from shapery_contracts.errors import InvalidInput, ShaperyError
from shapery_platform.jobs import ClaimedInput
from shapery_platform.storage import ObjectStore
from shapery_platform.storage.content import StoredObjectMissing
from shapery_worker.patience import patiently


class StoredObjectDamaged(ShaperyError):
    """The store gave other bytes than those that were uploaded."""


def stage_inputs(
    store: ObjectStore,
    inputs: Mapping[str, Sequence[ClaimedInput]],
    folder: Path,
    go_on: Callable[[], None],
    patience: float = 0.0,
) -> dict[str, Path]:
    """Copy a job's inputs into `folder`.

    Parameters
    ----------
    store
        Where they are.
    inputs
        The files of each input.
    folder
        An empty folder.
    go_on
        Called for every piece; what it raises ends the staging.
    patience
        Seconds for which a store that does not answer is asked again.

    Returns
    -------
    For each input ``folder/<name><usual extension>``, or the folder ``folder/<name>`` where it has several files; in
    there the files keep the names that they were uploaded with, because some refer to each other by name.

    Raises
    ------
    InvalidInput
        ``input_expired``: an input is no longer stored.
    StoredObjectDamaged
        Its bytes do not have its hash.
    """
    staged: dict[str, Path] = {}
    for name, files in inputs.items():

        def stage(file: ClaimedInput, target: Path, name: str = name) -> None:
            patiently(lambda: _stage(store, file, name, target, go_on), f"staging {file.filename!r}", patience, go_on)

        if len(files) == 1:
            target = folder / f"{name}{files[0].extension}"
            stage(files[0], target)
        else:
            target = folder / name
            target.mkdir()
            for file, unique in zip(files, unique_names(files), strict=True):
                stage(file, target / unique)
        staged[name] = target
    return staged


def unique_names(files: Sequence[ClaimedInput]) -> list[str]:
    """Return a name for each file that no other has, also where the file system takes no notice of case."""
    names: list[str] = []
    taken: set[str] = set()
    for position, file in enumerate(files):
        name = PurePath(file.filename).name or f"file{file.extension}"
        if name.casefold() in taken or len(name.encode()) > 200:
            name = f"{position:05d}{file.extension}"
        while name.casefold() in taken:
            name = f"_{name}"
        taken.add(name.casefold())
        names.append(name)
    return names


def _stage(store: ObjectStore, file: ClaimedInput, name: str, target: Path, go_on: Callable[[], None]) -> None:
    digest = hashlib.sha256()
    size = 0
    try:
        chunks = store.iter_range(file.key)
        with target.open("wb") as copy:
            for chunk in chunks:
                go_on()
                digest.update(chunk)
                size += copy.write(chunk)
    except StoredObjectMissing:
        raise InvalidInput(
            "input_expired",
            f"The file {file.filename!r} ({file.size:,} bytes) of the input {name!r} has been deleted.",
            "Upload it again and create a new job.",
        ) from None
    if size != file.size or digest.hexdigest() != file.sha256:
        raise StoredObjectDamaged(
            f"The object {file.key} has {size:,} bytes with SHA-256 {digest.hexdigest()}, not {file.size:,} bytes."
        )
