"""Heads that several tests look at; drawn once."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_segmentation.phantoms import HeadPhantom, TumorSpec, head_phantom

SHAPE, SPACING = (126, 150, 126), (1.25, 1.25, 1.25)
"""Voxels that the working grid keeps, and as few of them as a head allows."""


@pytest.fixture(scope="session")
def head() -> HeadPhantom:
    """A whole head with one tumor."""
    return head_phantom(np.random.default_rng(3), SHAPE, SPACING, tumors=[TumorSpec(radius=15.0)])


@pytest.fixture(scope="session")
def healthy_head() -> HeadPhantom:
    """A whole head without a tumor."""
    return head_phantom(np.random.default_rng(4), SHAPE, SPACING, tumors=())


@pytest.fixture(scope="session")
def tilted_head() -> HeadPhantom:
    """A stripped brain, tilted and off centre, with a tumor."""
    return head_phantom(
        np.random.default_rng(5),
        SHAPE,
        SPACING,
        tumors=[TumorSpec(radius=14.0)],
        rotation=(4.0, -7.0, 14.0),
        shift=(3.0, -4.0, 2.0),
        stripped=True,
    )
