"""Connectivity comes back, whatever the faces are, and costs little."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapery_geometry.sequence import read_sequence
from shapery_motion.container.connectivity import pack_connectivity, sorted_faces, unpack_connectivity
from tests.support.motions import difficult_sequences, grid_faces

SEQUENCES = difficult_sequences()


@pytest.mark.parametrize("name", SEQUENCES)
def test_faces_come_back(name: str) -> None:
    sequence = SEQUENCES[name]
    faces = sorted_faces(sequence.faces)
    found = unpack_connectivity(
        memoryview(pack_connectivity(sequence.vertex_count, faces)), sequence.vertex_count, len(faces)
    )
    assert np.array_equal(found, faces)


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 9), st.lists(st.tuples(*[st.integers(0, 8)] * 3), max_size=30))
def test_any_faces_come_back(vertices: int, corners: list[tuple[int, int, int]]) -> None:
    faces = sorted_faces(np.array(corners, dtype=np.int32).reshape(-1, 3) % vertices)
    found = unpack_connectivity(memoryview(pack_connectivity(vertices, faces)), vertices, len(faces))
    assert np.array_equal(found, faces)


def test_sorting_keeps_every_face_and_its_orientation() -> None:
    faces = np.array([[5, 2, 3], [0, 4, 1], [2, 3, 5]], dtype=np.int32)
    assert sorted_faces(faces).tolist() == [[0, 4, 1], [2, 3, 5], [2, 3, 5]]


def test_a_grid_costs_a_few_bits_and_a_shuffled_one_little_more_than_its_order() -> None:
    faces = grid_faces(60, 60)
    n = 3600
    assert len(pack_connectivity(n, sorted_faces(faces))) * 8 / n < 6.0
    order = np.random.default_rng(0).permutation(n).astype(np.int32)
    shuffled = len(pack_connectivity(n, sorted_faces(order[faces]))) * 8 / n
    assert shuffled < np.log2(n) + 3.0


@pytest.mark.data
@pytest.mark.parametrize("name", ["crane", "chickenCrossing", "horse-gallop", "pdance", "pcow", "mmface4d-3k"])
def test_real_meshes_cost_at_most_20_bits_a_vertex(shared_data: object, name: str) -> None:
    sequence = read_sequence(f"{shared_data}/motion/{name}.npz")
    faces, n = sorted_faces(sequence.faces), sequence.vertex_count
    data = pack_connectivity(n, faces)
    assert len(data) * 8 / n < 14.0
    assert np.array_equal(unpack_connectivity(memoryview(data), n, len(faces)), faces)
