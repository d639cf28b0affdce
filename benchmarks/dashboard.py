"""``python -m benchmarks.dashboard``: what the dashboard costs whoever looks at it.

Starts the platform as ``shapery up`` does, in a folder of its own, gives it a segmentation, a motion of 10,000 vertices
and a shape, and looks at them in a headless Chromium that draws by the processor:

- first load: bytes over the network page by page, and the time until a page can be used, with an empty cache;
- playback: frames per second of the motion, and the time that decoding one frame takes in the player's thread;
- lists: 10,000 shapes are scrolled through, and 10,000 jobs are paged;
- large: the time until a volume of 512 voxels along each axis is seen, and the memory that it takes;
- memory: what 100 views of jobs and shapes with their viewers leave behind, garbage collected.

Writes ``benchmarks/results/dashboard.json`` and ``.md``. The dashboard has to be built (``make setup``).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import psutil

from benchmarks.bare_chromium import bare_chromium
from benchmarks.search_over_http import RESULTS, platform
from shapery_client import Client
from shapery_contracts.states import JobState
from shapery_gateway.dashboard.service import STATIC
from shapery_geometry.mesh import icosphere
from shapery_geometry.mesh_io import write_mesh
from shapery_geometry.sequence import write_sequence_npz
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import write_nifti

BROWSER = [
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
]
SIZE = {"width": 1280, "height": 720}
PAGES = {
    "Start": ("/", "Recent work"),
    "Upload": ("/upload", "Drop volumes here"),
    "Jobs": ("/jobs", "Progress and outcome"),
    "Batches": ("/batches", "No batches yet"),
    "Shapes": ("/shapes", "All shapes"),
    "Motion": ("/motion", "Quality"),
    "Settings": ("/settings", "Make a key"),
}
"""Pages without a viewer: their paths, and a text that is there once they can be used."""
PARTS = ("loads", "viewers", "playback", "wall", "memory", "jobs", "large")
FPS = 60
PROCESSES = {"--type=renderer": "pages", "--type=gpu-process": "drawing"}
"""What the browser's processes are told to be, and what they do."""


