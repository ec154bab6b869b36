"""The filter with two errors that opens lesson 07: its recording, and what the lesson says of it."""

import numpy as np
import pytest
from scipy.stats import chi2

from nao_course.lessons.ekf_slam.bent_map import (
    draw_bearings,
    draw_bent_map,
    draw_covariance_test,
    draw_second_error,
)
from nao_course.lessons.ekf_slam.bent_map.figures import SCATTER
from nao_course.lessons.ekf_slam.bent_map.runs import (
    ONE_ERROR,
    SAMPLES,
    TEST_CONTROL,
    TWO_ERRORS,
    covariance_differences,
    recorded_run,
    recorded_test,
    run_filter,
    sampled_covariance,
)
from nao_course.lessons.ekf_slam.consistency import NOISY
from nao_course.metrics import squared_distances
from tests.lessons.ekf_slam.make_bent_map import functions_with, made


def assert_close(one, other):
    """Two JSON values are equal up to rounding errors."""
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            assert_close(one[key], other[key])
    else:
        assert np.allclose(one, other, rtol=1e-3, atol=1e-5)


def test_the_recording_is_made_by_two_declared_mistakes():
    again = made()
    for name in (TWO_ERRORS, ONE_ERROR):
        run = recorded_run(name)
        assert_close(again[name]["path"], run.path)
        assert_close(again[name]["landmarks"], run.landmarks)
        assert_close(again[name]["bearings"], run.bearings)
    assert_close(again["test"], recorded_test())


def test_the_lessons_numbers_hold(functions):
    two, one = recorded_run(TWO_ERRORS), recorded_run(ONE_ERROR)
    assert two.map_error == pytest.approx(0.90, abs=0.005) and one.map_error == pytest.approx(0.19, abs=0.005)
    yours = run_filter(functions)
    assert yours.map_error == pytest.approx(0.02, abs=0.005)
    assert yours.nees.min() > 0 and yours.nees.max() < 9.3
    inside = squared_distances(yours.landmarks - yours.true_landmarks, yours.landmark_covariances)
    assert inside.max() < 5.99 and yours.landmarks.size == 20
    assert yours.map_nees == pytest.approx(18.1, abs=0.05) and two.map_nees is None
    assert chi2.ppf([0.025, 0.975], 20) == pytest.approx([9.6, 34.2], abs=0.05)
    steps, values = two.bearings.T
    assert np.degrees((NOISY.bearing, NOISY.turn)) == pytest.approx((5, 3))
    assert len(values) == 208 and steps[np.abs(values) > np.radians(20)][0] == 8
    assert [np.degrees(values[steps == each].max()) for each in (8, 30)] == pytest.approx([356, 346], abs=0.5)
    assert one.nees.max() == pytest.approx(2200, abs=5) and np.sum(one.nees < 0) == 5
    assert np.sum(np.linalg.eigvalsh(one.landmark_covariances).min(axis=1) > 0) == 4
    assert 2 * np.sqrt(5.99 * np.linalg.eigvalsh(two.landmark_covariances).max()) < 0.2


def test_after_warp2pi_innovations_are_small_and_samples_show_the_forgotten_block_and_no_other(own):
    wrapped = np.degrees(np.abs(own["warp2pi"](recorded_run(ONE_ERROR).bearings[:, 1])))
    assert wrapped.max() < 20
    assert "at most 356 degrees" in draw_bearings().alt
    assert "at most 17 degrees" in draw_bearings(own["warp2pi"]).alt
    found = covariance_differences(np.array(recorded_test()["predicted"]))
    assert found["pose and map"] == pytest.approx(0.67, abs=0.005)
    assert found["pose"] < 0.03 and found["map"] < 0.03
    state, covariance = (np.array(recorded_test()[name]) for name in ("state", "covariance"))
    given = state, covariance, TEST_CONTROL, NOISY.control_covariance, (len(state) - 3) // 2
    correct = own["predict"](*given)[1]
    assert max(covariance_differences(correct).values()) < SCATTER == 0.03
    assert sampled_covariance().shape == covariance.shape and SAMPLES == 20_000


def test_every_wrong_block_is_visible_in_the_test_with_samples():
    state, covariance = (np.array(recorded_test()[name]) for name in ("state", "covariance"))
    given = state, covariance, TEST_CONTROL, NOISY.control_covariance, (len(state) - 3) // 2
    for mistake, block in (("no noise", "pose"), ("cross-covariances dropped", "pose and map")):
        wrong = functions_with(("predict", mistake))[0](*given)[1]
        assert covariance_differences(wrong)[block] > 0.05


@pytest.mark.slow
def test_figures_say_what_they_show(own):
    functions = own["predict"], own["update_landmarks"], own["add_landmark"]
    assert draw_bent_map().alt.endswith("half a turn in 16 steps, first in step 8 with 356 degrees.")
    assert "90 cm off" in draw_bent_map().alt and "2 cm off on average" in draw_bent_map(*functions).alt
    assert "negative in 5" in draw_second_error().alt
    assert "pose and map 0.67" in draw_covariance_test().alt
    assert "pose and map 0.02" in draw_covariance_test(own["predict"]).alt
