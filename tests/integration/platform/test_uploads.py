"""Resumable uploads on both databases and both stores."""

from __future__ import annotations

import hashlib
import random
import threading
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from uuid import UUID

import pytest
from sqlalchemy import update

from shapery_contracts.errors import UserError
from shapery_contracts.formats import FileFormat
from shapery_platform import assets, uploads
from shapery_platform.db import Database
from shapery_platform.db.models import Upload
from shapery_platform.settings import Settings
from shapery_platform.storage import ObjectStore, StagingLost, UploadStaging, object_key
from shapery_platform.storage import staging as staging_module
from tests.integration.platform.conftest import VOLUME

UNIT = 1 << 16
DATA = random.Random(3).randbytes(40 * UNIT + 777)
PIECE = 7 * UNIT
LARGE = random.Random(4).randbytes((21 << 20) + 777)
"""With pieces of another size than S3's, and more than one part of a multipart upload."""


class Bench:
    """One process's view of the platform, as a gateway has it."""

    def __init__(self, database: Database, store: ObjectStore, settings: Settings) -> None:
        self.database = database
        self.store = store
        self.settings = settings
        self.staging = UploadStaging.over(store)

    def restarted(self) -> Bench:
        """The same platform in a new process, which remembers nothing."""
        return Bench(self.database, self.store, self.settings)

    def create(self, length: int | None = len(DATA), owner: str = "ann") -> UUID:
        with self.database.session() as session:
            metadata = {"filename": "head.nii"}
            return uploads.create(session, self.staging, self.settings, owner, length, metadata).id

    def get(self, upload_id: UUID, owner: str = "ann") -> uploads.UploadState:
        with self.database.session(readonly=True) as session:
            return uploads.get(session, owner, upload_id)

    def append(
        self,
        upload_id: UUID,
        offset: int,
        data: bytes | Iterator[bytes],
        *,
        owner: str = "ann",
        length: int | None = None,
        checksum: tuple[str, bytes] | None = None,
    ) -> uploads.UploadState:
        chunks = (data[i : i + (UNIT)] for i in range(0, len(data), UNIT)) if isinstance(data, bytes) else data
        return uploads.append(
            self.database,
            self.staging,
            self.settings,
            owner,
            upload_id,
            offset,
            chunks,
            length=length,
            checksum=checksum,
        )

    def open_patch(self, upload_id: UUID, offset: int) -> uploads.UploadWriter:
        return uploads.open_patch(self.database, self.staging, self.settings, "ann", upload_id, offset)

    def finish(self, upload_id: UUID, owner: str = "ann") -> UUID:
        return uploads.finish(self.database, self.staging, self.store, self.settings, owner, upload_id).id

    def content(self, asset_id: UUID) -> bytes:
        with self.database.session(readonly=True) as session:
            asset = assets.get(session, "ann", asset_id)
        content = b"".join(self.store.iter_range(object_key(asset.sha256)))
        assert hashlib.sha256(content).hexdigest() == asset.sha256
        return content

    def lose_the_lease(self, upload_id: UUID) -> None:
        with self.database.session() as session:
            past = datetime.now(UTC) - timedelta(seconds=1)
            session.execute(update(Upload).where(Upload.id == upload_id).values(lease_until=past))

    def staged(self) -> list[str]:
        return [entry.key for entry in self.store.list("staging")]


@pytest.fixture
def bench(database: Database, pinned_store: ObjectStore, settings: Settings, monkeypatch: pytest.MonkeyPatch) -> Bench:
    monkeypatch.setattr(assets, "sniff", lambda stream, size: VOLUME)
    # the same proportions with less to move
    monkeypatch.setattr(staging_module, "_S3_PART", 16 * UNIT)
    monkeypatch.setattr(uploads, "_SETTLE_EVERY", 24 * UNIT)
    return Bench(database, pinned_store, settings)


def code_of(error: pytest.ExceptionInfo[UserError]) -> str:
    return error.value.code


def test_an_upload_in_pieces_becomes_an_asset(bench: Bench) -> None:
    upload_id = bench.create()
    for offset in range(0, len(DATA), PIECE):
        assert bench.get(upload_id).offset == offset
        state = bench.append(upload_id, offset, DATA[offset : offset + PIECE])
    assert state.complete
    asset_id = bench.finish(upload_id)
    assert bench.content(asset_id) == DATA
    assert bench.get(upload_id).asset_id == asset_id
    assert bench.staged() == []
    # finishing again gives the same asset, and nothing can be appended any more
    assert bench.finish(upload_id) == asset_id
    with pytest.raises(UserError) as error:
        bench.append(upload_id, len(DATA), b"more")
    assert code_of(error) == "upload_offset_mismatch"


