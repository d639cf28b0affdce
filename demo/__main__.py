"""``python -m demo``: start the platform, recover a tumor over HTTP, and leave the dashboard open."""

from __future__ import annotations

import argparse
import contextlib
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console
from rich.table import Table

from demo.comparison import compare
from shapery_client import Client, JobEndedBadly
from shapery_client.cli._following import follow
from shapery_client.cli._output import transfer_bar
from shapery_contracts.api import AssetView, JobView
from shapery_contracts.errors import ShaperyError
from shapery_contracts.segmentation import SegmentationResult
from shapery_geometry.mask_metrics import MaskMetrics

HOME = Path(".shapery") / "demo"
"""Everything the demo keeps; a second run finds its phantom there."""
PHANTOM_SEED = 7

console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)


def main() -> int:
    """Run the demo; returns 0 when the job succeeded."""
    arguments = parse_arguments()
    home: Path = arguments.home.absolute()
    home.mkdir(parents=True, exist_ok=True)
    post, pre, truth = volumes(arguments, home)
    with platform(home, arguments.port) as address:
        with Client(address) as client:
            try:
                job = run_job(client, post, pre)
            except JobEndedBadly as error:
                console.print(f"[bold red]The job did not succeed.[/] {error}")
                return 1
            results = home / "results"
            client.download(job, results)
        show(job, results, truth)
        page = f"{address}/jobs/{job.id}"
        if arguments.once:
            console.print(f"[dim]The dashboard showed it at {page}[/]")
            return 0
        console.print(f"\nSee it in the dashboard: [bold]{page}[/]   (Ctrl-C stops the platform)")
        with contextlib.suppress(KeyboardInterrupt):
            signal.pause()
    return 0


def parse_arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m demo", description=__doc__)
    parser.add_argument(
        "--once", action="store_true", help="leave after the results instead of keeping the dashboard open"
    )
    parser.add_argument("--pre", type=Path, help="a real T1 volume before contrast")
    parser.add_argument("--post", type=Path, help="a real T1 volume after contrast")
    parser.add_argument("--home", type=Path, default=HOME, help="folder for everything the demo keeps")
    parser.add_argument("--port", type=int, default=0, help="port of the dashboard; by default a free one")
    arguments = parser.parse_args()
    if arguments.pre is not None and arguments.post is None:
        parser.error("a volume before contrast needs the one after it: give VOLUME_POST too")
    for path in (arguments.pre, arguments.post):
        if path is not None and not path.exists():
            parser.error(f"{path} does not exist")
    return arguments


def volumes(arguments: argparse.Namespace, home: Path) -> tuple[Path, Path | None, Path | None]:
    """Return the volumes after and before contrast, and the truth where it is known."""
    if arguments.post is not None:
        return arguments.post, arguments.pre, None
    folder = home / "phantom"
    names = [folder / name for name in ("post.nii.gz", "pre.nii.gz", "truth.nii.gz")]
    if not all(path.exists() for path in names):
        console.print("generating a head phantom with a tumor …")
        command = [sys.executable, "-m", "shapery_segmentation.phantoms", str(folder), "--seed", str(PHANTOM_SEED)]
        subprocess.run(command, check=True)
    return names[0], names[1], names[2]


@contextlib.contextmanager
def platform(home: Path, port: int) -> Iterator[str]:
    """Run the embedded platform; yields its address."""
    console.print("starting the platform: Redis, gateway, one worker per service, reaper …")
    command = [sys.executable, "-m", "shapery_worker", "up", "--home", str(home / "platform"), "--port", str(port)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
    try:
        yield wait_for_address(process)
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def wait_for_address(process: subprocess.Popen[str]) -> str:
    """Read the supervisor's output until it tells the address, and keep reading so that it never blocks."""
    assert process.stdout is not None
    told = []
    for line in process.stdout:
        told.append(line)
        found = re.search(r"ready at (http://\S+)", line)
        if found:
            threading.Thread(target=process.stdout.read, daemon=True).start()
            return found.group(1)
    raise ShaperyError("The platform did not start:\n" + "".join(told[-20:]))


def run_job(client: Client, post: Path, pre: Path | None) -> JobView:
    """Upload the volumes, run the segmentation, and return the ended job."""
    inputs = {"post": upload(client, post).id}
    if pre is not None:
        inputs["pre"] = upload(client, pre).id
    job = client.submit("segmentation", inputs)
    return follow(client, job, "segmentation")


def upload(client: Client, path: Path) -> AssetView:
    """Upload a file with a progress bar."""
    with transfer_bar() as bars:
        task = bars.add_task(f"upload {path.name}", total=path.stat().st_size)
        return client.upload(path, progress=lambda done, _: bars.update(task, completed=done))


def show(job: JobView, results: Path, truth: Path | None) -> None:
    """Print what was found, and how far it agrees with the truth."""
    report = SegmentationResult.model_validate(job.result)
    table = Table(box=None, header_style="bold", title="\nWhat was found", title_justify="left", title_style="bold")
    for column in ("object", "confidence", "enhancing ml", "core ml", "area cm²", "faces", "self-intersections"):
        table.add_column(column, justify="right")
    for item in report.objects:
        table.add_row(
            str(item.label),
            f"{item.confidence:.2f}",
            f"{item.volume_mm3 / 1000:.2f}",
            f"{item.core_volume_mm3 / 1000:.2f}",
            f"{item.area_mm2 / 100:.1f}",
            str(item.faces),
            str(item.self_intersections),
        )
    console.print(table if report.objects else "\nNo enhancing tumor was found.")
    for warning in report.warnings:
        console.print(f"[yellow]note[/] {warning}")
    if truth is not None:
        show_agreement(compare(results / "labels.nii.gz", truth))
    seconds = sum(stage.seconds for stage in report.stages)
    console.print(f"\n{seconds:.1f} s of work; labels, surfaces and report are in {results}")


def show_agreement(parts: dict[str, MaskMetrics]) -> None:
    """Print the measures against the known truth."""
    table = Table(box=None, header_style="bold", title="\nAgainst the truth", title_justify="left", title_style="bold")
    for column in ("part", "IoU", "Dice", "mean distance mm", "95 % distance mm", "true ml", "found ml"):
        table.add_column(column, justify="left" if column == "part" else "right")
    for part, metrics in parts.items():
        table.add_row(
            part,
            f"{metrics.iou:.3f}",
            f"{metrics.dice:.3f}",
            f"{metrics.assd_mm:.2f}",
            f"{metrics.hd95_mm:.2f}",
            f"{metrics.reference_mm3 / 1000:.2f}",
            f"{metrics.result_mm3 / 1000:.2f}",
        )
    console.print(table)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
    except (ShaperyError, subprocess.CalledProcessError) as error:
        console.print(f"[bold red]error[/] {error}")
        sys.exit(1)
