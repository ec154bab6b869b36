"""The three numbers of the control panel: laws of a consistent estimate, and what is not known is not shown."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nao_course.geometry import Pose
from nao_course.sim import Truth
from nao_course.slam import DeadReckoning, Estimate
from nao_course.widgets import ControlPanel
from nao_course.widgets.control_panel.accuracy import accuracy, numbers_html, say_length
from nao_course.widgets.vector_map import ShortAxis
from tests.widgets.robots import clean_nao

COVARIANCE = np.array([[0.04, 0.01, 0.002], [0.01, 0.02, 0.001], [0.002, 0.001, 0.01]])
DRAWS = 2000


def estimate(pose=(0.0, 0.0, 0.0), covariance=COVARIANCE):
    return Estimate(Pose(*pose), covariance, np.empty((0, 2)), np.empty((0, 2, 2)))


def verdicts(stated, rng):
    """Return the fraction of each verdict over errors that have `COVARIANCE`."""
    errors = rng.multivariate_normal(np.zeros(3), COVARIANCE, DRAWS)
    found = [accuracy(estimate(error, stated), Pose()).verdict for error in errors]
    return {verdict: found.count(verdict) / DRAWS for verdict in set(found)}


@pytest.mark.slow
def test_an_estimate_with_the_covariance_of_its_errors_is_consistent_in_95_percent_of_the_cases():
    rng = np.random.default_rng(0)
    assert verdicts(COVARIANCE, rng)["consistent"] == pytest.approx(0.95, abs=0.015)
    assert verdicts(COVARIANCE / 50, rng)["overconfident"] > 0.95
    assert verdicts(COVARIANCE * 50, rng)["underconfident"] > 0.95


def test_the_radius_of_a_round_covariance_holds_95_percent_and_numbers_do_not_change_with_the_frame():
    rng = np.random.default_rng(1)
    covariance = np.diag([0.09, 0.09, 0.01])
    radius = accuracy(estimate(covariance=covariance), None).radius
    errors = rng.multivariate_normal(np.zeros(3), covariance, DRAWS)
    assert np.mean(np.hypot(*errors[:, :2].T) < radius) == pytest.approx(0.95, abs=0.015)
    turn = Pose(1.0, -2.0, 0.7)
    J = np.eye(3)
    J[:2, :2] = [[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]]
    before = accuracy(estimate((0.1, 0.2, 0.05)), Pose(0.0, 0.1, 0.0))
    at = turn @ Pose(0.1, 0.2, 0.05)
    after = accuracy(estimate(at.as_array(), J @ COVARIANCE @ J.T), turn @ Pose(0.0, 0.1, 0.0))
    for name in ("error", "radius", "nees"):
        assert getattr(after, name) == pytest.approx(getattr(before, name))


def test_a_value_without_a_variance_does_not_count_and_the_panel_draws_the_axis_that_is_too_small():
    shown = accuracy(estimate((0.1, 0.0, 0.5), np.diag([0.01, 0.01, 0.0])), Pose())
    assert shown.degrees == 2 and shown.nees == pytest.approx(1.0) and shown.verdict == "consistent"
    exact = np.zeros((3, 3))
    assert accuracy(estimate(covariance=exact), Pose()).verdict == ""
    assert accuracy(estimate((0.1, 0.0, 0.0), exact), Pose()).verdict == "overconfident"

    class Sure(DeadReckoning):
        def estimate(self):
            return estimate((0.0, 0.06, 0.0), np.diag([0.05, 0.01, 0.01]) ** 2)

    nao = clean_nao()
    panel = ControlPanel(nao, Truth(nao), Sure())
    short = panel._screen.contents().short
    assert (short.direction, short.error) == pytest.approx((-np.pi / 2, 0.06))
    assert isinstance(short, ShortAxis) and short.claimed == pytest.approx(0.0245, abs=1e-4)
    panel.show_truth = False
    assert panel._screen.contents().short is None


@pytest.mark.parametrize("covariance", [np.full((3, 3), np.nan), np.full((3, 3), np.inf), -np.eye(3)])
def test_a_matrix_that_is_no_covariance_gives_an_error_and_no_verdict(covariance):
    shown = accuracy(estimate((0.3, 0.4, 0.0), covariance), Pose())
    assert shown.error == pytest.approx(0.5) and shown.radius is None and shown.verdict == ""
    assert "not a valid covariance" in numbers_html(shown, "tick Show the truth", True)


def test_the_tiles_say_the_numbers_and_their_verdict_and_a_hidden_truth_gives_neither_error_nor_verdict():
    shown = accuracy(estimate((0.3, 0.4, 0.0)), None)
    assert shown.error is None and shown.verdict == "" and shown.radius > 0
    assert numbers_html(shown, "tick Show the truth", True).count("tick Show the truth") == 2
    assert "no truth" in numbers_html(shown, "no truth", True)
    assert "if its error fits its uncertainty." in numbers_html(shown, "no truth", True)
    html = numbers_html(accuracy(estimate((0.54, 0.72, 0.0)), Pose()), "tick Show the truth", True)
    said = {0.0: "< 1 cm", 0.0051: "1 cm", 0.994: "99 cm", 1.0: "1.00 m"}
    assert {metres: say_length(metres) for metres in said} == said
    assert "<b>90 cm</b>" in html and "<b>± 51 cm</b>" in html
    assert "; NEES " in html and ". NEES, the normalised" in html
    assert "<b>overconfident</b>" in html and "nao-bad" in html and "nao-good" not in html
    assert numbers_html(accuracy(Pose(0.3, 0.4, 0.0), Pose()), "no truth", False).count("–") == 2
    covariance = np.diag([0.1, 0.1, 0.05]) ** 2
    html = numbers_html(accuracy(estimate((0.27, 0.0, 0.0), covariance), Pose()), "no truth", True)
    assert "<b>27 cm</b>" in html and "<b>± 24 cm</b>" in html and "<b>consistent</b>" in html
    assert "outside the ellipse, as 1 of 20 is" in html


@pytest.mark.parametrize(
    ("off", "said"),
    [
        ((0.0, 0.05, 0.0), "5 cm across the heading, where ± 2 cm is claimed"),
        ((0.3, 0.0, 0.0), "30 cm along the heading, where ± 20 cm is claimed"),
        ((0.0, 0.0, 0.2), "11.5° of heading, where ± 2.2° is claimed"),
    ],
)
def test_an_overconfident_estimate_names_the_axis_that_is_too_small(off, said):
    covariance = np.diag([0.08, 0.01, 0.02]) ** 2
    turn = Pose(0.0, 0.0, 0.5)
    at = turn @ Pose(*off)
    c, s = np.cos(0.5), np.sin(0.5)
    J = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    shown = accuracy(estimate(at.as_array(), J @ covariance @ J.T), turn)
    assert shown.verdict == "overconfident" and said in numbers_html(shown, "no truth", True)


@given(st.integers(0, 2**32 - 1), st.floats(0.5, 6.0))
def test_whatever_is_called_overconfident_is_outside_of_what_is_drawn_and_said(seed, factor):
    # The axis points to the side of the truth, has the ellipse's extent there, and its printed numbers differ.
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3, 3)) * (0.05, 0.05, 0.02)
    covariance = root @ root.T + 1e-7 * np.eye(3)
    off = factor * np.linalg.cholesky(covariance) @ rng.normal(size=3)
    off[2] = np.clip(off[2], -1.0, 1.0)
    shown = accuracy(estimate((1.0, 2.0, 0.4), covariance), Pose(*(np.array([1.0, 2.0, 0.4]) + off)))
    short, said = shown.short, numbers_html(shown, "no truth", True)
    if shown.verdict == "overconfident" and short is None:
        assert "position and heading do not fit together" in said and not shown.is_outside
    if short is None:
        return
    assert abs(short.error) > short.claimed
    if short.is_heading:
        assert (short.direction, short.error) == pytest.approx((0.4, off[2]))
        assert short.claimed == pytest.approx(1.96 * np.sqrt(covariance[2, 2]), rel=1e-3)
    else:
        u = np.array([np.cos(short.direction), np.sin(short.direction)])
        assert short.error == pytest.approx(u @ off[:2]) and shown.is_outside
        reach = np.sqrt(5.991 / (u @ np.linalg.inv(covariance[:2, :2]) @ u))
        assert short.claimed == pytest.approx(reach, rel=1e-3)
    if shown.verdict == "overconfident":
        error, claimed = re.search(r"<small>([\d.]+) ?(?:c?m|°) .*, where ± ([\d.]+)", said).groups()
        assert float(error) > float(claimed) > 0
