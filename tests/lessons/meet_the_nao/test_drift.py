"""Drift: a distance from where commands lead, the growth of it with the way, and its figures."""

import numpy as np
import pytest

from nao_course.lessons.meet_the_nao import commanded, draw_drift, draw_growth, measure_drift
from nao_course.sim import Field, OdometryNoise, SimulatedNao, repeat_drive
from nao_course.slam import Motion
from tests.drawings import assert_same_bytes_with_words

SQUARE = [Motion(1.0, np.pi / 2)] * 4
AHEAD = [Motion(1.0, 0.0)] * 16


def drift():
    paths = repeat_drive([Motion(0.5, 0.3)] * 2, 5, np.random.default_rng(1))
    return draw_drift(paths, commanded=paths[0])


@pytest.mark.slow
@pytest.mark.parametrize("make", [drift, lambda: draw_growth({"square": SQUARE}, seed=1)])
def test_the_same_drawing_is_the_same_bytes_with_its_words(make):
    assert_same_bytes_with_words(make)


def test_a_drift_names_its_unit_and_one_degree_of_tilt_moves_a_post_by_a_third_of_a_metre():
    assert [ax.get_xlabel() for ax in drift().figure.axes] == ["x (m)"]
    assert "1 robot" in draw_drift(np.zeros((1, 1, 3))).alt
    for paths, said in ((np.zeros((4, 3)), "robots, steps"), (np.zeros((0, 4, 3)), "at least one robot")):
        with pytest.raises(ValueError, match=said):
            draw_drift(paths)
    view = SimulatedNao(Field(2012, half=True)).view("bottom")
    distance = np.hypot(2.8, 0.7) - np.hypot(*view.offset)  # from the camera
    below = np.arctan2(view.height, distance)
    off = [view.height / np.tan(below - np.radians(tilt)) - distance for tilt in (-2, -1, 1, 2)]
    assert off == pytest.approx([-0.49, -0.27, 0.33, 0.75], abs=0.02)


def test_drift_is_what_the_noise_says_and_grows_faster_straight_ahead_by_heading_errors():
    """One metre ahead, the mean square of the distance is the sum of both variances."""
    assert np.allclose(commanded(SQUARE)[:, :2], [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)])
    assert np.allclose(measure_drift(SQUARE, 1, OdometryNoise(0, 0, 0, 0)), 0.0)
    assert np.allclose(measure_drift(SQUARE, 1)[:, 0], 0.0)
    noise = OdometryNoise(along=0.06, across=0.04, turn=0.0, turn_per_turn=0.0)
    measured = measure_drift([Motion(1.0, 0.0)], 1, noise)[:, -1]
    assert np.mean(measured**2) == pytest.approx(0.06**2 + 0.04**2, rel=0.1)
    on_squares, ahead = (np.median(measure_drift(drive, 5), axis=0) for drive in (SQUARE * 4, AHEAD))
    assert on_squares[16] / on_squares[4] == pytest.approx(2, rel=0.05)
    assert ahead[16] / ahead[4] == pytest.approx(7.85, rel=0.05)
    assert ahead[4] == pytest.approx(0.25, abs=0.01)
    without = OdometryNoise(turn=0.0, turn_per_turn=0.0)
    for drive, of, times in ((AHEAD, ahead, 8), (SQUARE * 4, on_squares, 2.5)):
        assert of[-1] / np.median(measure_drift(drive, 5, without)[:, -1]) == pytest.approx(times, rel=0.05)
