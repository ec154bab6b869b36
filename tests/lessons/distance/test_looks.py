"""Looks at the field: marks lie on their landmarks, and the wrong belief is where it was put."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.distance.looks import ahead, look_around, tilted_measurements, usual_view
from nao_course.sim import TorsoTilt
from tests.lessons.distance.own import GEOMETRY, OWN

UPRIGHT = TorsoTilt(0.0, 0.0)
POSE = Pose(0.9, 0.4, -0.1)


def test_exact_marks_are_the_landmarks_and_a_camera_that_points_lower_than_assumed_puts_them_too_far():
    first, second = look_around(POSE, [0.5, 0.0], tilt=UPRIGHT, pixel_sigma=0.0)
    for look in (first, second):
        points = OWN["pixel_to_ground"](look.marks, look.view)
        assert len(points) >= 3 and POSE.to_parent(points) == pytest.approx(look.landmarks, abs=1e-6)
    tilted = OWN["pixel_to_ground"](second.marks, second.with_tilt(np.radians(1)).view)
    assert (np.hypot(*tilted.T) > np.hypot(*points.T)).all()


def test_only_near_marks_are_left():
    (look,) = look_around(POSE, [0.0])
    near = look.within(2.2)
    assert 0 < len(near.marks) < len(look.marks)
    assert len(near.marks) == len(near.landmarks) == len(near.kinds)
    assert np.linalg.norm(near.landmarks - (POSE.x, POSE.y), axis=1).max() < 2.2


def test_measurements_without_a_tilt_are_the_points_themselves():
    view = usual_view()
    points = ahead([1.0, 2.0], view)
    polar = tilted_measurements(**GEOMETRY, view=view, points=points, tilts=[0.0, 0.01])
    assert polar.shape == (2, 2, 2)
    assert polar[0] == pytest.approx(np.array([[0, 1], [0, 2]]) + (0, view.offset[0]), abs=1e-9)
    assert len(set(np.sign(polar[1, :, 1] - polar[0, :, 1]))) == 1
