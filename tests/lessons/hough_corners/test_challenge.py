"""The challenge of lesson 03: what is scored, and what is said of wrong answers."""

import numpy as np
import pytest

from benchmarks.challenges import margin
from nao_course.challenges import CaseResult, Run
from nao_course.lessons.hough_corners.challenge import CHALLENGE, PICTURES, judge
from nao_course.lessons.hough_corners.scenes import CornerPicture
from nao_course.metrics import CornerTruth, mean_interval
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


def test_what_is_no_points_is_said():
    for answer in (None, "corners", np.zeros((2, 3)), [(np.nan, 1.0)]):
        with pytest.raises((TypeError, ValueError)):
            judge(answer, PICTURE)


def test_less_is_better_and_a_failing_entry_pays_more_than_nothing():
    assert CHALLENGE.beats(-1.0, 0.0) and len(CHALLENGE.seeds) == PICTURES
    nothing = next(row for row in CHALLENGE.rows if row.name == "nothing")
    assert max(nothing.cases) <= CHALLENGE.nothing
    assert CHALLENGE.name_of(0) == "picture 1"


def test_the_figure_shows_the_worst_pictures():
    answers = ([(1, 1), (300, 200)], [(50, 90)], PICTURE.truth.corners)
    scored = [judge(np.array(each, dtype=float), PICTURE) for each in answers]
    results = tuple(
        CaseResult(name, name, each.score, each.columns, each.kept)
        for name, each in zip(("picture 1", "picture 2", "picture 3"), scored, strict=True)
    )
    assert (
        "The worst are picture 1 with 12.00, picture 2 with -0.33"
        in CHALLENGE.figure(Run(CHALLENGE, results)).alt
    )


def test_the_text_says_what_the_board_says():
    text = (PROJECT / "solutions" / "03_hough_corners.md").read_text(encoding="utf-8")
    rows = {row.name: row for row in CHALLENGE.rows}
    paper, nothing, own, better = (
        rows[name]
        for name in ("the paper's, infinite lines", "nothing", "the reference", "a better detector")
    )
    assert (
        f"Reporting nothing costs {nothing.score:.2f}." in text
        and f"board, costs {own.score:.2f}, and the" in text
    )
    assert (
        f"minimum saturation, costs {paper.score:.2f}.\n" in text
        and f"costs {better.score:.2f}; it beats" in text
    )
    hits, false = (round(PICTURES * better.columns[name]) for name in ("found", "false"))
    corners = round(PICTURES * nothing.columns["missed"])
    assert f"finds {hits} of these {corners} corners with {false} false ones" in text
    mean, low, high = margin(own.cases, better.cases)
    assert f"beats the reference by {mean:.2f} (95 % interval {low:.2f} to {high:.2f})" in text
    low, high = mean_interval(np.subtract(own.cases, nothing.cases))
    assert (
        f"95 % interval of its difference from nothing, {low:.2f} to {high:.2f}, contains 0" in text
        and low < 0 < high
    )
