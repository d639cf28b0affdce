"""Memory stays flat however large a file is: measured in a process of its own, on both stores."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.support.databases import migrated
from tests.support.s3 import S3Server

MIB = 1 << 20
SIZES = {"local": 512 * MIB, "s3": 128 * MIB}
"""The S3 of the tests needs time in proportion to the square."""
BOUND = 96 * MIB
"""What is really needed are a few parts of 8 or 16 MiB, and what the allocator keeps."""

SCRIPT = """
import json, sys
from pathlib import Path
from shapery_contracts.formats import AssetKind, FileFormat
from shapery_platform import assets, uploads
from shapery_platform.db import Database
from shapery_platform.settings import load_settings
from shapery_platform.storage import ObjectStore, UploadStaging
from shapery_platform.storage.opening import open_store

assets.sniff = lambda stream, size: FileFormat(
    kind=AssetKind.VOLUME, format="nifti1", media_type="x/y", extension=".nii")
way, size, folder = sys.argv[1], int(sys.argv[2]), Path(sys.argv[4])
settings = load_settings(min_free_bytes=0, **json.loads(sys.argv[3]))
database = Database(settings.database_url)
store = open_store(settings, database)
staging = UploadStaging.over(store)
block = bytes(range(256)) * 4096

def chunks(length):
    for begin in range(0, length, len(block)):
        yield block[: length - begin]

def run(length):
    if way == "writer":
        return store.put_blob(chunks(length), length)
    if way == "stream":
        store.put_stream(f"some/stream-{length}", chunks(length))
        return None
    if way == "file":
        path = folder / str(length)
        with path.open("wb") as file:
            file.writelines(chunks(length))
        try:
            return store.put_file(path)
        finally:
            path.unlink()
    if way == "read":
        blob = store.put_blob(chunks(length), length)
        with store.open_read(blob.key) as file:
            while file.read(1 << 20):
                pass
        store.download(blob.key, folder / "copy")
        (folder / "copy").unlink()
        return blob
    with database.session() as session:
        upload = uploads.create(session, staging, settings, "ann", length, {})
    offset = 0
    for number in range(3):
        piece = length // 3 if number < 2 else length - offset
        offset = uploads.append(database, staging, settings, "ann", upload.id, offset, chunks(piece)).offset
    # a process that has seen no byte: the hash is rebuilt by reading back
    other = UploadStaging.over(store)
    asset = uploads.finish(database, other, store, settings, "ann", upload.id)
    assert asset.size == length
    return None

def peak():
    # of this process alone: what getrusage says includes the one that it was forked from
    line = next(line for line in open("/proc/self/status") if line.startswith("VmHWM"))
    return int(line.split()[1])

run(20 << 20)
Path("/proc/self/clear_refs").write_text("5")
before = peak()
blob = run(size)
after = peak()
if blob is not None:
    assert store.size(blob.key) == blob.size == size
print(json.dumps({"grown": (after - before) * 1024, "peak": after * 1024}))
"""


@pytest.fixture(params=["local", pytest.param("s3", marks=pytest.mark.server)])
def storage(request: pytest.FixtureRequest) -> tuple[int, dict[str, str]]:
    server: S3Server | None = request.getfixturevalue("s3") if request.param == "s3" else None
    return SIZES[request.param], server.settings() if server else {}


@pytest.mark.slow
@pytest.mark.parametrize("way", ["writer", "stream", "file", "read", "upload"])
def test_peak_memory_does_not_grow_with_the_file(storage: tuple[int, dict[str, str]], tmp_path: Path, way: str) -> None:
    size, where = storage
    settings: dict[str, Any] = {"home": str(tmp_path), **where}
    migrated(f"sqlite:///{tmp_path}/shapery.db")
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, way, str(size), json.dumps(settings), str(tmp_path)],
        check=True,
        capture_output=True,
        text=True,
    )
    measured = json.loads(done.stdout)
    print(f"{way}: {measured['grown'] / MIB:.0f} MiB more, {measured['peak'] / MIB:.0f} MiB at the peak")
    assert measured["grown"] < BOUND
