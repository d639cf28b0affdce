"""The page of a compressed motion: plays what was encoded, beside its original, with its errors."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from shapery_geometry.sequence import write_sequence_npz
from tests.e2e.dashboard.conftest import OpenPage
from tests.e2e.dashboard.left_behind import check_nothing_is_left
from tests.e2e.dashboard.test_accessibility import AXE, check_open_to_everyone, overflow, serious
from tests.support.browser import keep_picture, picture, until

pytestmark = [pytest.mark.server, pytest.mark.browser]

ROWS, COLUMNS, FRAMES = 100, 100, 24


def wandering_ball() -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """A ball of 10,000 vertices that is dented as it goes from the left to the right."""
    polar, around = np.meshgrid(np.linspace(0.02, np.pi - 0.02, ROWS), np.arange(COLUMNS) * 2 * np.pi / COLUMNS)
    polar, around = polar.T.reshape(-1), around.T.reshape(-1)
    ball = np.stack((np.sin(polar) * np.cos(around), np.cos(polar), np.sin(polar) * np.sin(around)), axis=1)
    t = np.arange(FRAMES)[:, None] / (FRAMES - 1)
    size = 1 + 0.12 * np.sin(5 * polar + 6 * t) * np.cos(3 * around - 4 * t)
    frames = ball * size[..., None] + np.array([6.0, 0, 0]) * t[..., None]
    at = (np.arange(ROWS - 1)[:, None] * COLUMNS + np.arange(COLUMNS)).reshape(-1)
    beside = (np.arange(ROWS - 1)[:, None] * COLUMNS + (np.arange(COLUMNS) + 1) % COLUMNS).reshape(-1)
    faces = np.concatenate(
        (np.stack((at, beside, at + COLUMNS), axis=1), np.stack((beside, beside + COLUMNS, at + COLUMNS), axis=1))
    )
    return frames.astype(np.float32), faces.astype(np.int32)


@pytest.fixture(scope="module")
def encoded(chrome: Any, api: httpx.Client, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    frames, faces = wandering_ball()
    path = tmp_path_factory.mktemp("motion") / "ball.npz"
    write_sequence_npz(path, frames, faces, shape=frames.shape[:2])
    asset = api.post("/v1/assets", files={"file": (path.name, path.read_bytes())}, timeout=120)
    asset.raise_for_status()
    params = {"kg": 0.5, "preset": "fast", "fps": 30}
    job = api.post(
        "/v1/jobs", json={"kind": "motion-encode", "inputs": {"sequence": asset.json()["id"]}, "params": params}
    )
    job.raise_for_status()
    found = job.json()
    deadline = time.monotonic() + 300
    while found["state"] in {"queued", "running"}:
        assert time.monotonic() < deadline
        time.sleep(0.3)
        found = api.get(f"/v1/jobs/{found['id']}").json()
    assert found["state"] == "succeeded", found
    return dict(found)


def canvas(page: Any) -> Any:
    found = page.get_by_test_id("motion")
    found.wait_for()
    until(lambda: bool(lit(picture(found)).any()), "something is drawn")
    return found


def lit(pixels: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Where the mesh is: not black, and not what lies over the drawing at its edges."""
    inside = np.zeros(pixels.shape[:2], dtype=bool)
    inside[70:-70, 5:-5] = True
    return np.asarray((pixels.max(axis=2) > 30) & inside)


def choose(page: Any, group: str, name: str) -> None:
    page.get_by_role("radiogroup", name=group).get_by_text(name, exact=True).click()


def test_views_leave_nothing_behind(open_page: OpenPage, encoded: dict[str, Any]) -> None:
    check_nothing_is_left(open_page, f"/jobs/{encoded['id']}")


def test_frames_are_where_they_should_be(open_page: OpenPage, encoded: dict[str, Any]) -> None:
    page = open_page(f"/jobs/{encoded['id']}")
    drawing = canvas(page)
    assert page.get_by_test_id("frame").inner_text() == f"1 / {FRAMES}"
    first = lit(picture(drawing))
    rows, columns = np.nonzero(first)
    # a ball: as wide as high, and filled
    height, width = np.ptp(rows), np.ptp(columns)
    assert 0.7 < width / height < 1.4
    assert first.sum() > 0.6 * height * width

    def middle() -> float:
        return float(np.nonzero(lit(picture(drawing)))[1].mean())

    slider = page.get_by_role("slider", name="Frame")
    slider.focus()
    for _ in range(4):
        slider.press("ArrowRight")
    page.get_by_text(f"5 / {FRAMES}").wait_for()
    until(lambda: middle() > columns.mean() + 0.15 * width, "the motion has moved")
    # it goes on for three times its own width, and stays in the picture
    slider.press("End")
    page.get_by_text(f"{FRAMES} / {FRAMES}").wait_for()
    until(lambda: middle() > columns.mean() + 1.5 * width, "the motion has moved on")
    last = lit(picture(drawing))
    assert not last[:, [6, -7]].any()
    assert last.sum() > 0.5 * first.sum()
    page.get_by_role("button", name="Save this frame as a mesh").click()
    with page.expect_download() as coming:
        page.get_by_role("menuitem", name="OBJ").click()
    lines = Path(coming.value.path()).read_text().splitlines()
    points = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=float)
    frames, faces = wandering_ball()
    assert np.abs(points - frames[-1]).max() < 0.1
    assert sum(line.startswith("f ") for line in lines) == len(faces)


