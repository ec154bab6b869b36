"""The equations that lesson 07 displays, each held against the solution, and slips that its checks name."""

import numpy as np
import pytest
from scipy.linalg import expm

from nao_course.exercises.checking import grade_public
from nao_course.geometry import rotation_2d, wrap_angle
from nao_course.lessons.ekf_slam.invariant import LEVELS, draw_invariant, group_sheet
from nao_course.lessons.ekf_slam.rotation import keeps_rotation, rotation_information
from nao_course.slam import range_and_bearing
from tests.lessons import every
from tests.lessons.every import public_exercise


def random_covariance(rng, size, scale=0.2):
    root = rng.normal(0, 0.4, (size, size)) + np.eye(size)
    return scale**2 * root @ root.T


def random_map(rng, k):
    pose = np.array([*rng.uniform(-2, 2, 2), rng.uniform(-3, 3)])
    r, direction = rng.uniform(0.8, 4, k), rng.uniform(-np.pi, np.pi, k)
    landmarks = pose[:2] + np.column_stack([r * np.cos(direction), r * np.sin(direction)])
    return np.concatenate([pose, landmarks.ravel()]), random_covariance(rng, 3 + 2 * k)


def look(state, indices):
    """What is measured of some landmarks without noise, (2m,)."""
    return range_and_bearing(state[:3], state[3:].reshape(-1, 2)[list(indices)]).ravel()


def jacobian_of(function, x, h=1e-6):
    """Central differences; a bearing that passes the half turn is wrapped."""
    columns = []
    for step in h * np.eye(len(x)):
        change = np.asarray(function(x + step)) - np.asarray(function(x - step))
        columns.append(np.where(np.abs(change) > 3, wrap_angle(change), change) / (2 * h))
    return np.column_stack(columns)


def measured(rng, state, indices, sigma=0.05):
    z = look(state, indices) + rng.normal(0, sigma, 2 * len(indices))
    z[::2] = wrap_angle(z[::2])
    return z


@pytest.mark.asserts("eq-7-1")
def test_the_state_is_the_pose_then_the_landmarks_and_its_covariance_is_symmetric(own, rng):
    state, P = np.zeros(3), np.zeros((3, 3))
    for number in range(1, 4):
        state, P = own["add_landmark"](state, P, rng.uniform((-1, 1), (1, 3)), np.eye(2) * 0.01)
        assert state.shape == (3 + 2 * number,) and P.shape == (3 + 2 * number,) * 2
    state, P = own["predict"](state, P, np.array([0.5, 0.2]), np.eye(3) * 0.01, 3)
    assert np.array_equal(P[:3, 3:], P[3:, :3].T)


@pytest.mark.asserts("eq-7-2")
def test_initial_covariances_are_those_of_places_sampled_from_the_measurements_noise(own, rng):
    pose, z, R = np.array([1.0, -2.0, 0.6]), np.array([0.4, 2.0]), np.diag([0.01, 0.02]) ** 2
    k, landmarks, P = own["init_landmarks"](z, R, pose, np.eye(3))
    samples = rng.multivariate_normal(z, R, 200_000)
    direction = pose[2] + samples[:, 0]
    places = pose[:2] + samples[:, 1:] * np.column_stack([np.cos(direction), np.sin(direction)])
    assert k == 1 and landmarks == pytest.approx(places.mean(axis=0), abs=1e-3)
    assert pytest.approx(np.cov(places.T), rel=0.02, abs=2e-6) == P


@pytest.mark.asserts("eq-7-3")
def test_predict_is_the_whole_states_jacobian_on_both_sides(own, rng):
    state, P = random_map(rng, 3)
    control, Q = np.array([0.7, -0.4]), random_covariance(rng, 3, 0.1)

    def moved(values):
        x, y, theta, *rest = values[:-3]
        along, across, turned = values[-3:]
        c, s, d = np.cos(theta), np.sin(theta), control[0] + along
        return np.array([x + d * c - across * s, y + d * s + across * c, theta + control[1] + turned, *rest])

    jacobian = jacobian_of(moved, np.append(state, np.zeros(3)))
    F, G = jacobian[:, :-3], jacobian[:, -3:]
    new, covariance = own["predict"](state, P, control, Q, 3)
    assert new == pytest.approx(moved(np.append(state, np.zeros(3))), abs=1e-12)
    assert covariance == pytest.approx(F @ P @ F.T + G @ Q @ G.T, abs=1e-9)
    assert np.array_equal(covariance[3:, 3:], P[3:, 3:])


