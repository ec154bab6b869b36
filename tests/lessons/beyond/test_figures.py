"""The figures of lesson 12: drawn by the student's functions, and from what the benchmarks recorded."""

import numpy as np
import pytest

from nao_course.lessons import beyond
from nao_course.lessons.beyond import recorded
from nao_course.lessons.beyond.figures import COUNTS, FILTERS, FOUND, depleted, lap, lost_filter
from nao_course.lessons.beyond.particles import anywhere


def test_the_robot_finds_itself_only_after_it_has_moved(own):
    said = beyond.draw_finding(own["weigh"], own["resample"]).alt
    assert "after 13 observations 100% of the particles" in said and "after 3 observations 0%" in said


@pytest.mark.slow
def test_most_filters_that_start_anywhere_end_far_from_the_robot_but_state_a_few_centimetres(ekf):
    start, *_, end = lap(2, 12)
    ends = [lost_filter(*ekf[:2], first) for first in anywhere(FILTERS, np.random.default_rng(0))]
    errors = np.array([np.hypot(*(pose - end.pose)[:2]) for pose, _ in ends])
    assert (errors < FOUND).sum() == 13 and errors[errors > FOUND].min() > 1
    assert max(np.trace(covariance[:2, :2]) for _, covariance in ends) < 0.05**2
    assert "13 are within 0.3 m" in beyond.draw_lost_filters(*ekf[:2]).alt
    pose, _ = lost_filter(*ekf[:2], start.pose)  # a filter that starts near the robot finds it
    assert np.hypot(*(pose - end.pose)[:2]) < 0.15


@pytest.mark.slow
def test_of_a_hundred_particles_one_has_descendants_and_the_figure_says_so(own):
    functions = own["update_particle_landmark"], own["resample"]
    left = depleted(*functions, COUNTS[-1]).ancestors
    assert beyond.ancestors_left(*functions) == left[-1] == 1
    assert "1 of 100" in beyond.draw_depletion(*functions).alt


def test_the_students_choice_ends_more_certain_than_random_moves(own, ekf):
    said = beyond.draw_journeys(own["choose_move"], *ekf).alt
    assert "with random moves the standard deviation is 0.18 m" in said
    assert "with your choice the standard deviation is 0.07 m" in said


@pytest.mark.slow
def test_a_blind_start_ends_less_certain_than_random_moves_and_twelve_live_drives_agree_with_the_recorded(
    own, ekf
):
    sigma = beyond.blind_sigma(own["choose_move"], *ekf)
    assert sigma == pytest.approx(0.33, abs=0.01)
    assert "your choice 33 cm; random moves 23 cm" in beyond.draw_blind_start(own["choose_move"], *ekf).alt
    said = str(beyond.journeys_table(own["choose_move"], ekf))
    assert "0.105" in said and "0.070" in said


@pytest.mark.parametrize("name", ["draw_fast_slam", "draw_two_cameras", "draw_coverage", "draw_moves"])
def test_a_recorded_figure_has_labelled_axes_with_units_and_says_its_numbers(name):
    drawing = getattr(beyond, name)()
    for ax in drawing.figure.axes:
        assert ax.get_ylabel() and (ax.get_xlabel() or len(ax.get_xticklabels()) == 4)
    assert sum(each.isdigit() for each in drawing.alt) > 8


def test_chosen_moves_reduce_the_standard_deviation_by_a_quarter_and_the_filter_stays_consistent():
    found = recorded.read(recorded.MOVES)
    ways = found["variants"]
    assert len(ways["at random"]["sigma"]) == len(ways["smallest variance"]["sigma"]) == 30
    ratio = np.median(ways["smallest variance"]["sigma"]) / np.median(ways["at random"]["sigma"])
    assert ratio < 0.75 and found["saved"][0] == pytest.approx(1 - ratio, abs=1e-3)
    low, high = found["band"]
    assert low < np.mean(ways["smallest variance"]["nees"]) < high
    assert np.median(ways["smallest variance"]["error"]) < np.median(ways["at random"]["error"])


def test_fast_slam_loses_its_first_particles_and_its_consistency_but_the_filter_does_not():
    found = recorded.read(recorded.PARTICLES)
    filtered, *particles = found["rows"]
    low, high = found["band"]
    for move in recorded.AFTER:
        assert low < filtered["nees"][move] < high
        assert all(row["nees"][move] > high for row in particles)
    for row in particles:
        assert row["ancestors"][0] == row["particles"] and row["ancestors"][-1] == 1
    ends = [row["nees"][-1] for row in particles]
    assert ends == sorted(ends, reverse=True)


def test_the_nearest_frontier_knows_a_room_first():
    ways = recorded.read(recorded.EXPLORING)["variants"]
    median = {name: np.median([each or 80 for each in of["enough"]]) for name, of in ways.items()}
    assert median["nearest frontier"] < 0.7 * median["at random"] < 0.7 * median["lanes"]
