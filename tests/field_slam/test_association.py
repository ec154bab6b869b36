"""Joint association of a picture's measurements with the landmarks of a map."""

import numpy as np
import pytest
from scipy.stats import chi2

from nao_course.field_slam.association import associate_jointly, joint_gate
from nao_course.field_slam.observation import CAMERA_HEIGHT, as_observation
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


@pytest.mark.parametrize("pairs", [1, 2, 5])
def test_the_joint_gate_is_as_unlikely_for_many_pairs_as_for_one(pairs):
    assert chi2.sf(joint_gate(3.0, pairs), 2 * pairs) == pytest.approx(chi2.sf(9.0, 2))
