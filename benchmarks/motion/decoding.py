"""How motion files open and play: in Python, and in the browser with the dashboard's decoder."""

from __future__ import annotations

import base64
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.dashboard.browser import chromium, opened, processes
from benchmarks.motion.case import DATA, RESULTS, ROOT, load
from shapery_contracts.motion import MotionEncodeParams
from shapery_geometry.sequence import MeshSequence
from shapery_motion import encode, open_motion
from shapery_motion.container.connectivity import pack_connectivity, sorted_faces
from shapery_motion.container.sections import CONNECTIVITY, pack_section

KEPT = RESULTS / "motion" / "decoding.json"
DASHBOARD = ROOT / "services" / "dashboard"
OPENINGS = 3
LONG = ("chickenCrossing", 50)
"""Whose first group of so many frames is held against all its groups: memory must not grow with them."""

PEAK = """
import sys
from pathlib import Path
from shapery_motion import open_motion
for frame in open_motion(sys.argv[1]).frames():
    pass
print(next(line.split()[1] for line in Path("/proc/self/status").read_text().splitlines() if "VmHWM" in line))
"""
"""Decodes a file and tells the most that its process held, in KB."""

OPEN = """(text) => {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const start = performance.now();
  window.motion = new smc.Motion(bytes);
  window.frame = window.motion.frame(0).slice();
  return (performance.now() - start) / 1000;
}"""
PLAY = "(order) => { for (const index of order) window.motion.frame(index, window.frame); }"
TURNS = 5
"""How often all frames are given: the first time compiles, the others are measured."""


def measure(names: Sequence[str]) -> None:
    """Measure files of the default setting, and keep what was found."""
    with tempfile.TemporaryDirectory() as folder:
        script = _bundled(Path(folder) / "smc.js")
        files = {name: _encoded(name) for name in names}
        rows = {name: _in_python(place) for name, place in files.items()}
        with chromium() as browser:
            for name, place in files.items():
                rows[name]["browser"] = _in_browser(browser, script, place, rows[name]["frames"])
            version = browser.version
        memory = _memory(Path(folder))
    found = {"sequences": rows, "browser": version, "memory": memory, "connectivity": _connectivity()}
    KEPT.write_text(json.dumps(found, indent=1) + "\n")


def place_of(name: str) -> Path:
    """Return where the file of a sequence at the default setting is kept."""
    return KEPT.parent / f"{name}.smc"


def _encoded(name: str) -> Path:
    """Return that file; it is made where the rates were not measured here."""
    place = place_of(name)
    if not place.exists():
        case = load(name)
        place.write_bytes(encode(MeshSequence(case.frames.astype(np.float32), case.faces)).data)
    return place


def _order(frames: int) -> list[int]:
    return [int(index) for index in np.random.default_rng(0).permutation(frames)]


def _in_python(place: Path) -> dict[str, Any]:
    """Return CPU times: the median opening up to the first frame, and frames of the open group in any order."""
    firsts = []
    open_motion(place).frame(0)  # loads what is compiled
    for _ in range(OPENINGS):
        start = time.process_time()
        motion = open_motion(place)
        motion.frame(0)
        firsts.append(time.process_time() - start)
    assert len(motion.groups) == 1
    taken = []
    for index in _order(len(motion)):
        start = time.process_time()
        motion.frame(index)
        taken.append(time.process_time() - start)
    return {
        "frames": len(motion),
        "vertices": motion.header.vertices,
        "first_cpu_seconds": statistics.median(firsts),
        "frame_cpu_seconds": statistics.mean(taken),
        "longest_frame_cpu_seconds": max(taken),
    }


def _bundled(place: Path) -> str:
    """Return the dashboard's decoder as one script."""
    source = DASHBOARD / "src" / "features" / "motion" / "smc" / "motion.ts"
    bundler = DASHBOARD / "node_modules" / ".bin" / "rolldown"
    subprocess.run(
        [bundler, source, "--format", "iife", "--name", "smc", "--file", place],
        check=True,
        cwd=DASHBOARD,
        stdout=subprocess.DEVNULL,
    )
    return place.read_text()


def _in_browser(browser: Any, script: str, place: Path, frames: int) -> dict[str, float]:
    """Return the processor time that pages take for the first frame, and for any frame of the open group."""
    page = opened(browser)
    page.add_script_tag(content=script)
    text, order = base64.b64encode(place.read_bytes()).decode(), _order(frames)
    clock: list[float] = []
    first = _taken(lambda: clock.append(page.evaluate(OPEN, text)))
    page.evaluate(PLAY, order)
    all_frames = _taken(lambda: page.evaluate(PLAY, order * (TURNS - 1)))
    page.context.close()
    return {
        "first_cpu_seconds": first,
        "first_seconds": clock[0],
        "frame_cpu_seconds": all_frames / (len(order) * (TURNS - 1)),
    }


def _taken(action: Callable[[], object]) -> float:
    """Return the processor time that the main threads of pages take for an action."""

    def seconds() -> dict[int, float]:
        return {
            thread.id: thread.user_time + thread.system_time
            for process in processes("--type=renderer")
            for thread in process.threads()
            if thread.id == process.pid
        }

    before = seconds()
    action()
    return sum(total - before.get(pid, 0.0) for pid, total in seconds().items())


def _connectivity() -> dict[str, float]:
    """Return the bits a vertex that the faces of every mesh of the data take, the order of vertices kept."""
    found = {}
    for place in sorted(DATA.glob("*.npz")):
        with np.load(place) as stored:
            vertices = stored["vertices"].shape[1]
            packed = pack_section(CONNECTIVITY, pack_connectivity(vertices, sorted_faces(stored["faces"])))
        found[place.stem] = 8 * len(packed) / vertices
    return found


def _memory(folder: Path) -> list[dict[str, Any]]:
    """Return the most that a process holds which decodes one group of frames, and which decodes all."""
    name, frames = LONG
    case = load(name)
    rows = []
    for count in (frames, len(case.frames)):
        place = folder / f"{count}.smc"
        sequence = MeshSequence(case.frames[:count].astype(np.float32), case.faces)
        place.write_bytes(encode(sequence, MotionEncodeParams(preset="fast", group_frames=frames)).data)
        run = subprocess.run([sys.executable, "-c", PEAK, place], check=True, capture_output=True, text=True)
        rows.append({"sequence": name, "frames": count, "peak_megabytes": int(run.stdout) / 1024})
    return rows
