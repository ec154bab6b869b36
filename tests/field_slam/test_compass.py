"""Body tilt and heading from the lines of a picture."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.field_slam.compass import QUARTER, estimate_body_tilt, support, wrap_quarter
from nao_course.field_slam.observation import TILT_SIGMAS, tilted
from nao_course.geometry import Pose
from nao_course.sim import Field
from tests.field_slam.test_observation import VIEW, ground

POSE = Pose(1.2, 0.3, 0.4)


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


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.02, -0.01), (-0.03, 0.012)])
def test_exact_lines_give_the_tilt_and_the_heading(tilt):
    true = tilted(VIEW, *tilt)
    found = estimate_body_tilt(lines_in(true, POSE), replace(VIEW, k1=0.0))
    assert abs(wrap_quarter(found.direction + POSE.theta)) < np.radians(0.3)
    assert (found.pitch, found.roll) == pytest.approx(tilt, abs=np.radians(0.25))


def test_a_prior_may_be_given_as_a_covariance_and_stays_without_lines():
    found = estimate_body_tilt(np.zeros((0, 4)), VIEW)
    assert (found.pitch, found.roll) == (0.0, 0.0)
    assert found.covariance[2, 2] == pytest.approx(QUARTER**2 / 12)  # uniform
    assert np.degrees(np.sqrt(found.covariance[0, 0])) == pytest.approx(1.3)
    lines, view = lines_in(tilted(VIEW, 0.02, -0.01), POSE), replace(VIEW, k1=0.0)
    as_sigmas = estimate_body_tilt(lines, view)
    as_covariance = estimate_body_tilt(lines, view, np.diag(np.square(TILT_SIGMAS)))
    assert as_covariance.pitch == pytest.approx(as_sigmas.pitch)
    assert np.allclose(as_covariance.covariance, as_sigmas.covariance)
    correlated = np.array([[4e-4, 2e-4], [2e-4, 3e-4]])
    assert np.allclose(estimate_body_tilt(np.zeros((0, 4)), view, correlated).covariance[:2, :2], correlated)


def piece_of_circle(view) -> np.ndarray:
    """A piece of the centre circle, as a line reader takes it for straight: 36 cm long, 1 m ahead."""
    angles = np.array([-0.3, 0.3])
    points = 0.6 * np.column_stack([np.cos(angles), np.sin(angles)])
    here = Pose(1.6, 0.0, np.pi - view.yaw - 0.5)
    return view.project(points, here).reshape(1, 4)


def test_support_is_the_length_of_lines_that_agree_less_that_of_others_and_a_piece_of_a_circle_has_none():
    view = replace(VIEW, k1=0.0)
    true = tilted(view, 0.04, -0.02)
    lines = lines_in(true, POSE)
    tilt = estimate_body_tilt(lines, view)
    ends = [ground(lines[:, k : k + 2], true) for k in (0, 2)]
    metres = [np.column_stack([r * np.cos(b), r * np.sin(b)]) for b, r in (each.T for each in ends)]
    length = np.linalg.norm(metres[1] - metres[0], axis=1).sum()
    assert support(lines, view, tilt) == pytest.approx(length, rel=0.02)
    turned = replace(tilt, direction=tilt.direction + 0.3)
    assert support(lines, view, turned) == pytest.approx(-length, rel=0.02)
    view = replace(VIEW, k1=0.0)
    piece, lines = piece_of_circle(view), lines_in(VIEW, POSE)
    never = float("-inf")
    assert 0.005 < estimate_body_tilt(piece, view, least_support=never).direction_sigma < 0.1
    asked = estimate_body_tilt(piece, view)
    assert np.isinf(asked.direction_sigma) and (asked.pitch, asked.roll) == (0.0, 0.0)
    sure = estimate_body_tilt(lines, view, least_support=never)
    assert sure.direction == estimate_body_tilt(lines, view).direction


@pytest.mark.parametrize("degrees", [15, 25])
def test_two_equal_lines_that_disagree_leave_the_direction_uncertain_by_half_their_angle(degrees):
    view, half = replace(VIEW, k1=0.0), np.radians(degrees) / 2
    ways = [np.array([np.cos(angle), np.sin(angle)]) for angle in (view.yaw + half, view.yaw - half)]
    middle = 1.2 * np.array([np.cos(view.yaw), np.sin(view.yaw)])
    ends = [middle + length * way for way in ways for length in (-0.3, 0.3)]
    lines = view.project(np.array(ends)).reshape(2, 4)
    found = estimate_body_tilt(lines, view, least_support=float("-inf"))
    assert np.degrees(np.sqrt(found.covariance[2, 2])) == pytest.approx(degrees / 2, rel=0.1)
