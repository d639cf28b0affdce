"""Files on their way to the server: what they were found to be, and that no interruption costs what has arrived."""

from __future__ import annotations

import hashlib
import re
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from shapery_geometry.mesh import icosphere
from shapery_geometry.mesh_io import write_mesh
from shapery_geometry.sequence import write_sequence_npz
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io.nifti import write_nifti
from tests.e2e.dashboard.conftest import OpenPage
from tests.e2e.dashboard.test_accessibility import check_open_to_everyone
from tests.support.browser import eventually, keep_picture, picture, until
from tests.support.embedded import Embedded
from tests.support.proxy import Network, unreliable
from tests.support.volumes import write_series

pytestmark = [pytest.mark.server, pytest.mark.browser]

RATE = 6_000_000
"""Bytes per second of the slow network: slow enough to be interrupted, fast enough to wait for."""


@pytest.fixture
def network(platform: Embedded) -> Iterator[Network]:
    with unreliable(platform.port) as network:
        yield network


@pytest.fixture
def large(tmp_path: Path) -> Path:
    """A volume of 24 MB: several times what a browser and the kernel keep in their buffers."""
    data = np.random.default_rng(3).integers(0, 30_000, (250, 240, 200), dtype=np.int16)
    path = tmp_path / "large.nii"
    write_nifti(Volume(data, np.diag([1.0, 1.0, 1.2, 1.0])), path)
    return path


def wait_for_progress(network: Network, size: int, fraction: float) -> None:
    end = time.monotonic() + 60
    while network.uploaded < fraction * size:
        assert time.monotonic() < end, "the upload does not get on"
        time.sleep(0.02)


def content_of(api: httpx.Client, filename: str) -> bytes:
    assets = api.get("/v1/assets", params={"limit": 200}).json()["items"]
    asset = next(asset for asset in assets if asset["filename"] == filename)
    return api.get(asset["content_url"]).content


def test_says_what_files_were_found_to_be(open_page: OpenPage, tmp_path: Path) -> None:
    volume = tmp_path / "no_extension_at_all"
    write_nifti(Volume(np.zeros((7, 5, 6), np.int16), np.diag([0.8, 1.1, 2.5, 1.0])), tmp_path / "it.nii")
    (tmp_path / "it.nii").rename(volume)
    picture = tmp_path / "volume.nii.gz"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    page = open_page("/upload")
    page.watch.allowed.append("422")  # the browser tells of the refusal in its console
    page.get_by_test_id("files").set_input_files([volume, picture])
    found = page.get_by_role("list", name="Uploads").get_by_role("listitem")
    found.filter(has_text="Volume · NIfTI · 7 × 5 × 6 · 0.8 × 1.1 × 2.5 mm").wait_for()
    found.filter(has_text="PNG picture").get_by_role("alert").wait_for()
    page.get_by_role("button", name="Look at no_extension_at_all").first.click()
    page.get_by_role("dialog").locator("section[aria-label=Volume][data-status=ready]").wait_for()
    page.get_by_role("dialog").get_by_test_id("place").wait_for()


def test_goes_on_after_a_lost_connection(open_page: OpenPage, network: Network, large: Path, api: httpx.Client) -> None:
    size = large.stat().st_size
    network.upload_rate = RATE
    page = open_page("/upload", base=network.url)
    # what was cut off, and a server that is still busy with what came before
    page.watch.allowed += ["net::ERR", "409", "423"]
    page.get_by_test_id("files").set_input_files(large)
    wait_for_progress(network, size, 0.3)
    network.down = True
    page.locator("li[data-state=waiting]").get_by_text("It goes on by itself").wait_for()
    page.get_by_text("The server does not answer. What is shown").wait_for()
    network.down = False
    network.upload_rate = None
    page.locator("li[data-state=done]").wait_for()
    assert hashlib.sha256(content_of(api, "large.nii")).digest() == hashlib.sha256(large.read_bytes()).digest()
    # What had arrived was not sent again: at the most what was on its way when the connection broke.
    assert network.uploaded < 1.6 * size
    page.get_by_text("The server does not answer. What is shown").wait_for(state="detached")


def test_goes_on_by_itself_after_a_reload(
    open_page: OpenPage, network: Network, large: Path, api: httpx.Client
) -> None:
    renamed = large.rename(large.with_name("reloaded.nii"))
    size = renamed.stat().st_size
    network.upload_rate = RATE
    page = open_page("/upload", base=network.url)
    # what was cut off, and a server that is still busy with what came before
    page.watch.allowed += ["net::ERR", "409", "423"]
    page.get_by_test_id("files").set_input_files(renamed)
    wait_for_progress(network, size, 0.3)
    page.reload()
    row = page.locator("li", has_text="reloaded.nii").first
    row.wait_for()
    network.upload_rate = None
    page.locator("li[data-state=done]", has_text="reloaded.nii").wait_for()
    assert content_of(api, "reloaded.nii") == renamed.read_bytes()
    assert network.uploaded < 1.6 * size


