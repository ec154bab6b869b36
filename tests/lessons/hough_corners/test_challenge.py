"""The challenge of lesson 03: what is scored, and what is said of wrong answers."""

import numpy as np
import pytest

from nao_course.lessons.hough_corners.challenge import CHALLENGE, PICTURES, judge
from nao_course.lessons.hough_corners.scenes import CornerPicture
from nao_course.metrics import CornerTruth
from tests.paths import PROJECT

PICTURE = CornerPicture(
    np.zeros((240, 320, 3), dtype=np.uint8),
    CornerTruth(np.array([[50.0, 90.0], [200.0, 80.0]]), np.array([[10.0, 10.0]])),
)


def test_the_truth_earns_and_nothing_costs_what_is_missed():
    assert judge(PICTURE.truth.corners, PICTURE).score == pytest.approx(-2.666)
    assert judge(np.zeros((0, 2)), PICTURE).score == 2.0


def test_a_missed_corner_and_a_false_point_cost_and_are_told():
    scored = judge([(50, 90), (120, 30), (120, 60), (12, 10)], PICTURE)
    assert scored.score == pytest.approx(-1.333 + 2 * 5 + 1)
    assert scored.columns == {"found": 1.0, "false": 2.0, "missed": 1.0}
    assert judge(np.zeros((0, 2)), PICTURE).columns == {"found": 0.0, "false": 0.0, "missed": 2.0}


def test_the_text_counts_the_corners_of_the_better_detector():
    text = (PROJECT / "solutions" / "03_hough_corners.md").read_text(encoding="utf-8")
    rows = {row.name: row for row in CHALLENGE.rows}
    nothing, better = (rows[name] for name in ("nothing", "a better detector"))
    hits, false = (round(PICTURES * better.columns[name]) for name in ("found", "false"))
    corners = round(PICTURES * nothing.columns["missed"])
    assert f" {hits} of these {corners} corners with {false} false" in text
