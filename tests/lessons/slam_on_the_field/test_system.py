"""The system of lesson 11: laws of observations, the lean from lines, association, and drives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nao_course.geometry import Pose, wrap_angle
from nao_course.lessons.slam_on_the_field.system.association import associate_jointly
from nao_course.lessons.slam_on_the_field.system.compass import (
    lean_from_lines,
    support,
    wrap_quarter,
)
from nao_course.lessons.slam_on_the_field.system.drives import Driver, FieldOdometry, start_of
from nao_course.lessons.slam_on_the_field.system.lines import corners_of_lines, read_lines
from nao_course.lessons.slam_on_the_field.system.observation import (
    CAMERA_HEIGHT,
    as_observation,
    leaning,
    observation,
    picture_covariance,
    tilt_slopes,
)
from nao_course.sim import NAO_V4, Field, Reality, render
from nao_course.slam import Measurement, Motion, range_and_bearing

HEAD_PITCH = float(np.radians(-31.0))
VIEW = NAO_V4.view("bottom", 0.5, HEAD_PITCH)
POSE = Pose(1.2, 0.3, 0.4)


def some(number: int = 3) -> list[Measurement]:
    rng = np.random.default_rng(number)
    return [Measurement(b, r) for b, r in rng.uniform((-0.8, 0.8), (0.8, 3.5), (number, 2))]


def lines_in(view, pose: Pose) -> np.ndarray:
    """Lines of the field as a perfect detector finds them in a picture without the lens."""
    plain, found = replace(view, k1=0.0), []
    for x1, y1, x2, y2 in Field(2012).lines:
        points = np.linspace((x1, y1), (x2, y2), 200)
        pixels = plain.project(points, pose)
        inside = plain.contains(pixels)
        if inside.sum() > 1:
            found.append(pixels[inside][[0, -1]].ravel())
    return np.array(found)


def ground(pixels, view) -> np.ndarray:
    """Bearing and range of pixels, by the exact geometry."""
    right, below = ((view.undistort(pixels) - view.centre) / view.focal).T
    rays = np.column_stack([np.ones(len(right)), -right, -below]) @ view.rotation.T
    points = np.array(view.offset) - view.height * rays[:, :2] / rays[:, 2:]
    return np.column_stack([np.arctan2(points[:, 1], points[:, 0]), np.hypot(*points.T)])


def test_the_slopes_by_the_lean_are_those_of_a_camera_whose_body_leans():
    points = np.array([(1.2, 0.4), (2.0, 1.5), (2.8, 0.2)])
    pixels, step = VIEW.project(points), 1e-4
    slopes = [
        (ground(pixels, leaning(VIEW, *(sign * step for sign in lean))))
        for lean in ((1, 0), (-1, 0), (0, 1), (0, -1))
    ]
    by_pitch, by_roll = (slopes[0] - slopes[1]) / (2 * step), (slopes[2] - slopes[3]) / (2 * step)
    expected = -tilt_slopes(ground(pixels, VIEW)).reshape(-1, 2, 2)
    # The camera is not just above the point it leans about, but 5 cm ahead of it.
    assert np.allclose(by_pitch, expected[..., 0], rtol=0.12, atol=0.12)
    assert np.allclose(by_roll, expected[..., 1], rtol=0.12, atol=0.12)


def test_a_leaning_view_is_that_of_the_robots_own_kinematics():
    lean = 0.02, -0.015
    true = NAO_V4.view("bottom", 0.5, HEAD_PITCH, torso_pitch=lean[0], torso_roll=lean[1])
    made = leaning(VIEW, *lean)
    assert np.allclose(made.rotation, true.rotation) and np.allclose(made.position, true.position)


def test_a_covariance_is_a_part_for_each_and_one_lean_for_all():
    measured = some()
    alone, together = picture_covariance(measured, (0.0, 0.0)), picture_covariance(measured, (0.02, 0.0))
    assert np.allclose(alone, np.diag(np.diag(alone)))
    assert np.linalg.matrix_rank(together - alone, tol=1e-12) == 1


def test_a_post_is_known_to_its_thickness_and_a_corner_to_a_pixel():
    near = [Measurement(0.1, 1.0, "post"), Measurement(0.1, 1.0, "corner")]
    as_points, thick = (observation(near, post_sigma=sigma).covariance for sigma in (0.0, 0.02))
    assert np.allclose(thick - as_points, np.diag([0.02**2, 0.02**2, 0, 0]))
    far = [Measurement(0.1, 4.0, "post")]
    more = observation(far, post_sigma=0.02).covariance - observation(far).covariance
    assert np.allclose(np.diag(more), [(0.02 / 4) ** 2, 0.02**2])


def test_in_inverse_range_a_lean_is_a_straight_line():
    true = np.array([3.0, 2.0])
    for error in (0.02, -0.02):
        measured = 1 / (1 / true + error / CAMERA_HEIGHT)
        seen = as_observation([Measurement(0.0, r) for r in measured])
        values, _ = seen.about(true)
        assert np.allclose(values[1::2] - true, -(true**2) * error / CAMERA_HEIGHT)


def test_what_is_expected_stays_as_it_is():
    seen = as_observation(some())
    values, covariance = seen.about(seen.values[:, 1])
    assert np.allclose(values, seen.values.ravel()) and np.allclose(covariance, seen.covariance)


def test_measurements_apart_know_the_lean_no_better_than_together():
    seen = observation([Measurement(0.0, 2.0)] * 4, (0.02, 0.0))
    _, R = seen.apart([2.0] * 4)
    together = np.ones(4) @ np.linalg.inv(seen.covariance[1::2, 1::2]) @ np.ones(4)
    assert np.sum(1 / R[:, 1, 1]) == pytest.approx(together, rel=1e-6)


def test_a_part_keeps_what_its_measurements_share():
    seen = as_observation(some(4))
    assert np.allclose(seen.part([2, 0]).covariance[:2, 2:], seen.covariance[4:6, :2])
    assert len(seen.part([])) == 0 and seen.part([]).covariance.shape == (0, 0)


@pytest.mark.parametrize("lean", [(0.0, 0.0), (0.02, -0.01), (-0.03, 0.012)])
def test_perfect_lines_tell_lean_and_heading(lean):
    true = leaning(VIEW, *lean)
    found = lean_from_lines(lines_in(true, POSE), replace(VIEW, k1=0.0))
    assert abs(wrap_quarter(found.direction + POSE.theta)) < np.radians(0.3)
    assert (found.pitch, found.roll) == pytest.approx(lean, abs=np.radians(0.25))


def test_without_lines_the_lean_is_as_unsure_as_before():
    found = lean_from_lines(np.zeros((0, 4)), VIEW)
    assert (found.pitch, found.roll) == (0.0, 0.0)
    assert np.degrees(np.sqrt(found.covariance[0, 0])) == pytest.approx(1.3)


def piece_of_circle(view) -> np.ndarray:
    """A piece of the centre circle, as a line reader takes it for straight: 36 cm long, 1 m ahead."""
    angles = np.array([-0.3, 0.3])
    points = 0.6 * np.column_stack([np.cos(angles), np.sin(angles)])
    here = Pose(1.6, 0.0, np.pi - view.yaw - 0.5)
    return view.project(points, here).reshape(1, 4)


def test_support_is_the_length_of_lines_that_agree_less_that_of_others():
    view = replace(VIEW, k1=0.0)
    true = leaning(view, 0.04, -0.02)
    lines = lines_in(true, POSE)
    lean = lean_from_lines(lines, view)
    ends = [ground(lines[:, k : k + 2], true) for k in (0, 2)]
    metres = [np.column_stack([r * np.cos(b), r * np.sin(b)]) for b, r in (each.T for each in ends)]
    length = np.linalg.norm(metres[1] - metres[0], axis=1).sum()
    assert support(lines, view, lean) == pytest.approx(length, rel=0.02)
    assert support(lines, view, replace(lean, direction=lean.direction + 0.3)) == pytest.approx(
        -length, rel=0.02
    )


def test_a_piece_of_a_circle_is_no_compass_where_lines_must_agree():
    view = replace(VIEW, k1=0.0)
    piece, lines = piece_of_circle(view), lines_in(VIEW, POSE)
    never = float("-inf")
    assert np.isfinite(lean_from_lines(piece, view, least_support=never).direction_sigma)
    asked = lean_from_lines(piece, view)
    assert np.isinf(asked.direction_sigma) and (asked.pitch, asked.roll) == (0.0, 0.0)
    sure = lean_from_lines(lines, view, least_support=never)
    assert sure.direction == lean_from_lines(lines, view).direction


def test_lines_and_corners_of_a_rendered_picture_are_where_they_are():
    pose = Pose(1.3, 0.2, 0.4)
    picture, truth = render(Field(2012), pose, VIEW, Reality.lab(3), np.random.default_rng(3))
    lines = read_lines(picture, VIEW)
    corners = corners_of_lines(lines, VIEW)
    marks = np.array([mark.pixel for mark in truth.landmarks if mark.landmark.kind == "corner"])
    off = np.linalg.norm(corners[:, None] - marks, axis=2).min(axis=1)
    assert len(corners) >= 1 and off.max() < 1.5


def test_joint_association_finds_what_one_lean_has_moved():
    marks = np.array([(2.4, 1.1), (3.0, 1.1), (2.4, -1.1), (3.0, -1.1)])
    state = np.concatenate([[0.3, 0.0, 0.0], marks.ravel()])
    covariance = np.diag([1e-4] * 3 + [1e-4] * 8)
    polar = range_and_bearing(state[:3], marks)
    polar[:, 1] = 1 / (1 / polar[:, 1] + np.radians(2.5) * np.cos(polar[:, 0]) / CAMERA_HEIGHT)
    seen = as_observation([Measurement(b, r) for b, r in polar])
    indices = associate_jointly(state, covariance, ["corner"] * 4, seen, seen.covariance, 4.0)
    assert indices.tolist() == [0, 1, 2, 3]


def test_a_measurement_goes_to_no_landmark_of_another_kind():
    state = np.array([0.0, 0.0, 0.0, 2.0, 0.0])
    seen = as_observation([Measurement(0.0, 2.0, "post")])
    found = associate_jointly(state, np.eye(5) * 1e-4, ["corner"], seen, seen.covariance, 4.0)
    assert found.tolist() == [-1]


def test_odometry_is_a_tenth_of_the_way_and_of_the_turn():
    sd = np.sqrt(np.diag(FieldOdometry().covariance(Motion(1.0, 0.5))))
    assert sd == pytest.approx([0.101, 0.051, 0.05 + np.radians(1)])
    assert np.allclose(
        FieldOdometry(factor=2.0).covariance(Motion(1.0)), 4 * FieldOdometry().covariance(Motion(1.0))
    )


def test_a_drive_is_long_turns_and_stays_on_the_field():
    for seed in range(5):
        pose, driver, motions = start_of(seed), Driver(np.random.default_rng([seed, 13])), []
        for _ in range(60):
            motions.append(driver.next(pose))
            pose = pose @ motions[-1].as_pose()
            assert 0 < pose.x < 3 and -2 < pose.y < 2
        assert sum(motion.distance for motion in motions) >= 12
        assert np.degrees(sum(abs(motion.turn) for motion in motions)) >= 720
        assert abs(wrap_angle(start_of(seed).theta)) < np.pi / 2
