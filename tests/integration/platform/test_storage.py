"""The same tests on a local folder and on S3."""

from __future__ import annotations

import hashlib
import random
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from shapery_contracts.errors import LimitExceeded, Unavailable
from shapery_platform.settings import load_settings
from shapery_platform.storage import ObjectStore, StoredBlob, StoredObjectMissing, object_key
from shapery_platform.storage.local import LocalStore
from shapery_platform.storage.opening import open_store
from tests.support import processes

SMALL = b"a surface hidden in a volume"
LARGE = random.Random(7).randbytes((16 << 20) + 12345)
"""More than one part of a multipart upload."""


def keys(store: ObjectStore, prefix: str = "") -> list[str]:
    return sorted(entry.key for entry in store.list(prefix))


def read(store: ObjectStore, key: str) -> bytes:
    return b"".join(store.iter_range(key))


@pytest.mark.parametrize("data", [b"", SMALL, LARGE], ids=["empty", "small", "large"])
def test_a_blob_is_stored_under_its_hash(store: ObjectStore, data: bytes) -> None:
    digest = hashlib.sha256(data).hexdigest()
    blob = store.put_blob([data[:100], data[100:]])
    assert blob == StoredBlob(digest, len(data))
    assert blob.key == f"objects/{digest[:2]}/{digest[2:]}"
    assert keys(store) == [blob.key]
    assert store.size(blob.key) == len(data)
    assert read(store, blob.key) == data