def test_two_tabs_do_not_send_the_same_file_twice(open_page: OpenPage, network: Network, large: Path) -> None:
    renamed = large.rename(large.with_name("tabs.nii"))
    size = renamed.stat().st_size
    network.upload_rate = RATE
    page = open_page("/upload", base=network.url)
    page.get_by_test_id("files").set_input_files(renamed)
    wait_for_progress(network, size, 0.2)
    other = page.context.new_page()
    other.goto(f"{network.url}/upload")
    other.get_by_text("Drop volumes here").wait_for()
    network.upload_rate = None
    page.locator("li[data-state=done]", has_text="tabs.nii").wait_for()
    assert other.get_by_role("list", name="Uploads").count() == 0
    assert network.uploaded < 1.3 * size


def test_pauses_continues_and_cancels(open_page: OpenPage, network: Network, large: Path, api: httpx.Client) -> None:
    renamed = large.rename(large.with_name("paused.nii"))
    network.upload_rate = RATE / 6
    page = open_page("/upload", base=network.url)
    page.watch.allowed += ["net::ERR", "409", "423"]
    page.get_by_test_id("files").set_input_files(renamed)
    wait_for_progress(network, renamed.stat().st_size, 0.05)
    page.get_by_role("button", name="Pause paused.nii").click()
    page.get_by_text("Paused at").wait_for()
    page.get_by_role("button", name="Continue paused.nii").click()
    page.locator("li[data-state=sending]").wait_for()
    page.get_by_role("button", name="Cancel paused.nii").click()
    page.locator("li", has_text="paused.nii").wait_for(state="detached")
    page.reload()
    page.get_by_text("Drop volumes here").wait_for()
    assert page.get_by_role("list", name="Uploads").count() == 0
    assert all(asset["filename"] != "paused.nii" for asset in api.get("/v1/assets").json()["items"])


def test_a_folder_of_slices_becomes_one_series(open_page: OpenPage, tmp_path: Path, api: httpx.Client) -> None:
    folder = tmp_path / "t1c"
    volume = Volume(np.arange(20 * 18 * 12, dtype=np.int16).reshape(20, 18, 12), np.eye(4))
    write_series(folder, volume)
    (folder / "report.txt").write_text("not a slice")
    page = open_page("/upload")
    page.get_by_test_id("folder").set_input_files(folder)
    row = page.locator("li[data-state=done]", has_text="t1c.zip")
    row.get_by_text("DICOM series").wait_for()
    page.get_by_text("One file was left out").wait_for()
    asset = next(asset for asset in api.get("/v1/assets").json()["items"] if asset["filename"] == "t1c.zip")
    assert asset["format"] == "dicom-zip"
    assert asset["kind"] == "volume"


def drag(page: Any, target: Any, paths: list[Path]) -> None:
    """Drag files and folders onto an element, as one does from a file manager."""
    place = target.bounding_box()
    at = {"x": place["x"] + place["width"] / 2, "y": place["y"] + 20}
    data = {"items": [], "files": [str(path) for path in paths], "dragOperationsMask": 1}
    session = page.context.new_cdp_session(page)
    for kind in ("dragEnter", "dragOver", "drop"):
        session.send("Input.dispatchDragEvent", {"type": kind, "data": data, **at})
    session.detach()


def test_folders_are_dragged_into_the_page(open_page: OpenPage, tmp_path: Path, api: httpx.Client) -> None:
    """A study: two series in folders of their own, one with more files than a browser hands out at once, and a mesh."""
    study = tmp_path / "study"
    many = np.arange(6 * 5 * 120, dtype=np.int16).reshape(6, 5, 120)
    few = np.arange(6 * 5 * 4, dtype=np.int16).reshape(6, 5, 4)
    write_series(study / "head" / "dragged t1", Volume(many, np.eye(4)))
    write_series(study / "head" / "dragged t2", Volume(few, np.eye(4)))
    write_mesh(icosphere(subdivisions=2), study / "ball.off")
    (study / "head" / "notes.txt").write_text("none of ours")
    page = open_page("/upload")
    drag(page, page.get_by_role("region", name="Add files"), [study])
    page.get_by_text("One file was left out").wait_for()  # told for a moment only
    expected = {"dragged t1.zip": "DICOM series · 120 files", "dragged t2.zip": "4 files", "ball.off": "Mesh · OFF"}
    for name, found in expected.items():
        page.locator("li[data-state=done]", has_text=name).get_by_text(found).wait_for()
    asset = next(asset for asset in api.get("/v1/assets").json()["items"] if asset["filename"] == "dragged t1.zip")
    assert asset["details"]["files"] == 120