@pytest.mark.asserts("eq-7-4", "eq-7-5")
def test_no_other_gain_gives_a_smaller_variance(own, rng):
    state, P = random_map(rng, 2)
    R = np.diag([0.05, 0.1, 0.05, 0.1]) ** 2
    _, updated = own["update_landmarks"](state, P, [0, 1], measured(rng, state, [0, 1]), R)
    H = jacobian_of(lambda x: look(x, [0, 1]), state)
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)

    def after(gain):
        left = np.eye(len(state)) - gain @ H
        return left @ P @ left.T + gain @ R @ gain.T

    S = H @ P @ H.T + R
    assert after(K) == pytest.approx(P - K @ H @ P - P @ H.T @ K.T + K @ S @ K.T, abs=1e-10)
    assert after(K) == pytest.approx(updated, abs=1e-8)
    for _ in range(50):
        other = after(K + rng.normal(0, 0.05, K.shape))
        assert np.trace(other) > np.trace(updated)
        assert (np.diag(other) >= np.diag(updated) - 1e-9).all()


@pytest.mark.asserts("eq-7-5", "eq-7-6", "eq-7-7")
@pytest.mark.parametrize(("k", "indices"), [(1, [0]), (3, [2, 0]), (5, [4, 1, 3])])
def test_a_joint_update_is_that_of_the_information_form(own, rng, k, indices):
    state, P = random_map(rng, k)
    R = random_covariance(rng, 2 * len(indices), 0.05)
    z = measured(rng, state, indices)
    H = jacobian_of(lambda x: look(x, indices), state)
    assert np.count_nonzero(np.abs(H) > 1e-9) <= 2 * len(indices) * 5  # two blocks in a row, zeros elsewhere
    innovation = z - look(state, indices)
    innovation[::2] = wrap_angle(innovation[::2])
    weight = np.linalg.inv(R)
    left = np.linalg.inv(np.linalg.inv(P) + H.T @ weight @ H)
    expected = state + left @ H.T @ weight @ innovation
    expected[2] = wrap_angle(expected[2])
    new, covariance = own["update_landmarks"](state, P, indices, z, R)
    assert new == pytest.approx(expected, abs=1e-7)
    assert covariance == pytest.approx(left, abs=1e-8)


@pytest.mark.asserts("eq-7-8")
def test_the_mahalanobis_distance_of_a_consistent_map_is_1_25_on_average_and_its_square_2(own, rng):
    covariance = np.array([[0.09, 0.05], [0.05, 0.04]])
    errors = rng.multivariate_normal(np.zeros(2), covariance, 20_000)
    covariances = np.array([covariance] * len(errors))
    plain, weighed = own["evaluate_landmarks"](errors, covariances, np.zeros_like(errors))
    assert plain == pytest.approx(np.linalg.norm(errors, axis=1))
    assert weighed.mean() == pytest.approx(np.sqrt(np.pi / 2), rel=0.02)
    assert (weighed**2).mean() == pytest.approx(2.0, rel=0.03)


@pytest.mark.asserts("eq-7-9")
def test_no_measurement_sees_a_rotation_of_everything_if_all_estimates_are_the_same(rng):
    for _ in range(20):
        state, _ = random_map(rng, 1)
        x, y, _, l_x, l_y = state
        rotation = np.array([-y, x, 1.0, -l_y, l_x])
        H = jacobian_of(lambda values: look(values, [0]), state)
        dx, dy = l_x - x, l_y - y
        assert H @ rotation == pytest.approx([0, 0], abs=1e-7)
        assert H[:, 3:] @ [-dy, dx] - [1, 0] == pytest.approx([0, 0], abs=1e-7)
        moved = jacobian_of(lambda values: look(values, [0]), state + [0, 0, 0, 0.2, 0.1])
        assert np.abs(moved @ rotation).max() > 0.01


def on_group(state):
    """Return T, whose third column is the rotation of everything."""
    points = state[[0, 1, *range(3, len(state))]].reshape(-1, 2)
    T = np.eye(len(state))
    T[:, 2] = np.insert((points @ [[0, 1], [-1, 0]]).ravel(), 2, 1.0)
    return T


