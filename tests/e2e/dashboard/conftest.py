"""The dashboard in a real browser, before the real platform."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import httpx
import pytest

from shapery_gateway.dashboard.service import STATIC
from tests.support.browser import Watch, browser
from tests.support.embedded import Embedded, embedded_platform
from tests.support.probe import MODULE as PROBE

READY = 60_000
"""Milliseconds that anything on a page may take on a machine that does other things as well."""


@pytest.fixture(scope="package")
def chrome() -> Iterator[Any]:
    if not (STATIC / "index.html").is_file():
        pytest.skip("the dashboard is not built (make dashboard)")
    with browser() as running:
        yield running


@pytest.fixture(scope="package")
def platform(chrome: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Embedded]:  # the skip comes first
    home = tmp_path_factory.mktemp("platform")
    with embedded_platform(home, plugins=PROBE, retention_interval="1", rate_limit_per_minute="0") as running:
        yield running


@pytest.fixture(scope="package")
def api(platform: Embedded) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=platform.url, timeout=30) as client:
        yield client


@pytest.fixture(scope="package")
def phantom(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a head before and after contrast, and what is known of it (see `shapery_segmentation.phantoms`)."""
    folder = tmp_path_factory.mktemp("phantom")
    coarse = ["--shape", "100", "120", "100", "--spacing", "1.6", "1.6", "1.6"]  # quick to draw without a graphics card
    subprocess.run([sys.executable, "-m", "shapery_segmentation.phantoms", folder, "--seed", "7", *coarse], check=True)
    return folder


OpenPage = Callable[..., Any]


@pytest.fixture
def open_page(chrome: Any, platform: Embedded) -> Iterator[OpenPage]:
    """Opens a page of the dashboard in a browser profile of its own.

    At the end no page may have had an error that the test did not expect, or have asked any other host.
    """
    watches: list[Watch] = []
    with ExitStack() as contexts:

        def open_it(path: str, *, base: str = platform.url, before: Callable[[Any], None] | None = None,
                    **options: Any) -> Any:  # fmt: skip
            context = chrome.new_context(viewport={"width": 1280, "height": 720}, **options)
            contexts.callback(context.close)
            context.set_default_timeout(READY)
            page = context.new_page()
            watch = Watch(page)
            watches.append(watch)
            page.watch = watch
            if before is not None:
                before(page)
            page.goto(f"{base}{path}")
            return page

        yield open_it
        for watch in watches:
            assert watch.unexpected == []
            assert all(host.startswith("127.0.0.1:") for host in watch.hosts)


Probe = Callable[..., str]


@pytest.fixture
def probe(api: httpx.Client) -> Probe:
    """Starts a job that does what it is told, and gives its id."""

    def start(**params: Any) -> str:
        answer = api.post("/v1/jobs", json={"kind": "probe", "inputs": {}, "params": params})
        answer.raise_for_status()
        return str(answer.json()["id"])

    return start
