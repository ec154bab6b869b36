"""The three numbers of the control panel: laws of a consistent estimate, and what is not known is not shown."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.slam import Estimate
from nao_course.widgets.control_panel.accuracy import accuracy, numbers_html, say_length

COVARIANCE = np.array([[0.04, 0.01, 0.002], [0.01, 0.02, 0.001], [0.002, 0.001, 0.01]])
DRAWS = 2000


def estimate(pose=(0.0, 0.0, 0.0), covariance=COVARIANCE):
    return Estimate(Pose(*pose), covariance, np.empty((0, 2)), np.empty((0, 2, 2)))


def verdicts(stated, rng):
    """Return the fraction of each verdict over errors that have `COVARIANCE`."""
    errors = rng.multivariate_normal(np.zeros(3), COVARIANCE, DRAWS)
    found = [accuracy(estimate(error, stated), Pose()).verdict for error in errors]
    return {verdict: found.count(verdict) / DRAWS for verdict in set(found)}


def test_an_estimate_with_the_covariance_of_its_errors_is_consistent_in_95_percent_of_the_cases():
    rng = np.random.default_rng(0)
    assert verdicts(COVARIANCE, rng)["consistent"] == pytest.approx(0.95, abs=0.015)
    assert verdicts(COVARIANCE / 50, rng)["overconfident"] > 0.95
    assert verdicts(COVARIANCE * 50, rng)["underconfident"] > 0.95


def test_the_radius_of_a_round_covariance_holds_95_percent_of_the_errors():
    rng = np.random.default_rng(1)
    covariance = np.diag([0.09, 0.09, 0.01])
    radius = accuracy(estimate(covariance=covariance), None).radius
    errors = rng.multivariate_normal(np.zeros(3), covariance, DRAWS)
    assert np.mean(np.hypot(*errors[:, :2].T) < radius) == pytest.approx(0.95, abs=0.015)


def test_numbers_do_not_change_when_estimate_truth_and_covariance_are_turned_together():
    turn = Pose(1.0, -2.0, 0.7)
    J = np.eye(3)
    J[:2, :2] = [[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]]
    before = accuracy(estimate((0.1, 0.2, 0.05)), Pose(0.0, 0.1, 0.0))
    at = turn @ Pose(0.1, 0.2, 0.05)
    after = accuracy(estimate(at.as_array(), J @ COVARIANCE @ J.T), turn @ Pose(0.0, 0.1, 0.0))
    assert (after.error, after.radius, after.nees) == pytest.approx(
        (before.error, before.radius, before.nees)
    )


def test_a_value_without_a_variance_does_not_count():
    shown = accuracy(estimate((0.1, 0.0, 0.5), np.diag([0.01, 0.01, 0.0])), Pose())
    assert shown.degrees == 2 and shown.nees == pytest.approx(1.0) and shown.verdict == "consistent"


def test_an_estimate_that_claims_to_be_exact_is_overconfident_as_soon_as_it_is_off():
    exact = np.zeros((3, 3))
    assert accuracy(estimate(covariance=exact), Pose()).verdict == ""
    assert accuracy(estimate((0.1, 0.0, 0.0), exact), Pose()).verdict == "overconfident"


@pytest.mark.parametrize("covariance", [np.full((3, 3), np.nan), np.full((3, 3), np.inf), -np.eye(3)])
def test_a_matrix_that_is_no_covariance_gives_an_error_and_no_verdict(covariance):
    shown = accuracy(estimate((0.3, 0.4, 0.0), covariance), Pose())
    assert shown.error == pytest.approx(0.5) and shown.radius is None and shown.verdict == ""
    assert "not a valid covariance" in numbers_html(shown, has_truth=True, estimated=True)


def test_a_hidden_truth_gives_neither_an_error_nor_a_verdict():
    shown = accuracy(estimate((0.3, 0.4, 0.0)), None)
    assert shown.error is None and shown.verdict == "" and shown.radius > 0
    assert numbers_html(shown, has_truth=True, estimated=True).count("tick Show the truth") == 2
    assert "no truth" in numbers_html(shown, has_truth=False, estimated=True)


def test_the_tiles_say_the_numbers_and_their_verdict():
    html = numbers_html(accuracy(estimate((0.54, 0.72, 0.0)), Pose()), has_truth=True, estimated=True)
    assert "<b>90 cm</b>" in html and "<b>± 51 cm</b>" in html
    assert "; NEES " in html and 'title="NEES' in html
    assert "<b>overconfident</b>" in html and "nao-bad" in html and "nao-good" not in html
    assert (
        numbers_html(accuracy(Pose(0.3, 0.4, 0.0), Pose()), has_truth=True, estimated=False).count("–") == 2
    )


@pytest.mark.parametrize(
    ("metres", "said"), [(0.0, "< 1 cm"), (0.0051, "1 cm"), (0.994, "99 cm"), (1.0, "1.00 m")]
)
def test_lengths_are_whole_centimetres_up_to_a_metre(metres, said):
    assert say_length(metres) == said


@pytest.mark.parametrize(
    ("off", "said"),
    [
        ((0.0, 0.05, 0.0), "5 cm across the heading, where ± 2 cm is claimed"),
        ((0.3, 0.0, 0.0), "30 cm along the heading, where ± 20 cm is claimed"),
        ((0.0, 0.0, 0.2), "11° of heading, where ± 2.8° is claimed"),
    ],
)
def test_an_overconfident_estimate_names_the_axis_that_is_too_small(off, said):
    covariance = np.diag([0.08, 0.01, 0.02]) ** 2
    turn = Pose(0.0, 0.0, 0.5)
    at = turn @ Pose(*off)
    c, s = np.cos(0.5), np.sin(0.5)
    J = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    shown = accuracy(estimate(at.as_array(), J @ covariance @ J.T), turn)
    assert shown.verdict == "overconfident" and said in numbers_html(shown, True, True)
