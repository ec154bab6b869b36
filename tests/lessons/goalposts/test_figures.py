"""Figures of lesson 02: what they say is what they show."""

import numpy as np
import pytest

from nao_course.lessons.goalposts import figures
from nao_course.lessons.goalposts.measuring import FootMatch

BLACK = np.zeros((24, 32, 3), dtype=np.uint8)
MATCHES = [
    FootMatch(np.array([True, False]), 1, np.array([0.5, 1.5])),
    FootMatch(np.array([True]), 0, np.array([1.2])),
    FootMatch(np.zeros(0, dtype=bool), 2, np.zeros(0)),
]


def test_feet_are_named_by_picture():
    drawing = figures.draw_feet({"left": BLACK, "right": BLACK}, [[(3, 4)], np.zeros((0, 2))])
    assert drawing.alt.endswith("left: 1 foot at (3, 4); right: 0 feet.") and drawing.photo
    with pytest.raises(ValueError, match="2 pictures need as many"):
        figures.draw_feet({"left": BLACK, "right": BLACK}, [[(3, 4)]])


def test_a_column_says_its_foot_its_green_and_its_run():
    labels = np.array([[0, 2, 2, 2, 1, 3, 1, 1], [0] * 8, [2, 2, 0, 2, 0, 0, 1, 1]], dtype=np.uint8).T
    said = figures.draw_column(labels, [0, 1, 2], look_down=3).alt
    assert "Column 0: lowest yellow at 3, 2 of 3 pixels below it green, run of 3 pixels." in said
    assert "Column 1 has no yellow." in said
    assert "Column 2: lowest yellow at 3, 1 of 3 pixels below it green, run of 1 pixels." in said


def test_the_height_says_where_it_meets_its_limits():
    line = np.linspace(1, 8, 701)
    for tenth, said in ((40, "meets a tenth at 6.0 m."), (24, "stays above a tenth.")):
        drawing = figures.draw_heights([2.0], [110], (line, 240 / line), {"a fifth": 48, "a tenth": tenth})
        assert drawing.alt.endswith(f"to 8.0 m. Equation 2.1 meets a fifth at 5.0 m, {said}")


def test_recall_counts_feet_and_precision_points_by_distance_and_a_table_their_sum():
    assert figures.recall_counts(MATCHES) == {0: (1, 1), 1: (1, 2)}
    assert figures.precision_counts(MATCHES) == {0: (1, 2), 1: (1, 1)}
    assert figures.recall_counts(MATCHES, width=2.0) == {0: (2, 3)}
    at_the_edge = [FootMatch(np.array([True]), 0, np.array([6.0000000004]))]
    assert figures.recall_counts(at_the_edge) == figures.precision_counts(at_the_edge) == {5: (1, 1)}
    (row,) = figures.score_table({"forty": {"yours": MATCHES}}).rows
    assert row == ("forty", "yours", "2 of 3", "21% to 94%", "3")
