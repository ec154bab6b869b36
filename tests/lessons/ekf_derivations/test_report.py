"""What the report's slips would cost: each number of the lesson's text, measured with the solution."""

import numpy as np
import pytest

from nao_course.lessons.ekf_derivations import report


def test_the_pages_slips_cost_what_the_table_says_and_swapped_coordinates_are_off_as_their_formula_says(
    solution, rng
):
    right, page = report.derivative_at_one(solution["motion_jacobians"])
    assert right == pytest.approx(0, abs=1e-12) and page == pytest.approx(np.radians(5))
    away = report.swapped_coordinates(solution["landmark_position"], rng)
    heading, bearing, distance = 0.7, 0.4, 2.0
    right = distance * np.sin(heading + bearing)
    page = np.sin(heading) * distance * np.sin(bearing) + np.cos(heading) * distance * np.cos(bearing)
    assert abs(right - page) == pytest.approx(abs(distance * (np.sin(1.1) - np.cos(0.3))))
    assert 1.2 < np.median(away) < 2.0
    assert 0.08 < report.share_outside(solution["expected_measurement"], rng) < 0.16  # noise behind the wrap
    assert report.half_turns(solution["expected_measurement"], rng) == pytest.approx(0.5, abs=0.04)
    names = ("expected_measurement", "landmark_position", "motion_jacobians")
    shown = repr(report.report_costs(*(solution[name] for name in names)))
    assert "9 cm, not 0" in shown and all(page in shown for page in ("1.2", "1.3", "1.4", "1.5"))


def test_two_landmarks_of_one_look_are_as_correlated_as_the_jacobians_say(solution):
    names = ("landmark_position", "expected_measurement", "landmark_jacobians")
    functions = [solution[name] for name in names]
    errors, correlation = report.two_landmarks(*functions)
    assert np.corrcoef(errors.T)[0, 1] == pytest.approx(correlation, abs=0.04)
    assert "Jacobians give 0.88" in report.draw_two_landmarks(*functions).alt
