"""For those who use no mouse, or do not see the page: every page by the rules of axe, and by the keyboard alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.conftest import ROOT
from tests.e2e.dashboard.conftest import OpenPage, Probe

pytestmark = [pytest.mark.server, pytest.mark.browser]

AXE = ROOT / "services" / "dashboard" / "node_modules" / "axe-core" / "axe.min.js"
OTHER_PAGES = {
    "/": "Recent work",
    "/batches": "New batch",
    "/batches/new": "New batch",
    "/settings": "Make a key",
    "/motion": "Compress a motion",
    "/shapes": "Add shapes",
    "/shapes/search": "Drop a mesh here",
}
"""Pages that need nothing done first, and a text that is there when they are."""
SIZES = [(1280, 720), (820, 1180)]


@pytest.fixture(scope="module")
def axe() -> str:
    if not AXE.is_file():
        pytest.skip("axe-core is not installed (npm ci in services/dashboard)")
    return AXE.read_text()


def serious(page: Any, axe: str) -> list[str]:
    """What axe finds that keeps people out."""
    page.evaluate(axe)
    found = page.evaluate("axe.run(document, { resultTypes: ['violations'] })")
    return [
        f"{violation['id']}: {node['html'][:200]} {node.get('failureSummary', '')[:300]}"
        for violation in found["violations"]
        if violation["impact"] in {"serious", "critical"}
        for node in violation["nodes"]
    ]


def check_open_to_everyone(page: Any) -> None:
    """Ask axe about a page in the state that a test has brought it to."""
    if AXE.is_file():
        assert serious(page, AXE.read_text()) == []


def overflow(page: Any) -> int:
    """Pixels by which the page is wider than the window."""
    return int(page.evaluate("document.documentElement.scrollWidth - innerWidth"))


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_are_open_to_everyone(
    open_page: OpenPage, axe: str, probe: Probe, scheme: str, tmp_path: Path, api: httpx.Client
) -> None:
    failed = probe(action="user_error")
    running = probe(steps=600, step_seconds=0.1)
    page = open_page("/jobs", color_scheme=scheme)
    base = page.url.removesuffix("/jobs")
    page.locator(f"tr[data-job='{running}'] [role=progressbar]").wait_for()
    faults = {"jobs": serious(page, axe)}
    for path, shows in OTHER_PAGES.items():
        page.goto(base + path)
        page.get_by_text(shows).first.wait_for()
        faults[path] = serious(page, axe)
    page.goto(f"{base}/jobs/{running}")
    page.get_by_text("step").first.wait_for()
    faults["running"] = serious(page, axe)
    api.post(f"/v1/jobs/{running}/cancel")
    page.goto(page.url.replace(running, failed))
    page.get_by_test_id("job-error").wait_for()
    faults["failed"] = serious(page, axe)
    junk = tmp_path / "junk.bin"
    junk.write_bytes(b"junk" * 100)
    page.goto(page.url.replace(f"/jobs/{failed}", "/upload"))
    page.watch.allowed.append("422")
    page.get_by_test_id("files").set_input_files(junk)
    page.locator("li[data-state=failed]").wait_for()
    page.get_by_role("button", name="Details").click()
    page.get_by_label("Seed points").wait_for()
    faults["upload"] = serious(page, axe)
    assert {name: found for name, found in faults.items() if found} == {}


@pytest.mark.parametrize("size", SIZES)
def test_nothing_sticks_out_of_the_window(open_page: OpenPage, probe: Probe, size: tuple[int, int]) -> None:
    job = probe(action="user_error")
    page = open_page("/jobs")
    base = page.url.removesuffix("/jobs")
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.locator(f"tr[data-job='{job}']").wait_for()
    assert overflow(page) <= 0
    page.goto(page.url.replace("/jobs", f"/jobs/{job}"))
    page.get_by_test_id("job-error").wait_for()
    assert overflow(page) <= 0
    page.goto(page.url.replace(f"/jobs/{job}", "/upload"))
    page.get_by_text("Drop volumes here").wait_for()
    assert overflow(page) <= 0
    for path, shows in OTHER_PAGES.items():
        page.goto(base + path)
        page.get_by_text(shows).first.wait_for()
        assert overflow(page) <= 0, path


def test_the_keyboard_is_enough(open_page: OpenPage, probe: Probe, tmp_path: Path) -> None:
    """From the address bar to a failed job, and to trying it again, without a mouse."""
    job = probe(action="user_error", once=str(tmp_path / "failed once"))
    page = open_page("/jobs")
    page.locator(f"tr[data-job='{job}'] [data-state=failed]").wait_for()

    def tab_to(what: str, condition: str) -> None:
        for _ in range(60):
            page.keyboard.press("Tab")
            if page.evaluate(f"(() => {{ const it = document.activeElement; return {condition}; }})()"):
                return
        raise AssertionError(f"{what} is not reached by the tabulator key")

    tab_to("the link to the content", "it.textContent === 'Skip to the content'")
    page.keyboard.press("Enter")
    tab_to("the job", f"it.tagName === 'A' && it.href.endsWith('{job}')")
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") != "none"
    page.keyboard.press("Enter")
    page.wait_for_url(f"**/jobs/{job}")
    page.get_by_test_id("job-error").wait_for()
    tab_to("the button to retry", "it.textContent === 'Retry'")
    page.keyboard.press("Enter")
    page.locator("[data-state=succeeded]").wait_for()
