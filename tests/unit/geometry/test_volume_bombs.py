"""What a header claims costs nothing: damage and bombs are met under a real limit of memory."""

from __future__ import annotations

import gzip
import io
import json
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import write_nifti
from tests.support.volumes import phantom, write_multiframe

# What is measured is what reading adds to a process that has imported everything: its address space may grow by
# 48 MB and no more, so that an array of the claimed size cannot even be reserved.
CHILD = """
import json, resource, sys
import numpy, pydicom, pydicom.pixels, SimpleITK
from shapery_contracts.errors import UserError
from shapery_geometry.volume_io import read_volume
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (48 << 20),) * 2)
codes = {}
for path in sys.argv[1:]:
    try:
        read_volume(path)
        codes[path] = "read"
    except UserError as error:
        codes[path] = error.code
print(json.dumps(codes))
"""


def nifti_that_claims(shape: tuple[int, int, int], data: bytes) -> bytes:
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, *shape, 1, 1, 1, 1)
    struct.pack_into("<2h", head, 70, 2, 8)
    struct.pack_into("<8f", head, 76, *[1.0] * 8)
    struct.pack_into("<f", head, 108, 352)
    struct.pack_into("<2h", head, 252, 0, 1)
    struct.pack_into("<12f", head, 280, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
    head[344:348] = b"n+1\0"
    return bytes(head) + data


def zipped(**entries: bytes) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries.items():
            archive.writestr(name.replace("_", "."), data)
    return stream.getvalue()


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the limit of memory is set through /proc")
@pytest.mark.slow
def test_claims_and_bombs_are_refused_under_a_limit_of_memory(tmp_path: Path) -> None:
    zeros = bytes(64 << 20)
    mhd = b"NDims = 3\nDimSize = 4000 4000 4000\nElementType = MET_FLOAT\nElementDataFile = v.raw\n"
    mha = mhd.replace(b"v.raw", b"LOCAL").replace(b"ElementT", b"CompressedData = True\nElementT")
    nrrd = b"NRRD0004\ntype: float\ndimension: 3\nsizes: 4000 4000 4000\nencoding: gzip\n\n"
    write_multiframe(tmp_path / "frames.dcm", phantom(), Rows=65000, Columns=65000)
    small = gzip.compress(zeros)
    cases = {
        # a hundred bytes that claim 10¹² voxels
        "claim.nii": (nifti_that_claims((10000, 10000, 10000), b""), "corrupt_file"),
        "claim.nii.gz": (gzip.compress(nifti_that_claims((10000, 10000, 10000), b"")), "corrupt_file"),
        "claim.nrrd": (nrrd + bytes(20), "corrupt_file"),
        "claim.mha": (mha + bytes(20), "corrupt_file"),
        "claim.zip": (zipped(v_mhd=mhd, v_raw=bytes(1000)), "corrupt_file"),
        # enough compressed bytes that deflate could keep the claim: 10⁹ voxels and more, against the limit of 2³⁰
        "limit.nii.gz": (
            gzip.compress(nifti_that_claims((1100, 1000, 1000), zeros)) + bytes(1_100_000),
            "too_large",
        ),
        # little is claimed, much would be unpacked: only what was claimed is read
        "bomb.nii.gz": (gzip.compress(nifti_that_claims((4, 4, 4), zeros)), "read"),
        "bomb.nrrd": (nrrd.replace(b"4000 4000 4000", b"4 4 4").replace(b"float", b"uchar") + small, "read"),
        "bomb.mha": (mha.replace(b"4000 4000 4000", b"4 4 4").replace(b"FLOAT", b"UCHAR") + small, "read"),
        "bomb.zip": (zipped(v_mhd=mhd.replace(b"4000 4000 4000", b"4 4 4"), v_raw=zeros), "read"),
        "other.zip": (zipped(a_dcm=zeros, b_obj=zeros), "unknown_format"),
        "other.gz": (small, "unknown_format"),
        "frames.dcm": (None, "corrupt_file"),
    }
    for name, (data, _) in cases.items():
        if data is not None:
            (tmp_path / name).write_bytes(data)
    paths = [str(tmp_path / name) for name in cases]
    child = subprocess.run([sys.executable, "-c", CHILD, *paths], capture_output=True, text=True, check=False)
    assert child.returncode == 0, child.stderr
    assert {Path(p).name: code for p, code in json.loads(child.stdout).items()} == {n: c for n, (_, c) in cases.items()}


def test_the_limit_of_memory_is_felt(tmp_path: Path) -> None:
    # Else the test above would prove nothing.
    write_nifti(Volume(np.zeros((400, 400, 400), np.uint8), np.eye(4)), tmp_path / "large.nii.gz")
    child = subprocess.run(
        [sys.executable, "-c", CHILD, str(tmp_path / "large.nii.gz")], capture_output=True, text=True, check=False
    )
    assert child.returncode != 0
    assert "MemoryError" in child.stderr
