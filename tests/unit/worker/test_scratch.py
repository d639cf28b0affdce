"""Locked folders, and what is found of those whose owner is dead."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from uuid import uuid4

import pytest

from shapery_worker import scratch
from shapery_worker.scratch import Ownership, ScratchFolder, find_abandoned, has_folders


def ownership() -> Ownership:
    return Ownership(job_id=uuid4(), kind="probe", lease=uuid4())


def leave_by_death(root: Path, owner: Ownership, handler_pid: int = 0) -> None:
    """Let a child own a folder, and kill it."""
    ready, tell = os.pipe()
    child = os.fork()
    if child == 0:
        with ScratchFolder(root, owner) as folder:
            folder.tell_handler(handler_pid)
            (folder.folders.work / "big").write_bytes(b"x" * 1000)
            os.write(tell, b"!")
            signal.pause()
        os._exit(0)
    os.read(ready, 1)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.close(ready)
    os.close(tell)


def test_a_folder_goes_when_its_owner_is_done(tmp_path: Path) -> None:
    root = tmp_path / "root"
    assert not has_folders(root)
    with ScratchFolder(root, ownership()) as folder:
        for path in (folder.folders.inputs, folder.folders.output, folder.folders.work):
            assert path.is_dir()
        (folder.folders.work / "file").touch()
        locked = folder.folders.work / "locked"
        locked.mkdir()
        (locked / "file").touch()
        locked.chmod(0o500)
        assert has_folders(root)
        assert folder.path.stat().st_mode & 0o077 == 0
    assert list(root.iterdir()) == []


def test_the_folder_of_a_living_owner_is_left_alone(tmp_path: Path) -> None:
    with ScratchFolder(tmp_path, ownership()) as folder:
        child = os.fork()  # a lock of this very process would not stop it
        if child == 0:
            os._exit(len(list(find_abandoned(tmp_path))))
        _, status = os.waitpid(child, 0)
        assert os.waitstatus_to_exitcode(status) == 0
        assert folder.path.is_dir()


def test_the_folder_of_a_dead_owner_tells_what_it_had_and_is_removed(tmp_path: Path) -> None:
    owner = ownership()
    leave_by_death(tmp_path, owner, handler_pid=4_000_000)
    found = list(find_abandoned(tmp_path))
    assert [abandoned.ownership for abandoned in found] == [owner.model_copy(update={"handler_pid": 4_000_000})]
    assert list(tmp_path.iterdir()) == []


def test_a_child_that_outlives_its_owner_does_not_keep_the_lock(tmp_path: Path) -> None:
    with ScratchFolder(tmp_path, ownership()):
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            os.read(read, 1)
            os._exit(0)
    owner = ownership()
    leave_by_death(tmp_path, owner)
    assert [abandoned.ownership for abandoned in find_abandoned(tmp_path)] == [owner]
    os.write(write, b"!")
    os.waitpid(child, 0)
    os.close(read)
    os.close(write)


def test_a_folder_is_kept_when_its_job_could_not_be_given_back(tmp_path: Path) -> None:
    owner = ownership()
    leave_by_death(tmp_path, owner)

    def fail() -> None:
        for _ in find_abandoned(tmp_path):
            raise OSError("the database does not answer")

    with pytest.raises(OSError, match="does not answer"):
        fail()
    assert [abandoned.ownership for abandoned in find_abandoned(tmp_path)] == [owner]


def test_an_owner_that_died_while_it_wrote_is_told_apart(tmp_path: Path) -> None:
    leave_by_death(tmp_path, ownership())
    folder = next(tmp_path.iterdir())
    (folder / "owner.json").write_text('{"job_id": "01')
    assert [abandoned.ownership for abandoned in find_abandoned(tmp_path)] == [None]
    assert list(tmp_path.iterdir()) == []


def test_half_made_folders_are_litter_only_after_a_while(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / ".half").mkdir()
    (tmp_path / "without owner").mkdir()
    assert list(find_abandoned(tmp_path)) == []
    assert len(list(tmp_path.iterdir())) == 2
    monkeypatch.setattr(scratch, "_ABANDONED_AFTER", -1.0)
    assert list(find_abandoned(tmp_path)) == []
    assert list(tmp_path.iterdir()) == []


def test_links_in_a_folder_lead_nowhere(tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "precious").touch()
    with ScratchFolder(tmp_path / "root", ownership()) as folder:
        (folder.folders.work / "link").symlink_to(outside)
        (folder.path / "top").symlink_to(outside)
    assert (outside / "precious").exists()
