"""The surface as it grew: recorded within bounds, written and read back."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_contracts.handler import MAX_PREVIEW
from shapery_geometry.mesh import TriangleMesh
from shapery_segmentation.evolution import (
    MAGIC,
    MOST_AT_ONCE,
    MOST_FRAMES,
    MOST_VERTICES,
    Frame,
    Recorder,
    Scene,
    coarsened,
    evolution_bytes,
    numbered,
    read_evolution,
    write_evolution,
)
from shapery_segmentation.flow.params import FlowState
from shapery_segmentation.seeding.ball import surface_of
from tests.conftest import ROOT


def ball(radius: float) -> TriangleMesh:
    axis = np.arange(41) - 20
    inside = axis[:, None, None] ** 2 + axis[:, None] ** 2 + axis**2 <= radius**2
    affine = np.eye(4)
    affine[:3, 3] = -20
    return surface_of(inside, affine)


def state(iteration: int, mesh: TriangleMesh) -> FlowState:
    return FlowState(0, iteration, len(mesh.vertices), 0, oscillating=0, threshold=1.0, surface=lambda: mesh)


def test_coarsening_keeps_the_shape_with_few_vertices() -> None:
    mesh = ball(18.0)
    coarse = coarsened(mesh, MOST_VERTICES)
    assert len(mesh.vertices) > 2 * MOST_VERTICES
    assert 0.4 * MOST_VERTICES < len(coarse.vertices) <= MOST_VERTICES
    assert coarse.volume == pytest.approx(mesh.volume, rel=0.03)
    assert coarsened(coarse, MOST_VERTICES) is coarse


def test_a_long_flow_leaves_few_frames_over_all_of_it() -> None:
    recorder, mesh = Recorder(), ball(3.0)
    for iteration in range(1, 301):
        recorder.watch(state(iteration, mesh))
    frames = recorder.frames(mesh)
    iterations = [frame.iteration for frame in frames]
    assert iterations == sorted(set(iterations))
    assert MOST_FRAMES / 2 <= len(frames) <= MOST_FRAMES + 1
    assert iterations[0] == 1
    assert max(np.diff(iterations[:-1])) <= 2 * 300 / (MOST_FRAMES / 2)


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    meshes = [ball(radius) for radius in (3.0, 6.0, 9.0)]
    frames = numbered(tuple(Frame(0, 0, n, mesh) for n, mesh in enumerate(meshes)), 2)
    path = tmp_path / "evolution.bin"
    write_evolution(frames, path)
    again = read_evolution(path)
    assert [(frame.object, frame.iteration) for frame in again] == [(2, 0), (2, 1), (2, 2)]
    for frame, mesh in zip(again, meshes, strict=True):
        np.testing.assert_array_equal(frame.mesh.faces, mesh.faces)
        # 16 bits over the largest extent.
        np.testing.assert_allclose(frame.mesh.vertices, mesh.vertices, atol=19.0 / 65535)


def test_the_file_is_laid_out_as_described(tmp_path: Path) -> None:
    mesh = ball(3.0)
    path = tmp_path / "evolution.bin"
    write_evolution((Frame(1, 0, 5, mesh),), path)
    data = path.read_bytes()
    assert data[:8] == MAGIC
    (length,) = struct.unpack_from("<I", data, 8)
    assert (12 + length) % 4 == 0
    header = json.loads(data[12 : 12 + length])
    (told,) = header["frames"]
    assert told["offset"] == 0
    places = np.frombuffer(data, "<u2", 3 * told["vertices"], 12 + length).reshape(-1, 3)
    first = np.array(header["origin"]) + header["step"] * places[0]
    np.testing.assert_allclose(first, mesh.vertices[0], atol=header["step"])
    faces = 12 + length + (6 * told["vertices"] + 3) // 4 * 4
    np.testing.assert_array_equal(np.frombuffer(data, "<u4", 3, faces), mesh.faces[0])
    assert len(data) == faces + 12 * told["faces"]


def test_a_scene_shows_what_flows_beside_what_rests() -> None:
    shown: list[tuple[Frame, ...]] = []
    scene = Scene(shown.append)
    for number in (1, 2):
        recorder = Recorder(scene)
        for iteration in range(1, 10):
            recorder.watch(state(iteration, ball(2.0 + number)))
        recorder.frames(ball(4.0 + number))
    told = [[(frame.object, frame.iteration) for frame in frames] for frames in shown]
    assert told == [
        [(1, 1)], [(1, 5)], [(1, 9)], [(1, 0)],
        [(1, 0), (2, 1)], [(1, 0), (2, 5)], [(1, 0), (2, 9)], [(1, 0), (2, 0)],
    ]  # fmt: skip
    assert shown[-1][1].mesh.volume == pytest.approx(ball(6.0).volume, rel=0.03)


def test_a_surface_that_vanished_gives_its_place_to_the_next() -> None:
    shown: list[tuple[Frame, ...]] = []
    scene = Scene(shown.append)
    Recorder(scene).watch(state(1, ball(3.0)))
    Recorder(scene).watch(state(2, ball(4.0)))
    assert [[(frame.object, frame.iteration) for frame in frames] for frames in shown] == [[(1, 1)], [(1, 2)]]


def test_many_surfaces_together_stay_within_bounds() -> None:
    shown: list[tuple[Frame, ...]] = []
    scene = Scene(shown.append)
    for _ in range(20):
        scene.rested(ball(8.0))
    scene.moved(Frame(0, 0, 1, coarsened(ball(18.0), MOST_VERTICES)))
    assert len(shown[-1]) == 21
    assert sum(len(frame.mesh.vertices) for frame in shown[-1]) <= MOST_AT_ONCE
    assert len(evolution_bytes(shown[-1])) <= MAX_PREVIEW / 2


def test_the_dashboard_is_tested_with_what_is_written(tmp_path: Path) -> None:
    """Its decoder is tested with a file that this wrote. After a change of the format: write it anew, and say so."""

    def corner(place: float, length: float) -> TriangleMesh:
        points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * length + [place, 0, 0]
        return TriangleMesh(points, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.int32))

    frames = (Frame(2, 0, 1, corner(10.0, 4.0)), Frame(1, 0, 1, corner(0.0, 1.0)), Frame(1, 1, 5, corner(0.0, 2.0)))
    golden = ROOT / "services/dashboard/tests/golden/evolution.bin"
    assert golden.read_bytes() == evolution_bytes(frames)


@pytest.mark.parametrize("damage", ["other", "short", "cut"])
def test_damaged_files_are_refused(tmp_path: Path, damage: str) -> None:
    path = tmp_path / "evolution.bin"
    write_evolution((Frame(1, 0, 5, ball(3.0)),), path)
    data = path.read_bytes()
    path.write_bytes({"other": b"PNG" + data[3:], "short": data[:6], "cut": data[:-20]}[damage])
    with pytest.raises(InvalidInput) as caught:
        read_evolution(path)
    assert caught.value.code == "corrupt_file"
