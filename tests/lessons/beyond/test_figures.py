"""The figures of lesson 12: drawn by the student's functions, and from what the benchmarks recorded."""

import numpy as np
import pytest

from nao_course.lessons import beyond
from nao_course.lessons.beyond.figures import COUNTS, FILTERS, FOUND, depleted, lap, lost_filter
from nao_course.lessons.beyond.particles import anywhere


def test_the_robot_finds_itself_once_it_moved_and_the_students_choice_ends_surer_than_random_moves(own, ekf):
    said = beyond.draw_finding(own["weigh"], own["resample"]).alt
    assert "after 13 observations 100% of the particles" in said and "after 3 observations 0%" in said
    said = beyond.draw_journeys(own["choose_move"], *ekf).alt
    assert "with random moves the standard deviation is 0.18 m" in said
    assert "with your choice the standard deviation is 0.07 m" in said


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


@pytest.mark.slow
def test_a_blind_start_ends_less_sure_than_random_moves_and_twelve_live_drives_are_as_recorded(own, ekf):
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
