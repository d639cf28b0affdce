"""How much memory the gateway needs to take in a large file: once resumably, once at once.

Starts the gateway as it is run in earnest, over a local folder, sends a volume of zeros, and prints the peak resident
size of the server's process before and after each upload, the rate, and what asset came of it.

    python benchmarks/upload_memory.py --gib 4
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import httpx

MIB = 1 << 20
TUS = {"Tus-Resumable": "1.0.0"}
READY = "shapery-gateway ready at "


def volume(size: int) -> Iterator[bytes]:
    """Yield a NIfTI-2 volume of zeros that has `size` bytes in all."""
    header = bytearray(544)
    struct.pack_into("<i", header, 0, 540)
    header[4:12] = b"n+2\0\r\n\x1a\n"
    struct.pack_into("<2h", header, 12, 2, 8)
    voxels = size - len(header)
    struct.pack_into("<8q", header, 16, 3, 1024, 1024, voxels // MIB, 1, 1, 1, 1)
    struct.pack_into("<8d", header, 104, *[1.0] * 8)
    struct.pack_into("<q", header, 168, 544)
    struct.pack_into("<d", header, 176, 1.0)
    yield bytes(header)
    block = bytes(MIB)
    left = voxels
    while left > 0:
        yield block[: min(left, MIB)]
        left -= MIB


def peak(pid: int) -> int:
    """Return the largest resident size of a process so far, in bytes."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) * 1024
    raise RuntimeError("the kernel tells no peak")


def reset_peak(pid: int) -> None:
    """Let the kernel begin anew."""
    Path(f"/proc/{pid}/clear_refs").write_text("5")


def resumable(client: httpx.Client, size: int) -> str:
    """Send the volume through /v1/uploads in one PATCH, and return the asset's id."""
    made = client.post("/v1/uploads", headers={**TUS, "Upload-Length": str(size)})
    made.raise_for_status()
    sent = client.patch(
        made.headers["Location"],
        headers={
            **TUS,
            "Upload-Offset": "0",
            "Content-Type": "application/offset+octet-stream",
            "Content-Length": str(size),
        },
        content=volume(size),
    )
    sent.raise_for_status()
    return str(sent.headers["Upload-Asset-Id"])


def at_once(client: httpx.Client, size: int) -> str:
    """Send the volume as a form to /v1/assets, and return the asset's id."""
    head = b'--end\r\nContent-Disposition: form-data; name="file"; filename="large.nii"\r\n\r\n'
    tail = b"\r\n--end--\r\n"

    def body() -> Iterator[bytes]:
        yield head
        yield from volume(size)
        yield tail

    sent = client.post(
        "/v1/assets",
        headers={
            "Content-Type": "multipart/form-data; boundary=end",
            "Content-Length": str(len(head) + size + len(tail)),
        },
        content=body(),
    )
    sent.raise_for_status()
    return str(sent.json()["id"])


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gib", type=float, default=4.0, help="size of the file in GiB")
    parser.add_argument("--json", type=Path, help="write the figures there as well")
    options = parser.parse_args()
    size = 544 + int(options.gib * 1024) * MIB
    home = Path(tempfile.mkdtemp(prefix="shapery-upload-"))
    server = subprocess.Popen(
        [sys.executable, "-m", "shapery_gateway", "--port", "0", "--migrate"],
        env={**os.environ, "SHAPERY_HOME": str(home), "SHAPERY_MIN_FREE_BYTES": "0", "SHAPERY_LOG_LEVEL": "warning"},
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert server.stdout is not None
        line = server.stdout.readline()
        if not line.startswith(READY):
            raise RuntimeError("the gateway did not start")
        figures = {"bytes": size, "idle_peak_mib": round(peak(server.pid) / MIB, 1)}
        with httpx.Client(base_url=line.removeprefix(READY).strip(), timeout=3600) as client:
            for name, send in (("resumable", resumable), ("at_once", at_once)):
                reset_peak(server.pid)
                began = time.perf_counter()
                asset = client.get(f"/v1/assets/{send(client, size)}").json()
                seconds = time.perf_counter() - began
                figures[f"{name}_peak_mib"] = round(peak(server.pid) / MIB, 1)
                figures[f"{name}_mib_per_s"] = round(size / MIB / seconds, 1)
                figures[f"{name}_sha256"] = asset["sha256"]
                if asset["size"] != size:
                    raise RuntimeError(f"{asset['size']} bytes were stored")
        print(json.dumps(figures, indent=2))
        if options.json is not None:
            options.json.write_text(json.dumps(figures, indent=2) + "\n")
    finally:
        server.terminate()
        server.wait(30)
        shutil.rmtree(home, ignore_errors=True)


if __name__ == "__main__":
    main()
