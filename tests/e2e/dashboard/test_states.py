"""What one sees when there is nothing, when something is over, and when one is not let in."""

from __future__ import annotations

import time
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from uuid import UUID

import httpx
import numpy as np
import pytest
from sqlalchemy import update

from shapery_contracts.api import Scope
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io import write_mesh
from shapery_platform import keys
from shapery_platform.db import Database
from shapery_platform.db.models import Job
from shapery_platform.settings import load_settings
from tests.e2e.dashboard.conftest import OpenPage, Probe
from tests.e2e.dashboard.test_accessibility import check_open_to_everyone
from tests.support.embedded import Embedded
from tests.support.gateway import served

pytestmark = [pytest.mark.server, pytest.mark.browser]


@pytest.fixture
def guarded(tmp_path: Path) -> Iterator[tuple[str, str]]:
    """An empty server that asks for keys, and a key for it."""
    settings = load_settings(home=tmp_path, auth="keys", redis_url=f"unix://{tmp_path}/none.sock")
    database = Database(settings.database_url)
    database.migrate()
    with database.session() as session:
        _, secret = keys.create(session, "a browser", [Scope.READ, Scope.WRITE], None, "someone")
    database.dispose()
    with served(settings) as url:
        yield url, secret


def test_asks_for_a_key_and_forgets_it_with_the_tab(open_page: OpenPage, guarded: tuple[str, str]) -> None:
    url, secret = guarded
    page = open_page("/jobs", base=url)
    page.watch.allowed.append("401")
    page.get_by_role("heading", name="This server asks for a key").wait_for()
    check_open_to_everyone(page)
    field = page.get_by_role("textbox", name="API key")
    field.fill("shp_wrong")
    page.keyboard.press("Enter")
    page.get_by_role("alert").get_by_text("The key was not accepted").wait_for()
    field.fill(secret)
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="No jobs yet").wait_for()
    check_open_to_everyone(page)
    page.reload()
    page.get_by_role("heading", name="No jobs yet").wait_for()
    assert secret not in page.evaluate("JSON.stringify(localStorage) + document.cookie + location.href")
    other = page.context.new_page()
    other.goto(f"{url}/jobs")
    other.get_by_role("heading", name="This server asks for a key").wait_for()
    page.get_by_role("button", name="API key").click()
    page.get_by_role("menuitem", name="Forget the key").click()
    page.get_by_role("heading", name="This server asks for a key").wait_for()


EMPTY = {
    "/": "Nothing yet.",
    "/batches": "No batches yet",
    "/batches/new": "No volumes yet",
    "/shapes": "No shapes yet",
    "/shapes/search": "The bank is empty",
    "/motion": "No mesh sequences yet",
    "/upload": "Drop volumes here",
}
"""What pages say where nobody has done anything yet."""


def test_pages_without_anything_on_them_say_what_to_do(open_page: OpenPage, guarded: tuple[str, str]) -> None:
    url, secret = guarded
    page = open_page("/jobs", base=url, color_scheme="dark")
    page.watch.allowed += ["401", "503"]
    page.get_by_role("textbox", name="API key").fill(secret)
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="No jobs yet").wait_for()
    name = page.get_by_role("searchbox", name="Text in the name")
    assert name.count() == 0  # nor is there anything to filter
    for path, says in EMPTY.items():
        page.goto(f"{url}{path}")
        page.get_by_text(says).first.wait_for()
        assert name.count() == 0
        check_open_to_everyone(page)
    for path, says in {"/jobs": "No job is like that", "/shapes": "No shape is like that"}.items():
        page.goto(f"{url}{path}?name=knee")  # a filter that is set can be taken away
        page.get_by_role("heading", name=says).wait_for()
        name.press("Control+a")
        page.keyboard.press("Delete")
        name.wait_for(state="detached")


def test_a_key_goes_with_uploads_and_downloads(open_page: OpenPage, guarded: tuple[str, str], tmp_path: Path) -> None:
    url, secret = guarded
    mesh = TriangleMesh(np.eye(3), np.array([[0, 1, 2]]))
    path = tmp_path / "small.ply"
    write_mesh(mesh, path)
    page = open_page("/upload", base=url)
    page.watch.allowed.append("401")
    page.get_by_role("textbox", name="API key").fill(secret)
    page.keyboard.press("Enter")
    page.get_by_test_id("files").set_input_files(path)
    page.locator("li[data-state=done]", has_text="small.ply").get_by_text("Mesh · PLY").wait_for()
    with httpx.Client(base_url=url, headers={"Authorization": f"Bearer {secret}"}) as client:
        (asset,) = client.get("/v1/assets").json()["items"]
    assert asset["filename"] == "small.ply"
    assert asset["size"] == path.stat().st_size


def test_says_that_results_have_expired(
    open_page: OpenPage, platform: Embedded, probe: Probe, api: httpx.Client
) -> None:
    job = probe(artifacts={"a.bin": 10})
    page = open_page(f"/jobs/{job}")
    page.locator("[data-state=succeeded]").wait_for()
    expire(platform, job)
    end = time.monotonic() + 60
    while not api.get(f"/v1/jobs/{job}").json()["expired"]:
        assert time.monotonic() < end, "nobody clears what has expired"
        time.sleep(0.2)
    page.reload()
    page.get_by_role("heading", name="The results have expired").wait_for()
    check_open_to_everyone(page)
    page.get_by_role("button", name="Run it again").click()
    page.wait_for_url(lambda url: "/jobs/" in url and job not in url)
    page.locator("[data-state=succeeded]").wait_for()
    again = api.get(f"/v1/jobs/{page.url.rsplit('/', 1)[1]}").json()
    assert again["params"] == api.get(f"/v1/jobs/{job}").json()["params"]


def expire(platform: Embedded, job: str) -> None:
    """Let a job's time be over."""
    database = Database(f"sqlite:///{platform.home / 'shapery.db'}")
    with database.session() as session:
        session.execute(
            update(Job).where(Job.id == UUID(job)).values(expires_at=datetime.now(UTC) - timedelta(minutes=1))
        )
    database.dispose()


def test_says_that_there_is_no_such_page_or_job(open_page: OpenPage) -> None:
    page = open_page("/nowhere")
    page.get_by_role("heading", name="There is no such page").wait_for()
    check_open_to_everyone(page)
    page = open_page("/jobs/01890000-0000-7000-8000-000000000000")
    page.watch.allowed.append("404")
    page.get_by_role("heading", name="There is no such job").wait_for()
    check_open_to_everyone(page)


def test_the_theme_follows_the_system_and_the_button(open_page: OpenPage) -> None:
    def ground(page: object) -> int:
        color = page.evaluate("getComputedStyle(document.body).backgroundColor")  # type: ignore[attr-defined]
        return sum(int(part) for part in color[4:-1].split(",")[:3])

    light, dark = open_page("/jobs", color_scheme="light"), open_page("/jobs", color_scheme="dark")
    for page in (light, dark):
        page.get_by_role("heading", name="Jobs").wait_for()
    assert ground(light) > 600
    assert ground(dark) < 150
    dark.get_by_role("button", name="Switch to the light theme").click()
    dark.get_by_role("button", name="Switch to the dark theme").wait_for()
    assert ground(dark) > 600
    dark.reload()
    dark.get_by_role("button", name="Switch to the dark theme").wait_for()
