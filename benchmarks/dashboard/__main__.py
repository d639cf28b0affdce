"""``python -m benchmarks.dashboard``: what the dashboard costs whoever looks at it.

Starts the platform as ``shapery up`` does, in a folder of its own, gives it a segmentation, a motion of 10,000 vertices
and a shape, and looks at them in a headless Chromium that draws by the processor:

- first load: bytes over the network page by page, and the time until a page can be used, with an empty cache;
- playback: frames per second of the motion, and the time that decoding one frame takes in the player's thread;
- lists: 10,000 shapes are scrolled through, and 10,000 jobs are paged, and a page of them scrolled;
- large: the time until a volume of 512 voxels along each axis is seen, and the memory that it takes;
- mesh: the same for an uploaded mesh of more than a million faces, and for how long the page stands still;
- memory: what 100 views of jobs and shapes with their viewers leave behind, garbage collected.

Writes ``benchmarks/results/dashboard.json`` and ``.md``. The dashboard has to be built (``make setup``).
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx

from benchmarks.dashboard.browser import chromium
from benchmarks.dashboard.memory import memory
from benchmarks.dashboard.pages import first_load, looked_at, paged, playback, scrolled, seen, viewed
from benchmarks.dashboard.report import PARTS, report
from benchmarks.dashboard.samples import fill, fine
from benchmarks.search_over_http import RESULTS, platform
from shapery_client import Client

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
                "mesh": lambda: looked_at(browser, url, fine(Path(folder) / "fine.stl")),
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