def disturbed(state, xi):
    """The truth that differs from a state by an error on the group."""
    V = np.sinc(xi[2] / (2 * np.pi)) * rotation_2d(xi[2] / 2)
    points = np.delete(state, 2).reshape(-1, 2) @ rotation_2d(xi[2]).T
    return np.insert((points + np.delete(xi, 2).reshape(-1, 2) @ V.T).ravel(), 2, state[2] + xi[2])


@pytest.mark.asserts("eq-7-10")
def test_to_first_order_the_error_on_the_group_is_rotated_into_the_states(rng):
    state, _ = random_map(rng, 3)
    T = jacobian_of(lambda xi: disturbed(state, xi), np.zeros(len(state)))
    assert np.allclose(T, on_group(state), atol=1e-8)


def test_the_sheet_takes_the_derivatives_by_the_error_on_the_group_and_no_others(rng):
    state, _ = random_map(rng, 1)
    right = [
        *(["-y", "1"], ["x", "0"], ["1", "0"], ["-l_y", "0"], ["l_x", "0"]),
        *(["0", "dy / r**2"], ["0", "-dx / r"]),
    ]
    assert "All 14 entries are correct" in repr(group_sheet().write(right))
    at = dict(zip(("x", "y", "theta", "l_x", "l_y"), state, strict=True))
    at |= {"dx": at["l_x"] - at["x"], "dy": at["l_y"] - at["y"]}
    at["r"] = np.hypot(at["dx"], at["dy"])
    values = [[eval(entry, {}, at) for entry in row] for row in right]

    def seen(xi):
        truth = disturbed(state, xi)
        return np.concatenate([truth, look(truth, [0])])

    assert np.allclose(values, jacobian_of(seen, np.zeros(5))[:, [2, 0]], atol=1e-7)
    wrong = [["y", "1"], *right[1:5], ["-1", ""], right[6]]
    said = repr(group_sheet().write(wrong))
    assert (
        "true x by xi_theta: its sign is wrong" in said
        and "bearing by xi_theta: that is what the heading" in said
    )
    about_robot = [["-dy", "1"], *right[1:]]
    assert "everything rotates about the origin of the map" in repr(group_sheet().write(about_robot))
    assert "xi_theta is 0 where" in repr(group_sheet().write([["−y ξ_θ".replace(" ", "*"), "1"], *right[1:]]))


@pytest.mark.asserts("eq-7-11")
def test_on_the_group_no_jacobian_of_motion_depends_on_the_estimate_and_no_measurement_sees_the_heading(
    own, rng
):
    for _ in range(5):
        state, _ = random_map(rng, 2)
        control = rng.uniform(-1, 1, 2)
        F = np.eye(len(state))
        F[:3, :3] = every.own("05")["motion_jacobians"](state[:3], control)[0]
        moved, P = own["predict"](state, np.eye(7), control, np.zeros((3, 3)), 2)
        assert np.allclose(np.linalg.solve(on_group(moved), F @ on_group(state)), np.eye(7))
        assert np.allclose(P, F @ F.T)
        H = jacobian_of(lambda values: look(values, [0, 1]), state)
        assert (H @ on_group(state))[:, 2] == pytest.approx(np.zeros(4), abs=1e-7)


@pytest.mark.asserts("eq-7-12")
def test_the_invariant_update_keeps_the_error_on_the_group_and_adds_no_information_on_a_rotation(own, rng):
    R = np.diag([0.05, 0.1]) ** 2
    for _ in range(5):
        state, P = random_map(rng, 3)
        P = (P + P.T) / 2
        z = measured(rng, state, [2, 0], 0.3)
        plain, correct = own["update_landmarks"](state, P, [2, 0], z, R)
        updated, covariance = own["invariant_update"](state, P, [2, 0], z, R)
        correction = plain - state
        correction[2] = wrap_angle(correction[2])
        xi = np.linalg.solve(on_group(state), correction)
        algebra, element = np.zeros((6, 6)), np.eye(6)
        algebra[:2, :2] = xi[2] * np.array([[0, -1], [1, 0]])
        algebra[:2, 2:] = np.delete(xi, 2).reshape(-1, 2).T
        element[:2, 2:] = np.delete(state, 2).reshape(-1, 2).T
        assert np.allclose(np.delete(updated, 2), (expm(algebra) @ element)[:2, 2:].T.ravel())
        A = on_group(updated) @ np.linalg.inv(on_group(state))
        assert np.allclose(covariance, A @ correct @ A.T) and np.array_equal(covariance, covariance.T)
        before, after = rotation_information(state, P), rotation_information(updated, covariance)
        assert after == pytest.approx(before, rel=1e-7)
        assert rotation_information(plain, correct) != pytest.approx(before, rel=1e-3)
        assert "multiplies the information" in keeps_rotation((state, P), {}, (plain, correct))
        exact = own["invariant_update"](state, P, [2, 0], look(state, [2, 0]), R)[0]
        assert np.allclose(exact, state)


