"""Joint association of a picture's measurements with the landmarks of a map."""

from itertools import product

import numpy as np
import pytest
from scipy.stats import chi2

from nao_course.field_slam.association import associate_jointly, joint_gate, landmark_jacobian
from nao_course.field_slam.observation import CAMERA_HEIGHT, as_observation
from nao_course.geometry import wrap_angle
from nao_course.slam import Measurement, range_and_bearing


def test_joint_association_succeeds_although_a_tilt_has_moved_all_measurements():
    marks = np.array([(2.4, 1.1), (3.0, 1.1), (2.4, -1.1), (3.0, -1.1)])
    state = np.concatenate([[0.3, 0.0, 0.0], marks.ravel()])
    covariance = np.diag([1e-4] * 3 + [1e-4] * 8)
    polar = range_and_bearing(state[:3], marks)
    polar[:, 1] = 1 / (1 / polar[:, 1] + np.radians(2.5) * np.cos(polar[:, 0]) / CAMERA_HEIGHT)
    seen = as_observation([Measurement(b, r) for b, r in polar])
    indices = associate_jointly(state, covariance, ["corner"] * 4, seen, seen.covariance, 4.0)
    assert indices.tolist() == [0, 1, 2, 3]


def test_a_landmark_is_taken_by_one_measurement_of_its_kind_at_most_and_contradicted_ones_are_left_out():
    state = np.array([0.0, 0.0, 0.0, 2.0, 0.0])
    seen = as_observation([Measurement(0.0, 2.0, "post")])
    found = associate_jointly(state, np.eye(5) * 1e-4, ["corner"], seen, seen.covariance, 4.0)
    assert found.tolist() == [-1]
    seen = as_observation([Measurement(0.0, 2.0), Measurement(0.01, 2.0)])
    found = associate_jointly(state, np.eye(5) * 1e-4, ["corner"], seen, seen.covariance, 4.0)
    assert sorted(found.tolist()) == [-1, 0]
    bearings = np.array([-0.8, 0.0, 0.8])
    assert with_uncertain_heading(bearings, bearings + (-0.1, 0.15, 0.15), 0.01) == [-1, 1, 2]
    assert with_uncertain_heading(np.array([0.0, -0.12, 0.8]), [0.03, 0.95], 0.03) == [1, 2]


def with_uncertain_heading(bearings, measured, measurement_sigma) -> list[int]:
    """Associate bearings with landmarks 2 m away; the heading is uncertain by 0.1 rad, everything else is known."""
    marks = 2 * np.column_stack([np.cos(bearings), np.sin(bearings)])
    state = np.concatenate([np.zeros(3), marks.ravel()])
    covariance = np.diag([1e-8, 1e-8, 1e-2] + [1e-8] * marks.size)
    R = np.diag([measurement_sigma**2, 1e-2] * len(measured))
    seen = [Measurement(float(bearing), 2.0) for bearing in measured]
    return associate_jointly(state, covariance, ["corner"] * len(marks), seen, R, 4.0).tolist()


def exhaustive(state, covariance, seen, R, gate):
    """Return the association that a search through all of them finds, by the joint covariance of all pairs."""
    marks, best = state[3:].reshape(-1, 2), (0, 0.0, [-1] * len(seen))
    for tried in product(range(-1, len(marks)), repeat=len(seen)):
        chosen = [j for j in tried if j >= 0]
        if not chosen or len({*chosen}) < len(chosen):
            continue
        used, numbers = np.flatnonzero(np.array(tried) >= 0), np.array(chosen)
        rows = (2 * used[:, None] + (0, 1)).ravel()
        polar, offset = range_and_bearing(state[:3], marks[numbers]), marks[numbers] - state[:2]
        nu = np.array([(seen[i].bearing, seen[i].range) for i in used]) - polar
        nu[:, 0] = wrap_angle(nu[:, 0])
        H = landmark_jacobian(offset, polar[:, 1], numbers, len(state))
        S = H @ covariance @ H.T + R[np.ix_(rows, rows)]
        alone = [nu[k] @ np.linalg.solve(S[2 * k :, 2 * k :][:2, :2], nu[k]) for k in range(len(used))]
        distance = nu.ravel() @ np.linalg.solve(S, nu.ravel())
        fits = max(alone) <= gate**2 and distance <= joint_gate(gate, len(used))
        best = max(best, (len(used), -distance, list(tried))) if fits else best
    return best[2]


def test_the_association_is_that_of_an_exhaustive_search(rng):
    matched = []  # landmarks behind the robot have bearings of both signs; tilt and pose correlate the pairs
    for _ in range(60):
        marks = rng.uniform((-2.0, -0.6), (-1.0, 0.6), (4, 2))
        state, root = np.concatenate([rng.normal(0, 0.05, 3), marks.ravel()]), rng.normal(0, 0.05, (11, 11))
        polar = range_and_bearing(state[:3], marks[:3]) + rng.normal(0, (0.15, 0.2), (3, 2))
        seen = as_observation([Measurement(float(wrap_angle(b)), float(r)) for b, r in polar])
        found = associate_jointly(state, root @ root.T, ["corner"] * 4, seen, seen.covariance, 1.5)
        assert found.tolist() == exhaustive(state, root @ root.T, seen, seen.covariance, 1.5)
        matched.append(int((found >= 0).sum()))
    assert {1, 2, 3} <= {*matched}


@pytest.mark.parametrize("pairs", [1, 2, 5])
def test_the_joint_gate_is_as_unlikely_for_many_pairs_as_for_one(pairs):
    assert chi2.sf(joint_gate(3.0, pairs), 2 * pairs) == pytest.approx(chi2.sf(9.0, 2))
