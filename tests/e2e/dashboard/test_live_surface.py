"""A surface that is seen while it grows, also by those who come late."""

from __future__ import annotations

import re
from typing import Any

import httpx
import pytest

from tests.e2e.dashboard.conftest import OpenPage, Probe
from tests.support.browser import picture, share_of, until

pytestmark = [pytest.mark.server, pytest.mark.browser]


def drawn(page: Any) -> int:
    """How many pixels of the surface's color the picture has."""
    orange = share_of(picture(page.get_by_test_id("live")), red=(90, 255), green=(50, 190), blue=(10, 120))
    return int(orange.sum())


def test_a_reload_in_the_middle_of_a_job_shows_the_surface_growing_again(
    open_page: OpenPage, probe: Probe, api: httpx.Client
) -> None:
    job_id = probe(steps=400, step_seconds=0.25, previews=True)
    page = open_page(f"/jobs/{job_id}")
    for visit in range(2):
        canvas = page.get_by_test_id("live")
        canvas.wait_for()
        canvas.focus()
        page.keyboard.press("ArrowLeft")  # from now on the camera stays where it is
        until(lambda: drawn(page) > 500, f"visit {visit + 1}: the surface is not drawn")
        before = drawn(page)
        until(lambda before=before: drawn(page) > 1.1 * before, f"visit {visit + 1}: the surface does not grow")
        if visit == 0:
            page.reload()
    api.post(f"/v1/jobs/{job_id}/cancel").raise_for_status()
    page.locator("[data-state=cancelled]").first.wait_for()
    page.get_by_test_id("live").wait_for(state="detached")
    assert api.get(f"/v1/jobs/{job_id}/preview").status_code == 204


def test_a_job_that_shows_nothing_has_no_such_view(open_page: OpenPage, probe: Probe, api: httpx.Client) -> None:
    job_id = probe(steps=400, step_seconds=0.25)
    page = open_page(f"/jobs/{job_id}")
    page.get_by_text(re.compile(r"step \d+ of 400")).wait_for()
    assert page.get_by_role("region", name="As it grows").count() == 0
    api.post(f"/v1/jobs/{job_id}/cancel").raise_for_status()
