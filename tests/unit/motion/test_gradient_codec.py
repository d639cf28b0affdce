"""The dissertation's codec as a profile of the motion file: streams, bounds, choices, damaged input."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapery_contracts.errors import InvalidInput
from shapery_geometry.mesh import icosphere
from shapery_motion.gradient.encoder import EncodedFrames, GradientOptions, encode_frames
from shapery_motion.gradient.group import KeyFrame, PredictedFrame
from shapery_motion.gradient.profile import encode_group, open_group
from shapery_motion.gradient.sections import FRAMES, KEYS, LABELS, declared_memory, table_of
from shapery_motion.gradient.streams import IntegerStream, LabelStream
from shapery_motion.gradient.traversal import traverse
from shapery_motion.profiles import GroupTask

SPHERE = icosphere(subdivisions=2)
ROOM = 1 << 30
AS_IN_THE_TEXT = GradientOptions(spreads=(0,), predict_only=True)


def swaying(frames: int = 6, points: np.ndarray = SPHERE.vertices) -> np.ndarray:
    """A body that bends and stretches."""
    result = np.empty((frames, *points.shape))
    for t in range(frames):
        x, y, z = points.T
        bend = 0.15 * t
        result[t] = np.stack((x + bend * np.sin(2 * z), y * (1 + 0.05 * t) + 0.1 * t, z - bend * np.cos(x)), axis=1)
    return result


def allowed(frames: np.ndarray, kg: float) -> float:
    """The sum of squared errors that a KG error in percent allows."""
    return float((kg / 100) ** 2 * ((frames - frames.mean(axis=1, keepdims=True)) ** 2).sum())


def decoded(task: GroupTask, sections: tuple[tuple[str, bytes], ...]) -> np.ndarray:
    views = {tag: memoryview(payload) for tag, payload in sections}
    group = open_group(views, len(task.frames), task.frames.shape[1], task.faces, ROOM)
    return np.stack([group.frame(t) for t in range(len(task.frames))])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(*[st.integers(-(2**31) + 1, 2**31 - 1) | st.integers(-3, 3)] * 3), max_size=30))
def test_whole_numbers_come_back(rows: list[tuple[int, int, int]]) -> None:
    stream = IntegerStream(3)
    for part in (rows[:7], rows[7:]):
        stream.write(np.array(part, dtype=np.int64).reshape(-1, 3))
    data = stream.finish()
    reader = IntegerStream(3, memoryview(data))
    found = np.concatenate((reader.read(len(rows[:7])), reader.read(len(rows[7:]))))
    np.testing.assert_array_equal(found, np.array(rows, dtype=np.int64).reshape(-1, 3))
    assert not reader.overrun
    assert not reader.surplus


def test_numbers_beyond_the_format_are_not_written() -> None:
    with pytest.raises(OverflowError):
        IntegerStream(1).write(np.array([2**31]))


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.sampled_from([1, 2, 3, 17, 256, 65536]), st.integers(0, 5)), max_size=4), st.booleans())
def test_labels_come_back(frames: list[tuple[int, int]], smooth: bool) -> None:
    walk = traverse(SPHERE.faces, len(SPHERE.vertices))
    wanted = []
    stream = LabelStream(walk)
    for count, seed in frames:
        rng = np.random.default_rng(seed)
        field = SPHERE.face_normals @ rng.standard_normal(3) if smooth else rng.random(len(SPHERE.faces))
        labels = np.minimum((field - field.min()) / np.ptp(field) * count, count - 1).astype(np.int32)
        wanted.append((labels, count))
        stream.write(labels, count)
    data = stream.finish()
    reader = LabelStream(walk, memoryview(data))
    for labels, count in wanted:
        np.testing.assert_array_equal(reader.read(count), labels)
    assert not reader.overrun
    assert not reader.surplus


def test_smooth_and_steady_labels_cost_little() -> None:
    walk = traverse(SPHERE.faces, len(SPHERE.vertices))
    labels = ((SPHERE.face_normals[:, 2] + 1) * 7.99).astype(np.int32)
    stream = LabelStream(walk)
    stream.write(labels, 16)
    once = stream.position
    for _ in range(20):
        stream.write(labels, 16)
    assert once < len(labels) * 4 / 8
    assert stream.position - once < 20 * len(labels) * 0.3 / 8


def test_a_walk_reaches_everything_once() -> None:
    # two spheres, an edge of three faces, a face that names a vertex twice, and vertices without faces
    second = SPHERE.faces + len(SPHERE.vertices)
    a, b = SPHERE.faces[0, :2]
    extra = np.array([[a, b, 7], [a, a, b]], np.int32)
    faces = np.concatenate((SPHERE.faces, second, extra)).astype(np.int32)
    n = 2 * len(SPHERE.vertices) + 3
    walk = traverse(faces, n)
    assert sorted(walk.face_order.tolist()) == list(range(len(faces)))
    assert sorted(walk.vertex_order.tolist()) == list(range(n))
    assert (walk.parents < 0).sum() == 2
    place = np.empty(n, dtype=int)
    place[walk.vertex_order] = np.arange(n)
    for axis in range(3):
        known = walk.predictors[:, axis] >= 0
        assert (place[walk.predictors[known, axis]] < place[known]).all()
    values = np.random.default_rng(0).integers(-1000, 1000, (n, 3))
    np.testing.assert_array_equal(walk.values(walk.residuals(values)), values)


def test_parallelograms_predict_a_plane() -> None:
    side = 8
    x, y = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.concatenate(
        (np.stack((corner, corner + side, corner + 1), 1), np.stack((corner + 1, corner + side, corner + side + 1), 1))
    ).astype(np.int32)
    points = np.stack((5 * x.ravel(), 3 * y.ravel() + x.ravel(), 0 * x.ravel()), axis=1)
    residuals = traverse(faces, side * side).residuals(points)
    assert not residuals[3:].any()


@pytest.mark.parametrize("kg", [0.05, 0.5, 5.0])
def test_the_bound_is_met_by_what_is_decoded(kg: float) -> None:
    frames = swaying()
    task = GroupTask(frames, SPHERE.faces, allowed(frames, kg))
    found = decoded(task, encode_group(task).sections)
    assert ((found - frames) ** 2).sum() <= task.squared_error


@pytest.mark.parametrize("vertices", [1, 2, 3])
def test_few_vertices_do_not_err_like_the_mean_of_many(vertices: int) -> None:
    rng = np.random.default_rng(vertices)
    for _ in range(20):
        frames = rng.random((2, vertices, 3))
        task = GroupTask(frames, np.zeros((0, 3), np.int32), 1e-3 * vertices)
        found = decoded(task, encode_group(task).sections)
        assert ((found - frames) ** 2).sum() <= task.squared_error


def test_a_bound_on_the_largest_error_is_met() -> None:
    frames = swaying()
    for largest in (0.2, 0.01, 1e-5):
        task = GroupTask(frames, SPHERE.faces, math.inf, largest=largest)
        found = decoded(task, encode_group(task).sections)
        assert np.linalg.norm(found - frames, axis=2).max() <= largest


def test_the_encoder_knows_the_errors_of_the_decoder() -> None:
    frames = swaying()
    task = GroupTask(frames, SPHERE.faces, allowed(frames, 2.0))
    encoded = encode_frames(task)
    found = decoded(task, encoded.sections)
    np.testing.assert_array_equal(found, np.stack([encoded.group.frame(t) for t in range(len(frames))]))
    squared = ((found - frames) ** 2).sum(axis=2)
    np.testing.assert_allclose(encoded.squared, squared.sum(axis=1), rtol=1e-9)
    np.testing.assert_allclose(encoded.largest, squared.max(axis=1), rtol=1e-9)


def test_predictions_pay_where_the_motion_is_simple() -> None:
    # two halves that turn against each other: two clusters say it all, and key frames would be dear
    ball = icosphere(subdivisions=3)
    frames = np.repeat(ball.vertices[None], 8, axis=0)
    rng = np.random.default_rng(0)
    frames += 0.01 * rng.standard_normal(ball.vertices.shape)
    for t in range(8):
        turn = np.array(
            [[math.cos(0.2 * t), -math.sin(0.2 * t), 0], [math.sin(0.2 * t), math.cos(0.2 * t), 0], [0, 0, 1]]
        )
        frames[t] = frames[t] @ turn.T + t
    task = GroupTask(frames, ball.faces, allowed(frames, 0.1))
    encoded = encode_frames(task)
    assert [type(frame) for frame in encoded.group.frames] == [KeyFrame] + [PredictedFrame] * 7
    key_bytes = len(dict(encoded.sections)[KEYS])
    assert encoded.size < 1.3 * key_bytes
    assert encoded.squared.sum() <= task.squared_error


def test_the_texts_method_has_one_key_frame_and_256_clusters() -> None:
    frames = swaying()
    encoded = encode_frames(GroupTask(frames, SPHERE.faces, math.inf), AS_IN_THE_TEXT)
    kinds = [type(frame) for frame in encoded.group.frames]
    assert kinds == [KeyFrame] + [PredictedFrame] * 5
    assert all(len(f.matrices) == 256 for f in encoded.group.frames if isinstance(f, PredictedFrame))
    assert all(len(f.anchors) == 1 for f in encoded.group.frames if isinstance(f, PredictedFrame))


def test_more_clusters_and_more_anchors_err_less() -> None:
    frames = swaying()

    def error(clusters: int, spreads: tuple[int, ...]) -> float:
        task = GroupTask(frames, SPHERE.faces, math.inf, clusters=clusters)
        return float(encode_frames(task, GradientOptions(spreads=spreads, predict_only=True)).squared.sum())

    assert error(4, (0,)) > 2 * error(32, (0,)) > 4 * error(128, (0,))
    assert error(4, (0,)) > 2 * error(4, (16,))


def test_as_many_clusters_as_faces_lose_only_what_rounding_loses() -> None:
    frames = swaying(3)
    task = GroupTask(frames, SPHERE.faces, math.inf, clusters=4096)
    encoded = encode_frames(task, AS_IN_THE_TEXT)
    assert math.sqrt(encoded.largest.max()) < 4 * encoded.group.step


def test_key_frames_are_taken_where_they_are_given() -> None:
    frames = swaying(9)
    task = GroupTask(frames, SPHERE.faces, math.inf, key_frames=(4, 7))
    kinds = [isinstance(frame, KeyFrame) for frame in encode_frames(task).group.frames]
    assert np.flatnonzero(kinds).tolist() == [0, 4, 7]


def test_frames_are_read_in_any_order() -> None:
    frames = swaying(7)
    task = GroupTask(frames, SPHERE.faces, math.inf, key_frames=(3, 5))
    encoded = encode_group(task)
    forward = decoded(task, encoded.sections)
    group = open_group({k: memoryview(v) for k, v in encoded.sections}, 7, frames.shape[1], SPHERE.faces, ROOM)
    for t in (6, 0, 4, 1, 4, 2, 6):
        np.testing.assert_array_equal(group.frame(t), forward[t])


def test_encoding_is_deterministic() -> None:
    frames = swaying()
    task = GroupTask(frames, SPHERE.faces, allowed(frames, 2.0))
    assert encode_frames(task).sections == encode_frames(task).sections


POINTS = {
    "one triangle": (SPHERE.vertices[:3], np.array([[0, 1, 2]])),
    "no faces": (SPHERE.vertices[:5], np.zeros((0, 3))),
    "one vertex": (np.ones((1, 3)), np.zeros((0, 3))),
    "a point of all vertices": (np.ones((4, 3)), np.array([[0, 1, 2], [1, 2, 3]])),
    "needles": (np.linspace(0, 1, 12).reshape(-1, 1) * np.ones(3), np.array([[0, 1, 2], [3, 4, 5], [6, 6, 7]])),
    "unreferenced vertices": (np.concatenate((SPHERE.vertices, [[9.0, 0, 0], [0, 9, 0]])), SPHERE.faces),
    "duplicate faces": (SPHERE.vertices, np.concatenate((SPHERE.faces, SPHERE.faces[:9], SPHERE.faces[:2, ::-1]))),
    "far from the origin": (SPHERE.vertices + 1e6, SPHERE.faces),
    "tiny": (SPHERE.vertices * 1e-12, SPHERE.faces),
}


@pytest.mark.parametrize("name", POINTS)
@pytest.mark.parametrize("frames", [1, 2, 4])
def test_awkward_sequences_are_bounded(name: str, frames: int) -> None:
    points, faces = POINTS[name]
    extent = max(float(np.ptp(points)), 1e-30)
    moving = np.stack([points + extent * 0.1 * t * np.sin(points / extent + t) for t in range(frames)])
    largest = 0.02 * extent
    task = GroupTask(moving, np.asarray(faces, np.int32), math.inf, largest=largest)
    found = decoded(task, encode_group(task).sections)
    assert np.linalg.norm(found - moving, axis=2).max() <= largest


@pytest.mark.parametrize("motion", ["static", "mirrored", "collapsed", "inflated"])
def test_violent_motion_is_bounded(motion: str) -> None:
    scales = {"static": [1, 1, 1], "mirrored": [1, -1, 1], "collapsed": [1, 0, 1], "inflated": [1, 1000, 1e-3]}[motion]
    frames = np.array(scales)[:, None, None] * SPHERE.vertices
    task = GroupTask(frames, SPHERE.faces, allowed(frames, 0.3))
    encoded = encode_group(task)
    assert ((decoded(task, encoded.sections) - frames) ** 2).sum() <= task.squared_error
    if motion == "static":
        assert sum(len(payload) for tag, payload in encoded.sections if tag != KEYS) < 120


def test_coordinates_beyond_the_format_are_refused() -> None:
    with pytest.raises(InvalidInput, match="at most 1e\\+30"):
        encode_frames(GroupTask(np.full((1, 3, 3), 1e31), np.array([[0, 1, 2]], np.int32), math.inf))


def encoded_example() -> EncodedFrames:
    frames = swaying(4)
    task = GroupTask(frames, SPHERE.faces, math.inf, clusters=12, key_frames=(2,))
    return encode_frames(task)


def refusal(views: dict[str, memoryview]) -> bool:
    """Whether a group is refused, as it must be where it does not decode to finite frames."""
    try:
        group = open_group(views, 4, len(SPHERE.vertices), SPHERE.faces, ROOM)
        frames = [group.frame(t) for t in range(4)]
    except InvalidInput as error:
        if error.code != "corrupt_file" or "Section G" not in error.message:
            raise
        return True
    if not np.isfinite(frames).all():
        raise FloatingPointError("a damaged group decodes to frames that are not finite")
    return False


def test_damaged_sections_are_refused_or_decoded_to_something_finite() -> None:
    encoded = encoded_example()
    whole = dict(encoded.sections)
    rng = np.random.default_rng(11)
    refused = 0
    for trial in range(250):
        tag = list(whole)[trial % len(whole)]
        payload = bytearray(whole[tag])
        for _ in range(int(rng.integers(1, 4))):
            place = int(rng.integers(len(payload)))
            payload[place] = int(rng.integers(256))
        if trial % 5 == 0:
            del payload[int(rng.integers(len(payload))) :]
        views = {k: memoryview(bytes(payload) if k == tag else v) for k, v in whole.items()}
        refused += refusal(views)
    assert refused > 60


def test_more_memory_than_declared_is_refused() -> None:
    encoded = encoded_example()
    views = {k: memoryview(v) for k, v in encoded.sections}
    needed = declared_memory(len(SPHERE.vertices), len(SPHERE.faces), table_of(views[FRAMES], 4))
    open_group(views, 4, len(SPHERE.vertices), SPHERE.faces, needed)
    with pytest.raises(InvalidInput, match=r"GFRM.*memory"):
        open_group(views, 4, len(SPHERE.vertices), SPHERE.faces, needed - 1)
    del views[LABELS]
    with pytest.raises(InvalidInput, match=r"GLAB.*missing"):
        open_group(views, 4, len(SPHERE.vertices), SPHERE.faces, needed)


def test_cancelling_stops_between_frames() -> None:
    calls = []

    def cancel() -> None:
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt

    frames = swaying()
    with pytest.raises(KeyboardInterrupt):
        encode_frames(GroupTask(frames, SPHERE.faces, math.inf, check_cancelled=cancel))
    assert len(calls) == 3


@pytest.mark.data
@pytest.mark.parametrize(("name", "kg"), [("chickenCrossing", 0.5), ("mmface4d-3k", 1.0), ("horse-gallop", 0.5)])
@pytest.mark.slow
def test_bounds_on_real_sequences(shared_data: Path, name: str, kg: float) -> None:
    with np.load(shared_data / "motion" / f"{name}.npz") as stored:
        frames, faces = stored["vertices"][:40:8].astype(np.float64), stored["faces"]
    task = GroupTask(frames, faces, allowed(frames, kg))
    found = decoded(task, encode_group(task).sections)
    assert ((found - frames) ** 2).sum() <= task.squared_error
