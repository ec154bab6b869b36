"""The equations of lesson 05, and its Jacobians: each is the slope of its function at a thousand crooked places."""

import numpy as np
import pytest
import sympy

from nao_course.geometry import Pose, wrap_angle
from nao_course.lessons.ekf_derivations.limits import SIGMAS, short_mean
from nao_course.slam import Measurement, measured_points

NUMBER = 1000
STEP = 1e-5  # of central differences: an error of 1e-8 from the curve nearest by, of 1e-11 from rounding
NEAR = 1e-6


@pytest.fixture(scope="module")
def places():
    """Poses (3, N), controls (2, N), measurements (2, N): headings near half a turn, landmarks near and behind."""
    rng = np.random.default_rng(1605)
    poses = rng.uniform((-4, -3, -np.pi), (4, 3, np.pi), (NUMBER, 3)).T
    poses[2, :200] = np.pi - rng.uniform(0, 1e-4, 200)
    poses[2, 200:400] = -np.pi + rng.uniform(0, 1e-4, 200)
    poses[2, 400:404] = np.pi, -np.pi, np.pi / 2, 0.0
    controls = rng.uniform((-1, -2), (2, 2), (NUMBER, 2)).T
    measurements = rng.uniform((-np.pi, 0.3), (np.pi, 6.0), (NUMBER, 2)).T
    measurements[1, ::4] = rng.uniform(0.15, 0.4, NUMBER // 4)
    measurements[0, 1::4] = np.pi - rng.uniform(0, 1e-6, NUMBER // 4)
    measurements[0, 3::8] = -np.pi + rng.uniform(0, 1e-6, NUMBER // 8)
    return poses, controls, measurements


def slopes(model, at, *rest, angle=None):
    """Central differences of a model of (C, N) numbers: (N, R, C); the row of an angle is wrapped."""
    columns = []
    for row in range(len(at)):
        step = np.zeros_like(at)
        step[row] = STEP
        change = model(at + step, *rest) - model(at - step, *rest)
        if angle is not None:
            change[angle] = wrap_angle(change[angle])
        columns.append(change / (2 * STEP))
    return np.stack(columns).transpose(2, 1, 0)


def each(function, *arrays):
    """What a function of one place gives at all of them."""
    found = [function(*at) for at in zip(*(array.T for array in arrays), strict=True)]
    if isinstance(found[0], tuple):
        return [np.array(part, dtype=float) for part in zip(*found, strict=True)]
    return np.array(found, dtype=float)


@pytest.mark.asserts("eq-5-1")
def test_a_motion_is_the_composition_of_poses_and_its_heading_turns_last(solution, places):
    poses, controls, _ = places
    for pose, (distance, turn), end in zip(
        poses.T, controls.T, each(solution["predict_pose"], poses, controls), strict=True
    ):
        wanted = (Pose(*pose) @ Pose(distance, 0, turn)).as_array()
        assert np.allclose(wrap_angle(end - wanted), 0, atol=1e-12)


@pytest.mark.asserts("eq-5-2")
@pytest.mark.asserts("eq-5-3")
def test_a_measurement_is_where_the_landmark_lies_in_the_robots_frame_and_puts_it_back(solution, places):
    poses, _, measurements = places
    landmarks = solution["landmark_position"](poses, measurements)
    found = each(solution["expected_measurement"], poses, landmarks)
    assert ((found[:, 0] > -np.pi) & (found[:, 0] <= np.pi)).all()
    for pose, landmark, (bearing, distance) in zip(poses.T, landmarks.T, found, strict=True):
        local = distance * np.array([np.cos(bearing), np.sin(bearing)])
        assert np.allclose(local, Pose(*pose).to_local(landmark)[0], atol=1e-12)
    seen = solution["expected_measurement"](poses, landmarks)
    assert np.allclose(solution["landmark_position"](poses, seen), landmarks, atol=1e-12)
    assert np.allclose(wrap_angle(seen[0] - measurements[0]), 0, atol=1e-9)
    pose, (bearing, distance) = poses[:, 7], measurements[:, 7]
    placed = measured_points([Measurement(bearing, distance)], Pose(*pose))[0]
    assert np.allclose(placed, landmarks[:, 7])


@pytest.mark.asserts("eq-5-4")
def test_the_worked_jacobian_of_a_point_on_the_ground_is_its_slope():
    h, phi, beta = sympy.symbols("h phi beta")
    ground = sympy.Matrix([h / sympy.tan(phi) * sympy.cos(beta), h / sympy.tan(phi) * sympy.sin(beta)])
    jacobian = sympy.lambdify((h, phi, beta), ground.jacobian([phi, beta]))
    value = jacobian(0.48, np.arctan2(0.48, 2.0), 0.0)
    assert np.allclose(value * np.radians(1), [[-0.154, 0], [0, 0.035]], atol=5e-4)

    def point(at):
        return np.array([np.cos(at[1]), np.sin(at[1])]) * 0.48 / np.tan(at[0])

    view = np.array([0.3, 0.2])
    assert np.allclose(slopes(point, view[:, None])[0], jacobian(0.48, *view), atol=NEAR)


def noisy(errors, solution, poses, controls):
    """Equation 5.5: the drive's errors along, across and of the turn."""
    moved = solution["predict_pose"](poses, controls + errors[[0, 2]])
    moved[:2] += errors[1] * np.array([-np.sin(poses[2]), np.cos(poses[2])])
    return moved


@pytest.mark.asserts("eq-5-5")
@pytest.mark.asserts("eq-5-7")
def test_the_motions_jacobians_are_its_derivatives_and_the_matrices_of_the_lesson(solution, places):
    poses, controls, _ = places
    by_pose, by_noise = each(solution["motion_jacobians"], poses, controls)
    assert np.abs(by_pose - slopes(solution["predict_pose"], poses, controls, angle=2)).max() < NEAR
    errors = np.zeros((3, NUMBER))
    assert np.abs(by_noise - slopes(noisy, errors, solution, poses, controls, angle=2)).max() < NEAR
    c, s, d = np.cos(poses[2]), np.sin(poses[2]), controls[0]
    assert np.allclose(by_pose, matrices((1, 0, -d * s), (0, 1, d * c), (0, 0, 1)))
    assert np.allclose(by_noise, matrices((c, -s, 0), (s, c, 0), (0, 0, 1)))


@pytest.mark.asserts("eq-5-6")
def test_a_covariance_is_carried_as_many_samples_are_where_the_motion_is_nearly_straight(solution, rng):
    root, noise = rng.normal(0, 1e-3, (3, 3)), rng.normal(0, 1e-3, (3, 3))
    covariance, control_covariance = root @ root.T, noise @ noise.T
    pose, control = np.array([1.0, -2.0, 2.2]), np.array([1.3, 0.4])
    predicted = solution["predict_covariance"](covariance, pose, control, control_covariance)
    number = 200_000
    poses = pose[:, None] + root @ rng.standard_normal((3, number))
    ends = noisy(noise @ rng.standard_normal((3, number)), solution, poses, control[:, None])
    assert np.allclose(np.cov(ends), predicted, atol=0.02 * np.abs(predicted).max())
    assert np.allclose(predicted, predicted.T) and (np.linalg.eigvalsh(predicted) >= 0).all()


@pytest.mark.asserts("eq-5-10")
def test_the_mean_of_a_drive_with_an_uncertain_heading_falls_short_by_the_formula(rng):
    for sigma in SIGMAS[::3]:
        mean = np.cos(rng.normal(0, sigma, 400_000)).mean()
        assert mean == pytest.approx(1 - short_mean(sigma), abs=4e-3)


def matrices(*rows):
    """Matrices (N, R, C) from rows of entries; each entry is a number or an array (N,)."""
    return np.array([[np.broadcast_to(entry, NUMBER) for entry in row] for row in rows]).transpose(2, 0, 1)


@pytest.mark.asserts("eq-5-8")
@pytest.mark.asserts("eq-5-9")
def test_jacobians_of_landmarks_and_measurements_are_derivatives_and_the_lessons_matrices(solution, places):
    poses, _, measurements = places
    place, seen = solution["landmark_position"], solution["expected_measurement"]
    by_pose, by_measurement = each(solution["landmark_jacobians"], poses, measurements)
    assert np.abs(by_pose - slopes(place, poses, measurements)).max() < NEAR
    assert np.abs(by_measurement - slopes(lambda z: place(poses, z), measurements)).max() < NEAR
    (beta, r), theta = measurements, poses[2]
    c, s = np.cos(theta + beta), np.sin(theta + beta)
    assert np.allclose(by_pose, matrices((1, 0, -r * s), (0, 1, r * c)))
    assert np.allclose(by_measurement, matrices((-r * s, c), (r * c, s)))
    landmarks = place(poses, measurements)
    by_pose = each(solution["measurement_jacobian_pose"], poses, landmarks)
    by_landmark = each(solution["measurement_jacobian_landmark"], poses, landmarks)
    assert np.abs(by_pose - slopes(seen, poses, landmarks, angle=0)).max() < NEAR
    assert np.abs(by_landmark - slopes(lambda at: seen(poses, at), landmarks, angle=0)).max() < NEAR
    assert np.allclose(by_landmark, -by_pose[:, :, :2])
    assert np.allclose(by_measurement @ by_landmark, np.eye(2), atol=1e-9)
    first, second = by_landmark.transpose(1, 0, 2)
    assert np.allclose((first * second).sum(axis=1), 0)
    assert np.allclose(np.linalg.norm(second, axis=1), 1)
    assert np.allclose(np.linalg.norm(first, axis=1), 1 / measurements[1])
    dx, dy = landmarks - poses[:2]
    q, r = dx**2 + dy**2, np.hypot(dx, dy)
    assert np.allclose(by_pose, matrices((dy / q, -dx / q, -1), (-dx / r, -dy / r, 0)))
    assert np.allclose(by_landmark, matrices((-dy / q, dx / q), (dx / r, dy / r)))


def test_what_sympy_derives_is_what_numpy_computes(solution, places):
    """Only the derivation of the measurement's Jacobian is an exercise; other tests hold the others."""
    x, y, theta, l_x, l_y = sympy.symbols("x y theta l_x l_y")
    model, derived = solution["derive_measurement_jacobian"]()
    assert sympy.simplify(model.jacobian([x, y, theta]) - derived) == sympy.zeros(2, 3)
    poses, _, measurements = (array[:, :50] for array in places)
    landmarks = solution["landmark_position"](poses, measurements)
    for symbolic, name in (
        (derived, "measurement_jacobian_pose"),
        (model.jacobian([l_x, l_y]), "measurement_jacobian_landmark"),
    ):
        compiled = sympy.lambdify([x, y, theta, l_x, l_y], symbolic)
        wanted = np.array([compiled(*pose, *at) for pose, at in zip(poses.T, landmarks.T, strict=True)])
        assert np.allclose(each(solution[name], poses, landmarks), wanted, atol=1e-12)
