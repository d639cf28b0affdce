"""A Chromium that is spoken to over a pipe, in the DevTools protocol, without anything that is not asked for.

Playwright listens to the network of each page. For whoever does, Chromium keeps the body of every response in the
page's process (200 MB at the most), so that a page that looks at files seems to grow by them. Here nobody listens.
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any


class Page:
    """A page, by the session that is attached to it."""

    def __init__(self, browser: BareChromium, session: str) -> None:
        self._browser = browser
        self._session = session

    def send(self, method: str, **params: Any) -> dict[str, Any]:
        """Call a method of the protocol, and return what it returns."""
        return self._browser.send(method, self._session, **params)

    def heap_snapshot(self) -> dict[str, Any]:
        """Return what is in the heap of the page's scripts, once garbage is collected, in DevTools' format."""
        self.send("HeapProfiler.takeHeapSnapshot", reportProgress=False)
        told = [
            event["params"] for event in self._browser.meanwhile if event["method"].endswith("addHeapSnapshotChunk")
        ]
        found: dict[str, Any] = json.loads("".join(part["chunk"] for part in told))
        return found

    def evaluate(self, script: str, *given: Any) -> Any:
        """Call a function written in JavaScript, wait for what it promises, and return that.

        Raises ``RuntimeError`` with what it threw.
        """
        call = f"({script})({', '.join(json.dumps(one) for one in given)})"
        told = self.send("Runtime.evaluate", expression=call, awaitPromise=True, returnByValue=True, userGesture=True)
        if "exceptionDetails" in told:
            raise RuntimeError(json.dumps(told["exceptionDetails"]))
        return told["result"].get("value")


class BareChromium:
    """A running browser: what goes to it and what comes back are lines of JSON that end with a zero byte."""

    def __init__(self, process: subprocess.Popen[bytes], commands: int, answers: int) -> None:
        self.process = process
        self._commands = commands
        self._answers = answers
        self._last = 0
        self._rest = b""
        self.meanwhile: list[dict[str, Any]] = []
        """Events that came while the last method ran."""

    def send(self, method: str, session: str | None = None, **params: Any) -> dict[str, Any]:
        """Call a method of the protocol, of the browser or of a session.

        Raises ``RuntimeError`` with the browser's own words where it refuses, ``ConnectionError`` where it has ended.
        """
        self._last += 1
        self.meanwhile.clear()
        message = {"id": self._last, "method": method, "params": params, **({"sessionId": session} if session else {})}
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        while True:
            answer = json.loads(self._read())
            if "method" in answer:
                self.meanwhile.append(answer)
            if answer.get("id") != self._last:
                continue
            if "error" in answer:
                raise RuntimeError(f"{method}: {answer['error']}")
            result: dict[str, Any] = answer["result"]
            return result

    def open(self, url: str, width: int, height: int) -> Page:
        """Open a page of a size in CSS pixels in a tab of its own."""
        target = self.send("Target.createTarget", url=url)["targetId"]
        page = Page(self, self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"])
        page.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        return page

    def _read(self) -> bytes:
        while b"\0" not in self._rest:
            part = os.read(self._answers, 1 << 16)
            if not part:
                raise ConnectionError("the browser has ended")
            self._rest += part
        line, _, self._rest = self._rest.partition(b"\0")
        return line


@contextmanager
def bare_chromium(path: str, arguments: Sequence[str]) -> Iterator[BareChromium]:
    """Run a Chromium with a profile of its own, and end it afterwards."""
    its_commands, commands = os.pipe()
    answers, its_answers = os.pipe()

    def connect() -> None:
        # It reads from its descriptor 3 and writes to 4; neither may be overwritten before it is copied.
        low, high = os.dup(its_commands), os.dup(its_answers)
        os.dup2(low, 3)
        os.dup2(high, 4)

    with tempfile.TemporaryDirectory() as profile:
        process = subprocess.Popen(
            [path, *arguments, "--remote-debugging-pipe", f"--user-data-dir={Path(profile)}", "--no-first-run"],
            preexec_fn=connect,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(its_commands)
        os.close(its_answers)
        browser = BareChromium(process, commands, answers)
        try:
            yield browser
            browser.send("Browser.close")
            process.wait(30)
        finally:
            if process.poll() is None:
                process.kill()
                process.wait(30)
            os.close(commands)
            os.close(answers)
