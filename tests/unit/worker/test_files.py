"""Inputs into a job's folder, and outputs out of it."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from uuid import uuid4

import pytest

from shapery_contracts.errors import InvalidInput
from shapery_platform.jobs import ClaimedInput
from shapery_platform.settings import load_settings
from shapery_platform.storage import ObjectStore, object_key
from shapery_platform.storage.opening import open_store
from shapery_worker.publishing import UnusableOutput, list_output, media_type, store_output
from shapery_worker.staging import StoredObjectDamaged, stage_inputs, unique_names


@pytest.fixture
def store(tmp_path: Path) -> ObjectStore:
    return open_store(load_settings(home=tmp_path / "home", min_free_bytes=0))


def stored(store: ObjectStore, data: bytes, filename: str, extension: str = ".nii.gz") -> ClaimedInput:
    blob = store.put_bytes(data)
    return claimed(blob.sha256, blob.size, filename, extension)


def claimed(sha256: str, size: int, filename: str, extension: str = ".nii.gz") -> ClaimedInput:
    return ClaimedInput(
        asset_id=uuid4(),
        sha256=sha256,
        size=size,
        kind="volume",
        format="nifti1",
        extension=extension,
        filename=filename,
        media_type="application/gzip",
    )


def go_on() -> None:
    """Nobody wants it to stop."""


def test_one_file_has_the_usual_extension_and_several_their_own_names(store: ObjectStore, tmp_path: Path) -> None:
    inputs = {
        "post": (stored(store, b"post", "T1C.NII"),),
        "pre": (stored(store, b"header", "head.mhd", ".mhd"), stored(store, b"voxels", "head.raw", ".raw")),
    }
    staged = stage_inputs(store, inputs, tmp_path, go_on)
    assert staged == {"post": tmp_path / "post.nii.gz", "pre": tmp_path / "pre"}
    assert staged["post"].read_bytes() == b"post"
    assert {path.name: path.read_bytes() for path in staged["pre"].iterdir()} == {
        "head.mhd": b"header",
        "head.raw": b"voxels",
    }


def test_names_are_unique_and_stay_in_their_folder() -> None:
    names = ["a.dcm", "A.DCM", "00002.dcm", "../../etc/passwd", "x" * 300, ""]
    files = [claimed("0" * 64, 1, name, ".dcm") for name in names]
    unique = unique_names(files)
    assert unique == ["a.dcm", "00001.dcm", "00002.dcm", "passwd", "00004.dcm", "file.dcm"]
    clash = unique_names([claimed("0" * 64, 1, name, ".dcm") for name in ["00001.dcm", "00001.dcm"]])
    assert clash == ["00001.dcm", "_00001.dcm"]


def test_a_deleted_input_is_the_users_and_a_damaged_one_is_ours(store: ObjectStore, tmp_path: Path) -> None:
    gone = stored(store, b"gone", "gone.nii.gz")
    store.delete(gone.key)
    with pytest.raises(InvalidInput, match=r"'gone.nii.gz' \(4 bytes\) of the input 'post'") as caught:
        stage_inputs(store, {"post": (gone,)}, tmp_path, go_on)
    assert caught.value.code == "input_expired"
    store.put_stream(object_key(hashlib.sha256(b"sound").hexdigest()), [b"wrong"])
    with pytest.raises(StoredObjectDamaged, match="not 5 bytes"):
        stage_inputs(store, {"pre": (claimed(hashlib.sha256(b"sound").hexdigest(), 5, "x"),)}, tmp_path, go_on)


def test_staging_ends_when_it_is_no_longer_wanted(store: ObjectStore, tmp_path: Path) -> None:
    calls = []

    def stop_at_the_third() -> None:
        calls.append(1)
        if len(calls) == 3:
            raise InterruptedError

    large = stored(store, os.urandom(5 << 20), "large.nii.gz")
    with pytest.raises(InterruptedError):
        stage_inputs(store, {"post": (large,)}, tmp_path, stop_at_the_third)
    assert (tmp_path / "post.nii.gz").stat().st_size < 5 << 20


def test_outputs_are_stored_by_name_in_order(store: ObjectStore, tmp_path: Path) -> None:
    folder = tmp_path / "output"
    (folder / "surfaces").mkdir(parents=True)
    (folder / "empty folder").mkdir()
    for name in ("surfaces/2.ply", "labels.nii.gz", "surfaces/1.ply"):
        (folder / name).write_bytes(name.encode())
    artifacts = store_output(store, folder, go_on)
    assert [(a.name, a.size, a.media_type) for a in artifacts] == [
        ("labels.nii.gz", 13, "application/gzip"),
        ("surfaces/1.ply", 14, "application/x-ply"),
        ("surfaces/2.ply", 14, "application/x-ply"),
    ]
    for artifact in artifacts:
        assert b"".join(store.iter_range(object_key(artifact.sha256))) == artifact.name.encode()


def test_what_leads_out_of_the_folder_is_no_output(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to("/etc/passwd")
    with pytest.raises(UnusableOutput, match="'link' is not a regular file"):
        list_output(tmp_path)
    (tmp_path / "link").unlink()
    (tmp_path / "folder").symlink_to("/etc")
    with pytest.raises(UnusableOutput, match="'folder'"):
        list_output(tmp_path)
    (tmp_path / "folder").unlink()
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(UnusableOutput, match="'pipe'"):
        list_output(tmp_path)
    (tmp_path / "pipe").unlink()
    (tmp_path / "new\nline").touch()
    with pytest.raises(UnusableOutput, match="cannot be stored"):
        list_output(tmp_path)


def test_media_types_of_our_results() -> None:
    assert media_type("report.json") == "application/json"
    assert media_type("scene.GLB") == "model/gltf-binary"
    assert media_type("walk.smc") == "application/x-shapery-motion"
    assert media_type("unknown.xyz") == "application/octet-stream"
