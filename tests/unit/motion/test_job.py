"""The jobs as a worker runs them: files in, files out, a report that adds up; and their commands."""

from __future__ import annotations

import gzip
import json
import struct
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree as ET

import matplotlib.pyplot as plt
import numpy as np
import pytest
import trimesh

from shapery_client._local import run_locally
from shapery_contracts.errors import InvalidInput
from shapery_geometry.sequence import read_sequence, write_sequence_npz
from shapery_motion import decode
from shapery_motion.container.connectivity import sorted_faces
from tests.conftest import ROOT
from tests.support.motions import waving

FRAMES, FACES = waving(9, 10, 12)


def nothing(*_arguments: object) -> None:
    return


@pytest.fixture(scope="module")
def encoded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("motion")
    write_sequence_npz(folder / "walk.npz", FRAMES, FACES, shape=FRAMES.shape[:2])
    stages: list[tuple[str, float]] = []
    run_locally(
        "motion-encode",
        {"sequence": folder / "walk.npz"},
        {"kg": 0.2, "fps": 25, "name": "walk"},
        folder,
        lambda stage, fraction, _message: stages.append((stage, fraction)),
    )
    names = list(dict.fromkeys(stage for stage, _ in stages))
    assert names == ["read", "encode", "verify", "write"]
    fractions = [fraction for _, fraction in stages]
    assert fractions == sorted(fractions)
    return folder


def test_the_report_adds_up(encoded: Path) -> None:
    report = json.loads((encoded / "report.json").read_text())
    data = (encoded / "motion.smc").read_bytes()
    assert report["bytes"] == len(data) == sum(report["parts"].values())
    assert report["errors"]["kg_percent"] <= 0.2 == report["bounds"]["kg"]
    assert len(report["frame_rmse"]) == len(report["frame_largest"]) == 12
    decoded = decode(data).vertices.astype(np.float64)
    rmse = np.sqrt(((decoded - FRAMES.astype(np.float32)) ** 2).sum(axis=2).mean(axis=1))
    assert np.allclose(rmse, report["frame_rmse"], rtol=1e-6)
    assert len(report["vertex_clusters"]) == 90
    assert max(report["vertex_clusters"]) + 1 == report["clusters"]
    rates = report["rate_distortion"]
    assert [point["kg_percent"] for point in rates] == sorted(point["kg_percent"] for point in rates)
    assert len(trimesh.load(encoded / "clusters.ply", process=False).vertices) == 90


def test_residuals_lead_back_to_the_original(encoded: Path) -> None:
    data = gzip.decompress((encoded / "residuals.bin.gz").read_bytes())
    magic, frames, vertices, step = struct.unpack_from("<4s2If", data)
    assert (magic, frames, vertices) == (b"SMR1", 12, 90)
    residuals = np.frombuffer(data, np.int8, offset=16).reshape(12, 90, 3)
    assert np.abs(residuals).max() > 60
    decoded = decode((encoded / "motion.smc").read_bytes()).vertices
    assert np.abs(decoded + residuals * step - FRAMES).max() < 0.51 * step + 1e-5


def test_the_pictures_show_clusters_and_the_curve(encoded: Path) -> None:
    report = json.loads((encoded / "report.json").read_text())
    picture = plt.imread(encoded / "clusters.png")
    covered = picture[..., 3] > 0.99
    assert 0.1 < covered.mean() < 0.95
    assert not covered[0].any()
    shades = picture[covered][:, :3] / picture[covered][:, :3].max(axis=1, keepdims=True)
    hues = np.unique(np.rint(shades * 8).astype(int), axis=0)
    assert len(hues) >= report["clusters"]
    tree = ET.parse(encoded / "rate.svg")
    circles = tree.findall(".//{http://www.w3.org/2000/svg}circle")
    assert len(circles) == len(report["rate_distortion"])
    assert [circle.get("r") for circle in circles].count("5") == 1
    by_error = [float(circle.get("cy", "nan")) for circle in sorted(circles, key=lambda c: float(c.get("cx", "nan")))]
    assert by_error == sorted(by_error)  # downwards: fewer bits at larger errors


@pytest.mark.parametrize("form", ["npz", "obj", "ply"])
def test_frames_come_out_as_other_programs_read_them(encoded: Path, form: str, tmp_path: Path) -> None:
    result = run_locally(
        "motion-decode",
        {"motion": encoded / "motion.smc"},
        {"format": form, "first": 3, "stop": 9},
        tmp_path,
        nothing,
    ).model_dump()
    assert (result["frames"], result["first"]) == (6, 3)
    found = read_sequence(tmp_path / result["file"])
    expected = decode((encoded / "motion.smc").read_bytes(), first=3, stop=9)
    assert np.array_equal(found.vertices.astype(np.float32), expected.vertices)
    assert np.array_equal(sorted_faces(found.faces), expected.faces)
    if form != "npz":
        with zipfile.ZipFile(tmp_path / result["file"]) as archive:
            assert archive.namelist()[0] == f"frame0003.{form}"


