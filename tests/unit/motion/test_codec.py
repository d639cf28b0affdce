"""Encoding and decoding: every bound is met by the decoded file, on whatever is encoded."""

from __future__ import annotations

import math

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_contracts.motion import MotionEncodeParams
from shapery_geometry.sequence import MeshSequence, read_sequence, write_sequence_npz
from shapery_motion import decode, encode, info, open_motion
from shapery_motion.container.connectivity import sorted_faces
from shapery_motion.errors import SequenceErrors, sequence_errors
from shapery_motion.reading import open_motion_input
from shapery_motion.trajectory import streams
from tests.support.motions import difficult_sequences, waving

SEQUENCES = difficult_sequences()


def errors_of(sequence: MeshSequence, data: bytes) -> SequenceErrors:
    decoded = decode(data)
    assert decoded.vertices.shape == sequence.vertices.shape
    assert decoded.vertices.dtype == sequence.vertices.dtype
    assert np.array_equal(decoded.faces, sorted_faces(sequence.faces))
    return sequence_errors(sequence.vertices, decoded.vertices, decoded.faces, surface=False)


@pytest.mark.parametrize("name", SEQUENCES)
def test_whatever_is_encoded_meets_every_bound(name: str) -> None:
    sequence = SEQUENCES[name]
    bounds = MotionEncodeParams(kg=0.2, rmse=0.02, max_error=0.004)
    encoding = encode(sequence, bounds)
    found = errors_of(sequence, encoding.data)
    extent = float(found.frame_spread.max())
    assert found.kg_percent <= 0.2 or extent == 0.0
    assert found.rmse_edges <= 0.02 or found.mean_edge == 0.0
    assert found.largest_fraction <= 0.004 or found.diagonal == 0.0
    assert math.isclose(found.rmse, encoding.errors.rmse, rel_tol=1e-12)
    assert sum(encoding.parts.values()) == len(encoding.data)
    assert encoding.data == encode(sequence, bounds).data


@pytest.mark.parametrize(
    ("name", "value"),
    [("kg", 1.0), ("kg", 0.01), ("rmse", 0.05), ("rmse", 0.002), ("max_error", 0.01), ("max_error", 1e-4)],
)
@pytest.mark.parametrize("preset", ["default", "fast"])
def test_a_bound_is_met_and_used_up(name: str, value: float, preset: str) -> None:
    sequence = SEQUENCES["waving"]
    encoding = encode(sequence, MotionEncodeParams.model_validate({name: value, "preset": preset}))
    found = errors_of(sequence, encoding.data)
    met = {"kg": found.kg_percent, "rmse": found.rmse_edges, "max_error": found.largest_fraction}[name]
    assert (0.6 if name == "max_error" else 0.95) * value < met <= value
    told = info(encoding.data)
    assert told.bounds == {name: value}
    assert math.isclose(told.errors[name], met, rel_tol=1e-9)


def test_without_a_bound_it_is_a_tenth_of_a_percent() -> None:
    encoding = encode(SEQUENCES["waving"])
    assert 0.09 < encoding.errors.kg_percent <= 0.1
    assert info(encoding.data).bounds == {"kg": 0.1}


def test_finer_bounds_make_larger_files() -> None:
    sizes = [len(encode(SEQUENCES["waving"], MotionEncodeParams(kg=kg)).data) for kg in (2.0, 0.5, 0.1, 0.02)]
    assert sizes == sorted(sizes)
    assert sizes[-1] > 2 * sizes[0]


def test_a_bound_finer_than_the_coordinates_is_refused() -> None:
    with pytest.raises(InvalidInput, match="too fine") as caught:
        encode(SEQUENCES["waving"], MotionEncodeParams(kg=1e-9))
    assert caught.value.code == "invalid_params"


@pytest.mark.parametrize("profile", ["trajectory", "gradient"])
def test_coordinates_too_large_for_the_format_are_refused(profile: str) -> None:
    frames, faces = waving(frames=3)
    with pytest.raises(InvalidInput, match="Coordinates may be at most") as caught:
        encode(MeshSequence(1e32 * frames, faces), MotionEncodeParams.model_validate({"profile": profile}))
    assert caught.value.code == "invalid_mesh"


def test_a_fine_bound_on_a_long_motion_far_away_is_met() -> None:
    """The first step that is tried is finer than the last: it must not be refused as too fine."""
    frames, faces = waving(frames=8)
    sequence = MeshSequence(frames + 40 * np.sin(np.arange(8.0))[:, None, None], faces)
    found = errors_of(sequence, encode(sequence, MotionEncodeParams(max_error=2e-5)).data)
    assert found.largest_fraction <= 2e-5


def test_repeated_frames_cost_next_to_nothing() -> None:
    frames, faces = waving()
    once = encode(MeshSequence(frames, faces))
    thrice = encode(MeshSequence(np.concatenate([frames] * 3), faces))
    assert len(thrice.data) < len(once.data) * 1.02 + 64


def test_a_rigid_motion_costs_little_more_than_its_first_frame() -> None:
    frames, faces = waving(20, 20, 1)
    axis = np.array([0.3, 1.0, 0.2])
    turned = []
    for t in range(24):
        c, s = np.cos(0.15 * t), np.sin(0.15 * t)
        turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        turned.append(frames[0] @ turn.T + axis * t)
    one, all_frames = encode(MeshSequence(frames, faces)), encode(MeshSequence(np.array(turned), faces))
    assert len(all_frames.data) < 2.0 * len(one.data)
    assert all_frames.clusters == 1


