"""The benchmark of the course's fields counts what is found, missed and false, near and far."""

import numpy as np
import pytest

from benchmarks.field.own_fields import NEAR, Match, _match, _rates, ends, field_results
from nao_course.field_slam.demo.drive import FARTHEST, Story
from nao_course.field_slam.drives import drive_over_field
from nao_course.field_slam.walk import WalkFrame
from nao_course.geometry import Pose
from nao_course.sim import Field
from nao_course.slam import Estimate


def test_rates_split_landmarks_by_distance_and_count_false_points_per_picture():
    first = Match(np.array([True, False]), 1, np.array([1.0, NEAR + 1]))
    second = Match(np.array([False, True, True]), 2, np.array([2.0, NEAR + 2, NEAR - 1]))
    near = {"near": 3, "recall, near": pytest.approx(2 / 3)}
    assert _rates([first, second]) == near | {"far": 2, "recall, far": 0.5, "false per picture": 1.5}


def test_true_landmarks_are_hits_and_a_point_beside_them_is_false():
    field, seen = Field(2025), {"corner": 0, "post": 0}
    for shot in drive_over_field(3, moves=2, field=field):
        for kind in seen:
            marks = (m for m in shot.truth.landmarks if m.landmark.kind == kind and not m.occluded)
            pixels = [mark.pixel for mark in marks if mark.distance < FARTHEST]
            match = _match(shot, field, np.array([*pixels, (-300.0, 999.0)]), kind)
            assert match.found.all() and match.false == 1 and (match.distances < FARTHEST).all()
            seen[kind] += len(pixels)
    assert all(seen.values())


def test_the_errors_are_measured_at_the_end_of_the_drives():
    frame = WalkFrame(None, None, None, Pose(1.0, 0.0, 0.0))
    off = Estimate(Pose(1.3, 0.4, 0.0), np.eye(3), [[3.0, 0.7]], [np.eye(2)], ("post",))
    story = Story([frame], [], [Pose(1.0, 0.6, 0.0)], {"ekf": [off]}, [0.0], {"ekf": [0.0]})
    found = ends([story], Field(2012))
    assert found["ekf"]["position worst"] == pytest.approx(0.5)
    assert found["odometry"]["position median"] == pytest.approx(0.6)
    assert (found["odometry"]["lost"], found["ekf"]["landmarks_median"]) == (1, pytest.approx(0.0))


@pytest.mark.slow
def test_a_field_without_goals_has_results_for_corners_alone():
    assert list(field_results("lab", [0])["detectors"]) == ["corners"]
