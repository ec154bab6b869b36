"""A worn carpet: what lies where."""

import numpy as np

from nao_course.sim.carpet import TEXEL, Wear, carpet_levels

EXTENT, LINES = (-1.0, -1.2, 1.0, 1.2), (-0.6, -0.8, 0.6, 0.8)
NONE = dict.fromkeys(("grain", "mottle", "seams", "specks", "crumbs", "tape"), 0.0)
GREEN = (40, 120, 50)


def test_tape_lies_outside_the_outer_lines_and_joints_are_darker_than_the_carpet():
    carpet = carpet_levels(EXTENT, LINES, GREEN, Wear(**NONE | {"tape": 5.0}), 3)[0][..., :3]
    rows, columns = np.nonzero((carpet != GREEN).any(axis=2))
    x, y = EXTENT[0] + (columns + 0.5) * TEXEL, EXTENT[1] + (rows + 0.5) * TEXEL
    beyond = np.maximum(np.abs(x) - LINES[2], np.abs(y) - LINES[3])  # m, outside of the nearest line
    assert len(x) > 1000
    assert (beyond > 0).mean() > 0.95 and (beyond < 0.2).all()
    for side in (x < -0.6, x > 0.6, y < -0.8, y > 0.8):
        assert side.any()
    carpet = carpet_levels(EXTENT, LINES, GREEN, Wear(**NONE | {"seams": 0.5}), 4)[0][..., 1].astype(int)
    rows = np.median(carpet, axis=1)
    assert rows.min() < GREEN[1] - 5 and rows.max() == GREEN[1]
