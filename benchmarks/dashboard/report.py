"""What was measured, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

PARTS = ("loads", "viewers", "playback", "wall", "memory", "jobs", "large", "mesh")


def table(heads: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Write a table in Markdown."""
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def report(found: dict[str, Any]) -> str:
    """Tell in words what was measured."""
    played, wall, jobs, held, large, mesh = (
        found[name]["found"] for name in ("playback", "wall", "jobs", "memory", "large", "mesh")
    )
    loads = [(name, *one.values()) for name, one in found["loads"]["found"].items()]
    viewers = [(name, *one.values()) for name, one in found["viewers"]["found"].items()]
    kinds = held["heap_kb_per_view"]
    memories = [
        (name, ", ".join(map(str, held[key]["every_tenth"])), held[key]["kb_per_view"])
        for name, key in (("heap", "heap_mb"), ("page process", "pages_mb"), ("drawing process", "drawing_mb"))
    ]
    conditions = ", ".join(f"{name} {found[name]['load']}" for name in PARTS)
    versions = " and ".join(sorted({part["browser"] for part in found.values()}))
    return f"""# The dashboard

Embedded profile, headless Chromium {versions} that draws by the processor (SwiftShader) on a machine of
{found["loads"]["processors"]} processors without a graphics card, 1280 × 720, an empty cache. The machine's
load when each part's run began: {conditions}.

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
{jobs["jobs"]:,} jobs the next page of their list is there after {jobs["next_page_ms"]} ms, and its {jobs["rows"]} rows
scroll at {jobs["fps"]} frames/s, {jobs["p95_ms"]} ms at the 95th percentile, {jobs["longest_ms"]} ms at the most.

A volume of 512 × 512 × 512 voxels is seen after {large["seen_s"]} s, its download included; meanwhile the page takes
{large["page_most_mb"]} MB at the most, and afterwards {large["page_after_mb"]} MB, the process that draws
{large["drawing_after_mb"]} MB. An uploaded mesh of {mesh["faces"]:,} faces ({mesh["file_mb"]} MB) is seen after
{mesh["seen_s"]} s, as {mesh["drawn_faces"]:,} faces; meanwhile the page stands still for {mesh["longest_task_ms"]} ms
at the most, and takes {mesh["page_most_mb"]} MB at the most.

Memory over {held["views"]} views of a segmentation, a motion and a shape in turn, garbage collected after each, in a
browser that nobody watches (to whoever listens to the network of a page, Chromium keeps what the page has loaded: 3 MB
a view of the segmentation); of processes what they hold for themselves, without what is read from files. MB after every
tenth view, and kB a view as the median slope between any two views of the second half (Theil and Sen): the process that
draws keeps buffers of megabytes at hand, which come and go. Nodes of documents went from {held["nodes"][1]} at half to
{held["nodes"][2]}. In half as many views more, of what the heap holds, objects of scripts grew by
{kinds["objects"]} kB a view and the browser's own by {kinds["native"]}; the engine, which goes on compiling what runs
often, kept {kinds["code"]} kB of code a view.

{table(("memory", "MB after every tenth view", "kB a view"), memories)}
"""