def test_groups_are_cut_as_asked_and_do_not_depend_on_each_other() -> None:
    sequence = SEQUENCES["waving"]
    encoding = encode(sequence, MotionEncodeParams(group_frames=5))
    assert info(encoding.data).groups == [4, 4, 4, 4]
    assert errors_of(sequence, encoding.data).kg_percent <= 0.1
    whole = decode(encoding.data).vertices
    assert np.array_equal(decode(encoding.data, first=6, stop=11).vertices, whole[6:11])


def test_random_access_gives_what_sequential_decoding_gives() -> None:
    data = encode(SEQUENCES["flips"], MotionEncodeParams(group_frames=7, max_error=0.003)).data
    whole = decode(data).vertices
    motion = open_motion(data)
    for index in np.random.default_rng(2).permutation(len(motion)).tolist():
        assert np.array_equal(motion.frame(index), whole[index])
    assert np.array_equal(motion.frame(-1), whole[-1])
    with pytest.raises(InvalidInput, match="no frame 16"):
        motion.frame(16)
    with pytest.raises(InvalidInput, match="frames 0 to 15"):
        decode(data, first=16)


def test_a_file_larger_than_memory_is_read_in_passes(tmp_path: object) -> None:
    frames, faces = waving(frames=20)
    path = f"{tmp_path}/waving.npz"
    write_sequence_npz(path, frames, faces, shape=(20, frames.shape[1]), single=False)
    params = MotionEncodeParams(group_frames=8)
    assert encode(open_motion_input(path), params).data == encode(MeshSequence(frames, faces), params).data


def test_metadata_comes_back() -> None:
    params = MotionEncodeParams(fps=24.0, unit="m", name="Grüße")
    told = info(encode(SEQUENCES["two frames"], params).data)
    assert (told.fps, told.unit, told.name, told.frames) == (24.0, "m", "Grüße", 2)
    assert sum(told.sections.values()) + 8 == told.bytes


def test_clusters_without_any_mode_stand_beside_others() -> None:
    """What does not move enough to pay for a mode stays where the offset is."""
    frames, faces = waving()
    speck = 1e-7 * np.random.default_rng(3).normal(size=(len(frames), 30, 3)) + frames.mean(axis=(0, 1))
    sequence = MeshSequence(np.concatenate((frames, speck), axis=1), faces)
    encoding = encode(sequence, MotionEncodeParams(kg=0.5, clusters=3))
    assert encoding.clusters == 3
    assert errors_of(sequence, encoding.data).kg_percent <= 0.5


def test_links_in_any_order_of_rounding_give_the_same_vertices(monkeypatch: pytest.MonkeyPatch) -> None:
    """Weights that are off by 1e-12 move nothing: what is decoded depends continuously on rounding."""
    data = encode(SEQUENCES["41 components"]).data
    exact = decode(data).vertices.astype(np.float64)
    whole = streams.PairingTree.of_members

    def nudged(*arguments: object) -> streams.PairingTree:
        tree = whole(*arguments)  # type: ignore[arg-type]
        parts = list(tree.parts)
        noise = np.random.default_rng(0)
        parts[5] = parts[5] * (1 + 1e-12 * noise.normal(size=len(parts[5])))
        return streams.PairingTree(tuple(parts), tree.vertices)

    monkeypatch.setattr(streams.PairingTree, "of_members", nudged)
    assert np.abs(decode(data).vertices - exact).max() < 1e-5 * np.ptp(exact)


@pytest.mark.parametrize(
    ("kind", "said"),
    [("connectivity", "frame 1"), ("not finite", "frame 2"), ("missing", "'walk3.obj' is not there")],
)
def test_broken_sequences_are_refused_naming_the_frame(tmp_path: object, kind: str, said: str) -> None:
    from pathlib import Path

    folder = Path(str(tmp_path))
    for number in (1, 2, 4, 5) if kind == "missing" else (1, 2, 3, 4):
        z = "nan" if kind == "not finite" and number == 3 else str(number)
        face = "1 3 2" if kind == "connectivity" and number == 2 else "1 2 3"
        (folder / f"walk{number}.obj").write_text(f"v 0 0 {z}\nv 1 0 0\nv 0 1 0\nf {face}\n")
    with pytest.raises(InvalidInput) as caught:
        encode(open_motion_input(folder))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "names",
    [
        ["a1.obj", "a2.obj", "a3.obj"],
        ["f0010.ply", "f0020.ply", "f0030.ply"],
        ["x.obj", "y.obj", "z.obj"],
        ["1.obj", "5.obj"],
        ["run1.obj", "run2.obj", "walk1.obj", "walk4.obj"],
    ],
)
def test_numbering_without_gaps_is_taken(names: list[str]) -> None:
    from shapery_motion.reading import check_numbering

    check_numbering(names)


@pytest.mark.data
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "bits"),
    [
        ("crane", 0.73),
        ("chickenCrossing", 0.31),
        ("horse-gallop", 0.58),
        ("mmface4d-3k", 0.93),
        ("pcow", 1.42),
        ("pdance", 0.22),
    ],
)
def test_real_motions_meet_the_default_bound_at_a_low_rate(shared_data: object, name: str, bits: float) -> None:
    sequence = read_sequence(f"{shared_data}/motion/{name}.npz")
    encoding = encode(sequence)
    assert errors_of(sequence, encoding.data).kg_percent <= 0.1
    motion = len(encoding.data) - encoding.parts["connectivity"]
    assert 8 * motion / (len(sequence) * sequence.vertex_count) < bits
