"""What lesson 03 measures: its figures say their numbers, and the text's are those of its own solution."""

import json

import numpy as np
import pytest

from nao_course.colours import GREEN, YELLOW, mean_lightness
from nao_course.exercises import load_definitions
from nao_course.lessons.hough_corners import results
from nao_course.lessons.hough_corners.measuring import STEPS, count_corners
from nao_course.lessons.hough_corners.scenes import match_pictures, real_pictures, tuning_pictures
from nao_course.metrics import PointMatch, corner_cost, total
from tests.paths import PROJECT

COLOURS = load_definitions(PROJECT / "solutions" / "01_hsl_filtering.ipynb")
OWN = load_definitions(PROJECT / "solutions" / "03_hough_corners.ipynb")
TEXT = (PROJECT / "solutions" / "03_hough_corners.md").read_text(encoding="utf-8")


def label(picture):
    return COLOURS["color_labels"](
        picture, GREEN, YELLOW, COLOURS["white_threshold"](mean_lightness(picture))
    )


def matched(hits, false, missed):
    return PointMatch(np.arange(hits + missed) < hits, false)


def test_costs_are_said_with_their_counts_and_held_against_the_first():
    alt = results.draw_matches(
        {"nothing": [matched(0, 0, 2)] * 4, "other": [matched(1, 0, 1), matched(1, 1, 1)] * 2}
    ).alt
    assert "nothing: 0 found, 0 false, 8 missed, mean cost 2.00 (95 % from 2.00 to 2.00)" in alt
    assert (
        "other: 4 found, 2 false, 4 missed, mean cost 2.17" in alt
        and "nothing taken off 0.17 (95 % from" in alt
    )


def test_a_funnel_says_every_count():
    counts = dict(zip(STEPS, (10, 9, 7, 7, 2), strict=True))
    alt = results.draw_counts({"here": counts, "there": dict.fromkeys(STEPS, 0)}).alt
    assert "here: in the picture 10, white within 3 px 9" in alt and "two that are not parallel 2" in alt


def test_without_the_recordings_the_solutions_counts_stand_in_their_place(monkeypatch):
    monkeypatch.setattr(results, "tuning_pictures", tuple)
    monkeypatch.setattr(results, "real_pictures", tuple)
    alt = results.draw_funnel(None, None, None).alt
    assert f"a real NAO, 8 pictures: in the picture {results.REAL[STEPS[0]]}" in alt


def test_the_distance_at_which_half_is_left_lies_between_the_pictures():
    assert results.last_seen([1, 2, 3], [1.0, 1.0, 0.0]) == 2.5
    assert results.last_seen([1, 2, 3], [1.0, 0.75, 0.25]) == 2.5
    assert np.isnan(results.last_seen([1, 2], [1.0, 1.0])) and np.isnan(results.last_seen([1, 2], [0.0, 0.0]))


def test_the_goal_line_ends_where_the_equation_sees_it():
    distances = np.arange(3.0, 3.61, 0.1)
    left = results.goal_line_left(distances, label, OWN["erase_background"], runs=(7,))
    assert results.last_seen(distances, left[7]) == pytest.approx(3.3, abs=0.1)
    assert "run of 7: 3.3 m by equation 3.2" in results.draw_goal_line(distances, left).alt


def test_the_table_of_other_pictures_is_what_the_benchmark_recorded():
    recorded = json.loads((PROJECT / "benchmarks" / "results" / "corners.json").read_text(encoding="utf-8"))
    for row, name in (
        ("simulator, a whole field, a full room", "simulator, whole field"),
        ("a real NAO, eight places", "the other 56 real scenes"),
        ("a real NAO on a straight walk", "real straight walk"),
    ):
        nothing, paper = recorded[name]["nothing"], recorded[name]["the paper's"]
        interval = f"{paper['low']:.2f} to {paper['high']:.2f}"
        costs = f"{nothing['missed']} | {nothing['cost']:.2f} | {paper['cost']:.2f} | {interval}"
        assert f"| {row} ({nothing['pictures']}) | {costs} |" in TEXT


def find_segments(labels):
    return OWN["hough_segments"](OWN["line_picture"](labels))


@pytest.mark.slow
def test_the_costs_of_the_text_are_those_of_the_solution():
    match = total(match_pictures(lambda picture: OWN["find_corners"](label(picture)), tuning_pictures()))
    assert f"finds {match.hits} of {len(match.found)} corners with {match.false} false ones" in TEXT
    cost = results.mean_cost(lambda picture: OWN["find_corners"](label(picture)))
    assert cost == pytest.approx(corner_cost(match) / 30) and f"costs {cost:.2f}. On the right" in TEXT
    steps = (label, OWN["erase_background"], find_segments)
    counts = list(count_corners(tuning_pictures(), *steps).values())
    assert counts == [61, 61, 49, 37, 12]  # these stand in the question "where_corners_go", too
    for left in counts[3:]:
        assert f"{left / counts[0]:.0%}".replace("%", " %") in TEXT


def test_what_is_said_of_real_pictures_is_what_the_solution_leaves_there(data_dir, monkeypatch):
    monkeypatch.setenv("NAO_COURSE_DATA", str(data_dir))
    steps = (label, OWN["erase_background"], find_segments)
    assert count_corners(real_pictures(), *steps) == results.REAL
