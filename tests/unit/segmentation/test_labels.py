"""From surfaces to labels."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from shapery_segmentation.labels import (
    DIRECTIONS,
    ENCLOSED_FROM,
    close_seam,
    enhancing_part,
    fill_enclosed,
    fill_indentations,
)

INDEX = np.stack(np.meshgrid(*(np.arange(41),) * 3, indexing="ij"), axis=-1)
RADIUS = np.linalg.norm(INDEX - 20, axis=-1)
SHELL = (RADIUS <= 14) & (RADIUS > 10)


def test_a_closed_shell_is_filled_to_the_last_voxel() -> None:
    np.testing.assert_array_equal(fill_enclosed(SHELL, 1.0), RADIUS <= 10)


def test_a_shell_with_a_hole_is_filled_and_a_bowl_is_not() -> None:
    cone = INDEX[..., 2] - 20 > 0.85 * RADIUS
    filled = fill_enclosed(SHELL & ~cone, 1.0)
    assert filled[RADIUS <= 4].all()
    assert not filled[RADIUS > 14].any()
    bowl = SHELL & (INDEX[..., 2] <= 20)
    assert not fill_enclosed(bowl, 1.0)[20, 20, 20]


def test_rays_end_at_thirty_millimetres() -> None:
    cone = INDEX[..., 2] - 20 > 0.85 * RADIUS
    # The same voxels, larger: the rim is now 40 mm and more from the middle.
    assert not fill_enclosed(SHELL & ~cone, 4.0)[20, 20, 20]
    # A hole without a way out is a hole at any size.
    assert fill_enclosed(SHELL, 4.0)[20, 20, 20]


def test_ray_counts_equal_looking_along_each_ray() -> None:
    rim = np.random.default_rng(0).random((13, 12, 14)) < 0.08
    found = fill_enclosed(rim, 3.0)
    labels, _ = ndimage.label(np.pad(~rim, 1, constant_values=True))
    holes = (labels[1:-1, 1:-1, 1:-1] != labels[0, 0, 0]) & ~rim
    for i, j, k in np.argwhere(~rim):
        count = 0
        for d in DIRECTIONS:
            for n in range(1, int(30 / (3.0 * np.linalg.norm(d))) + 1):
                p = np.array([i, j, k]) + n * d
                if (p < 0).any() or (p >= rim.shape).any():
                    break
                if rim[tuple(p)]:
                    count += 1
                    break
        assert found[i, j, k] == (count >= ENCLOSED_FROM or holes[i, j, k])


def test_clefts_of_a_core_are_filled_and_what_is_convex_stays() -> None:
    ball = RADIUS <= 12
    assert not fill_indentations(ball, 1.0).any()
    assert not fill_indentations(np.zeros_like(ball), 1.0).any()
    narrow, wide = np.zeros_like(ball), np.zeros_like(ball)
    narrow[20, 20:, :] = True
    wide[17:24, 20:, :] = True
    filled = fill_indentations(ball & ~narrow, 1.0)
    assert not (filled & ~(ball & narrow)).any()
    assert filled[RADIUS <= 9][narrow[RADIUS <= 9]].all()
    assert not fill_indentations(ball & ~wide, 1.0)[20, 26, 20]
    # The same cleft in voxels of 3 mm is wider than what is filled.
    assert not fill_indentations(ball & ~wide, 3.0)[20, 26, 20]
    # A core that fills its array has no indentation.
    assert not fill_indentations(np.ones((4, 5, 6), dtype=np.bool_), 1.0).any()


def test_a_seam_is_closed_where_it_enhances() -> None:
    inside = SHELL.copy()
    inside[20, 20:, :] = False
    closed = close_seam(inside, SHELL, 1.0)
    # All of the slit but its ends at the shell's two surfaces, which a ball of 2 mm does not reach.
    assert closed[SHELL].mean() > 0.99
    assert not (closed & ~SHELL).any()
    np.testing.assert_array_equal(close_seam(inside, np.zeros_like(SHELL), 1.0), inside)


def test_closing_reaches_the_border_of_the_array() -> None:
    slab = np.ones((12, 10, 10), bool)
    slab[6] = False
    assert close_seam(slab, np.ones_like(slab), 1.0)[6, 4, 4]


def test_flecks_and_septa_inside_the_core_are_told_by_the_threshold() -> None:
    core = RADIUS < 12
    rim = core & (RADIUS >= 7)
    septum = core & (INDEX[..., 0] == 20)
    fleck = np.zeros_like(core)
    fleck[30, 20, 20] = True
    skin = core & ~ndimage.binary_erosion(core)
    # Weak voxels in the outer layer stay what the surface says.
    enhancing = (rim | septum) & ~fleck & ~(skin & (INDEX[..., 2] > 25))
    bright = enhancing_part(rim, core & ~rim, enhancing)
    np.testing.assert_array_equal(bright, (rim | septum) & ~fleck)
    # What lies outside of the core is not asked.
    np.testing.assert_array_equal(enhancing_part(rim, core & ~rim, np.ones_like(core)), core)
