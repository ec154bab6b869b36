"""EKF SLAM on landmarks whose numbers are known: which functions are called, with what, and what they must return."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim.drives import NamedEkf, checked_functions


@pytest.fixture
def calls():
    return []


@pytest.fixture
def functions(calls):
    def predict(state, covariance, control, noise, k):
        calls.append(("predict", k))
        return state, covariance

    def update_landmarks(state, covariance, indices, measurements, noise):
        calls.append(("update", list(indices), measurements.tolist(), noise.shape))
        return state, covariance

    def add_landmark(state, covariance, measurement, noise):
        calls.append(("add", measurement.tolist(), noise.shape))
        return np.append(state, measurement), np.eye(len(state) + 2) * len(state)

    return predict, update_landmarks, add_landmark


def test_known_landmarks_correct_the_state_before_new_ones_are_added(functions, calls):
    slam = NamedEkf(Pose(1.0, 2.0, 0.0), *functions)
    slam.observe([7, 3], np.array([(0.1, 1.0), (0.2, 2.0)]), np.zeros((2, 2, 2)))
    slam.move(np.zeros(2), np.zeros((3, 3)))
    slam.observe([5, 3], np.array([(0.3, 3.0), (0.4, 4.0)]), np.zeros((2, 2, 2)))
    assert calls == [
        ("add", [0.1, 1.0], (2, 2)),
        ("add", [0.2, 2.0], (2, 2)),
        ("predict", 2),
        ("update", [1], [0.4, 4.0], (1, 2, 2)),
        ("add", [0.3, 3.0], (2, 2)),
    ]
    assert slam.known == [7, 3, 5]


def test_the_estimate_has_each_landmarks_kind_and_covariance_and_a_copy_goes_on_by_itself(functions):
    slam = NamedEkf(Pose(1.0, 2.0, 0.5), *functions)
    slam.observe([1, 0], np.array([(0.1, 1.0), (0.2, 2.0)]), np.zeros((2, 2, 2)))
    estimate = slam.estimate(("corner", "post"))
    assert estimate.kinds == ("post", "corner") and estimate.pose == Pose(1.0, 2.0, 0.5)
    assert estimate.landmarks.tolist() == [[0.1, 1.0], [0.2, 2.0]]
    assert estimate.landmark_covariances.tolist() == 2 * [(5 * np.eye(2)).tolist()]
    slam = NamedEkf(Pose(), *functions)
    other = slam.copy()
    other.observe([4], np.ones((1, 2)), np.zeros((1, 2, 2)))
    assert slam.known == [] and len(slam.state) == 3 and other.known == [4]


def test_functions_get_copies_and_an_answer_of_another_shape_is_named(functions):
    def spoil(state, covariance, control, noise, k):
        state += 1
        control += 1
        return state[:2], covariance

    predict, _, _ = checked_functions((spoil, *functions[1:]))
    state, control = np.zeros(3), np.zeros(2)
    with pytest.raises(ValueError, match="predict must return shapes"):
        predict(state, np.eye(3), control, np.eye(3), 0)
    assert not state.any() and not control.any()
    _, _, add_landmark = checked_functions((*functions[:2], lambda *given: given[:2]))
    with pytest.raises(ValueError, match=r"add_landmark must return shapes \(5,\)"):
        add_landmark(state, np.eye(3), control, np.eye(2))
    with pytest.raises(ValueError, match=r"predict must return \(state, covariance\)"):
        checked_functions((lambda *given: None, *functions[1:]))[0](state, np.eye(3), control, np.eye(3), 0)
