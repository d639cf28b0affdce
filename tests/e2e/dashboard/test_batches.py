"""Batches as they are seen: made by picking volumes, followed as a whole, and what failed run again."""

from __future__ import annotations

from pathlib import Path

import httpx
import pytest

from tests.e2e.dashboard.conftest import OpenPage
from tests.support.gateway import nifti

pytestmark = [pytest.mark.server, pytest.mark.browser]


def test_a_batch_is_followed_and_what_failed_runs_again(open_page: OpenPage, api: httpx.Client, tmp_path: Path) -> None:
    fails_once = {"action": "user_error", "once": str(tmp_path / "failed once")}
    items = [{"inputs": {}, "params": params} for params in ({}, {"steps": 20, "step_seconds": 0.1}, fails_once)]
    batch = api.post("/v1/batches", json={"kind": "probe", "items": items}).json()["id"]
    page = open_page("/batches")
    page.locator(f"tr[data-batch='{batch}'] [role=progressbar]").wait_for()
    page.goto(page.url + f"/{batch}")
    page.get_by_text("3 of 3 done, 1 failed").wait_for()
    bar = page.get_by_role("progressbar", name="3 of 3 done")
    assert (bar.get_attribute("aria-valuenow"), bar.get_attribute("aria-valuemax")) == ("3", "3")
    page.locator("tr[data-job]").nth(1).wait_for(state="detached")  # what failed is shown alone at first
    page.locator("tr[data-job] [data-state=failed]").wait_for()
    page.get_by_role("button", name="Retry the failed one").click()
    page.get_by_text("3 of 3 done", exact=True).wait_for()
    page.get_by_text("All 3", exact=True).click()
    page.locator("tr[data-job] [data-state=succeeded]").nth(2).wait_for()


def test_a_batch_is_made_by_picking_volumes(open_page: OpenPage, api: httpx.Client) -> None:
    ids = {}
    for seed, name in enumerate(["ann_t1.nii", "ann_t1c.nii", "bob_t1c.nii", "atlas.nii"]):
        answer = api.post("/v1/assets", files={"file": (name, nifti(seed=seed + 40))})
        ids[name] = answer.json()["id"]
    page = open_page("/batches/new")
    page.get_by_role("checkbox", name="Segment ann_t1c.nii").check()
    assert page.get_by_role("combobox", name="Before contrast, for ann_t1c.nii").input_value() == "ann_t1.nii"
    assert page.get_by_role("checkbox", name="Segment ann_t1.nii").is_disabled()
    page.get_by_role("checkbox", name="Segment bob_t1c.nii").check()
    page.get_by_text("2 volumes, 1 with one before contrast.").wait_for()
    page.get_by_role("button", name="The same as code").click()
    code = page.get_by_test_id("code-curl").text_content()
    assert all(ids[name] in code for name in ("ann_t1.nii", "ann_t1c.nii", "bob_t1c.nii"))
    page.get_by_role("button", name="Segment 2").click()
    page.wait_for_url("**/batches/*-*")
    batch = page.url.rsplit("/", 1)[1]
    jobs = api.get("/v1/jobs", params={"batch_id": batch}).json()["items"]
    assert sorted((job["inputs"] for job in jobs), key=len) == [
        {"post": [ids["bob_t1c.nii"]]},
        {"post": [ids["ann_t1c.nii"]], "pre": [ids["ann_t1.nii"]]},
    ]
    api.post(f"/v1/batches/{batch}/cancel")
    page.get_by_text("2 of 2 done").wait_for()


def test_there_is_no_such_batch(open_page: OpenPage) -> None:
    page = open_page("/batches/01890a5d-ac96-774b-bcce-b302099a8057")
    page.watch.allowed.append("404")
    page.get_by_role("heading", name="There is no such batch").wait_for()
    page.get_by_role("link", name="To the batches").click()
    page.get_by_role("heading", name="Batches").wait_for()