def executable() -> str:
    """Return the path of the browser that ``SHAPERY_TEST_CHROMIUM`` names, or of the system's."""
    path = os.environ.get("SHAPERY_TEST_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    if path is None:
        raise FileNotFoundError("no Chromium: SHAPERY_TEST_CHROMIUM names one")
    return path


@contextmanager
def chromium() -> Iterator[Any]:
    """Start a browser."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=executable(), args=BROWSER)
        try:
            yield running
        finally:
            running.close()


def ball(frames: int) -> tuple[Any, Any]:
    """Return a ball of 10,000 vertices that is dented in another way in each frame: (frames, n, 3) and (m, 3)."""
    polar, around = np.meshgrid(np.linspace(0.02, np.pi - 0.02, 100), np.arange(100) * 2 * np.pi / 100)
    polar, around = polar.T.reshape(-1), around.T.reshape(-1)
    rest = np.stack((np.sin(polar) * np.cos(around), np.cos(polar), np.sin(polar) * np.sin(around)), axis=1)
    t = np.arange(frames)[:, None] / frames
    size = 1 + 0.12 * np.sin(5 * polar + 2 * np.pi * t) * np.cos(3 * around - 4 * np.pi * t)
    at = (np.arange(99)[:, None] * 100 + np.arange(100)).reshape(-1)
    beside = (np.arange(99)[:, None] * 100 + (np.arange(100) + 1) % 100).reshape(-1)
    quads = (np.stack((at, beside, at + 100), axis=1), np.stack((beside, beside + 100, at + 100), axis=1))
    return (rest * size[..., None]).astype(np.float32), np.concatenate(quads).astype(np.int32)


def shells(size: int, path: Path) -> None:
    """Write an ellipsoid of shells and a bright ball, with noise: `size` voxels along each axis, signed 16-bit."""
    rng = np.random.default_rng(0)
    at = np.linspace(-1, 1, size, dtype=np.float32)
    data = np.empty((size, size, size), dtype=np.int16)
    for index, x in enumerate(at):
        away = np.sqrt((x / 0.8) ** 2 + (at[:, None] / 0.9) ** 2 + (at / 0.85) ** 2)
        ball = (x - 0.3) ** 2 + (at[:, None] - 0.1) ** 2 + (at + 0.1) ** 2 < 0.15**2
        plane = np.where(away < 1, 600 + 200 * np.cos(9 * away), 20) + 400 * ball
        data[index] = np.maximum(plane + rng.normal(0, 12, plane.shape), 0)
    write_nifti(Volume(data, np.diag([230 / size, 230 / size, 230 / size, 1.0])), path)


def fill(client: Client, folder: Path, *, large: bool) -> dict[str, str]:
    """Give the platform something to show, also a `large` volume; ids by name."""
    head = folder / "head"
    coarse = ["--shape", "100", "120", "100", "--spacing", "1.6", "1.6", "1.6"]
    subprocess.run(
        [sys.executable, "-m", "shapery_segmentation.phantoms", str(head), "--seed", "7", *coarse], check=True
    )
    write_sequence_npz(folder / "ball.npz", *ball(120), shape=(120, 10_000))
    write_mesh(icosphere(subdivisions=3), folder / "ball.ply")
    post, pre = client.upload(head / "post.nii.gz"), client.upload(head / "pre.nii.gz")
    sequence, mesh = client.upload(folder / "ball.npz"), client.upload(folder / "ball.ply")
    jobs = {
        "segmentation": client.submit("segmentation", {"post": post.id, "pre": pre.id}),
        "motion": client.submit("motion-encode", {"sequence": sequence.id}, {"kg": 0.5, "preset": "fast", "fps": FPS}),
        "index": client.submit("shape-index", {"mesh": mesh.id}),
    }
    if large:
        shells(512, folder / "large.nii.gz")
        volume = client.upload(folder / "large.nii.gz")
        jobs["large"] = client.submit("segmentation", {"post": volume.id})
    ended = {name: client.wait(job.id) for name, job in jobs.items()}
    failed = {name: job.error for name, job in ended.items() if job.state != JobState.SUCCEEDED}
    if failed:
        raise RuntimeError(f"not ready to be looked at: {failed}")
    return {name: str(job.id) for name, job in ended.items()}


def opened(browser: Any) -> Any:
    """Open a page in a browser profile of its own."""
    page = browser.new_context(viewport=SIZE).new_page()
    page.set_default_timeout(120_000)
    return page


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
    """Make many jobs and call them off, then go through pages of their list."""
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
    page.context.close()
    return {"jobs": total, "next_page_ms": round(1000 * statistics.median(seconds))}


def seen(browser: Any, url: str, job: str) -> dict[str, float]:
    """Open the segmentation of a large volume: seconds until its slices are drawn, and what the page takes at most."""
    page = opened(browser)
    page.goto(f"{url}/jobs")
    page.get_by_text("Progress and outcome").wait_for()
    before = held(psutil.Process())
    began = time.perf_counter()
    page.goto(f"{url}/jobs/{job}", wait_until="commit")
    drawn = page.locator("section[aria-label=Volume][data-status=ready]")
    most = 0.0
    while drawn.count() == 0:
        most = max(most, held(psutil.Process())["pages"] - before["pages"])
        page.wait_for_timeout(50)
    page.evaluate("new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))")
    seconds = time.perf_counter() - began
    after = held(psutil.Process())
    page.context.close()
    return {
        "seen_s": round(seconds, 1),
        "page_most_mb": round(most),
        "page_after_mb": round(after["pages"] - before["pages"]),
        "drawing_after_mb": round(after["drawing"] - before["drawing"]),
    }


def held(above: psutil.Process) -> dict[str, float]:
    """Tell what is held by the browser's processes below one, and by them alone, in MB."""
    return {
        name: sum(process.memory_full_info().uss for process in processes(kind, above)) / 1e6
        for kind, name in PROCESSES.items()
    }


def frame_times(times: Sequence[float]) -> dict[str, float]:
    """Tell how smooth it was from the times between frames (ms)."""
    ordered = sorted(times)
    return {
        "fps": round(1000 * len(times) / sum(times), 1),
        "p95_ms": round(ordered[int(0.95 * len(ordered))], 1),
        "longest_ms": round(ordered[-1], 1),
    }


VIEW = """
async (path) => {
    const until = async (there) => {
        for (let waited = 0; !there(); waited += 20) {
            if (waited > 120_000) throw new Error(`${path} is not there`);
            await new Promise((resolve) => setTimeout(resolve, 20));
        }
    };
    const go = (to) => {
        history.pushState({}, "", to);
        dispatchEvent(new PopStateEvent("popstate"));
    };
    go(path);
    await until(() => document.querySelector("section[data-status=ready]"));
    await new Promise((resolve) => setTimeout(resolve, 200));
    go("/jobs");
    await until(() => document.body.textContent.includes("Progress and outcome"));
}
"""


def memory(url: str, paths: Sequence[str], views: int) -> dict[str, Any]:
    """Go to and fro between pages with viewers and the list of jobs, all within one page; memory after each view.

    Of processes it is what is theirs alone: shared libraries and files that are mapped count for nothing.
    """
    with bare_chromium(executable(), BROWSER) as browser:
        page = browser.open(f"{url}/jobs", SIZE["width"], SIZE["height"])
        time.sleep(2)
        heaps, nodes = [], []
        process = psutil.Process(browser.process.pid)
        taken: dict[str, list[float]] = {name: [] for name in PROCESSES.values()}
        for view in range(views):
            page.evaluate(VIEW, paths[view % len(paths)])
            page.send("HeapProfiler.collectGarbage")
            heaps.append(page.send("Runtime.getHeapUsage")["usedSize"] / 1e6)
            nodes.append(page.send("Memory.getDOMCounters")["nodes"])
            for name, megabytes in held(process).items():
                taken[name].append(megabytes)
    half = views // 2
    return {
        "views": views,
        "nodes": [nodes[0], nodes[half], nodes[-1]],
        "heap_mb": growth(heaps, half),
        **{f"{name}_mb": growth(megabytes, half) for name, megabytes in taken.items()},
    }


def growth(values: Sequence[float], settled: int) -> dict[str, Any]:
    """Tell how something grows from view to view: every tenth value, and the slope once caches are filled."""
    return {
        "every_tenth": [round(value, 1) for value in values[9::10]],
        "kb_per_view": round(1000 * slope(values[settled:]), 1),
    }


def processes(kind: str, above: psutil.Process | None = None) -> Iterator[psutil.Process]:
    """Find the browser's processes of a kind, below a process or this one."""
    for child in (above or psutil.Process()).children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            if kind in child.cmdline():
                yield child


def processor_seconds() -> float:
    """Return the processor time that the processes that run and draw pages have taken."""
    times = [process.cpu_times() for kind in PROCESSES for process in processes(kind)]
    return sum(one.user + one.system for one in times)


def slope(values: Sequence[float]) -> float:
    """Return how much values grow in a step."""
    return float(np.polyfit(np.arange(len(values)), values, 1)[0])


def table(heads: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Write a table in Markdown."""
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def report(found: dict[str, Any]) -> str:
    """Tell in words what was measured."""
    played, wall, jobs, held, large = (found[name]["found"] for name in ("playback", "wall", "jobs", "memory", "large"))
    loads = [(name, *one.values()) for name, one in found["loads"]["found"].items()]
    viewers = [(name, *one.values()) for name, one in found["viewers"]["found"].items()]
    memories = [
        (name, ", ".join(map(str, held[key]["every_tenth"])), held[key]["kb_per_view"])
        for name, key in (("heap", "heap_mb"), ("page process", "pages_mb"), ("drawing process", "drawing_mb"))
    ]
    conditions = ", ".join(f"{name} {found[name]['load']}" for name in PARTS)
    versions = " and ".join(sorted({part["browser"] for part in found.values()}))
    return f"""# The dashboard

Embedded profile, headless Chromium {versions} that draws by the processor (SwiftShader) on a machine of
{found["loads"]["processors"]} processors without a graphics card, 1280 × 720, an empty cache. Others worked on the
machine: its load before each part was {conditions}.

Pages without a viewer: what goes over the network, compressed; the time until the page can be used (its content is
there, and no task of more than 50 ms has run since); and how long the main thread was busy. Medians.

{table(("page", "kB", "usable after s", "main thread s"), loads)}

Pages with a viewer: scripts, styles and fonts, and all with the data that is shown.

{table(("page", "app kB", "all kB"), viewers)}

Playback at 10,000 vertices, {played["asked_fps"]} frames/s asked for: {played["shown_fps"]} frames/s shown, at
{played["cpu_ms_per_frame"]} ms of processor time a frame in the browser's page and drawing processes together. Opening
the file takes {played["open_ms"]} ms, decoding a frame {played["decode_ms"]} ms in the player's thread; the
rest is drawing.

A wall of {wall["rows"]:,} shapes, scrolled through its middle: {wall["fps"]} frames/s, {wall["p95_ms"]} ms between
frames at the 95th percentile, {wall["longest_ms"]} ms at the most, {wall["elements"]} elements in the page. With
{jobs["jobs"]:,} jobs the next page of their list is there after {jobs["next_page_ms"]} ms.

A volume of 512 × 512 × 512 voxels is seen after {large["seen_s"]} s, its download included; meanwhile the page takes
{large["page_most_mb"]} MB at the most, and afterwards {large["page_after_mb"]} MB, the process that draws
{large["drawing_after_mb"]} MB.

Memory over {held["views"]} views of a segmentation, a motion and a shape in turn, garbage collected after each, in a
browser that nobody watches (to whoever listens to the network of a page, Chromium keeps what the page has loaded: 3 MB
a view of the segmentation); of processes what is theirs alone. MB after every tenth view, and kB a view by a line
through the second half. Nodes of documents went from {held["nodes"][1]} at half to {held["nodes"][2]}.

{table(("memory", "MB after every tenth view", "kB a view"), memories)}
"""


def main() -> None:
    """Measure everything and write it down."""
    parser = argparse.ArgumentParser(description="Measure the dashboard in a browser.")
    parser.add_argument("--rounds", type=int, default=5, help="loads of each page")
    parser.add_argument("--views", type=int, default=100, help="views over which memory is watched")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS, help="what is measured; the rest stays")
    parser.add_argument("--jobs", type=int, default=10_000, help="jobs in the list, and shapes on the wall")
    options = parser.parse_args()
    load = os.getloadavg()[0]
    written = RESULTS / "dashboard.json"
    found: dict[str, Any] = json.loads(written.read_text()) if written.is_file() else {}
    os.environ["SHAPERY_RATE_LIMIT_PER_MINUTE"] = "0"
    with tempfile.TemporaryDirectory() as folder, platform(Path(folder)) as (url, _), Client(url) as client:
        ids = fill(client, Path(folder), large="large" in options.only)
        [shape] = httpx.get(f"{url}/v1/shapes").raise_for_status().json()["items"]
        with chromium() as browser:
            conditions = {"browser": browser.version, "processors": os.cpu_count(), "load": round(load, 1)}
            viewers = {
                "Segmentation": f"/jobs/{ids['segmentation']}",
                "Motion": f"/jobs/{ids['motion']}",
                "Shape": f"/shapes/{shape['id']}",
            }
            rounds = options.rounds
            parts: dict[str, Callable[[], dict[str, Any]]] = {
                "loads": lambda: {name: first_load(browser, url, *page, rounds) for name, page in PAGES.items()},
                "viewers": lambda: {name: viewed(browser, url, path) for name, path in viewers.items()},
                "playback": lambda: playback(browser, url, ids["motion"]),
                "wall": lambda: scrolled(browser, url, shape, options.jobs),
                "memory": lambda: memory(url, list(viewers.values()), options.views),
                "large": lambda: seen(browser, url, ids["large"]),
                "jobs": lambda: paged(browser, url, shape["asset_id"], options.jobs),
            }
            for name in options.only:
                found[name] = {"found": parts[name](), **conditions}
                print(name, json.dumps(found[name]), flush=True)
    written.write_text(json.dumps(found, indent=2) + "\n")
    if all(name in found for name in PARTS):
        written.with_suffix(".md").write_text(report(found))


if __name__ == "__main__":
    main()