@pytest.mark.parametrize("data", [SMALL, LARGE], ids=["small", "large"])
def test_the_same_bytes_are_stored_once(store: ObjectStore, data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(data)
    blobs = [store.put_bytes(data), store.put_file(path), store.put_blob([data]), store.put_file(path, move=True)]
    assert len(set(blobs)) == 1
    assert keys(store) == [blobs[0].key]
    assert not path.exists()


def test_writers_of_the_same_bytes_at_the_same_time_agree(store: ObjectStore) -> None:
    faults: list[BaseException] = []
    barrier = threading.Barrier(6)

    def put() -> None:
        try:
            with store.writer() as writer:
                writer.write(SMALL)
                barrier.wait()
                assert writer.finish().sha256 == hashlib.sha256(SMALL).hexdigest()
        except BaseException as error:
            faults.append(error)

    threads = [threading.Thread(target=put) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert faults == []
    assert len(keys(store)) == 1


@pytest.mark.parametrize("data", [SMALL, LARGE], ids=["small", "large"])
def test_half_a_blob_is_never_visible(store: ObjectStore, data: bytes) -> None:
    with pytest.raises(RuntimeError, match="client went away"), store.writer() as writer:  # noqa: PT012
        writer.write(data[: len(data) // 2])
        assert keys(store, "objects") == []
        writer.write(data[len(data) // 2 :])
        assert keys(store, "objects") == []
        raise RuntimeError("client went away")
    assert keys(store) == []


@pytest.mark.parametrize("pieces", [2, 18], ids=["small", "large"])
def test_half_a_stream_is_never_visible(store: ObjectStore, pieces: int) -> None:
    def broken() -> Iterator[bytes]:
        for _ in range(pieces):
            yield bytes(1 << 20)
        raise RuntimeError("client went away")

    with pytest.raises(RuntimeError, match="client went away"):
        store.put_stream("some/stream", broken())
    assert keys(store) == []


def test_a_stream_replaces_what_was_there(store: ObjectStore) -> None:
    assert store.put_stream("some/stream", [b"one", b"two"]) == 6
    assert store.put_stream("some/stream", [LARGE]) == len(LARGE)
    assert read(store, "some/stream") == LARGE
    assert store.put_stream("some/stream", []) == 0
    assert read(store, "some/stream") == b""


def test_create_takes_a_name_once(store: ObjectStore) -> None:
    outcomes: list[bool] = []
    threads = [
        threading.Thread(target=lambda i=i: outcomes.append(store.create("some/name", b"%d" % i))) for i in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(outcomes) == [False] * 7 + [True]
    first = read(store, "some/name")
    assert not store.create("some/name", b"later")
    assert read(store, "some/name") == first


@pytest.mark.parametrize(
    ("start", "stop"),
    [(0, 10), (5, 5), (8 << 20, (8 << 20) + 1), (3, None), ((8 << 20) - 1, (16 << 20) + 1), (len(LARGE) - 1, None)],
)
def test_ranges(store: ObjectStore, start: int, stop: int | None) -> None:
    store.put_stream("some/large", [LARGE])
    assert b"".join(store.iter_range("some/large", start, stop)) == LARGE[start:stop]


def test_a_file_over_an_object_seeks_and_reads(store: ObjectStore) -> None:
    store.put_stream("some/large", [LARGE])
    with store.open_read("some/large") as file:
        assert file.seekable()
        assert file.read(4) == LARGE[:4]
        assert file.seek(-5, 2) == len(LARGE) - 5
        assert file.read() == LARGE[-5:]
        assert file.read() == b""
        file.seek(9 << 20)
        assert file.read(3 << 20) == LARGE[9 << 20 : 12 << 20]
        assert file.tell() == 12 << 20
        with pytest.raises(OSError, match=r"Invalid|before"):
            file.seek(-1)


def test_download_appears_complete_or_not_at_all(store: ObjectStore, tmp_path: Path) -> None:
    store.put_stream("some/large", [LARGE])
    target = tmp_path / "downloads" / "file.bin"
    target.parent.mkdir()
    assert store.download("some/large", target) == len(LARGE)
    assert target.read_bytes() == LARGE
    with pytest.raises(StoredObjectMissing):
        store.download("some/other", target.with_name("other"))
    assert [path.name for path in target.parent.iterdir()] == ["file.bin"]


def test_a_downloaded_file_may_be_written_to(store: ObjectStore, tmp_path: Path) -> None:
    blob = store.put_bytes(SMALL)
    target = tmp_path / "file.bin"
    store.download(blob.key, target)
    target.write_bytes(b"overwritten by a handler")
    assert read(store, blob.key) == SMALL


def test_what_is_missing_says_so_at_once(store: ObjectStore) -> None:
    for read_it in (store.open_read, store.iter_range):
        with pytest.raises(StoredObjectMissing, match="some/object"):
            read_it("some/object")
    assert store.size("some/object") is None
    assert not store.exists("some/object")
    store.delete("some/object")


def test_delete_and_list(store: ObjectStore) -> None:
    for key in ("a/one", "a/two", "ab/three"):
        store.put_stream(key, [key.encode()])
    assert keys(store, "a/") == ["a/one", "a/two"]
    assert {entry.key: entry.size for entry in store.list()} == {"a/one": 5, "a/two": 5, "ab/three": 8}
    store.delete("a/one")
    assert keys(store) == ["a/two", "ab/three"]


def test_the_store_answers(store: ObjectStore) -> None:
    store.ping()


def test_blobs_are_pinned_before_they_are_visible(store: ObjectStore, tmp_path: Path) -> None:
    seen: list[tuple[str, int, bool]] = []
    store.pin = lambda sha256, size: seen.append((sha256, size, store.exists(object_key(sha256))))
    path = tmp_path / "file"
    for number, put in enumerate(
        [store.put_bytes, lambda data: store.put_file(path), lambda data: store.put_blob([data])]
    ):
        data = bytes([number]) * 10
        path.write_bytes(data)
        blob = put(data)
        assert seen.pop() == (blob.sha256, 10, False)


def test_what_is_no_hash_is_no_key() -> None:
    for wrong in ("", "ab", "A" * 64, "../" + "a" * 61):
        with pytest.raises(ValueError, match="not a SHA-256"):
            object_key(wrong)


@pytest.mark.parametrize("key", ["../outside", "a/../../outside", "/etc/passwd", "", "a\0b", "."])
def test_a_local_key_cannot_lead_out_of_the_folder(tmp_path: Path, key: str) -> None:
    with pytest.raises(ValueError, match="not a key"):
        LocalStore(tmp_path).path(key)


def test_a_disk_nearly_full_refuses_before_anything_is_written(tmp_path: Path) -> None:
    free = LocalStore(tmp_path / "probe").free_bytes()
    store = LocalStore(tmp_path / "objects", min_free_bytes=free + (1 << 40))
    for attempt in (
        lambda: store.writer(),
        lambda: store.put_bytes(SMALL),
        lambda: store.put_stream("some/key", [SMALL]),
        lambda: store.create("some/key", SMALL),
    ):
        with pytest.raises(LimitExceeded, match="has room for 0 more bytes") as caught:
            attempt()
        assert caught.value.code == "storage_full"
    assert keys(store) == []


def test_a_declared_length_must_have_room(tmp_path: Path) -> None:
    store = LocalStore(tmp_path)
    with pytest.raises(LimitExceeded, match="are needed"):
        store.writer(expected=store.free_bytes() + (1 << 40))
    store.writer(expected=1).discard()


def test_a_writer_of_unknown_length_stops_while_there_is_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = LocalStore(tmp_path, min_free_bytes=1 << 30)
    written = 0
    # a disk with 1 GiB + 100 MiB free, which fills as we write
    monkeypatch.setattr(LocalStore, "free_bytes", lambda self: (1 << 30) + (100 << 20) - written)
    with pytest.raises(LimitExceeded) as caught, store.writer() as writer:  # noqa: PT012
        for _ in range(400):
            writer.write(bytes(1 << 20))
            written += 1 << 20
    assert caught.value.code == "storage_full"
    assert written <= 164 << 20
    assert keys(store) == []


def test_a_damaged_local_blob_is_mended_by_the_next_upload(tmp_path: Path) -> None:
    store = LocalStore(tmp_path)
    blob = store.put_bytes(SMALL)
    path = store.path(blob.key)
    path.chmod(0o644)
    path.write_bytes(SMALL[:3])
    assert store.put_bytes(SMALL) == blob
    assert read(store, blob.key) == SMALL


def test_a_blob_that_goes_while_it_is_published_is_there_in_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = LocalStore(tmp_path)
    blob = store.put_bytes(b"content")
    link, answers = LocalStore._link, []

    def link_and_lose(self: LocalStore, file: Path, target: Path) -> bool:
        answers.append(link(self, file, target))
        if len(answers) == 1:
            store.delete(blob.key)
        return answers[-1]

    monkeypatch.setattr(LocalStore, "_link", link_and_lose)
    assert store.put_bytes(b"content") == blob
    assert answers == [False, True]
    assert b"".join(store.iter_range(blob.key)) == b"content"


def test_what_dead_writers_left_is_swept(tmp_path: Path) -> None:
    store = LocalStore(tmp_path)
    writer = store.writer()
    writer.write(SMALL)
    assert store.sweep_temporary(older_than=3600) == 0
    assert len(keys(store, "tmp")) == 1
    assert store.sweep_temporary(older_than=-1) == 1
    assert keys(store) == []
    writer.discard()


def test_an_unreachable_store_is_told_from_a_missing_object(tmp_path: Path) -> None:
    settings = load_settings(
        home=tmp_path,
        storage_url="s3://bucket",
        s3_endpoint=f"http://127.0.0.1:{processes.free_port()}",
        s3_access_key="key",
        s3_secret_key="not-a-real-secret",
    )
    with pytest.raises(Unavailable) as caught:
        open_store(settings).ping()
    assert caught.value.code == "service_unavailable"
