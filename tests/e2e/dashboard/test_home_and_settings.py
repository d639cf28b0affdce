"""Where one begins, and where keys are made: both tell the truth about the server, and code that they show works."""

from __future__ import annotations

import subprocess

import httpx
import pytest

from tests.e2e.dashboard.conftest import OpenPage, Probe

pytestmark = [pytest.mark.server, pytest.mark.browser]


def test_the_start_tells_how_the_server_is(open_page: OpenPage, api: httpx.Client, probe: Probe) -> None:
    job = probe(action="user_error")
    page = open_page("/")
    # Where the machine is busy a check may come late, and that is told; the page asks again.
    page.watch.allowed.append("503")
    for part in ("Database", "Queue", "Storage"):
        page.locator("li[data-is=good]").filter(has_text=part).filter(has_text="answers").wait_for()
    page.get_by_test_id("workers").locator("li[data-is=good]").filter(has_text="Segmentation").wait_for()
    usage = api.get("/v1/usage").json()
    page.get_by_test_id("kept").get_by_text(f"{usage['results']['files']} result").wait_for()
    page.get_by_role("link", name=f"Job {job[-8:]}").wait_for()
    page.get_by_role("navigation", name="What you can do").get_by_text("Find a tumor’s surface").click()
    page.wait_for_url("**/upload")


def test_a_part_that_is_down_is_named(open_page: OpenPage) -> None:
    def down(page: object) -> None:
        answer = {
            "status": 503,
            "detail": "Not answering: database.",
            "code": "service_unavailable",
            "checks": {
                "database": {"status": "down", "seconds": 3.0, "detail": "no answer within 3 s"},
                "queue": {"status": "ok", "seconds": 0.1, "detail": ""},
            },
        }
        page.route("**/readyz", lambda route: route.fulfill(status=503, json=answer))  # type: ignore[attr-defined]

    page = open_page("/", before=down)
    page.watch.allowed.append("503")
    page.locator("li[data-is=bad]").filter(has_text="Database").filter(has_text="no answer within 3 s").wait_for()
    page.locator("li[data-is=good]").filter(has_text="Queue").wait_for()


def test_a_key_is_made_seen_once_and_revoked(open_page: OpenPage, api: httpx.Client) -> None:
    page = open_page("/settings")
    page.get_by_label("Name").fill("a notebook")
    page.get_by_role("button", name="Make a key").click()
    secret = page.get_by_test_id("secret").text_content()
    [key] = [key for key in api.get("/v1/keys").json()["items"] if key["name"] == "a notebook"]
    assert secret.startswith(key["prefix"])
    assert key["scopes"] == ["read", "write"]
    assert key["expires_at"] is not None
    page.reload()
    row = page.get_by_role("row").filter(has_text="a notebook")
    row.wait_for()
    assert secret not in page.content()
    row.get_by_role("button", name="Revoke").click()
    assert key["id"] in api.get("/v1/keys").text, "one click is not enough"
    row.get_by_role("button", name="Revoke for good").click()
    row.wait_for(state="detached")
    assert key["id"] not in api.get("/v1/keys").text


def test_the_code_that_is_shown_does_what_the_page_does(open_page: OpenPage, api: httpx.Client) -> None:
    page = open_page("/settings")
    page.get_by_label("Name").fill("from a shell")
    page.get_by_role("button", name="The same as code").click()
    code = page.get_by_test_id("code-curl").text_content()
    subprocess.run(["bash", "-c", code.replace("curl", "curl -sf", 1)], check=True, capture_output=True)
    assert "from a shell" in api.get("/v1/keys").text