def test_the_original_stands_beside_and_over_it(open_page: OpenPage, encoded: dict[str, Any]) -> None:
    page = open_page(f"/jobs/{encoded['id']}")
    drawing = canvas(page)
    alone = lit(picture(drawing)).sum()
    choose(page, "What is shown", "Side by side")
    page.get_by_text("Original", exact=True).last.wait_for()

    def halves() -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        mask = lit(picture(drawing))
        middle = mask.shape[1] // 2
        return mask[:, :middle], mask[:, middle : 2 * middle]

    # the same body twice, seen from the same side
    until(lambda: all(half.any() for half in halves()), "both halves are drawn")
    left, right = halves()
    assert (left & right).sum() > 0.9 * (left | right).sum()
    choose(page, "What is shown", "Overlaid")

    def orange() -> int:
        pixels = picture(drawing).astype(int)
        mask = lit(pixels.astype(np.uint8))
        return int((mask & (pixels[..., 0] > pixels[..., 2] + 40)).sum())

    until(lambda: orange() > 0.05 * alone, "the error is colored")


def test_errors_and_clusters_are_seen_as_colors(open_page: OpenPage, encoded: dict[str, Any]) -> None:
    page = open_page(f"/jobs/{encoded['id']}")
    drawing = canvas(page)

    def hues() -> int:
        pixels = picture(drawing)
        colors = pixels[lit(pixels)].astype(float)
        return len(np.unique(np.rint(6 * colors / colors.max(axis=1, keepdims=True)), axis=0))

    plain = hues()
    choose(page, "Color", "Error")
    legend = page.get_by_role("figure", name="Error by color")
    legend.wait_for()
    assert "RMS" in legend.inner_text()
    until(lambda: hues() > 2 * plain, "clusters are colored")
    keep_picture(page, "motion")
    if encoded["result"]["clusters"] > 1:
        choose(page, "Color", "Clusters")
        legend.wait_for(state="detached")
        until(lambda: hues() > plain, "clusters are colored again")


def test_it_plays(open_page: OpenPage, encoded: dict[str, Any], record_property: Callable[[str, object], None]) -> None:
    page = open_page(f"/jobs/{encoded['id']}")
    canvas(page)
    page.evaluate(
        """() => {
            window.drawn = [];
            window.told = new Set();
            const at = document.querySelector("[data-testid=frame]");
            new MutationObserver(() => window.told.add(at.textContent))
                .observe(at, { characterData: true, childList: true, subtree: true });
            const draw = WebGL2RenderingContext.prototype.drawElements;
            WebGL2RenderingContext.prototype.drawElements = function (...given) {
                window.drawn.push(performance.now());
                return draw.apply(this, given);
            };
        }"""
    )
    page.get_by_role("button", name="Play").click()
    until(lambda: page.evaluate("window.drawn.length") > 2 * FRAMES, "it plays on")
    page.get_by_role("button", name="Pause").click()
    drawn = page.evaluate("window.drawn")
    record_property("frames_per_second", (len(drawn) - 1) / ((drawn[-1] - drawn[0]) / 1000))
    # The controls follow some times a second.
    assert page.evaluate("window.told.size") > 3


def test_what_comes_slowly_is_waited_for_and_called_off_with_its_page(
    open_page: OpenPage, encoded: dict[str, Any]
) -> None:
    """A file that does not come: the page says so, and stops asking for it when somebody goes elsewhere."""
    page = open_page("/jobs")
    page.watch.allowed.append("net::ERR_ABORTED")
    page.route("**/artifacts/motion.smc", lambda route: None)
    with page.expect_request("**/artifacts/motion.smc"):
        page.locator(f"tr[data-job='{encoded['id']}']").get_by_role("link").first.click()
    viewer = page.locator("section[aria-label=Motion][data-status=loading]")
    viewer.get_by_role("status").get_by_text("Loading the motion…").wait_for()
    check_open_to_everyone(page)
    with page.expect_event("requestfailed", lambda request: request.url.endswith("/motion.smc")):
        page.get_by_role("link", name="Jobs", exact=True).first.click()
    page.unroute("**/artifacts/motion.smc")
    page.go_back()
    canvas(page)


def test_another_quality_is_a_new_job(open_page: OpenPage, encoded: dict[str, Any], api: httpx.Client) -> None:
    page = open_page(f"/jobs/{encoded['id']}")
    again = page.get_by_role("region", name="Another quality")
    again.scroll_into_view_if_needed()
    slider = again.get_by_role("slider")
    slider.focus()
    slider.press("End")
    assert slider.get_attribute("aria-valuetext") == "1 %"
    again.get_by_role("button", name="Compress again").click()
    page.wait_for_url(lambda url: encoded["id"] not in url)
    started = api.get(f"/v1/jobs/{page.url.rsplit('/', 1)[1]}").json()
    assert started["inputs"] == encoded["inputs"]
    assert started["params"]["kg"] == 1
    assert started["params"]["preset"] == "fast"


@pytest.mark.parametrize(("scheme", "size"), [("light", (1280, 720)), ("dark", (820, 1180))])
def test_the_page_is_open_to_everyone(
    open_page: OpenPage, encoded: dict[str, Any], scheme: str, size: tuple[int, int], tmp_path: Path
) -> None:
    if not AXE.is_file():
        pytest.skip("axe-core is not installed (npm ci in services/dashboard)")
    page = open_page(f"/jobs/{encoded['id']}", color_scheme=scheme)
    page.set_viewport_size({"width": size[0], "height": size[1]})
    canvas(page)
    choose(page, "Color", "Error")
    page.get_by_role("figure", name="Error by color").wait_for()
    assert serious(page, AXE.read_text()) == []
    assert overflow(page) <= 0
    page.screenshot(path=tmp_path / "page.png", full_page=True)
