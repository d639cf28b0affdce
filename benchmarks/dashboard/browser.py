"""The browser that looks, and what its processes take."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import psutil

BROWSER = [
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
]
SIZE = {"width": 1280, "height": 720}
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


def opened(browser: Any) -> Any:
    """Open a page in a browser profile of its own."""
    page = browser.new_context(viewport=SIZE).new_page()
    page.set_default_timeout(120_000)
    return page


def processes(kind: str, above: psutil.Process | None = None) -> Iterator[psutil.Process]:
    """Find the browser's processes of a kind, below a process or this one."""
    for child in (above or psutil.Process()).children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            if kind in child.cmdline():
                yield child


def held(above: psutil.Process) -> dict[str, float]:
    """Tell what the process of the page, and the one that draws, hold for themselves, in MB; browser below `above`.

    The page's is the one that has worked most of those that run pages: the browser's own window is such a page, too.
    """
    return {name: private(max(processes(kind, above), key=worked)) / 1e6 for kind, name in PROCESSES.items()}


def worked(process: psutil.Process) -> float:
    """Return the seconds of processor time that a process has taken."""
    times = process.cpu_times()
    return float(times.user + times.system)


def private(process: psutil.Process) -> int:
    """Return a process's own memory in bytes, as Chromium tells its "private footprint".

    It is what stands for no file and is not shared, also where it is swapped. What is read from files counts for
    nothing: it is a process's own only as long as no other browser runs.
    """
    memory = process.memory_full_info()
    return int(memory.rss - memory.shared + memory.swap)


def processor_seconds() -> float:
    """Return the processor time that the processes that run and draw pages have taken."""
    return sum(worked(process) for kind in PROCESSES for process in processes(kind))
