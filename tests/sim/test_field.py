"""The field's geometry agrees with the rule books and with itself."""

import numpy as np
import pytest

from nao_course.sim import DIMENSIONS, Field, Landmark


@pytest.mark.parametrize(
    ("year", "half", "corners_l", "corners_t", "posts"),
    [
        # Counted by hand on the rule books' drawings; half a field ends at the halfway line, in two more L.
        (2012, False, 8, 6, 4),
        (2012, True, 6, 2, 2),
        (2013, False, 8, 6, 4),
        (2025, False, 12, 10, 4),
        (2025, True, 8, 4, 2),
    ],
)
def test_landmarks_are_as_many_as_on_the_drawing(year, half, corners_l, corners_t, posts):
    shapes = [mark.shape for mark in Field(year, half).landmarks]
    assert (shapes.count("L"), shapes.count("T"), shapes.count("post")) == (corners_l, corners_t, posts)


@pytest.mark.parametrize("year", DIMENSIONS)
@pytest.mark.parametrize("half", [True, False])
def test_every_corner_lies_where_two_lines_at_right_angles_meet(year, half):
    field = Field(year, half)
    for mark in field.landmarks:
        if mark.kind != "corner":
            continue
        x0, y0, x1, y1 = field.lines.T
        on = (np.minimum(x0, x1) <= mark.x) & (mark.x <= np.maximum(x0, x1))
        on &= (np.minimum(y0, y1) <= mark.y) & (mark.y <= np.maximum(y0, y1))
        along_x = (y0 == y1)[on]
        assert along_x.any() and (~along_x).any(), mark


@pytest.mark.parametrize("year", DIMENSIONS)
def test_a_field_is_symmetric_and_its_half_is_the_positive_half(year):
    field = Field(year, half=False)
    turned = {(round(-m.x, 9), round(-m.y, 9), m.shape) for m in field.landmarks}
    assert turned == {(round(m.x, 9), round(m.y, 9), m.shape) for m in field.landmarks}
    half, whole = Field(year, True), Field(year, False)
    own = {(m.x, m.y, m.kind) for m in half.landmarks if m.x > 0}
    assert own == {(m.x, m.y, m.kind) for m in whole.landmarks if m.x > 0}


def test_the_seed_papers_field_is_three_by_four_metres_and_detectors_report_its_corners_and_posts():
    field = Field()
    assert (field.x_range, field.y_range) == ((0.0, 3.0), (-2.0, 2.0))
    assert field.posts.tolist() == [[3.0, -0.7], [3.0, 0.7]]
    assert field.carpet == (-0.7, -2.7, 3.7, 2.7)
    with pytest.raises(ValueError, match=r"year must be one of \[2012, 2013, 2025\].*got 1999"):
        Field(1999)
    field = Field(2012)
    assert {mark.detected_as for mark in field.landmarks} == {"corner", "post", None}
    assert all(mark.detected_as in (mark.kind, None) for mark in field.landmarks)
    assert len(field.detectable) == len(field.detectable_positions) == len(field.detectable_kinds)
    assert [[mark.x, mark.y] for mark in field.detectable] == field.detectable_positions.tolist()
    with pytest.raises(ValueError, match="read-only"):
        field.detectable_positions[0] = 0.0
    mark = Landmark(0.0, 0.0, "corner", "L")
    object.__setattr__(mark, "kind", "penalty mark")
    with pytest.raises(AssertionError, match="penalty mark"):
        mark.detected_as  # noqa: B018
