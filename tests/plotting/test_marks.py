"""Marks in a panel's small pictures lie at their pixels, on a copy."""

import numpy as np
import pytest

from nao_course.plotting.marks import TRUE, at_scale, enlarged, rgb, with_crosses, with_rings
from nao_course.plotting.style import FOUND

PLAIN = np.full((60, 80, 3), 90, dtype=np.uint8)


def test_a_cross_lies_at_its_point_on_a_copy_and_its_white_rim_is_seen_on_a_dark_wall_and_on_a_line():
    shown = with_crosses(PLAIN, [(20, 30)])
    changed = np.argwhere((shown != 90).any(axis=2))
    assert changed.mean(axis=0) == pytest.approx([30, 20], abs=0.5)
    assert tuple(shown[30, 20]) == rgb(TRUE) and (PLAIN == 90).all()
    for ground in (0, 255):
        shown = with_crosses(np.full_like(PLAIN, ground), [(40, 30)], scale=2)
        assert (shown != ground).any(axis=2).sum() > 30


def test_a_ring_lies_around_its_point_on_a_copy_and_a_cross_on_it_leaves_both_to_be_seen():
    shown = with_rings(PLAIN, [(40, 20)])
    rows, columns = np.nonzero((shown != 90).any(axis=2))
    assert (rows.mean(), columns.mean()) == pytest.approx((20, 40))
    assert (shown[20, 40] == 90).all() and (PLAIN == 90).all()
    ring = with_rings(PLAIN, [(43, 31)])
    both = with_crosses(ring, [(40, 30)])
    left = [(each == rgb(FOUND)).all(axis=2).sum() for each in (ring, both)]
    assert left[1] > 0.5 * left[0] > 10 and tuple(both[30, 40]) == rgb(TRUE)
    with pytest.raises(ValueError, match=r"corners \(u, v\)"):
        with_rings(PLAIN, np.zeros((2, 3)), "corners (u, v)")


def test_a_pixel_of_an_enlarged_picture_is_a_square_around_its_point(rng):
    picture = rng.integers(0, 255, (4, 5, 3)).astype(np.uint8)
    large = enlarged(picture, 3)
    (u, v), *_ = at_scale([(2, 1)], 3).round().astype(int)
    assert large.shape == (12, 15, 3) and (large[v - 1 : v + 2, u - 1 : u + 2] == picture[1, 2]).all()
    assert at_scale([(-0.5, -0.5), (4.5, 3.5)], 3).tolist() == [[-0.5, -0.5], [14.5, 11.5]]
