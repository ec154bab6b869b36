"""Where lesson 03's corners are lost, and what its challenge, figures and stage make of them."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.hough_corners import measuring
from nao_course.lessons.hough_corners.challenge import CHALLENGE, PICTURES, judge
from nao_course.lessons.hough_corners.figures import draw_close_up, draw_segments, draw_votes
from nao_course.lessons.hough_corners.scenes import CornerPicture
from nao_course.metrics import CornerTruth
from nao_course.sim import Truth
from tests.lessons.driven import STAGES, functions_of, look, robot
from tests.lessons.every import text

LABELS = np.ones((48, 64), dtype=np.uint8)
LABELS[20, 10:50] = LABELS[20:40, 30] = 3
PICTURE = CornerPicture(
    np.zeros((48, 64, 3), dtype=np.uint8),
    CornerTruth(np.array([[30.0, 20.0], [5.0, 45.0]]), np.zeros((0, 2))),
)
CROSS = np.array([[10.0, 20.0, 50.0, 20.0], [30.0, 20.0, 30.0, 40.0]])


def counts(labels=LABELS, erase=lambda labels: labels, segments=CROSS):
    return list(
        measuring.count_corners([PICTURE], lambda pixels: labels, erase, lambda kept: segments).values()
    )


def test_a_corner_with_white_and_two_segments_stays_to_the_end_and_each_step_loses_its_own():
    assert counts() == [2, 1, 1, 1, 1]
    assert counts(labels=np.zeros_like(LABELS), segments=np.zeros((0, 4))) == [2, 0, 0, 0, 0]
    assert counts(erase=np.zeros_like, segments=np.zeros((0, 4))) == [2, 1, 0, 0, 0]
    assert counts(segments=np.zeros((0, 4))) == [2, 1, 1, 0, 0]
    assert counts(segments=CROSS[:1]) == [2, 1, 1, 1, 0]
    parallel = np.array([[10.0, 20.0, 50.0, 20.0], [10.0, 23.0, 50.0, 23.0]])
    assert counts(segments=parallel) == [2, 1, 1, 1, 0]


def test_each_segment_is_crossed_with_each_later_one_and_a_step_gets_what_the_one_before_returned():
    segments = [[1.0, 0, 0, 0], [2.0, 0, 0, 0], [3.0, 0, 0, 0]]
    pairs = measuring.all_crossings(segments, lambda first, second: np.array([first[0], second[0]]))
    assert pairs.tolist() == [[1, 2], [1, 3], [2, 3]]
    assert measuring.all_crossings(segments, lambda first, second: None).shape == (0, 2)
    assert measuring.all_crossings([], None).shape == (0, 2)
    got = []
    measuring.count_corners(
        [PICTURE], lambda pixels: LABELS, lambda labels: labels * 0, lambda kept: got.append(kept) or []
    )
    assert (got[0] == 0).all() and got[0].shape == LABELS.shape
    assert list(measuring.count_corners([], None, None, None)) == list(measuring.STEPS)


@pytest.mark.parametrize(("distance", "near"), [(3.0, True), (3.1, False)])
def test_white_is_near_within_three_pixels(distance, near):
    assert measuring.near_white(LABELS, np.array([10.0 - distance, 20.0])) == near


def test_ten_degrees_are_parallel_and_a_function_finds_others_behind_its_names():
    for degrees, crossing in ((9.0, False), (11.0, True)):
        up = 20 * np.tan(np.radians(degrees))
        segments = np.array([[10.0, 20.0, 50.0, 20.0], [10.0, 20 - up, 50.0, 20 + up]])
        assert measuring.near_segments(segments, np.array([30.0, 20.0])) == (True, crossing)
    assert measuring.near_segments(CROSS, np.array([30.0, 13.9])) == (False, False)
    other = measuring.with_others(use, double=lambda x: 10 * x)
    assert (other(2), other(2, 3), other(2, added=1)) == (20, 60, 21)
    assert use(2) == 4 and other.__name__ == "use"


def double(x):
    return 2 * x


def use(x, factor=1, *, added=0):
    return factor * double(x) + added


SCENE = CornerPicture(
    np.zeros((240, 320, 3), dtype=np.uint8),
    CornerTruth(np.array([[50.0, 90.0], [200.0, 80.0]]), np.array([[10.0, 10.0]])),
)


def test_the_truth_earns_and_misses_and_false_points_cost_and_the_text_counts_those_of_the_better_detector():
    assert judge(SCENE.truth.corners, SCENE).score == pytest.approx(-2.666)
    assert judge(np.zeros((0, 2)), SCENE).score == 2.0
    scored = judge([(50, 90), (120, 30), (120, 60), (12, 10)], SCENE)
    assert scored.score == pytest.approx(-1.333 + 2 * 5 + 1)
    assert scored.columns == {"found": 1.0, "false": 2.0, "missed": 1.0}
    assert judge(np.zeros((0, 2)), SCENE).columns == {"found": 0.0, "false": 0.0, "missed": 2.0}
    rows = {row.name: row for row in CHALLENGE.rows}
    nothing, better = (rows[name] for name in ("nothing", "a better detector"))
    hits, false = (round(PICTURES * better.columns[name]) for name in ("found", "false"))
    corners = round(PICTURES * nothing.columns["missed"])
    assert f" {hits} of these {corners} corners with {false} false" in text("03")


BLACK = np.zeros((24, 32, 3), dtype=np.uint8)
TWO = [(2, 3, 20, 3), (2, 3, 2, 20)]


def test_segments_and_corners_are_counted_also_in_a_close_up_and_missing_segments_are_refused():
    assert draw_segments({"here": BLACK}, [TWO]).alt.endswith("here: 2 segments.")
    both = draw_segments({"a": BLACK, "b": BLACK}, [TWO, np.zeros((0, 4))], [[(2, 3)], np.zeros((0, 2))]).alt
    assert "a: 2 segments and 1 corner at (2, 3)" in both and "b: 0 segments and 0 corners." in both
    for given in (({}, []), ({"a": BLACK}, []), ({"a": BLACK}, [TWO], [[], []])):
        with pytest.raises(ValueError, match="pictures need"):
            draw_segments(*given)
    with pytest.raises(ValueError, match=r"segments \(u1, v1, u2, v2\)"):
        draw_segments({"a": BLACK}, [[(1, 2, 3)]])
    lines = np.zeros((48, 64), dtype=np.uint8)
    lines[20:26, 10:60] = 255
    segments = [(10, 20, 59, 20), (10, 25, 59, 25), (0, 45, 8, 45)]
    drawn = draw_close_up(lines, segments, (30, 23))
    assert "300 white pixels, 108 edge pixels, 2 segments along the edges" in drawn.alt
    assert "The most votes are 50 at 89 degrees and 2 px and 49 at 91" in draw_votes(lines, (30, 23)).alt


def test_what_is_marked_is_a_corner_of_the_lines_and_a_picture_without_corners_has_none():
    labels = STAGES["labels"]
    nao = robot(Pose(1.3, -0.4, -0.6))
    found = look("corners", nao, labels, **functions_of(labels)).overlays["corners"]
    match = CornerTruth.of(Truth(nao).picture).match(found.pixels)
    assert match.hits == len(found.pixels) == 1 and match.false == 0
    assert found.text == "1 corner" and np.array_equal(found.result, found.pixels)
    none = look("corners", robot(Pose(1.5, 0.0, np.pi)), labels, **functions_of(labels))
    assert none.overlays["corners"].text == "0 corners"
