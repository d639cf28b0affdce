"""Files on their way to the server: what they were found to be, and that no interruption costs what has arrived."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import numpy as np
import pytest

from shapery_geometry.volume import Volume
from shapery_geometry.volume_io.nifti import write_nifti
from tests.e2e.dashboard.conftest import OpenPage
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
