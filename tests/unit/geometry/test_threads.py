"""One thread of linear algebra, and as many as before afterwards."""

from __future__ import annotations

import pytest

from shapery_geometry import threads


def counts() -> list[int]:
    return [get() for get, _ in threads._controls()]


def test_one_thread_within_and_as_before_afterwards() -> None:
    before = counts()
    if not before:
        pytest.skip("neither NumPy nor SciPy brings an OpenBLAS of its own")
    with threads.one_blas_thread():
        assert set(counts()) == {1}
    assert counts() == before


def test_a_function_may_be_decorated() -> None:
    assert set(threads.one_blas_thread()(counts)()) <= {1}
