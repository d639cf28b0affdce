"""Python SDK of the Shapery platform.

>>> from shapery_client import Client, Preview
>>> with Client("http://127.0.0.1:8000") as shapery:
...     post = shapery.upload("t1c.nii.gz")
...     job = shapery.submit("segmentation", {"post": post.id})
...     job = shapery.wait(job.id)
...     shapery.download(job, "result")
"""

from shapery_client._errors import ApiError, ConnectionFailed, JobEndedBadly, TransferError
from shapery_client._sdk import Client, Preview

__all__ = ["ApiError", "Client", "ConnectionFailed", "JobEndedBadly", "Preview", "TransferError"]
