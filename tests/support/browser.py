"""A real browser for tests: Debian's Chromium without a window, driven by Playwright."""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import urlsplit

import numpy as np
import pytest
from numpy.typing import NDArray

Found = TypeVar("Found")

ARGUMENTS = [
    "--headless=new",
    "--no-sandbox",
    # drawing by the processor: test machines have no graphics card
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    # nothing goes out to the network by itself
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]


def chromium() -> str:
    """Return the browser's path (`SHAPERY_TEST_CHROMIUM` names another), or skip."""
    named = os.environ.get("SHAPERY_TEST_CHROMIUM")
    found = named or shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if found is None:
        pytest.skip("no Chromium on this machine (apt-get install chromium, or set SHAPERY_TEST_CHROMIUM)")
    return found


@contextmanager
def browser() -> Iterator[Any]:
    """Start the browser; skips where Playwright or Chromium is missing."""
    api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    path = chromium()
    with api.sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        try:
            yield running
        finally:
            running.close()


class Watch:
    """What went wrong in a page without being seen, and where it went on the network."""

    def __init__(self, page: Any) -> None:
        self.faults: list[str] = []
        self.hosts: set[str] = set()
        self.allowed: list[str] = []
        """Patterns of messages that the test provokes."""
        page.on("console", lambda message: message.type == "error" and self._told(message))
        page.on("pageerror", lambda error: self.faults.append(str(error)[:500]))
        page.on("request", self._request)

    def _told(self, message: Any) -> None:
        self.faults.append(f"{message.text[:500]} {message.location.get('url', '')}".strip())

    def _request(self, request: Any) -> None:
        parts = urlsplit(request.url)
        if parts.scheme not in {"blob", "data"}:
            self.hosts.add(parts.netloc)

    @property
    def unexpected(self) -> list[str]:
        """The faults that no pattern of `allowed` expects."""
        return [text for text in self.faults if not any(re.search(pattern, text) for pattern in self.allowed)]


def until(condition: Callable[[], bool], what: str, seconds: float = 60.0) -> None:
    """Wait until a page that changes by itself is as it should be."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.1)


def eventually(check: Callable[[], Found], seconds: float = 60.0) -> Found:
    """Check a page that changes by itself until it is as it should be; return what the check returns.

    At the end of the time the assertion that fails is raised.
    """
    deadline = time.monotonic() + seconds
    while True:
        try:
            return check()
        except AssertionError:
            if time.monotonic() > deadline:
                raise
        time.sleep(0.1)


def picture(locator: Any) -> NDArray[np.uint8]:
    """Return what an element looks like, (height, width, 3)."""
    import io

    from PIL import Image

    with Image.open(io.BytesIO(locator.screenshot())) as image:
        return np.asarray(image.convert("RGB"))


def keep_picture(page: Any, name: str) -> None:
    """Leave a picture of a page for the docs, where ``SHAPERY_TEST_PICTURES`` names a folder (``docs/images``)."""
    folder = os.environ.get("SHAPERY_TEST_PICTURES")
    if folder:
        page.mouse.move(0, 0)
        page.wait_for_timeout(500)
        page.screenshot(path=Path(folder) / f"{name}.png")


def share_of(pixels: NDArray[np.uint8], *, red: tuple[int, int], green: tuple[int, int], blue: tuple[int, int]) -> Any:
    """Tell which pixels have a color in a box of the color space, (height, width) bool."""
    inside = np.ones(pixels.shape[:2], dtype=bool)
    for channel, (low, high) in enumerate((red, green, blue)):
        inside &= (pixels[..., channel] >= low) & (pixels[..., channel] <= high)
    return inside
