"""What recognition gives: the kind of an asset, its format, and what its header tells."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum

from pydantic import BaseModel, ConfigDict

from shapery_contracts.errors import InvalidInput

Details = dict[str, str | int | float | list[int] | list[float]]

DEFLATE_RATIO = 1032
"""No deflate stream expands further than this; a header that claims more contradicts its file."""


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
    details: Details = {}
    """What the header tells at no cost: shape, spacing, counts of vertices or faces."""


def corrupt(
    message: str, hint: str = "Check the file with the program that wrote it, and send it again."
) -> InvalidInput:
    """Return the error for a file that is damaged, truncated, or contradicts itself."""
    return InvalidInput("corrupt_file", message, hint)


def unsupported(message: str, hint: str) -> InvalidInput:
    """Return the error for a known format, or a variant of one, that is not read."""
    return InvalidInput("unsupported_format", message, hint)


def check_data_fits(what: str, claimed: int, available: int, *, deflated: bool = False) -> None:
    """Refuse a header that claims more bytes of data than can be in the file.

    Parameters
    ----------
    what
        The format's name, for the sentence.
    claimed
        Bytes that the header asks for.
    available
        Bytes of the file from where the data begins.
    deflated
        Whether these are compressed with deflate.

    Raises
    ------
    InvalidInput
        ``corrupt_file``.
    """
    most = (available + 64) * DEFLATE_RATIO if deflated else available
    if claimed > most:
        room = f"{available} compressed bytes" if deflated else f"{available} bytes"
        raise corrupt(
            f"The {what} header asks for {claimed} bytes of data, and the file has {room}.",
            "The file is truncated or its header is wrong; send it again.",
        )


def text_of(head: bytes) -> str | None:
    """Return `head` as text, or None if it is binary. A UTF-8 byte order mark is dropped."""
    if head.startswith(b"\xef\xbb\xbf"):
        head = head[3:]
    if head.translate(None, _TEXT_BYTES):
        return None
    return head.decode("latin-1")


_TEXT_BYTES = bytes(b for b in range(256) if b >= 0x20 and b != 0x7F) + b"\t\n\v\f\r"


def finite_spacing(values: Sequence[float]) -> list[float]:
    """Return `values` fit for `FileFormat.details`: absolute, and 0 where the header has no finite number."""
    return [abs(v) if math.isfinite(v) else 0.0 for v in values]


def voxel_count(shape: Sequence[int]) -> int:
    """Return the product of `shape`, exactly."""
    return math.prod(shape)
