"""Where the straight line ends: what is measured is what the formulas say, and what the lesson's text says."""

import numpy as np
import pytest

from nao_course.lessons.ekf_derivations import limits
from nao_course.lessons.ekf_derivations.limits import (
    SIGMAS,
    TITLES,
    across_too_large,
    draw_limits,
    heading_clouds,
    limit_of_mean,
    measure_limits,
    short_mean,
)
from nao_course.lessons.ekf_derivations.samples import Cloud


@pytest.fixture(scope="module")
def measured(solution):
    return measure_limits(solution["predict_pose"], solution["predict_covariance"])


def test_mean_and_standard_deviation_are_off_by_their_formulas(measured):
    mean, across, _ = (measured[title] for title in TITLES)
    assert np.allclose(mean[:, 1], 100 * short_mean(SIGMAS), atol=0.4)
    assert np.allclose(across[:, 1], 100 * across_too_large(SIGMAS), atol=1.0)
    assert ((mean[:, 0] <= mean[:, 1]) & (mean[:, 1] <= mean[:, 2])).all()
    drawing = draw_limits(measured)
    assert len(drawing.figure.axes) == 3
    assert "samples in the 95 % ellipse (%): 94 at 5°, 79 at 15°" in drawing.alt


def test_the_numbers_of_the_lesson_are_those_that_are_measured(solution, measured):
    assert limit_of_mean(solution["predict_pose"], 5) == 18.35
    assert np.degrees(np.sqrt(-2 * np.log(0.95))) == pytest.approx(18.35, abs=0.005)
    inside = dict(zip(np.degrees(SIGMAS).round(), measured[TITLES[2]][:, 1], strict=True))
    assert (round(inside[10]), round(inside[15])) == (89, 79)
    functions = solution["predict_pose"], solution["predict_covariance"]
    thick = heading_clouds(*functions, np.radians(15), position_sigma=0.1)
    assert np.mean([each.inside() for each in thick]) == pytest.approx(0.92, abs=0.01)


def test_after_three_metres_the_ellipse_holds_fewer_robots_as_the_lesson_says(rng):
    for degrees, percent in ((10, 73), (15, 57)):
        headings = rng.normal(0, np.radians(degrees), 400_000)
        ends = 3 * np.array([np.cos(headings), np.sin(headings)]) + rng.normal(0, 0.03, (2, 400_000))
        predicted = np.diag([0.03**2, 0.03**2 + (3 * np.radians(degrees)) ** 2])
        assert round(100 * Cloud(ends.T, np.array([3.0, 0.0]), predicted).inside()) == percent


def test_a_robot_that_cannot_turn_has_no_limits(monkeypatch):
    assert limit_of_mean(lambda pose, control: pose + [1.0, 0.0, 0.0], 5) == np.inf
    monkeypatch.setattr(limits, "RUNS", 2)
    found = measure_limits(lambda pose, control: pose + [1.0, 0.0, 0.0], lambda covariance, *rest: covariance)
    assert np.allclose(found[TITLES[0]][:, 1], 0, atol=0.5) and (found[TITLES[2]][:, 1] > 90).all()
