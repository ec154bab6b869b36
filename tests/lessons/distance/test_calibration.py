"""Looks at the field, and calibration on marked pictures: marks lie on their landmarks, and the offset is found."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.distance.calibration import (
    EDGES,
    OFFSET,
    Marked,
    by_distance,
    marked_pictures,
    range_errors,
)
from nao_course.lessons.distance.calibration_figure import REAL, draw_calibrated
from nao_course.lessons.distance.looks import ahead, look_around, tilted_measurements, usual_view
from nao_course.sim import TorsoTilt
from tests.lessons.distance.own import GEOMETRY, OWN, polar

UPRIGHT = TorsoTilt(0.0, 0.0)
POSE = Pose(0.9, 0.4, -0.1)


def test_exact_marks_are_the_landmarks_and_a_camera_that_points_lower_than_assumed_puts_them_too_far():
    first, second = look_around(POSE, [0.5, 0.0], tilt=UPRIGHT, pixel_sigma=0.0)
    for look in (first, second):
        points = OWN["pixel_to_ground"](look.marks, look.view)
        assert len(points) >= 3 and POSE.to_parent(points) == pytest.approx(look.landmarks, abs=1e-6)
    tilted = OWN["pixel_to_ground"](second.marks, second.with_tilt(np.radians(1)).view)
    assert (np.hypot(*tilted.T) > np.hypot(*points.T)).all()


def test_only_near_marks_are_left_and_measurements_without_a_tilt_are_the_points_themselves():
    (look,) = look_around(POSE, [0.0])
    near = look.within(2.2)
    assert 0 < len(near.marks) < len(look.marks)
    assert len(near.marks) == len(near.landmarks) == len(near.kinds)
    assert np.linalg.norm(near.landmarks - (POSE.x, POSE.y), axis=1).max() < 2.2
    view = usual_view()
    points = ahead([1.0, 2.0], view)
    polar = tilted_measurements(**GEOMETRY, view=view, points=points, tilts=[0.0, 0.01])
    assert polar.shape == (2, 2, 2)
    assert polar[0] == pytest.approx(np.array([[0, 1], [0, 2]]) + (0, view.offset[0]), abs=1e-9)
    assert len(set(np.sign(polar[1, :, 1] - polar[0, :, 1]))) == 1


def exact(pixels, view):
    return polar(pixels, view)[:, 1]


def test_ten_pictures_give_the_offset_and_with_it_distances_are_decimetres_off_and_not_metres():
    pictures = marked_pictures(10, rng=3)
    found = [OWN["estimate_pitch"](each.pixels, each.ground, each.view) for each in pictures]
    assert np.median(found) == pytest.approx(OFFSET, abs=np.radians(0.5))
    pictures = marked_pictures(25, rng=2)
    before, after = (by_distance(*range_errors(exact, pictures, offset)) for offset in (0.0, OFFSET))
    assert before[1][0] > 1.0
    assert after[0][0] < 0.08 and after[1][0] < 0.2


def test_errors_of_the_range_are_binned_by_it_and_the_figure_has_the_real_robots_numbers_too():
    view = marked_pictures(1)[0].view
    mark = Marked(np.array([[100.0, 200.0]]), np.array([[3.0, 4.0]]), view)
    true, errors = range_errors(lambda pixels, view: np.array([6.5]), [mark])
    assert true.tolist() == [5.0] and errors.tolist() == [1.5]
    found = by_distance(np.array([1.5, 1.6, 2.5, 3.5, 4.5]), np.array([-0.1, 0.3, np.nan, 0.2, 1.0]))
    assert found[0] == (0.3, 0.3) and found[1] == (np.inf, np.inf) and found[3] == (1.0, 1.0)
    assert len(found) == len(EDGES) - 1
    errors = (np.array([1.5, 2.5, 3.5, 4.5]), np.array([0.1, 0.2, 0.3, 0.4]))
    words = draw_calibrated({"the paper's formula": errors, "exact": errors}).alt
    assert "simulated, exact: 0.10, 0.20, 0.30, 0.40 m" in words
    assert "real walk, exact: 0.04, 0.06, 0.10, 0.19 m" in words
    assert set(REAL) == {"real scenes", "real walk"}
    for methods in REAL.values():  # the exact distances have the shorter tail far away
        assert methods["exact"][-1][1] < methods["the paper's formula"][-1][1]