def test_an_animated_scene_shows_every_frame_at_its_time(encoded: Path, tmp_path: Path) -> None:
    run_locally("motion-decode", {"motion": encoded / "motion.smc"}, {"format": "glb"}, tmp_path, nothing)
    data = (tmp_path / "motion.glb").read_bytes()
    magic, version, length, size, kind = struct.unpack_from("<4s2LL4s", data)
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
    document = json.loads(data[20 : 20 + size])
    binary = data[28 + size :]
    assert document["buffers"][0]["byteLength"] == len(binary)

    def array(index: int) -> np.ndarray:
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        width = {"VEC3": 3, "SCALAR": 1}[accessor["type"]]
        dtype = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        values = np.frombuffer(binary, dtype, accessor["count"] * width, view["byteOffset"])
        assert view["byteLength"] == values.nbytes
        return values.reshape(-1, width)

    primitive = document["meshes"][0]["primitives"][0]
    base = array(primitive["attributes"]["POSITION"])
    targets = np.stack([array(target["POSITION"]) for target in primitive["targets"]])
    sampler = document["animations"][0]["samplers"][0]
    weights = array(sampler["output"]).reshape(12, 11)
    assert np.allclose(array(sampler["input"])[:, 0], np.arange(12) / 25)
    shown = base + np.einsum("ft,tvc->fvc", weights, targets)
    assert np.allclose(shown, decode((encoded / "motion.smc").read_bytes()).vertices, atol=1e-5)
    for index in (primitive["attributes"]["POSITION"], primitive["targets"][3]["POSITION"]):
        accessor = document["accessors"][index]
        assert np.allclose(array(index).min(axis=0), accessor["min"])
        assert np.allclose(array(index).max(axis=0), accessor["max"])
    assert array(primitive["indices"]).max() == 89


def test_the_scene_that_three_loads_is_what_is_written(tmp_path: Path) -> None:
    """The dashboard's tests load this very file in three, and hold its animation against the decoded frames."""
    golden = ROOT / "services" / "dashboard" / "tests" / "golden"
    run_locally("motion-decode", {"motion": golden / "trajectory-1.1.smc"}, {"format": "glb"}, tmp_path, nothing)
    assert (tmp_path / "motion.glb").read_bytes() == (golden / "trajectory-1.1.glb").read_bytes()


def test_a_range_without_frames_is_refused(encoded: Path, tmp_path: Path) -> None:
    for params in ({"first": 12}, {"first": 4, "stop": 4}):
        with pytest.raises(InvalidInput):
            run_locally("motion-decode", {"motion": encoded / "motion.smc"}, params, tmp_path, nothing)


def shapery(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "shapery_client", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)


@pytest.mark.slow
def test_the_commands_encode_tell_and_decode(encoded: Path, tmp_path: Path) -> None:
    out = tmp_path / "walk.smc"
    done = shapery("encode", encoded / "walk.npz", "--out", out, "--max-error", "0.003", "--report", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["errors"]["largest_fraction"] <= 0.003
    assert (tmp_path / "report.json").is_file()
    told = shapery("info", out, "--json")
    assert json.loads(told.stdout)["name"] == "walk"
    assert json.loads(told.stdout)["bounds"] == {"max_error": 0.003}
    assert "bits per vertex and frame" in shapery("info", out).stdout
    back = shapery("decode", out, "--out", tmp_path / "part.npz", "--frames", "2:5")
    assert back.returncode == 0, back.stderr
    assert len(read_sequence(tmp_path / "part.npz")) == 3
    report = ["clusters.ply", "clusters.png", "rate.svg", "report.json", "residuals.bin.gz"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*report, "part.npz", "walk.smc"])


def test_the_commands_refuse_in_a_sentence(encoded: Path, tmp_path: Path) -> None:
    for arguments, said in (
        (("encode", tmp_path / "none.npz", "--out", tmp_path / "x.smc"), "does not exist"),
        (("encode", encoded / "walk.npz", "--out", tmp_path / "x.smc", "--kg", "-1"), "kg"),
        (("decode", encoded / "motion.smc", "--out", tmp_path / "x.mp4"), ".npz"),
        (("decode", encoded / "motion.smc", "--out", tmp_path / "x.npz", "--frames", "a:b"), "10:20"),
        (("info", encoded / "walk.npz"), "no motion file"),
    ):
        done = shapery(*arguments)
        assert done.returncode == 3
        assert said in done.stderr
        assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())
