"""The gradient profile in a motion file: bounds, key frames, random access, damage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_contracts.motion import MotionEncodeParams
from shapery_geometry.mesh import icosphere
from shapery_geometry.sequence import MeshSequence
from shapery_motion import decode, encode, open_motion
from shapery_motion.errors import sequence_errors

SPHERE = icosphere(subdivisions=2)


def swaying(frames: int) -> MeshSequence:
    x, y, z = SPHERE.vertices.T
    moved = [np.stack((x + 0.1 * t * np.sin(2 * z), y, z - 0.1 * t * np.cos(x)), axis=1) for t in range(frames)]
    return MeshSequence(np.stack(moved).astype(np.float32), SPHERE.faces)


@pytest.mark.parametrize(
    "bound", [{"kg": 0.2}, {"rmse": 0.05}, {"max_error": 0.004}, {"kg": 2.0, "max_error": 0.004}], ids=str
)
def test_bounds_are_met_by_the_decoded_file(bound: dict[str, float]) -> None:
    sequence = swaying(6)
    encoding = encode(sequence, MotionEncodeParams(profile="gradient", group_frames=4, **bound))
    found = decode(encoding.data)
    errors = sequence_errors(sequence.vertices, found.vertices, found.faces, surface=False)
    for name, measured in (
        ("kg", errors.kg_percent),
        ("rmse", errors.rmse_edges),
        ("max_error", errors.largest_fraction),
    ):
        assert measured <= bound.get(name, np.inf)
    assert encoding.header.groups == 2
    assert sum(encoding.parts.values()) == len(encoding.data)


def test_frames_of_the_file_in_any_order() -> None:
    sequence = swaying(6)
    params = MotionEncodeParams(profile="gradient", kg=2.0, key_frames=[3], clusters=16)
    motion = open_motion(encode(sequence, params).data)
    forward = [motion.frame(t) for t in range(6)]
    for t in (5, 0, 3, 1, -1):
        np.testing.assert_array_equal(motion.frame(t), forward[t])


def test_a_changed_byte_is_noticed() -> None:
    data = bytearray(encode(swaying(3), MotionEncodeParams(profile="gradient", kg=1.0)).data)
    data[-40] ^= 1
    with pytest.raises(InvalidInput, match="Section G"):
        list(open_motion(bytes(data)).frames())


def test_a_file_of_the_first_version_decodes_to_what_it_did() -> None:
    """Golden: a closed and an open part, a vertex without faces, a face that names a vertex twice; two key frames."""
    folder = Path(__file__).parent / "golden"
    found = decode((folder / "gradient-1.0.smc").read_bytes())
    with np.load(folder / "gradient-1.0.npz") as stored:
        np.testing.assert_array_equal(found.faces, stored["faces"])
        # every other frame; the solution of the equations may differ in its last digits
        np.testing.assert_allclose(found.vertices[1::2], stored["vertices"], atol=2e-6)
