"""Jobs as they are seen: live, filtered, paged, called off, tried again, and why they failed."""

from __future__ import annotations

import re
from typing import Any

import httpx
import pytest

from tests.e2e.dashboard.conftest import OpenPage, Probe
from tests.e2e.dashboard.test_accessibility import check_open_to_everyone
from tests.support.browser import until
from tests.support.embedded import Embedded
from tests.support.proxy import unreliable

pytestmark = [pytest.mark.server, pytest.mark.browser]


def row_of(page: Any, job_id: str) -> Any:
    return page.locator(f"tr[data-job='{job_id}']")


def wait_for_state(scope: Any, state: str) -> None:
    scope.locator(f"[data-state={state}]").first.wait_for()


def step_shown(page: Any) -> int:
    """The step that the page of a running probe names."""
    text = page.get_by_text(re.compile(r"^step \d+ of \d+$")).text_content()
    return int(text.split()[1])


def test_a_job_is_followed_while_it_runs(open_page: OpenPage, probe: Probe) -> None:
    page = open_page("/jobs")
    job = probe(steps=20, step_seconds=0.5)
    row = row_of(page, job)
    wait_for_state(row, "running")
    bar = row.get_by_role("progressbar")
    bar.wait_for()
    seen: set[str] = set()
    while row.locator("[data-state=succeeded]").count() == 0:
        seen.update(bar.evaluate_all("bars => bars.map((bar) => bar.getAttribute('aria-valuenow'))"))
        page.wait_for_timeout(100)
    assert len(seen) > 4, f"the bar stood at {seen} only"


def test_events_come_at_once_and_not_with_the_next_question(
    open_page: OpenPage, probe: Probe, api: httpx.Client
) -> None:
    """With the job's own address refused, only the stream can tell of progress."""
    job = probe(steps=400, step_seconds=0.25)
    page = open_page(f"/jobs/{job}")
    step = step_shown(page)
    page.watch.allowed.append("net::ERR")
    page.route(f"**/v1/jobs/{job}", lambda route: route.abort())
    page.wait_for_timeout(300)
    later = [step_shown(page)]
    while len(later) < 5:
        page.wait_for_timeout(200)
        if (now := step_shown(page)) != later[-1]:
            later.append(now)
    assert later == sorted(later)
    assert later[0] >= step
    api.post(f"/v1/jobs/{job}/cancel")


def test_asks_again_and_again_where_streams_do_not_come_through(open_page: OpenPage, probe: Probe) -> None:
    job = probe(steps=40, step_seconds=0.25)

    def refuse_streams(page: Any) -> None:
        page.watch.allowed.append("net::ERR")
        page.route("**/events", lambda route: route.abort())

    page = open_page(f"/jobs/{job}", before=refuse_streams)
    page.get_by_text(re.compile("step .* of 40")).wait_for()
    wait_for_state(page, "succeeded")


def test_a_reload_in_the_middle_loses_nothing(open_page: OpenPage, probe: Probe, api: httpx.Client) -> None:
    job = probe(steps=400, step_seconds=0.25)
    page = open_page(f"/jobs/{job}")
    before = step_shown(page)
    page.reload()
    assert step_shown(page) >= before
    api.post(f"/v1/jobs/{job}/cancel")
    wait_for_state(page, "cancelled")


def test_a_job_is_called_off_and_tried_again(open_page: OpenPage, probe: Probe, api: httpx.Client) -> None:
    job = probe(steps=400, step_seconds=0.1)
    page = open_page("/jobs")
    row = row_of(page, job)
    wait_for_state(row, "running")
    row.get_by_role("button", name=re.compile("^Cancel")).click()
    wait_for_state(row, "cancelled")
    assert api.get(f"/v1/jobs/{job}").json()["state"] == "cancelled"
    row.get_by_role("button", name=re.compile("^Retry")).click()
    wait_for_state(row, "running")
    row.get_by_role("link").click()
    step = step_shown(page)
    page.wait_for_timeout(1_000)
    assert step_shown(page) > step, "the job is followed: the end of its first run is not taken for its end"
    page.get_by_role("button", name=re.compile("^Cancel")).click()
    page.get_by_text("The job was cancelled").wait_for()
    assert api.get(f"/v1/jobs/{job}").json()["state"] == "cancelled"


def test_says_why_a_job_failed_and_what_to_do(open_page: OpenPage, probe: Probe) -> None:
    job = probe(action="user_error")
    page = open_page("/jobs?state=failed")
    row = row_of(page, job)
    row.get_by_text("There are 0 objects in 3 voxels.").wait_for()
    row.get_by_text("Send more voxels.").wait_for()
    row.get_by_role("link").click()
    told = page.get_by_test_id("job-error")
    told.get_by_text("There are 0 objects in 3 voxels.").wait_for()
    told.get_by_text("Send more voxels.").wait_for()
    told.get_by_text("no_object_found").wait_for()
    page.get_by_role("button", name=re.compile("^Retry")).wait_for()


def test_two_tabs_agree(open_page: OpenPage, probe: Probe) -> None:
    job = probe(steps=300, step_seconds=0.1)
    first = open_page("/jobs")
    second = first.context.new_page()
    second.goto(first.url)
    wait_for_state(row_of(second, job), "running")
    second.bring_to_front()
    row_of(second, job).get_by_role("button", name=re.compile("^Cancel")).click()
    wait_for_state(row_of(second, job), "cancelled")
    first.bring_to_front()
    wait_for_state(row_of(first, job), "cancelled")