def test_a_large_upload_in_pieces_is_put_together(
    pinned_store: ObjectStore, database: Database, settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(assets, "sniff", lambda stream, size: VOLUME)
    bench = Bench(database, pinned_store, settings)
    upload_id = bench.create(len(LARGE))
    for begin, end in ((0, 17 << 20), (17 << 20, 20 << 20), (20 << 20, len(LARGE))):
        bench.append(upload_id, begin, LARGE[begin:end])
    assert bench.content(bench.finish(upload_id)) == LARGE


def test_an_upload_goes_on_after_a_restart_at_any_point(bench: Bench) -> None:
    upload_id = bench.create()
    for offset in range(0, len(DATA), PIECE):
        bench = bench.restarted()
        bench.append(upload_id, offset, DATA[offset : offset + PIECE])
    bench = bench.restarted()
    # the hash is rebuilt from what is staged: this process has seen no byte
    assert bench.content(bench.finish(upload_id)) == DATA


def test_what_arrived_before_the_client_went_away_is_kept(bench: Bench) -> None:
    upload_id = bench.create()

    def broken() -> Iterator[bytes]:
        for begin in range(0, 18 * UNIT, UNIT):
            yield DATA[begin : begin + (UNIT)]
        raise ConnectionResetError

    with pytest.raises(ConnectionResetError):
        bench.append(upload_id, 0, broken())
    assert bench.get(upload_id).offset == 18 * UNIT
    bench.append(upload_id, 18 * UNIT, DATA[18 * UNIT :])
    assert bench.content(bench.finish(upload_id)) == DATA


@pytest.mark.parametrize("kept", [5 * UNIT, 0])
def test_bytes_that_were_written_and_never_recorded_do_not_count(bench: Bench, kept: int) -> None:
    upload_id = bench.create()
    if kept:
        bench.append(upload_id, 0, DATA[:kept])
    # a process that dies between its writes and the update of the row
    dying = bench.restarted()
    writer = dying.open_patch(upload_id, kept)
    writer._patch.write(b"\xff" * (20 * UNIT))
    writer._patch.settle()
    writer._patch.close()
    bench.lose_the_lease(upload_id)
    assert bench.get(upload_id).offset == kept
    bench.append(upload_id, kept, DATA[kept:])
    assert bench.content(bench.finish(upload_id)) == DATA
    assert bench.staged() == []


def test_a_request_that_hung_changes_nothing_after_another_took_over(bench: Bench) -> None:
    upload_id = bench.create()
    bench.append(upload_id, 0, DATA[:PIECE])
    hung = bench.restarted().open_patch(upload_id, PIECE)
    hung.write(DATA[PIECE : PIECE + 1000])
    bench.lose_the_lease(upload_id)
    with bench.open_patch(upload_id, PIECE) as writer:
        writer.write(DATA[PIECE : 2 * PIECE])
        # it wakes up and writes to what it still has open
        hung._patch.write(b"\xff" * (17 * UNIT))
        writer.write(DATA[2 * PIECE :])
        writer.finish()
    with pytest.raises(UserError) as error:
        hung.finish()
    assert code_of(error) == "upload_locked"
    assert bench.get(upload_id).offset == len(DATA)
    assert bench.content(bench.restarted().finish(upload_id)) == DATA


def test_two_requests_do_not_write_at_the_same_time(bench: Bench) -> None:
    upload_id = bench.create()
    with bench.open_patch(upload_id, 0) as writer:
        for attempt in (
            lambda: bench.open_patch(upload_id, 0),
            lambda: uploads.terminate(bench.database, bench.staging, "ann", upload_id),
        ):
            with pytest.raises(UserError) as error:
                attempt()
            assert code_of(error) == "upload_locked"
        writer.write(DATA[:100])
        writer.finish()
    assert bench.get(upload_id).offset == 100


def test_many_clients_race_for_one_upload_and_its_bytes_stay_right(bench: Bench) -> None:
    upload_id = bench.create(UNIT)
    data = DATA[:UNIT]
    unexpected: list[BaseException] = []

    def client(seed: int) -> None:
        rng = random.Random(seed)
        while True:
            try:
                state = bench.get(upload_id)
                if state.complete:
                    return
                piece = rng.randrange(1, 1 << 14)
                bench.append(upload_id, state.offset, data[state.offset : state.offset + piece])
            except UserError as error:
                if error.code not in ("upload_locked", "upload_offset_mismatch"):
                    unexpected.append(error)
                    return
            except BaseException as error:
                unexpected.append(error)
                return

    threads = [threading.Thread(target=client, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert unexpected == []
    assert bench.content(bench.finish(upload_id)) == data


@pytest.mark.parametrize("algorithm", uploads.CHECKSUM_ALGORITHMS)
def test_a_wrong_checksum_keeps_the_offset(bench: Bench, algorithm: str) -> None:
    upload_id = bench.create()
    bench.append(upload_id, 0, DATA[:1000])
    piece = DATA[1000 : 20 * UNIT]
    digest = hashlib.new(algorithm, piece).digest()
    with pytest.raises(UserError) as error:
        bench.append(upload_id, 1000, piece[:-1] + bytes([piece[-1] ^ 1]), checksum=(algorithm, digest))
    assert code_of(error) == "checksum_mismatch"
    assert bench.get(upload_id).offset == 1000
    state = bench.append(upload_id, 1000, piece, checksum=(algorithm, digest))
    assert state.offset == 20 * UNIT
    bench.append(upload_id, state.offset, DATA[state.offset :])
    assert bench.content(bench.finish(upload_id)) == DATA


def test_what_cannot_be_verified_is_not_kept(bench: Bench) -> None:
    upload_id = bench.create()

    def broken() -> Iterator[bytes]:
        yield DATA[: 17 * UNIT]
        raise ConnectionResetError

    with pytest.raises(ConnectionResetError):
        bench.append(upload_id, 0, broken(), checksum=("sha1", hashlib.sha1(DATA).digest()))
    assert bench.get(upload_id).offset == 0
    assert [key for key in bench.staged() if not key.endswith(str(upload_id))] == []


def test_an_unknown_checksum_algorithm_is_refused(bench: Bench) -> None:
    with pytest.raises(UserError, match="sha1, sha256, md5") as error:
        bench.append(bench.create(), 0, b"", checksum=("crc32", b"1234"))
    assert code_of(error) == "bad_request"


@pytest.mark.parametrize("offset", [0, 99, 101])
def test_another_offset_is_refused(bench: Bench, offset: int) -> None:
    upload_id = bench.create()
    bench.append(upload_id, 0, DATA[:100])
    with pytest.raises(UserError, match="continues at byte 100") as error:
        bench.append(upload_id, offset, DATA[offset:200])
    assert code_of(error) == "upload_offset_mismatch"


def test_more_bytes_than_declared_are_refused(bench: Bench) -> None:
    upload_id = bench.create(1000)
    with pytest.raises(UserError) as error:
        bench.append(upload_id, 0, DATA[:1001])
    assert code_of(error) == "request_too_large"
    bench.append(upload_id, bench.get(upload_id).offset, DATA[:1000])
    assert bench.content(bench.finish(upload_id)) == DATA[:1000]


def test_a_length_may_be_told_later_and_then_stays(bench: Bench) -> None:
    upload_id = bench.create(None)
    assert not bench.append(upload_id, 0, DATA[:100]).complete
    with pytest.raises(UserError) as error:
        bench.finish(upload_id)
    assert code_of(error) == "conflict"
    state = bench.append(upload_id, 100, DATA[100:200], length=300)
    assert (state.length, state.complete) == (300, False)
    with pytest.raises(UserError) as error:
        bench.append(upload_id, 200, b"", length=200)
    assert code_of(error) == "bad_request"
    assert bench.append(upload_id, 200, DATA[200:300]).complete
    assert bench.content(bench.finish(upload_id)) == DATA[:300]


def test_an_upload_of_nothing(bench: Bench) -> None:
    upload_id = bench.create(0)
    assert bench.get(upload_id).complete
    assert bench.content(bench.finish(upload_id)) == b""


def test_too_long_uploads_are_refused_before_they_begin(bench: Bench) -> None:
    bench.settings = bench.settings.model_copy(update={"max_upload_bytes": 1000})
    with pytest.raises(UserError) as error:
        bench.create(1001)
    assert code_of(error) == "too_large"
    upload_id = bench.create(None)
    with pytest.raises(UserError) as error:
        bench.append(upload_id, 0, b"", length=1001)
    assert code_of(error) == "too_large"
    with pytest.raises(UserError) as error:
        bench.append(upload_id, 0, DATA[:1001])
    assert code_of(error) == "request_too_large"


def test_a_file_of_no_known_kind_ends_the_upload(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(stream: object, size: int) -> FileFormat:
        raise UserError("unknown_format", "The file is of no known format.")

    monkeypatch.setattr(assets, "sniff", refuse)
    upload_id = bench.create(100)
    bench.append(upload_id, 0, DATA[:100])
    with pytest.raises(UserError) as error:
        bench.finish(upload_id)
    assert code_of(error) == "unknown_format"
    with pytest.raises(UserError) as error:
        bench.get(upload_id)
    assert code_of(error) == "not_found"
    assert bench.staged() == []


def test_a_fault_of_ours_while_finishing_leaves_the_upload_as_it_was(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    upload_id = bench.create(100)
    bench.append(upload_id, 0, DATA[:100])
    with monkeypatch.context() as patch, pytest.raises(OSError, match="storage"):  # noqa: PT012
        patch.setattr(assets, "sniff", lambda stream, size: (_ for _ in ()).throw(OSError("storage")))
        bench.finish(upload_id)
    assert bench.content(bench.finish(upload_id)) == DATA[:100]


def test_terminate_removes_row_and_bytes(bench: Bench) -> None:
    upload_id = bench.create()
    bench.append(upload_id, 0, DATA[:PIECE])
    uploads.terminate(bench.database, bench.staging, "ann", upload_id)
    with pytest.raises(UserError) as error:
        bench.get(upload_id)
    assert code_of(error) == "not_found"
    assert bench.staged() == []


def test_expiry(bench: Bench) -> None:
    upload_id, other = bench.create(), bench.create()
    bench.append(upload_id, 0, DATA[:PIECE])
    before = bench.get(upload_id).expires_at
    # the one to which something came lives longer than the one to which nothing did
    assert uploads.expire(bench.database, bench.staging, now=bench.get(other).expires_at) == 1
    with pytest.raises(UserError) as error:
        bench.get(other)
    assert code_of(error) == "not_found"
    # each piece that arrives gives the upload its time anew
    bench.append(upload_id, PIECE, DATA[PIECE : 2 * PIECE])
    assert bench.get(upload_id).expires_at > before
    late = datetime.now(UTC) + timedelta(seconds=bench.settings.upload_ttl + 60)
    with bench.database.session(readonly=True) as session, pytest.raises(UserError) as error:
        uploads.get(session, "ann", upload_id, now=late)
    assert code_of(error) == "upload_expired"
    assert uploads.expire(bench.database, bench.staging, now=late) == 1
    assert bench.staged() == []


def test_an_upload_that_is_being_written_does_not_expire(bench: Bench) -> None:
    upload_id = bench.create()
    with bench.open_patch(upload_id, 0) as writer:
        with bench.database.session() as session:
            past = datetime.now(UTC) - timedelta(seconds=1)
            session.execute(update(Upload).where(Upload.id == upload_id).values(expires_at=past))
        assert uploads.expire(bench.database, bench.staging) == 0
        writer.write(DATA[:100])
        writer.finish()
    assert bench.get(upload_id).offset == 100


def test_staged_bytes_without_a_row_are_swept_and_no_others(bench: Bench) -> None:
    kept, lost = bench.create(), bench.create()
    bench.append(kept, 0, DATA[:100])
    bench.append(lost, 0, DATA[:100])
    with bench.database.session() as session:
        session.delete(session.get_one(Upload, lost))
    assert uploads.sweep_staging(bench.database, bench.staging) == 1
    assert uploads.sweep_staging(bench.database, bench.staging) == 0
    bench.append(kept, 100, DATA[100:200])


def test_staging_that_lost_bytes_says_so(bench: Bench) -> None:
    upload_id = bench.create(200)
    bench.append(upload_id, 0, DATA[:200])
    bench.staging.remove(upload_id)
    with pytest.raises(StagingLost, match="staged"):
        bench.restarted().finish(upload_id)
    with pytest.raises(StagingLost, match="staged"):
        bench.finish(upload_id)
