"""What views of pages leave behind."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import psutil

from benchmarks.dashboard.bare_chromium import bare_chromium
from benchmarks.dashboard.browser import BROWSER, PROCESSES, SIZE, executable, held

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

KINDS = ("code", "native")
"""Nodes of a heap snapshot that no script has made: compiled functions, and the browser's own."""


def memory(url: str, paths: Sequence[str], views: int) -> dict[str, Any]:
    """Go to and fro between pages with viewers and the list of jobs, all within one page; memory after each view.

    Of processes it is what they hold for themselves. What it is that grows in the heap is told by half as many views
    more, before and after which all of it is listed (which takes memory, too): as long as scripts run, the engine
    compiles what runs often, and keeps the code.
    """
    half = views // 2
    with bare_chromium(executable(), BROWSER) as browser:
        page = browser.open(f"{url}/jobs", SIZE["width"], SIZE["height"])
        time.sleep(2)
        heaps, nodes = [], []
        process = psutil.Process(browser.process.pid)
        taken: dict[str, list[float]] = {name: [] for name in PROCESSES.values()}
        for view in range(1, views + 1):
            page.evaluate(VIEW, paths[view % len(paths)])
            page.send("HeapProfiler.collectGarbage")
            heaps.append(page.send("Runtime.getHeapUsage")["usedSize"] / 1e6)
            nodes.append(page.send("Memory.getDOMCounters")["nodes"])
            for name, megabytes in held(process).items():
                taken[name].append(megabytes)
        before = by_kind(page.heap_snapshot())
        for view in range(half):
            page.evaluate(VIEW, paths[view % len(paths)])
        after = by_kind(page.heap_snapshot())
    return {
        "views": views,
        "nodes": [nodes[0], nodes[half - 1], nodes[-1]],
        "heap_mb": growth(heaps, half),
        "heap_kb_per_view": {kind: round((after[kind] - before[kind]) / half / 1e3, 1) for kind in after},
        **{f"{name}_mb": growth(megabytes, half) for name, megabytes in taken.items()},
    }


def by_kind(snapshot: dict[str, Any]) -> dict[str, int]:
    """Tell the bytes of a heap by what they are for: code, the browser's own, and objects of scripts."""
    meta = snapshot["snapshot"]["meta"]
    fields = meta["node_fields"]
    nodes = np.reshape(snapshot["nodes"], (-1, len(fields)))
    sizes = nodes[:, fields.index("self_size")]
    kinds = np.array(meta["node_types"][0])[nodes[:, fields.index("type")]]
    found = {kind: int(sizes[kinds == kind].sum()) for kind in KINDS}
    return {**found, "objects": int(sizes.sum()) - sum(found.values())}


def growth(values: Sequence[float], settled: int) -> dict[str, Any]:
    """Tell how something grows from view to view: every tenth value, and the slope once caches are filled."""
    return {
        "every_tenth": [round(value, 1) for value in values[9::10]],
        "kb_per_view": round(1000 * slope(values[settled:]), 1),
    }


def slope(values: Sequence[float]) -> float:
    """Return how much values grow in a step: the median over all pairs (Theil and Sen).

    The process that draws takes and gives back buffers of megabytes for what it keeps at hand, and a line of least
    squares follows those.
    """
    at = np.arange(len(values))
    one, other = np.triu_indices(len(values), 1)
    return float(np.median((np.asarray(values)[other] - np.asarray(values)[one]) / (at[other] - at[one])))
