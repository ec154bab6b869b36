"""What lesson 03 measures: its figures say their numbers, and the text's are those of its own solution."""

import json

import numpy as np
import pytest

from nao_course.lessons.hough_corners import results
from nao_course.lessons.hough_corners.challenge import CHALLENGE
from nao_course.lessons.hough_corners.labels import DISTANCES, recorded_labels
from nao_course.lessons.hough_corners.measuring import STEPS, count_corners, with_others
from nao_course.lessons.hough_corners.scenes import (
    match_pictures,
    more_rooms,
    other_rooms,
    ready_made_segments,
    real_pictures,
    running_picture,
    three_places,
    tuning_pictures,
)
from nao_course.metrics import PointMatch, corner_cost, mean_interval, total
from tests.lessons.every import label, own, quoted_with_the_locked_opencv, quotes, text
from tests.paths import PROJECT

OWN, TEXT = own("03"), text("03")


def matched(hits, false, missed):
    return PointMatch(np.arange(hits + missed) < hits, false)


def test_costs_are_said_with_their_counts_and_held_against_the_first_and_a_funnel_says_every_count():
    other = [matched(1, 0, 1), matched(1, 1, 1)] * 2
    alt = results.draw_matches({"nothing": [matched(0, 0, 2)] * 4, "other": other}).alt
    assert "nothing: 0 found, 0 false, 8 missed, mean cost 2.00 (95 % from 2.00 to 2.00)" in alt
    assert "other: 4 found, 2 false, 4 missed, mean cost 2.17" in alt and "from nothing 0.17 (95 %" in alt
    counts = dict(zip(STEPS, (10, 9, 7, 7, 2), strict=True))
    alt = results.draw_counts({"here": counts, "there": dict.fromkeys(STEPS, 0)}).alt
    assert "here: in the picture 10, white within 3 px 9" in alt and "two segments, not parallel 2" in alt


def test_without_the_recordings_the_solutions_counts_stand_in_their_place(monkeypatch):
    monkeypatch.setattr(results, "tuning_pictures", tuple)
    monkeypatch.setattr(results, "real_pictures", tuple)
    alt = results.draw_funnel(None, None, None).alt
    assert f"a real NAO, 8 pictures: in the picture {results.REAL[STEPS[0]]}" in alt


def test_the_goal_line_ends_where_the_equation_sees_it_and_half_of_it_is_left_between_the_pictures():
    assert results.last_seen([1, 2, 3], [1.0, 1.0, 0.0]) == 2.5
    assert results.last_seen([1, 2, 3], [1.0, 0.75, 0.25]) == 2.5
    assert np.isnan(results.last_seen([1, 2], [1.0, 1.0])) and np.isnan(results.last_seen([1, 2], [0.0, 0.0]))
    distances = np.arange(3.0, 3.61, 0.1)
    left = results.goal_line_left(distances, label, OWN["erase_background"], runs=(7,))
    assert results.last_seen(distances, left[7]) == pytest.approx(3.3, abs=0.1)
    assert "m measured, 3.3 m by equation 3.2" in results.draw_goal_line(distances, left).alt

    def keep(labels, run):
        return labels

    recorded, own = (results.goal_line_left(DISTANCES, by, keep)[0] for by in (recorded_labels, label))
    assert recorded == pytest.approx(own, abs=0.05)


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
    cost = results.mean_cost(lambda picture: OWN["find_corners"](label(picture)))
    assert cost == pytest.approx(corner_cost(match) / 30)
    quotes(TEXT, f"{match.hits} of {len(match.found)} corners with {match.false} false", f"costs {cost:.2f}")
    steps = (label, OWN["erase_background"], find_segments)
    counts = list(count_corners(tuning_pictures(), *steps).values())
    assert counts == [61, 61, 49, 37, 12]  # these stand in the question "where_corners_go", too
    quotes(TEXT, *(f"{100 * left / counts[0]:.0f} %" for left in counts[3:]))


def test_what_is_said_of_real_pictures_is_what_the_solution_leaves_there(data_dir, monkeypatch):
    monkeypatch.setenv("NAO_COURSE_DATA", str(data_dir))
    steps = (label, OWN["erase_background"], find_segments)
    assert count_corners(real_pictures(), *steps) == results.REAL


def with_centre_lines(labels, gap=10):
    def segments(*values):
        return OWN["merge_edges"](OWN["hough_segments"](*values))

    return with_others(OWN["find_corners"], hough_segments=segments)(labels, gap)


def with_a_larger_gap(labels):
    return OWN["find_corners"](labels, 10)


def against_nothing(pictures, find):
    """Return what is found in all pictures, the mean cost, and the difference from nothing with its interval."""
    matches = match_pictures(lambda picture: find(label(picture)), pictures)
    costs = np.array([corner_cost(match) for match in matches])
    difference = costs - [len(match.found) for match in matches]
    return total(matches), costs.mean(), difference.mean(), mean_interval(difference)


@pytest.mark.slow
def test_with_centre_lines_the_detector_is_better_than_nothing_and_the_text_says_by_how_much():
    match, cost, less, (low, high) = against_nothing(tuning_pictures(), with_centre_lines)
    assert match.false == 0 and high < 0
    counts = f"{match.hits} of {len(match.found)} corners"
    quotes(TEXT, counts, f"cost is {cost:.2f}", f"{less:.2f} ({low:.2f} to {high:.2f})")


