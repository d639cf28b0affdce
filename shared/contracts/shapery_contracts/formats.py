"""Which kind of thing a file is, told from its content and never from its name.

Readers in `shapery_geometry` and the gateway's uploads ask the same function, so that what was accepted on upload is
what is read later.
"""

from __future__ import annotations

from enum import StrEnum
from typing import BinaryIO

from pydantic import BaseModel, ConfigDict


class AssetKind(StrEnum):
    """What an asset can be used as."""

    VOLUME = "volume"
    MESH = "mesh"
    SEQUENCE = "sequence"
    MOTION = "motion"


class FileFormat(BaseModel):
    """What a file was found to be."""

    model_config = ConfigDict(frozen=True)

    kind: AssetKind
    format: str
    """``nifti1``, ``nifti2``, ``nrrd``, ``metaimage``, ``dicom``, ``dicom-zip``, ``obj``, ``ply``, ``stl``, ``off``,
    ``glb``, ``npz``, ``mesh-zip``, ``smc``."""
    media_type: str
    extension: str
    """The usual extension, with its dot: ``.nii.gz``."""
    details: dict[str, str | int | float | list[int] | list[float]] = {}
    """What the header tells at no cost: shape, spacing, counts of vertices or faces."""


def sniff(stream: BinaryIO, size: int) -> FileFormat:
    """Tell what the `size` bytes of a seekable `stream` are.

    Reads a bounded number of bytes, whatever the file claims.

    Raises
    ------
    InvalidInput
        ``unknown_format``, ``unsupported_format``, ``empty_content``, ``unsafe_archive`` or ``corrupt_file``.
    """
    raise NotImplementedError
