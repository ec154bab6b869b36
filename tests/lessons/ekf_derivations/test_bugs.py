"""The bug hunt: each bug is what its name says, and hides where the lesson says it does."""

import numpy as np
import pytest

from nao_course.lessons.ekf_derivations import bugs


@pytest.fixture
def predictions(solution):
    return bugs.Predictions(solution["motion_jacobians"], solution["predict_covariance"])


def test_each_bug_is_the_formula_of_its_name(solution, predictions, rng):
    theta = 0.7
    root = rng.normal(size=(3, 3))
    covariance, noise = root @ root.T, np.diag([3.0, 1.0, 0.2])
    F, G = solution["motion_jacobians"]((0, 0, theta), bugs.BUG_DRIVE)
    formulas = {
        "FᵀPF": F.T @ covariance @ F + G @ noise @ G.T,
        "GᵀQG": F @ covariance @ F.T + G.T @ noise @ G,
        "noise not rotated": F @ covariance @ F.T + noise,
    }
    assert formulas.keys() == bugs.BUGS.keys()
    for bug, wanted in formulas.items():
        assert np.allclose(predictions.wrong(bug, covariance, theta, bugs.BUG_DRIVE, noise), wanted)


def test_bugs_hide_and_show_at_the_headings_that_the_lesson_names(predictions):
    headings = np.radians([0, 45, 90, 135, 180])
    swapped, unturned, wrong = (
        predictions.off(bug, headings) for bug in ("GᵀQG", "noise not rotated", "FᵀPF")
    )
    assert np.allclose(swapped[[0, 2, 4]], 0, atol=1e-6) and swapped[1] == pytest.approx(3.5, abs=0.05)
    assert np.allclose(unturned[[0, 4]], 0, atol=1e-6) and unturned[2] == pytest.approx(3.5, abs=0.05)
    assert np.allclose(wrong, 0.27, atol=0.01)


def test_the_figure_says_how_the_forgotten_heading_shows_in_many_steps(solution, predictions):
    right, wrong = (predictions.across(bug, np.radians(30))[-1] for bug in ("", "FᵀPF"))
    assert (round(100 * right), round(100 * wrong)) == (28, 8)
    names = ("predict_pose", "motion_jacobians", "predict_covariance")
    drawing = bugs.draw_bug_hunt(*(solution[name] for name in names))
    assert "28 cm across after 3.6 m. FᵀPF" in drawing.alt and "8 cm across" in drawing.alt
    assert len(drawing.figure.axes) == 3 and bugs.BUG_NOISE[0, 0] == pytest.approx(0.09)


def test_a_covariance_is_wrong_by_its_worst_direction():
    for worst in (4.0, 0.25):
        assert bugs.wrong_by(np.eye(3), np.diag([1.0, worst, 9.0])) == pytest.approx(1.0)
    assert bugs.wrong_by(bugs.BUG_POSE, bugs.BUG_POSE) == pytest.approx(0.0)