def test_the_invariant_filters_figure_names_the_means_of_three_levels(functions, own):
    said = draw_invariant(*functions, own["invariant_update"], runs=1).alt
    assert all(f"{level}: your filter" in said for level in LEVELS) and said.count("invariant filter") == 3


def test_a_new_landmarks_covariances_are_those_of_samples(own, rng):
    state, P = random_map(rng, 1)
    P, R = P * 0.002, np.diag([0.01, 0.02]) ** 2
    z = np.array([0.7, 2.0])
    grown, covariance = own["add_landmark"](state, P, z, R)
    states = rng.multivariate_normal(state, P, 200_000)
    seen = rng.multivariate_normal(z, R, 200_000)
    direction = states[:, 2] + seen[:, 0]
    places = states[:, :2] + seen[:, 1:] * np.column_stack([np.cos(direction), np.sin(direction)])
    sampled = np.cov(np.column_stack([states, places]).T)
    scale = np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    assert grown[5:] == pytest.approx(places.mean(axis=0), abs=2e-3)
    assert np.abs(sampled - covariance).max() < 0.02 * scale.max()
    assert (np.abs(sampled - covariance) / scale).max() < 0.015


def test_a_new_landmark_is_that_of_an_update_from_an_unknown_position(own, rng):
    state, P = random_map(rng, 2)
    z, R = np.array([0.5, 2.0]), np.diag([0.03, 0.08]) ** 2
    grown, covariance = own["add_landmark"](state, P, z, R)
    vague = np.zeros((9, 9))
    vague[:7, :7], vague[7:, 7:] = P, 1e7 * np.eye(2)
    updated, limit = own["update_landmarks"](grown, vague, [2], z, R)
    assert updated == pytest.approx(grown, abs=1e-6)
    assert limit == pytest.approx(covariance, abs=1e-5)


def said(name, function):
    return str(grade_public(public_exercise("07_ekf_slam", name), function))


@pytest.mark.parametrize(
    ("moved", "message"),
    [
        (lambda P, new, back: new @ P @ new.T, "Your A is T(s⁺) alone"),
        (lambda P, new, back: back @ P @ back.T, "Your covariance is the covariance of ξ"),
        (lambda P, new, back: new @ back @ P, "You multiply by A on one side only"),
        (lambda P, new, back: new.T @ back.T @ P @ back @ new, "Your A is transposed"),
        (lambda P, new, back: new @ back @ P @ np.linalg.inv(new @ back), "the inverse of A on the right"),
    ],
)
def test_a_slip_with_the_matrices_of_the_invariant_update_has_its_own_message(own, moved, message):
    def invariant_update(state, P, indices, z, R):
        updated = own["invariant_update"](state, P, indices, z, R)[0]
        correct = own["update_landmarks"](state, P, indices, z, R)[1]
        covariance = moved(correct, on_group(updated), np.linalg.inv(on_group(state)))
        return updated, (covariance + covariance.T) / 2

    assert message in said("invariant_update", invariant_update)


def test_several_passes_are_not_called_one_turn():
    def by_passes(angle):
        for _ in range(4):
            angle = np.where(angle > np.pi, angle - 2 * np.pi, angle)
            angle = np.where(angle < -np.pi, angle + 2 * np.pi, angle)
        return angle

    assert "too few turns" in said("warp2pi", by_passes)


def test_shapes_that_do_not_fit_are_answered_with_each_line_that_may_be_wrong():
    def update_landmarks(state, P, indices, z, R):
        return state + np.ones((len(state), 2 * len(indices))) * z, P

    answer = said("update_landmarks", update_landmarks)
    assert "use @ between K and the innovation" in answer and "the order is (pose, landmark)" in answer


@pytest.mark.parametrize("indices", [lambda k: range(1, k + 1), lambda k: [k], lambda k: range(2 * k)])
def test_an_index_that_is_too_large_is_named(own, indices):
    def update(state, covariance, measurements, R, k):
        return own["update_landmarks"](state, covariance, indices(k), measurements, R)

    assert "too large" in said("update", update)
