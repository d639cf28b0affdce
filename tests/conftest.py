"""Fixtures that every test folder shares."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

# The tests run side by side, and a second thread of linear algebra on the same processors only waits for the first.
# Read when NumPy is loaded, so it is said before; processes that tests start inherit it.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real volumes, meshes and motions beside the checkout; `SHAPERY_TEST_DATA` names another place."""
    folder = Path(os.environ.get("SHAPERY_TEST_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("real data is not beside this checkout (set SHAPERY_TEST_DATA to its folder)")
    return folder