def test_pages_and_filters(open_page: OpenPage, api: httpx.Client) -> None:
    # Long enough that most of them are still there to be cancelled.
    items = [{"inputs": {}, "params": {"seed": seed, "steps": 40, "step_seconds": 0.5}} for seed in range(60)]
    batch = api.post("/v1/batches", json={"kind": "probe", "params": {}, "items": items}).json()["id"]
    listed = [job["id"] for job in api.get("/v1/jobs", params={"limit": 60}).json()["items"]]
    page = open_page("/jobs")
    rows = page.locator("tr[data-job]")

    def shown() -> list[str]:
        rows.first.wait_for()
        return [str(name) for name in rows.evaluate_all("rows => rows.map(row => row.dataset.job)")]

    assert shown() == listed[:25]
    page.get_by_role("button", name="Older").click()
    row_of(page, listed[25]).wait_for()
    assert shown() == listed[25:50]
    page.reload()  # the address says which page it is
    row_of(page, listed[25]).wait_for()
    page.get_by_role("button", name=re.compile("Newe")).click()
    row_of(page, listed[0]).wait_for()
    api.post(f"/v1/batches/{batch}/cancel")
    page.get_by_text("Cancelled", exact=True).first.click()
    page.wait_for_url("**/jobs?state=cancelled")
    page.locator("[aria-busy=false] tr[data-job]").first.wait_for()
    states = page.locator("tr[data-job] [data-state]").evaluate_all(
        "badges => badges.map(badge => badge.dataset.state)"
    )
    assert set(states) <= {"cancelled"}
    # the list is sorted by a column, all of it and not the page alone, and turned around; the keyboard does it, too
    for name, order in (
        ("Created", "created"),
        ("Took", "-took"),
        ("Took", "took"),
        ("State", "state"),
        ("Job", "name"),
    ):
        page.get_by_role("columnheader", name=name, exact=True).get_by_role("button").press("Enter")
        page.locator(f"th[aria-sort={'descending' if order[0] == '-' else 'ascending'}]", has_text=name).wait_for()
        expected = api.get("/v1/jobs", params={"state": "cancelled", "order": order, "limit": 50}).json()["items"]
        sorted_so = [job["id"] for job in expected]
        until(lambda ids=sorted_so: shown() == ids[:25], f"the jobs are sorted by {order}")  # type: ignore[misc]
    page.get_by_role("button", name="Next").click()
    row_of(page, sorted_so[25]).wait_for()
    page.goto(page.url.split("/jobs")[0] + "/jobs")
    row_of(page, listed[0]).wait_for()
    page.get_by_role("searchbox", name="Text in the name").fill("no job is called so")
    page.get_by_text("No job is like that").wait_for()
    page.get_by_role("searchbox", name="Text in the name").fill("")
    row_of(page, listed[0]).wait_for()
    page.get_by_role("searchbox", name="Text in the name").press("n")
    page.wait_for_url("**/jobs?name=n")
    page.keyboard.type("o")  # whoever writes on is still in the field
    page.wait_for_url("**/jobs?name=no")
    page.get_by_role("searchbox", name="Text in the name").fill("")
    page.wait_for_url("**/jobs")
    page.get_by_role("combobox", name="Show jobs of one kind").click()
    page.get_by_role("option", name="Compression", exact=True).click()
    page.wait_for_url("**/jobs?kind=motion-encode")
    row_of(page, listed[0]).wait_for(state="detached")


def test_says_when_the_server_does_not_answer(open_page: OpenPage, platform: Embedded, probe: Probe) -> None:
    job = probe()
    with unreliable(platform.port) as network:
        page = open_page("/jobs", base=network.url)
        page.watch.allowed.append("net::ERR")
        row_of(page, job).wait_for()
        home = open_page("/", base=network.url)
        home.watch.allowed.append("net::ERR")
        server = home.get_by_role("region", name="This server")
        server.get_by_text("Database").wait_for()
        network.down = True
        page.get_by_text("The server does not answer. What is shown").wait_for()
        row_of(page, job).wait_for()  # what was known stays
        check_open_to_everyone(page)
        server.get_by_text("does not answer", exact=True).wait_for()
        assert server.get_by_text("Database").count() == 0
        check_open_to_everyone(home)
        network.down = False
        page.get_by_text("The server does not answer. What is shown").wait_for(state="detached")
        later = probe()
        row_of(page, later).wait_for()


def test_what_was_never_loaded_waits_for_the_server(open_page: OpenPage) -> None:
    """Above the page stands once why."""

    def silence(page: Any) -> None:
        page.watch.allowed.append("net::ERR")
        page.route("**/v1/**", lambda route: route.abort())

    page = open_page("/batches", before=silence, color_scheme="dark")
    page.get_by_text("Waiting for the server…").wait_for()
    assert page.get_by_text("does not answer").count() == 1
    check_open_to_everyone(page)
    page.unroute("**/v1/**")
    page.get_by_text("Waiting for the server…").wait_for(state="detached")
    page.get_by_text("does not answer").wait_for(state="detached")
