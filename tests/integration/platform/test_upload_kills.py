"""A process that is killed while it writes: another goes on where the row says, and the bytes are right."""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from uuid import UUID

import pytest

from shapery_platform import assets, uploads
from shapery_platform.db import Database
from shapery_platform.settings import load_settings
from shapery_platform.storage import UploadStaging, object_key
from shapery_platform.storage.opening import open_store
from tests.integration.platform.conftest import VOLUME
from tests.support.s3 import S3Server

DATA = random.Random(5).randbytes(24 << 20)

WRITER = """
import json, random, sys, time
from datetime import timedelta
from uuid import UUID
from shapery_platform import uploads
from shapery_platform.db import Database
from shapery_platform.settings import load_settings
from shapery_platform.storage import ObjectStore, UploadStaging
from shapery_platform.storage.opening import open_store

settings = load_settings(**json.loads(sys.argv[1]))
database = Database(settings.database_url)
store = open_store(settings, database)
staging = UploadStaging.over(store)
uploads._SETTLE_EVERY = 1 << 19
# the one killed before holds the upload for a shorter time than in earnest
uploads._LEASE = timedelta(seconds=1)
uploads._RENEW_EVERY = timedelta(seconds=0.2)
data = random.Random(5).randbytes(24 << 20)
upload_id = UUID(sys.argv[2])
while True:
    try:
        with database.session(readonly=True) as session:
            offset = uploads.get(session, "ann", upload_id).offset
        with uploads.open_patch(database, staging, settings, "ann", upload_id, offset) as writer:
            print("writing", flush=True)
            for begin in range(offset, len(data), 1 << 16):
                writer.write(data[begin : begin + (1 << 16)])
                time.sleep(0.001)
            writer.finish()
        break
    except Exception as error:
        if getattr(error, "code", "") != "upload_locked":
            raise
        time.sleep(0.05)
"""


@pytest.fixture(params=["local", pytest.param("s3", marks=pytest.mark.server)])
def where(request: pytest.FixtureRequest) -> dict[str, str]:
    server: S3Server | None = request.getfixturevalue("s3") if request.param == "s3" else None
    return server.settings() if server else {}


@pytest.mark.slow
def test_an_upload_survives_kills_at_any_moment(where: dict[str, str], tmp_path: Path) -> None:
    chosen = {"home": str(tmp_path), "min_free_bytes": 0, **where}
    settings = load_settings(**chosen)
    database = Database(settings.database_url)
    database.migrate()
    store = open_store(settings, database)
    staging = UploadStaging.over(store)
    with database.session() as session:
        upload_id: UUID = uploads.create(session, staging, settings, "ann", len(DATA), {}).id
    rng = random.Random(11)
    reached = [0]
    kills = 0
    while True:
        process = subprocess.Popen(
            [sys.executable, "-c", WRITER, json.dumps(chosen), str(upload_id)], stdout=subprocess.PIPE
        )
        assert process.stdout is not None
        # the lease of the one killed before runs out within seconds
        assert process.stdout.readline() == b"writing\n"
        if kills < 2:
            time.sleep(rng.uniform(0.02, 0.15))
            process.send_signal(signal.SIGKILL)
            kills += process.wait() == -signal.SIGKILL
        else:
            assert process.wait() == 0
        process.stdout.close()
        with database.session(readonly=True) as session:
            state = uploads.get(session, "ann", upload_id)
        reached.append(state.offset)
        if state.complete:
            break
    assert kills == 2
    assert reached == sorted(reached)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(assets, "sniff", lambda stream, size: VOLUME)
        asset = uploads.finish(database, staging, store, settings, "ann", upload_id)
    assert b"".join(store.iter_range(object_key(asset.sha256))) == DATA
    assert [entry.key for entry in store.list("staging")] == []
    database.dispose()
