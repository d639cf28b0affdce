"""How fast pages are there, and how smoothly they move."""

from __future__ import annotations

import re
import statistics
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import httpx
import psutil

from benchmarks.dashboard.browser import held, opened, processor_seconds
from benchmarks.dashboard.samples import FPS
from shapery_gateway.dashboard.service import STATIC

FRAME_TIMES = """
(milliseconds) => new Promise((resolve) => {
    const times = [];
    let before = performance.now();
    const end = before + milliseconds;
    const step = (now) => {
        times.push(now - before);
        before = now;
        if (now < end) requestAnimationFrame(step);
        else resolve(times.slice(1));
    };
    requestAnimationFrame(step);
})
"""

COUNT = """
window.drawn = [];
const draw = WebGL2RenderingContext.prototype.drawElements;
WebGL2RenderingContext.prototype.drawElements = function (...given) {
    const now = document.timeline.currentTime;
    if (window.drawn.at(-1) !== now) window.drawn.push(now);
    return draw.apply(this, given);
};
"""
"""Notes each animation frame in which meshes were drawn."""

SHOWN = """
(milliseconds) => new Promise((resolve) => {
    window.drawn.length = 0;
    setTimeout(() => resolve(window.drawn), milliseconds);
})
"""

DECODED = """
async ([script, file, rounds]) => {
    const worker = new Worker(script, { type: "module" });
    const ask = (message, given) => new Promise((resolve) => {
        worker.onmessage = ({ data }) => resolve(data);
        worker.postMessage(message, given);
    });
    const content = await (await fetch(file)).arrayBuffer();
    const began = performance.now();
    const { header } = await ask({ open: content }, [content]);
    const open = performance.now() - began;
    let into = new Float32Array(3 * header.vertices);
    const times = [];
    for (let index = 0; index < rounds; index += 1) {
        const start = performance.now();
        ({ positions: into } = await ask({ frame: index % header.frames, into }, [into.buffer]));
        times.push(performance.now() - start);
    }
    worker.terminate();
    return { open, times };
}
"""


def first_load(browser: Any, url: str, path: str, text: str, rounds: int) -> dict[str, float]:
    """Load a page with an empty cache: bytes over the network, and seconds until it can be used.

    It can be used once its text is there and no task has kept the main thread for more than 50 ms since.
    """
    kilobytes, seconds, busy = [], [], []
    for _ in range(rounds):
        page = opened(browser)
        session = page.context.new_cdp_session(page)
        session.send("Network.enable")
        session.send("Performance.enable")
        sizes: list[float] = []
        session.on("Network.loadingFinished", lambda event, sizes=sizes: sizes.append(event["encodedDataLength"]))
        page.add_init_script(
            "window.tasks = [];"
            "new PerformanceObserver((list) => tasks.push(...list.getEntries().map((e) => e.startTime + e.duration)))"
            ".observe({ type: 'longtask', buffered: true });"
        )
        page.goto(url + path, wait_until="commit")
        page.get_by_text(text).first.wait_for()
        there = page.evaluate("performance.now()")
        page.wait_for_timeout(1_500)
        seconds.append(max(there, *page.evaluate("[0, ...tasks]")) / 1000)
        told = {one["name"]: one["value"] for one in session.send("Performance.getMetrics")["metrics"]}
        busy.append(told["TaskDuration"])
        kilobytes.append(sum(sizes) / 1000)
        page.context.close()
    return {
        "kilobytes": round(statistics.median(kilobytes)),
        "interactive_s": round(statistics.median(seconds), 2),
        "main_thread_s": round(statistics.median(busy), 2),
    }


