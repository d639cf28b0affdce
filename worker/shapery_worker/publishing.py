"""What a handler left in its output folder, on its way into the store."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from functools import partial
from pathlib import Path

from shapery_contracts.errors import ShaperyError
from shapery_platform.jobs import NewArtifact
from shapery_platform.storage import ObjectStore
from shapery_worker.patience import patiently

_LONGEST_NAME = 255

_MEDIA_TYPES = {
    ".csv": "text/csv",
    ".dcm": "application/dicom",
    ".glb": "model/gltf-binary",
    ".gz": "application/gzip",
    ".html": "text/html",
    ".json": "application/json",
    ".mha": "application/x-metaimage",
    ".nii": "application/x-nifti",
    ".npz": "application/x-npz",
    ".nrrd": "application/x-nrrd",
    ".off": "application/x-off",
    ".obj": "model/obj",
    ".ply": "application/x-ply",
    ".png": "image/png",
    ".smc": "application/x-shapery-motion",
    ".stl": "model/stl",
    ".txt": "text/plain",
    ".zip": "application/zip",
}


class UnusableOutput(ShaperyError):
    """The handler left something in its output folder that cannot become an artifact: a defect of the handler."""


def media_type(name: str) -> str:
    """Return the media type of an artifact, told from its name: our own handlers named it."""
    return _MEDIA_TYPES.get(Path(name).suffix.lower(), "application/octet-stream")


def list_output(folder: Path) -> list[tuple[str, Path]]:
    """Return the files below `folder` with their relative names, in the order of the names.

    Raises
    ------
    UnusableOutput
        Links and special files (they could lead out of the folder), and names that cannot be shown or stored.
    """
    found: list[tuple[str, Path]] = []
    for base, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(base) / name
            relative = path.relative_to(folder).as_posix()
            mode = path.lstat().st_mode
            if stat.S_ISDIR(mode):
                continue
            if not stat.S_ISREG(mode):
                raise UnusableOutput(f"The output {relative!r} is not a regular file.")
            if len(relative) > _LONGEST_NAME or not relative.isprintable():
                raise UnusableOutput(f"The output {relative[:80]!r} has a name that cannot be stored.")
            found.append((relative, path))
    return sorted(found)


def store_output(
    store: ObjectStore, folder: Path, go_on: Callable[[], None], patience: float = 0.0
) -> list[NewArtifact]:
    """Put the files below `folder` into the store; they are moved where that is possible.

    Nothing refers to them yet: if the caller dies now, or its lease was lost, the sweep removes them.

    Parameters
    ----------
    store
        Where to.
    folder
        What the handler left; nobody writes to it any more.
    go_on
        Called before every file; what it raises ends the publishing.
    patience
        Seconds for which a store that does not answer is asked again, for each file.
    """
    artifacts = []
    for name, path in list_output(folder):
        go_on()
        blob = patiently(partial(store.put_file, path, move=True), f"storing {name!r}", patience, go_on)
        artifacts.append(NewArtifact(name=name, sha256=blob.sha256, size=blob.size, media_type=media_type(name)))
    return artifacts
