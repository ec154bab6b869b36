"""Slips that students make in lesson 07: each is named by the check, and two at once are named both."""

import numpy as np
import pytest

from nao_course.exercises.checking import grade_public
from nao_course.instructor.authoring.plans import load_solution
from nao_course.lessons.ekf_slam.noise import joint_noise
from tests.lessons.every import public_exercise
from tests.paths import SOLUTIONS


@pytest.fixture(scope="module")
def functions(own):
    """Return what a student calls: lesson 05's functions and `warp2pi`."""
    earlier = load_solution(SOLUTIONS / "05_ekf_derivations.ipynb")
    models = "predict_pose", "motion_jacobians", "expected_measurement"
    jacobians = "measurement_jacobian_pose", "measurement_jacobian_landmark"
    return {"warp2pi": own["warp2pi"], **{name: earlier[name] for name in (*models, *jacobians)}}


def by_passes(angle):
    """Wrap angles in four passes, each of which removes one turn."""
    for _ in range(4):
        angle = np.where(angle > np.pi, angle - 2 * np.pi, angle)
        angle = np.where(angle < -np.pi, angle + 2 * np.pi, angle)
    return angle


def updating(
    functions, *, form="joseph", symmetric=True, innovation=slice(0, None, 2), heading=True, each=False
):
    """Return a student's `update_landmarks`, perhaps with slips."""

    def update_landmarks(state, covariance, indices, measurements, measurement_covariance):
        R = joint_noise(measurement_covariance, len(indices))
        if each and len(indices) > 1:
            for j, i in enumerate(indices):
                rows = slice(2 * j, 2 * j + 2)
                state, covariance = update_landmarks(
                    state, covariance, [i], measurements[rows], R[rows, rows]
                )
            return state, covariance
        nu, H = measurements.copy(), np.zeros((len(R), len(state)))
        for j, i in enumerate(indices):
            rows, place = slice(2 * j, 2 * j + 2), slice(3 + 2 * i, 5 + 2 * i)
            given = state[:3], state[place]
            nu[rows] -= functions["expected_measurement"](*given)
            H[rows, :3] = functions["measurement_jacobian_pose"](*given)
            H[rows, place] = functions["measurement_jacobian_landmark"](*given)
        if innovation is not None:
            nu[innovation] = functions["warp2pi"](nu[innovation])
        S = H @ covariance @ H.T + R
        K = covariance @ H.T @ np.linalg.inv(S)
        rest = np.eye(len(state)) - K @ H
        forms = {
            "joseph": lambda: rest @ covariance @ rest.T + K @ R @ K.T,
            "factor": lambda: rest @ covariance,
            "difference": lambda: covariance - K @ S @ K.T,
        }
        new, P = state + K @ nu, forms[form]()
        new[2] = functions["warp2pi"](new[2]) if heading else new[2]
        return new, (P + P.T) / 2 if symmetric else P

    return update_landmarks


def said(name, function):
    with np.errstate(all="ignore"):
        return str(grade_public(public_exercise("07_ekf_slam", name), function))


@pytest.mark.parametrize(
    ("slips", "words"),
    [
        (
            {"each": True, "innovation": None},
            ["one landmark after the other", "You do not wrap the innovation"],
        ),
        ({"innovation": 0, "heading": False}, ["only the first bearing", "when it is corrected"]),
        ({"form": "factor", "symmetric": False, "innovation": None}, ["two errors", "(P + P.T) / 2"]),
    ],
)
def test_slips_of_update_landmarks_are_named_alone_and_together(functions, slips, words):
    text = said("update_landmarks", updating(functions, **slips))
    assert all(each in text for each in words), text


def test_a_wrong_sign_of_the_poses_jacobian_is_one_error(functions):
    def negative(pose, landmark):
        return -functions["measurement_jacobian_pose"](pose, landmark)

    text = said("update_landmarks", updating({**functions, "measurement_jacobian_pose": negative}))
    assert "wrong sign" in text and "two errors" not in text


@pytest.mark.parametrize("form", ["joseph", "factor", "difference"])
def test_every_right_form_passes_if_it_is_made_symmetric(functions, form):
    assert grade_public(public_exercise("07_ekf_slam", "update_landmarks"), updating(functions, form=form))


def test_several_passes_are_not_called_one_turn():
    assert "too few turns" in said("warp2pi", by_passes)


@pytest.mark.parametrize("indices", [lambda k: range(1, k + 1), lambda k: [k], lambda k: range(2 * k)])
def test_an_index_that_is_too_large_is_named(own, indices):
    def update(state, covariance, measurements, R, k):
        return own["update_landmarks"](state, covariance, indices(k), measurements, R)

    assert "too large" in said("update", update)