def viewed(browser: Any, url: str, path: str) -> dict[str, float]:
    """Load a page with a viewer with an empty cache: bytes of scripts and styles, and of everything."""
    page = opened(browser)
    session = page.context.new_cdp_session(page)
    session.send("Network.enable")
    kinds: dict[str, str] = {}
    sizes: dict[str, float] = {}
    session.on("Network.responseReceived", lambda event: kinds.update({event["requestId"]: event["response"]["url"]}))
    session.on("Network.loadingFinished", lambda event: sizes.update({event["requestId"]: event["encodedDataLength"]}))
    page.goto(url + path)
    page.locator("section[data-status=ready]").first.wait_for()
    page.wait_for_timeout(1_500)
    page.context.close()
    ours = sum(size for request, size in sizes.items() if "/v1/" not in kinds.get(request, ""))
    return {"app_kilobytes": round(ours / 1000), "all_kilobytes": round(sum(sizes.values()) / 1000)}


def playback(browser: Any, url: str, job: str) -> dict[str, float]:
    """Play the motion for some seconds, then decode its frames alone."""
    page = opened(browser)
    page.add_init_script(COUNT)
    page.goto(f"{url}/jobs/{job}")
    page.locator("section[aria-label=Motion][data-status=ready]").wait_for()
    page.get_by_role("button", name="Play", exact=True).click()
    page.wait_for_timeout(1_500)
    before = processor_seconds()
    shown = page.evaluate(SHOWN, 6_000)
    drawn = processor_seconds() - before
    page.get_by_role("button", name="Pause", exact=True).click()
    script = next(path for path in (STATIC / "assets").iterdir() if re.fullmatch(r"player\.worker-.*\.js", path.name))
    decoded = page.evaluate(DECODED, [f"/assets/{script.name}", f"/v1/jobs/{job}/artifacts/motion.smc", 360])
    page.context.close()
    return {
        "asked_fps": FPS,
        "shown_fps": round((len(shown) - 1) / ((shown[-1] - shown[0]) / 1000), 1),
        "cpu_ms_per_frame": round(1000 * drawn / len(shown)),
        "open_ms": round(decoded["open"], 1),
        "decode_ms": round(statistics.median(decoded["times"][120:]), 2),
    }


def scrolled(browser: Any, url: str, shape: dict[str, Any], total: int) -> dict[str, float]:
    """Scroll through copies of one shape, a page of the list after another, then back through all of them."""
    size = 200

    def answer(route: Any) -> None:
        begin = int((re.search(r"cursor=(\d+)", route.request.url) or [0, 0])[1])
        items = [{**shape, "id": str(begin + i), "name": f"No {begin + i}"} for i in range(size)]
        route.fulfill(json={"items": items, "next_cursor": str(begin + size) if begin + size < total else None})

    page = opened(browser)
    page.route(re.compile(r"/v1/shapes\?"), answer)
    page.goto(f"{url}/shapes")
    page.locator("li[data-shape='No 0']").wait_for()
    while page.locator(f"li[data-shape='No {total - 1}']").count() == 0:
        page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
        page.wait_for_timeout(40)
    page.evaluate("scrollTo(0, document.documentElement.scrollHeight / 2)")
    page.wait_for_timeout(1_000)
    page.evaluate(
        "() => { const go = () => { scrollBy(0, -40); window.going = requestAnimationFrame(go); }; go(); }",
    )
    times = page.evaluate(FRAME_TIMES, 6_000)
    nodes = page.evaluate("document.getElementsByTagName('*').length")
    page.context.close()
    return {"rows": total, "elements": nodes, **frame_times(times)}


def paged(browser: Any, url: str, mesh: str, total: int) -> dict[str, float]:
    """Make many jobs and call them off, then go through pages of their list, and scroll one up and down."""
    items = [{"inputs": {"mesh": mesh}, "params": {}}] * total
    with httpx.Client(base_url=url, timeout=120) as api:
        batch = api.post("/v1/batches", json={"kind": "shape-index", "items": items}).raise_for_status().json()
        api.post(f"/v1/batches/{batch['id']}/cancel").raise_for_status()
    page = opened(browser)
    page.goto(f"{url}/jobs?state=cancelled")
    seconds = []
    for _ in range(10):
        first = page.locator("[aria-busy=false] tr[data-job]").first
        first.wait_for()
        before = first.get_attribute("data-job")
        began = time.perf_counter()
        page.get_by_role("button", name="Older").click()
        page.wait_for_function(
            "(before) => { const row = document.querySelector('[aria-busy=false] tr[data-job]');"
            " return row && row.dataset.job !== before; }",
            arg=before,
        )
        seconds.append(time.perf_counter() - began)
    page.wait_for_timeout(1_000)
    page.evaluate(
        "() => { let by = 20; const go = () => { const before = scrollY; scrollBy(0, by);"
        " if (scrollY === before) by = -by; requestAnimationFrame(go); }; go(); }",
    )
    times = page.evaluate(FRAME_TIMES, 6_000)
    rows = page.locator("tr[data-job]").count()
    page.context.close()
    return {
        "jobs": total,
        "next_page_ms": round(1000 * statistics.median(seconds)),
        "rows": rows,
        **frame_times(times),
    }


