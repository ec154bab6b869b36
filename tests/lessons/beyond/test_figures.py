"""The figures of lesson 12: drawn by the student's functions, and from what the benchmarks recorded."""

import numpy as np
import pytest

from nao_course.lessons import beyond
from nao_course.lessons.beyond import recorded
from nao_course.lessons.beyond.figures import COUNTS, depleted


def test_the_robot_finds_itself_only_after_it_has_moved(own):
    said = beyond.draw_finding(own["weigh"], own["resample"]).alt
    assert "after 13 looks 100% of the particles" in said and "after 3 looks 0%" in said


def test_ancestors_only_become_fewer(own):
    left = depleted(own["update_particle_landmark"], own["resample"], 10).ancestors
    assert left[0] == 10 and left[-1] == 1 and (np.diff(left) <= 0).all()


@pytest.mark.slow
def test_of_a_hundred_particles_one_has_descendants_and_the_figure_says_so(own):
    functions = own["update_particle_landmark"], own["resample"]
    left = depleted(*functions, COUNTS[-1]).ancestors
    assert beyond.ancestors_left(*functions) == left[-1] == 1
    assert "1 of 100" in beyond.draw_depletion(*functions).alt


def test_the_students_choice_ends_surer_than_chance(own, ekf):
    said = beyond.draw_journeys(own["choose_move"], *ekf).alt
    assert "at random its standard deviation is 0.18 m" in said
    assert "by your choice its standard deviation is 0.07 m" in said


@pytest.mark.slow
def test_from_a_blind_start_the_students_choice_ends_less_sure_than_chance(own, ekf):
    doubt = beyond.blind_doubt(own["choose_move"], *ekf)
    assert doubt == pytest.approx(0.33, abs=0.01)
    assert "by your choice 33 cm; at random 23 cm" in beyond.draw_blind_start(own["choose_move"], *ekf).alt


@pytest.mark.slow
def test_twelve_live_drives_say_what_thirty_recorded_ones_do(own, ekf):
    said = str(beyond.journeys_table(own["choose_move"], ekf))
    assert "0.105" in said and "0.070" in said


@pytest.mark.parametrize("name", ["draw_fast_slam", "draw_two_cameras", "draw_coverage", "draw_moves"])
def test_a_recorded_figure_has_labelled_axes_with_units_and_says_its_numbers(name):
    drawing = getattr(beyond, name)()
    for ax in drawing.figure.axes:
        assert ax.get_ylabel() and (ax.get_xlabel() or len(ax.get_xticklabels()) == 4)
    assert sum(each.isdigit() for each in drawing.alt) > 8


@pytest.mark.parametrize("name", ["fast_slam_table", "cameras_table", "coverage_table", "moves_table"])
def test_a_recorded_table_has_a_number_in_each_row(name):
    _, *rows = str(getattr(beyond, name)()).splitlines()
    assert len(rows) >= 3 and all(any(letter.isdigit() for letter in row) for row in rows)


def test_what_is_known_after_some_moves_is_the_median_of_the_rooms():
    assert beyond.known_after("at random", 30) == pytest.approx(77, abs=1)
    assert beyond.known_after("nearest frontier", 79) == pytest.approx(100, abs=0.5)


# --- what the issue asks for ---


def test_the_informative_move_leaves_a_quarter_less_doubt_than_chance_and_states_it_honestly():
    found = recorded.read(recorded.MOVES)
    ways = found["ways"]
    assert len(ways["at random"]["doubt"]) == len(ways["what tells most"]["doubt"]) == 30
    ratio = np.median(ways["what tells most"]["doubt"]) / np.median(ways["at random"]["doubt"])
    assert ratio < 0.75 and found["saved"][0] == pytest.approx(1 - ratio, abs=1e-3)
    low, high = found["band"]
    assert low < np.mean(ways["what tells most"]["nees"]) < high
    assert np.median(ways["what tells most"]["off"]) < np.median(ways["at random"]["off"])


def test_fast_slam_loses_its_ancestors_and_its_honesty_and_the_filter_does_not():
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


def test_the_formulas_of_one_camera_and_of_both_hold():
    for row in recorded.read(recorded.CAMERAS)["rows"]:
        assert row["one"] == pytest.approx(row["one_formula"], rel=0.12)
        assert row["both"] == pytest.approx(row["both_formula"], rel=0.04)


def test_the_nearest_frontier_knows_a_room_first():
    ways = recorded.read(recorded.EXPLORING)["ways"]
    median = {name: np.median([each or 80 for each in of["enough"]]) for name, of in ways.items()}
    assert median["nearest frontier"] < 0.7 * median["at random"] < 0.7 * median["lawn-mower"]
