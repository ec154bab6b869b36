"""Looks at the field: marks lie on their landmarks, and the wrong belief is where it was put."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.distance.looks import ahead, look_around, tilted_measurements, usual_view
from nao_course.sim import TorsoTilt
from tests.lessons.distance.own import geometry, own

UPRIGHT = TorsoTilt(0.0, 0.0)
POSE = Pose(0.9, 0.4, -0.1)


def test_exact_marks_of_an_upright_robot_are_the_landmarks():
    for look in look_around(POSE, [0.5, 0.0], tilt=UPRIGHT, pixel_sigma=0.0):
        points = POSE.to_parent(own()["pixel_to_ground"](look.marks, look.view))
        assert len(points) >= 3 and points == pytest.approx(look.landmarks, abs=1e-6)


def test_a_camera_that_points_lower_than_assumed_puts_every_landmark_too_far():
    (look,) = look_around(POSE, [0.0], tilt=UPRIGHT, pixel_sigma=0.0)
    tilted = own()["pixel_to_ground"](look.marks, look.with_tilt(np.radians(1)).view)
    upright = own()["pixel_to_ground"](look.marks, look.view)
    assert (np.hypot(*tilted.T) < np.hypot(*upright.T)).all() or (
        np.hypot(*tilted.T) > np.hypot(*upright.T)
    ).all()
    assert (np.hypot(*tilted.T) > np.hypot(*upright.T)).all()


def test_only_near_marks_are_left():
    (look,) = look_around(POSE, [0.0])
    near = look.within(2.2)
    assert 0 < len(near.marks) < len(look.marks)
    assert len(near.marks) == len(near.landmarks) == len(near.kinds)
    assert np.linalg.norm(near.landmarks - (POSE.x, POSE.y), axis=1).max() < 2.2


def test_measurements_without_a_tilt_are_the_points_themselves():
    view = usual_view()
    points = ahead([1.0, 2.0], view)
    polar = tilted_measurements(**geometry(), view=view, points=points, tilts=[0.0, 0.01])
    assert polar.shape == (2, 2, 2)
    assert polar[0] == pytest.approx(
        np.column_stack([[0, 0], np.array([1.0, 2.0]) + view.offset[0]]), abs=1e-9
    )
    assert (polar[1, :, 1] < polar[0, :, 1]).all() or (polar[1, :, 1] > polar[0, :, 1]).all()