def matched_in(pictures, *detectors):
    """Return the sums of each detector's matches, and its costs picture by picture."""
    found = [match_pictures(lambda picture, find=find: find(label(picture)), pictures) for find in detectors]
    costs = [np.array([corner_cost(match) for match in each]) for each in found]
    return [total(each) for each in found], costs


@pytest.mark.slow
def test_in_other_rooms_only_both_repairs_are_better_than_nothing_and_the_text_says_by_how_much():
    detectors = (OWN["find_corners"], with_a_larger_gap, with_centre_lines)
    matches, costs = matched_in(other_rooms(), *detectors)
    nothing = np.array([len(picture.truth.corners) for picture in other_rooms()])
    intervals = [mean_interval(each - nothing) for each in costs]
    assert [high < 0 for _, high in intervals] == [False, False, True]
    rows = ("edges, gap 5", "edges, gap 10", "centre lines, gap 10")
    for row, match, cost, (low, high) in zip(rows, matches, costs, intervals, strict=True):
        difference = f"{(cost - nothing).mean():.2f} ({low:.2f} to {high:.2f})"
        assert f"| {row} | {match.hits} | {match.false} | {cost.mean():.2f} | {difference} |" in TEXT
    for before, confirmed in ((costs[1], True), (costs[0], False)):
        assert (mean_interval(costs[2] - before)[1] < 0) == confirmed


@pytest.mark.slow
def test_in_150_pictures_both_repairs_are_better_than_none_and_the_text_says_by_how_much():
    (first, centres), costs = matched_in(more_rooms(), OWN["find_corners"], with_centre_lines)
    low, high = mean_interval(costs[1] - costs[0])
    assert high < 0
    quotes(
        TEXT,
        f"{(costs[1] - costs[0]).mean():.2f} ({low:.2f} to {high:.2f})",
        f"{centres.hits} corners are found instead of {first.hits}",
        f"{centres.false} are false instead of {first.false}",
    )


@pytest.mark.slow
def test_the_false_corners_of_the_detector_are_in_the_two_pictures_that_the_text_names():
    found = match_pictures(lambda picture: OWN["find_corners"](label(picture)), tuning_pictures())
    assert {number: match.false for number, match in enumerate(found) if match.false} == {27: 2, 8: 1}
    assert "(17, 13, 10, 27, 8), start=1" in TEXT
    assert "All three false corners of your detector are in pictures 4 and 5" in TEXT


@pytest.mark.slow
def test_with_centre_lines_the_gap_of_the_text_costs_least():
    costs = {
        gap: against_nothing(tuning_pictures(), lambda labels, gap=gap: with_centre_lines(labels, gap))[1]
        for gap in (5, 7, 10, 14)
    }
    assert min(costs, key=costs.get) == 10 and "a gap of 10 is the best of 5, 7, 10 and 14" in TEXT


@pytest.mark.slow
def test_the_cost_depends_little_on_the_width_as_the_text_says():
    costs = []
    for width in (12.0, 16.0, 20.0, 24.0):

        def centres(labels, gap=10, length=40, width=width):
            return OWN["merge_edges"](OWN["hough_segments"](labels, gap, length), width)

        find = with_others(OWN["find_corners"], hough_segments=centres)
        costs.append(against_nothing(tuning_pictures(), lambda labels, find=find: find(labels, 10))[1])
    quotes(TEXT, "12 to 24 pixels", f"{min(costs):.2f} and {max(costs):.2f}")


@quoted_with_the_locked_opencv
def test_far_lines_are_merged_and_the_running_picture_gets_fewer_segments_as_the_text_says():
    far = list(three_places().values())[2]
    white = OWN["line_picture"](OWN["erase_background"](label(far.pixels)))
    segments = OWN["hough_segments"](white, 10)
    wide, narrow = (len(OWN["merge_edges"](segments, width)) for width in (20.0, 4.0))
    quotes(TEXT, f"{len(segments)} segments into {wide} centre lines", f"only {narrow}")
    place = running_picture()
    white = OWN["line_picture"](label(place.pixels))
    kept = OWN["line_picture"](OWN["erase_background"](label(place.pixels)))
    raw, labelled, erased = (len(ready_made_segments(each)) for each in (place.pixels, white, kept))
    assert len(place.truth.corners) == 3
    assert erased < labelled < raw
    quotes(TEXT, f"finds {raw} segments")
    found = OWN["find_corners"](label(place.pixels))
    near = found[np.linalg.norm(found - place.truth.corners[2], axis=1) < 10]
    assert len(found) == 4 and f"{np.hypot(*(near[1] - near[0])):.0f} pixels apart" in TEXT


@pytest.mark.slow
def test_it_is_so_in_the_pictures_of_the_challenge_too():
    unseen = [CHALLENGE.make(number) for number in CHALLENGE.seeds]
    match, cost, less, (low, high) = against_nothing(unseen, with_centre_lines)
    counts = f"{match.hits} | {match.false} | {cost:.2f} | {less:.2f} ({low:.2f} to {high:.2f})"
    assert f"| centre lines, gap 10 | {counts} |" in TEXT
    assert high < 0
