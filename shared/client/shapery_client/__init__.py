"""Python SDK of the Shapery platform.

>>> from shapery_client import Client, Preview
>>> with Client("http://127.0.0.1:8000") as shapery:
...     post = shapery.upload("t1c.nii.gz")
...     job = shapery.submit("segmentation", {"post": post.id})
...     job = shapery.wait(job.id)
...     shapery.download(job, "result")
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from shapery_client._errors import ApiError, ConnectionFailed, JobEndedBadly, TransferError
    from shapery_client._sdk import Client, Preview

__all__ = ["ApiError", "Client", "ConnectionFailed", "JobEndedBadly", "Preview", "TransferError"]

_HOMES = {"Client": "shapery_client._sdk", "Preview": "shapery_client._sdk"}


def __getattr__(name: str) -> Any:
    # Lazily, because a command that works on this machine alone needs neither HTTP nor what a server says.
    if name in __all__:
        from importlib import import_module

        return getattr(import_module(_HOMES.get(name, "shapery_client._errors")), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