def test_files_are_seen_at_once(open_page: OpenPage, tmp_path: Path) -> None:
    """Small pictures of a mesh, a motion and a DICOM series, and what they are when one looks: no job has run."""
    ball = icosphere()
    write_mesh(ball, tmp_path / "ball.stl")
    frames = (ball.vertices + np.array([[[3.0 * t, 0, 0]] for t in range(4)])).astype(np.float32)
    write_sequence_npz(tmp_path / "rolls.npz", frames, ball.faces, shape=frames.shape[:2])
    data = np.zeros((24, 30, 12), np.int16)  # R, A, S
    data[14:20, 4:10] = 900  # a bright block behind, on the patient's right
    write_series(tmp_path / "slices", Volume(data, np.diag([1.0, 1.0, 2.0, 1.0])))
    with zipfile.ZipFile(tmp_path / "slices.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for path in (tmp_path / "slices").iterdir():
            archive.write(path, path.name)
    page = open_page("/upload")
    page.get_by_test_id("files").set_input_files([tmp_path / name for name in ("ball.stl", "rolls.npz", "slices.zip")])
    small = {}
    for name in ("ball.stl", "rolls.npz", "slices.zip"):
        canvas = page.get_by_role("img", name=f"Preview of {name}")
        canvas.wait_for()
        pixels = canvas.evaluate("c => [...c.getContext('2d').getImageData(0, 0, c.width, c.height).data]")
        width = canvas.evaluate("c => c.width")
        small[name] = np.array(pixels).reshape(-1, width, 4)[..., :3].max(axis=2)
    for name in ("ball.stl", "rolls.npz"):
        assert 0.5 < (small[name] > 40).mean() < 0.75, name  # a disc that fills the square: pi / 4 of 0.92 squared
    rows, columns = np.nonzero(small["slices.zip"] > 128)
    height, width = small["slices.zip"].shape
    np.testing.assert_allclose([rows.min() / height, rows.max() / height], [20 / 30, 26 / 30], atol=0.06)
    np.testing.assert_allclose([columns.min() / width, columns.max() / width], [4 / 24, 10 / 24], atol=0.08)

    keep_picture(page, "upload")

    def look(name: str) -> Any:
        page.locator("li[data-state=done]", has_text=name).get_by_role("button", name=f"Look at {name}").click()
        return page.get_by_role("dialog").locator("section[data-status=ready]")

    look("slices.zip").get_by_test_id("place").wait_for()
    check_open_to_everyone(page)
    page.keyboard.press("Escape")
    viewer = look("rolls.npz")
    viewer.get_by_test_id("frame").get_by_text("1 / 4").wait_for()

    def middle() -> float:
        lit = picture(viewer.get_by_test_id("mesh"))[20:-70].max(axis=2) > 40
        assert lit.any()
        assert not lit[:, [0, -1]].any()  # it stays in the picture
        return float(np.nonzero(lit)[1].mean())

    before = eventually(middle)
    viewer.get_by_role("slider", name="Frame").press("End")
    viewer.get_by_test_id("frame").get_by_text("4 / 4").wait_for()
    until(lambda: middle() > before + 100, "the sequence has moved")


def test_a_mesh_of_many_faces_is_seen_coarser(open_page: OpenPage, tmp_path: Path) -> None:
    """What is drawn of a ball of 327,680 faces, each with corners of its own, is still a ball, and is told."""
    write_mesh(icosphere(subdivisions=7), tmp_path / "fine.stl")
    page = open_page("/upload")
    page.get_by_test_id("files").set_input_files(tmp_path / "fine.stl")
    page.get_by_role("button", name="Look at fine.stl").click()
    viewer = page.get_by_role("dialog").locator("section[data-status=ready]")
    told = viewer.get_by_text("drawn coarser than it is")
    drawn, whole = (int(re.sub(r"\D", "", number)) for number in told.inner_text().split(":")[1].split(" of "))
    assert whole == 327_680
    check_open_to_everyone(page)
    assert 50_000 < drawn <= 200_000
    told.evaluate("(element) => { element.style.visibility = 'hidden'; }")  # it lies over the picture

    def disc() -> None:
        lit = picture(viewer.get_by_test_id("mesh")).max(axis=2) > 40
        rows, columns = np.nonzero(lit)
        height, width = np.ptp(rows), np.ptp(columns)
        assert height > 100
        assert abs(width / height - 1) < 0.03
        assert abs(lit.sum() / (np.pi / 4 * height * width) - 1) < 0.03  # and nowhere is a hole

    eventually(disc)
