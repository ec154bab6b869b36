"""What the report's slips would cost: each number of the lesson's text, measured with the solution."""

import numpy as np
import pytest

from nao_course.lessons.ekf_derivations.report import (
    derivative_at_one,
    draw_two_landmarks,
    half_turns,
    report_costs,
    share_outside,
    swapped_coordinates,
    two_landmarks,
)


def test_the_slope_at_the_pages_value_makes_y_uncertain_where_it_is_not(solution):
    right, page = derivative_at_one(solution["motion_jacobians"])
    assert right == pytest.approx(0, abs=1e-12) and page == pytest.approx(np.radians(5))


def test_swapped_coordinates_are_off_as_their_formula_says(solution, rng):
    away = swapped_coordinates(solution["landmark_position"], rng)
    heading, bearing, distance = 0.7, 0.4, 2.0
    right = distance * np.sin(heading + bearing)
    page = np.sin(heading) * distance * np.sin(bearing) + np.cos(heading) * distance * np.cos(bearing)
    assert abs(right - page) == pytest.approx(abs(distance * (np.sin(1.1) - np.cos(0.3))))
    assert 1.2 < np.median(away) < 2.0


def test_noise_behind_the_wrap_leaves_the_range_and_noise_inside_does_not(solution, rng):
    look = solution["expected_measurement"]
    assert 0.08 < share_outside(look, rng) < 0.16


def test_the_pages_arctan_is_wrong_on_half_of_the_field(solution, rng):
    assert half_turns(solution["expected_measurement"], rng) == pytest.approx(0.5, abs=0.04)


def test_the_table_has_a_row_for_each_slip(solution):
    names = ("expected_measurement", "landmark_position", "motion_jacobians")
    shown = repr(report_costs(*(solution[name] for name in names)))
    assert "9 cm, not 0" in shown and all(page in shown for page in ("1.2", "1.3", "1.4", "1.5"))


def test_two_landmarks_of_one_look_are_as_correlated_as_the_jacobians_say(solution):
    names = ("landmark_position", "expected_measurement", "landmark_jacobians")
    functions = [solution[name] for name in names]
    errors, correlation = two_landmarks(*functions)
    assert np.corrcoef(errors.T)[0, 1] == pytest.approx(correlation, abs=0.04)
    assert "Jacobians give 0.88" in draw_two_landmarks(*functions).alt
