"""The figures of lesson 06: what they draw is what the filter says, and what the text says of them is so."""

import numpy as np
import pytest

from nao_course.lessons.localization import beliefs, honesty, surest
from nao_course.lessons.localization.drives import LANDMARKS, follow_many
from nao_course.lessons.localization.lab import with_parts
from nao_course.lessons.localization.panels import FusePanel
from nao_course.metrics import band
from tests.paths import SOLUTIONS

TEXT = (SOLUTIONS / "06_localization.md").read_text(encoding="utf-8")


def test_one_look_brings_the_robot_back_as_the_payoff_says(own):
    _, states = beliefs.one_look(own["localize"])
    off = [state.error(beliefs.TRUE)[0] for state in states]
    assert off[0] > 0.6 and off[-1] < 0.15
    sizes = [np.linalg.det(state.covariance) for state in states]
    assert sizes == sorted(sizes, reverse=True)
    alt = beliefs.draw_put_down_wrongly(own["localize"], own["covariance_ellipse"]).alt
    assert "0.68 m and 14 degrees off" in alt and "0.11 m and 5 degrees off" in alt
    assert "0.68 m from where it is" in TEXT and "to 0.11 m at the end" in TEXT


def test_far_from_the_truth_one_look_is_overconfident_as_the_end_says(own, monkeypatch):
    squares = []
    for seed in range(60):
        monkeypatch.setattr(beliefs, "SEED", seed)
        state = beliefs.one_look(own["localize"])[1][-1]
        squares.append(own["nees"](state.pose - beliefs.TRUE.as_array(), state.covariance))
    assert f"the median NEES is {np.median(squares):.1f}" in TEXT


def test_four_tenths_lie_within_one_sigma(own):
    spread = np.array([[0.09, 0.05], [0.05, 0.05]])
    part = beliefs.inside(beliefs.cloud(spread), *own["covariance_ellipse"](spread, 1 - np.exp(-0.5)))
    assert part == pytest.approx(1 - np.exp(-0.5), abs=0.02)
    assert "95 %" in beliefs.draw_cloud(spread, own["covariance_ellipse"], (0.3935, 0.95)).alt


def test_an_ellipse_holds_what_is_inside_it_whatever_its_angle():
    angle, axes = 0.7, np.array([2.0, 0.5])
    c, s = np.cos(angle), np.sin(angle)
    long, short = np.array([c, s]), np.array([-s, c])
    points = np.array([1.9 * long, 2.1 * long, 0.4 * short, 0.6 * short])
    assert beliefs.inside(points, axes, angle) == 0.5


def test_a_bearing_that_is_not_wrapped_throws_the_estimate_away(own):
    unwrapped = with_parts(own["localize"], {"innovation": lambda expected, measured: measured - expected})
    assert beliefs.jump(own["localize"]) < 0.2 and beliefs.jump(unwrapped) > 1.5
    assert f"{beliefs.jump(unwrapped):.1f} m from the truth" in TEXT
    alt = beliefs.draw_not_wrapped(own["localize"], unwrapped, own["covariance_ellipse"]).alt
    assert "Before the look: 0.14 m and 34 degrees off" in alt and "Not wrapped: 1.92 m" in alt


def test_the_text_says_where_the_corner_behind_is_seen_and_expected(own, report):
    expected = report["expected_measurement"](beliefs.BEHIND_BELIEVED.as_array(), LANDMARKS[beliefs.BEHIND])
    measured = beliefs.behind().measurement
    assert f"a corner at {np.degrees(measured[0]):.0f} degrees to its left" in TEXT
    assert f"expects the corner at {np.degrees(expected[0]):.0f}" in TEXT
    assert f"The innovation is {np.degrees(own['innovation'](expected, measured)[0]):.0f} degrees" in TEXT
    assert f"without wrapping {np.degrees(measured[0] - expected[0]):.0f}" in TEXT


def test_a_landmark_in_line_with_the_doubt_tells_the_position_by_its_range_and_one_beside_by_its_bearing(own):
    c, s = np.cos(surest.ROBOT.theta), np.sin(surest.ROBOT.theta)
    at = np.array([surest.ROBOT.x, surest.ROBOT.y])
    ahead, behind, beside = at + (1.5 * c, 1.5 * s), at - (1.5 * c, 1.5 * s), at + (-1.5 * s, 1.5 * c)

    def position(place, use_range):
        return surest.left_after(own["localize"], place, use_range)[0]

    assert position(ahead, True) == pytest.approx(position(behind, True), rel=1e-6)
    assert position(ahead, True) < 0.8 * position(beside, True)
    assert position(beside, False) < 0.8 * position(ahead, False) and position(ahead, False) > 0.45


def test_the_heading_wants_a_landmark_that_is_far_ahead(own):
    at, ahead = (
        np.array([surest.ROBOT.x, surest.ROBOT.y]),
        np.array([np.cos(surest.ROBOT.theta), np.sin(surest.ROBOT.theta)]),
    )
    headings = [surest.left_after(own["localize"], at + away * ahead)[1] for away in (0.5, 1.0, 2.0, 4.0)]
    assert headings == sorted(headings, reverse=True)


def test_the_map_of_what_is_left_says_it_of_real_landmarks(own, monkeypatch):
    monkeypatch.setattr(surest, "GRID", 0.9)
    position, heading = surest.left_after(own["localize"], LANDMARKS[9])
    said = f"the post at (3.0, 0.7) leaves {100 * position:.0f} cm and {np.degrees(heading):.1f} degrees"
    assert said in surest.draw_surest(own["localize"]).alt


def test_the_bands_figure_counts_what_is_inside(filter_of):
    traces = follow_many(range(4), *filter_of)
    alt = honesty.draw_bands(traces).alt
    assert "the mean NEES of 4 drives" in alt
    low, high = band(3, 30)
    inside = np.mean([low <= trace.nees[1:].mean() <= high for trace in traces])
    assert honesty.inside_naive_band(traces) == inside and f"only {inside:.0%} of the drives" in alt


def test_negative_eigenvalues_are_told(own, monkeypatch):
    monkeypatch.setattr(honesty, "UPDATES", 60)
    assert "All are positive." in honesty.draw_smallest_eigenvalue(own["kalman_update"]).alt

    def negative(mean, covariance, *rest):
        return mean, -covariance

    assert "negative from a standard deviation of 1e-01 on" in honesty.draw_smallest_eigenvalue(negative).alt


def test_the_fuse_panel_says_what_the_students_function_makes_of_its_sliders(own):
    panel = FusePanel(own["fuse"])
    assert (
        "Fused: 2.40 m, standard deviation 0.134 m. The weight of the measurement is 0.80." in panel.summary()
    )
    panel.set(prediction_sigma=0.2, measurement_sigma=0.2, measured=3.0)
    assert "Fused: 2.50 m" in panel.summary() and "is 0.50." in panel.summary()
    panel.set(measured=2.0)
    assert "weight" not in panel.summary()
    assert "fused: 2.00 m" in panel.shown.drawings["Beliefs"].alt


def test_the_fuse_panel_of_a_blank_notebook_shows_both_beliefs_and_says_what_to_write():
    def fuse(*given):
        raise NotImplementedError

    panel = FusePanel(fuse)
    assert "Finish exercise 6.1" in panel.summary()
    assert "fused" not in panel.shown.drawings["Beliefs"].alt