def looked_at(browser: Any, url: str, path: Path) -> dict[str, float]:
    """Upload a mesh of many faces, and look at it.

    Seconds until it is drawn, the longest task in which the page does nothing else, and what the page takes at most.
    """
    page = opened(browser)
    page.add_init_script(
        "window.tasks = [];"
        "new PerformanceObserver((list) => tasks.push(...list.getEntries().map((e) => e.duration)))"
        ".observe({ type: 'longtask', buffered: true });"
    )
    page.goto(f"{url}/upload")
    page.get_by_test_id("files").set_input_files(path)
    page.get_by_role("img", name=f"Preview of {path.name}").wait_for()
    button = page.get_by_role("button", name=f"Look at {path.name}").first
    button.wait_for()
    page.wait_for_timeout(1_500)
    before = held(psutil.Process())
    page.evaluate("tasks.length = 0")
    began = time.perf_counter()
    button.click(no_wait_after=True)
    most = until_drawn(page, page.locator("section[aria-label=Mesh][data-status=ready]"), before)
    seconds = time.perf_counter() - began
    faces = page.get_by_text("drawn coarser than it is").inner_text()
    longest = page.evaluate("Math.max(0, ...tasks)")
    page.context.close()
    drawn, whole = (int(re.sub(r"\D", "", number)) for number in faces.split(":")[1].split(" of "))
    return {
        "faces": whole,
        "drawn_faces": drawn,
        "file_mb": round(path.stat().st_size / 1e6),
        "seen_s": round(seconds, 1),
        "longest_task_ms": round(longest),
        "page_most_mb": round(most),
    }


def seen(browser: Any, url: str, job: str) -> dict[str, float]:
    """Open the segmentation of a large volume: seconds until its slices are drawn, and what the page takes at most."""
    page = opened(browser)
    page.goto(f"{url}/jobs")
    page.get_by_text("Progress and outcome").wait_for()
    before = held(psutil.Process())
    began = time.perf_counter()
    page.goto(f"{url}/jobs/{job}", wait_until="commit")
    most = until_drawn(page, page.locator("section[aria-label=Volume][data-status=ready]"), before)
    seconds = time.perf_counter() - began
    after = held(psutil.Process())
    page.context.close()
    return {
        "seen_s": round(seconds, 1),
        "page_most_mb": round(most),
        "page_after_mb": round(after["pages"] - before["pages"]),
        "drawing_after_mb": round(after["drawing"] - before["drawing"]),
    }


def until_drawn(page: Any, ready: Any, before: dict[str, float]) -> float:
    """Wait until something is drawn; return what the page has taken more than before at most, in MB."""
    most = 0.0
    while ready.count() == 0:
        most = max(most, held(psutil.Process())["pages"] - before["pages"])
        page.wait_for_timeout(50)
    page.evaluate("new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))")
    return most


def frame_times(times: Sequence[float]) -> dict[str, float]:
    """Tell how smooth it was from the times between frames (ms)."""
    ordered = sorted(times)
    return {
        "fps": round(1000 * len(times) / sum(times), 1),
        "p95_ms": round(ordered[int(0.95 * len(ordered))], 1),
        "longest_ms": round(ordered[-1], 1),
    }
