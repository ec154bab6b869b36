"""The solution's filter along whole drives: exact without noise, and with a valid covariance to the end."""

import numpy as np
import pytest

from nao_course.geometry import Pose, wrap_angle
from nao_course.lessons.ekf_slam.noise import in_one_turn, joint_noise
from nao_course.slam import range_and_bearing

LANDMARKS = np.array([(2.0, 1.0), (-1.0, 2.0), (0.5, -2.0), (3.0, -1.0)])


def test_without_noise_a_whole_drive_is_the_truth_to_1e_9(own):
    Q, R = np.diag([0.03, 0.02, 0.04]) ** 2, np.diag([0.03, 0.06]) ** 2
    truth, state, P = Pose(), np.zeros(3), np.zeros((3, 3))
    for pair in range_and_bearing(truth.as_array(), LANDMARKS):
        state, P = own["add_landmark"](state, P, pair, R)
    for step in range(120):
        control = np.array([0.2, 0.13 * np.cos(step / 9)])
        truth = truth @ Pose(control[0], 0.0, control[1])
        state, P = own["predict"](state, P, control, Q, 4)
        z = range_and_bearing(truth.as_array(), LANDMARKS).ravel()
        state, P = own["update"](state, P, z, R, 4)
        off = state[:3] - truth.as_array()
        assert np.abs([*off[:2], wrap_angle(off[2])]).max() < 1e-9
    assert state[3:] == pytest.approx(LANDMARKS.ravel(), abs=1e-9)


@pytest.mark.slow
def test_after_10000_steps_the_covariance_is_symmetric_and_has_no_negative_eigenvalue(own, rng):
    Q, R = np.diag([0.01, 0.005, 0.01]) ** 2, np.diag([0.02, 0.05]) ** 2
    state, P = np.zeros(3), np.diag([0.1, 0.1, 0.05]) ** 2
    truth = Pose()
    for pair in range_and_bearing(truth.as_array(), LANDMARKS[:2]):
        state, P = own["add_landmark"](state, P, pair, R)
    for step in range(10_000):
        control = np.array([0.1, 0.1])
        truth = truth @ Pose(0.1, 0.0, 0.1)
        state, P = own["predict"](state, P, control, Q, 2)
        i = step % 2
        z = range_and_bearing(truth.as_array(), LANDMARKS[i]) + rng.normal(0, (0.02, 0.05))
        state, P = own["update_landmarks"](state, P, [i], z, R)
    assert np.abs(P - P.T).max() < 1e-12
    assert np.linalg.eigvalsh((P + P.T) / 2)[0] > -1e-12
    assert -np.pi <= state[2] <= np.pi


@pytest.mark.slow
def test_a_long_way_past_many_landmarks_keeps_the_covariance_symmetric(own, rng):
    """Rounding errors that are not made symmetric grow over a long loop."""
    around, aside = np.linspace(0, 2 * np.pi, 300, endpoint=False), 25 + rng.uniform(-2, 2, 300)
    landmarks = np.column_stack([aside * np.sin(around), 25 - aside * np.cos(around)])
    Q, R = np.diag([0.03, 0.02, 0.012]) ** 2, np.diag([0.026, 0.05]) ** 2
    state, P, known, truth = np.zeros(3), np.zeros((3, 3)), [], Pose()
    for _ in range(340):
        error = rng.normal(0, (0.03, 0.02, 0.012))
        truth = truth @ Pose(0.5 + error[0], error[1], 0.02 + error[2])
        state, P = own["predict"](state, P, np.array([0.5, 0.02]), Q, len(known))
        exact = range_and_bearing(truth.as_array(), landmarks)
        seen = np.flatnonzero((exact[:, 1] < 3) & (exact[:, 1] > 0.5) & (np.abs(exact[:, 0]) < 1))
        noisy = exact + rng.normal(0, (0.026, 0.05), exact.shape)
        if again := [i for i in seen if i in known]:
            indices = [known.index(i) for i in again]
            state, P = own["update_landmarks"](state, P, indices, noisy[again].ravel(), R)
        for i in set(seen) - set(again):
            state, P = own["add_landmark"](state, P, noisy[i], R)
            known.append(i)
    assert len(known) > 150
    assert np.abs(P - P.T).max() < 1e-10 * np.abs(P).max()
    assert np.linalg.eigvalsh((P + P.T) / 2)[0] > 0


def test_nothing_that_comes_in_is_changed_and_an_update_without_landmarks_changes_nothing(own, rng):
    state, P = np.array([0.1, 0.2, 3.0, 2.0, 1.0]), np.eye(5) * 0.04
    z, R, control, Q = np.array([0.4, 2.0]), np.eye(2) * 0.01, np.array([0.4, 0.5]), np.eye(3) * 0.01
    given = [each.copy() for each in (state, P, z, R, control, Q)]
    own["predict"](state, P, control, Q, 1)
    own["update_landmarks"](state, P, [0], z, R)
    own["add_landmark"](state, P, z, R)
    own["init_landmarks"](z, R, state[:3], P[:3, :3])
    for before, after in zip(given, (state, P, z, R, control, Q), strict=True):
        assert np.array_equal(before, after)
    state, P = np.array([0.1, 0.2, 3.0, 2.0, 1.0]), np.eye(5) * 0.04
    new, after = own["update_landmarks"](state, P, [], np.zeros(0), np.eye(2) * 0.01)
    assert np.array_equal(new[[0, 1, 3, 4]], state[[0, 1, 3, 4]]) and np.array_equal(after, P)


def test_joint_noise_takes_three_forms_and_angles_beyond_the_half_turn_break_warp2pis_law(own):
    one = np.array([[1.0, 0.5], [0.5, 4.0]])
    assert np.array_equal(joint_noise(one, 2), np.kron(np.eye(2), one))
    assert np.array_equal(joint_noise([one, 2 * one], 2), np.kron(np.diag([1.0, 2.0]), one))
    full = np.arange(16.0).reshape(4, 4)
    assert np.array_equal(joint_noise(full, 2), full) and joint_noise(full, 2) is not full
    assert joint_noise(one, 0).shape == (0, 0)
    for wrong in (np.eye(3), np.ones((3, 2, 2)), 1.0, np.eye(6)):
        with pytest.raises(ValueError, match="measurement_covariance of 2 landmarks"):
            joint_noise(wrong, 2)
    assert in_one_turn((), {}, own["warp2pi"](np.linspace(-50, 50, 999))) == ""
    assert in_one_turn((), {}, np.array([0.0, 3.2])) != ""
