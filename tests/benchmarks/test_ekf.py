"""Lesson 07's filters on larger maps, and on the logs of others."""

import numpy as np
import pytest

from benchmarks.ekf import ekf_ideas, ekf_speed
from benchmarks.ekf.ekf_ideas import Compressed, Forgetful, Whole, go_round
from benchmarks.ekf.ekf_logs import COURSE, aligned, freiburg_values
from nao_course.datasets import read_freiburg_log
from nao_course.lessons.ekf_slam.costs import draw_costs


def test_on_a_long_way_round_a_large_map_the_covariance_stays_one(monkeypatch):
    monkeypatch.setattr(ekf_ideas, "LANDMARKS", 100)
    ring = ekf_ideas.world(0)
    own, compressed, few = Whole(), Compressed(), Forgetful()
    whole, loop, forgetful = (go_round(each, ring) for each in (own, compressed, few))
    assert len(own.known) == 100
    assert np.abs(own.covariance - own.covariance.T).max() < 1e-12 * own.covariance.max()
    assert np.linalg.eigvalsh(own.covariance).min() > 0
    assert compressed.moves > 3 and len(compressed.on_map) == 100
    assert np.abs(loop.errors - whole.errors).max() < 1e-9, "the compressed filter believes the same"
    assert len(few.known) < 40
    assert np.hypot(*forgetful.errors[-1, :2]) > 2 * np.hypot(*whole.errors[-1, :2])


def test_in_place_and_all_ways_that_are_timed_believe_what_new_arrays_do(rng):
    state, covariance, landmark, seen = ekf_speed.a_map(12)
    own = ekf_speed.InPlaceFilter(state, covariance)
    for _ in range(20):
        own.predict(ekf_speed.CONTROL, ekf_speed.Q)
        own.update_landmark(landmark, seen, ekf_speed.R)
        state, covariance = ekf_ideas.OWN["predict"](state, covariance, ekf_speed.CONTROL, ekf_speed.Q, 12)
        update = ekf_ideas.OWN["update_landmarks"]
        state, covariance = update(state, covariance, [landmark], seen, ekf_speed.R)
    assert np.allclose(own.state, state, atol=1e-10) and np.allclose(own.covariance, covariance, atol=1e-10)
    names = [name for name in ekf_speed.WAYS if name != "filterpy" or ekf_speed.ExtendedKalmanFilter]
    assert ekf_speed.apart(names, k=8) < 1e-12


def test_the_recorded_costs_are_drawn_with_the_largest_map_that_each_way_reached():
    words = draw_costs().alt
    assert "new arrays" in words and "in place" in words and "compressed: 0." in words
    assert words.count(" for 1000") >= 4


def test_a_map_that_is_only_turned_and_shifted_has_the_right_shape(rng):
    truth = rng.uniform(-3, 3, (6, 2))
    c, s = np.cos(0.3), np.sin(0.3)
    laid, turn = aligned((truth - (1.0, 2.0)) @ np.array([[c, -s], [s, c]]), truth)
    assert np.allclose(laid, truth) and abs(turn) == pytest.approx(0.3)


def test_freiburgs_log_is_run_to_its_end(data_dir):
    found = freiburg_values(read_freiburg_log(data_dir / "slam" / "freiburg"), COURSE)
    assert found["landmarks"] == 9
    assert (round(found["error"], 3), round(found["shape"], 3)) == (0.230, 0.020)
