"""Laws of the head's chain, the projection and the lens."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, NAO_V6, CameraView


def view(**changes):
    values = {"size": (320, 240), "hfov": 1.06, "vfov": 0.83, "height": 0.48, "pitch": 0.3} | changes
    return CameraView(**values)


def test_camera_heights_are_the_published_ones_and_the_head_gives_yaw_and_pitch_and_a_lean_rolls_or_pitches_it():
    # Maker's links, NAO V4: straight legs .523 / .477 m, walking .505 / .459 m.
    heights = [NAO_V4.view(c, stance=s).height for s in ("standing", "walking") for c in ("top", "bottom")]
    assert np.allclose(heights, [0.523, 0.477, 0.505, 0.459], atol=0.0005)
    v = NAO_V4.view("bottom", yaw=0.5, pitch=-0.3)
    assert np.allclose((v.yaw, v.pitch, v.roll), (0.5, np.radians(39.7) - 0.3, 0.0))
    ahead = NAO_V4.view("top", torso_roll=0.1)
    aside = NAO_V4.view("top", yaw=-np.pi / 2, torso_roll=0.1)
    level = NAO_V4.view("top", yaw=-np.pi / 2)
    assert np.isclose(ahead.roll, 0.1, atol=1e-3)
    assert np.isclose(aside.pitch - level.pitch, 0.1, atol=1e-3)
    assert ahead.offset[1] < 0


def test_the_optical_axis_meets_the_middle_and_the_field_of_view_spans_the_picture_with_left_at_smaller_u():
    for yaw in (-0.4, 0.0, 0.7):
        for roll in (0.0, 0.1):
            v = view(yaw=yaw, roll=roll, offset=(0.05, -0.02), k1=-0.08)
            distance = v.height / np.tan(v.pitch)
            hit = np.array(v.offset) + distance * np.array([np.cos(yaw), np.sin(yaw)])
            assert np.allclose(v.project([hit]), [v.centre])
    v = view()
    left, right, far = v.project([[2, 0.5], [2, -0.5], [4, 0]])
    assert left[0] < v.centre[0] < right[0]
    assert far[1] < left[1]
    v = view(pitch=0.7)
    near, end = v.visible_ground()
    assert v.contains(v.project([[end, 0.0]])) and not v.contains(v.project([[end + 0.01, 0.0]]))
    assert not v.contains(v.project([[near - 0.01, 0.0]]))
    assert (
        view(pitch=0.0, yaw=2.0).visible_ground()[1] == np.inf and view(pitch=-1.0).visible_ground() is None
    )
    leaning = view(roll=0.1)
    horizon = leaning.project([[1e6, 4e5], [1e6, -4e5]])
    assert horizon[0, 1] > horizon[1, 1]
    v = view(pitch=0.0)
    edge = v.project([[1.0, np.tan(v.hfov / 2), v.height], [1.0, 0.0, v.height + np.tan(v.vfov / 2)]])
    assert np.isclose(edge[0, 0], -0.5)
    assert np.isclose(edge[1, 1], -0.5)
    phone = CameraView.from_fov((4000, 3000), np.radians(65), height=0.4, pitch=0.5)
    assert np.isclose(*phone.focal), "square pixels"


@given(st.floats(-0.15, 0.15), st.floats(-0.5, 319.5), st.floats(-0.5, 239.5))
def test_lens_and_its_removal_cancel(k1, u, v):
    camera = view(k1=k1)
    assert np.allclose(camera.distort(camera.undistort([u, v])), [u, v], atol=1e-6)


@pytest.mark.parametrize("size", [(320, 240), (1, 1)])
def test_the_picture_reaches_half_a_pixel_beyond_the_middles_of_its_outer_pixels(size):
    camera = view(size=size)
    low, high = np.array([-0.5, -0.5]), np.array(size) - 0.5
    assert camera.contains([low, high, (low[0], high[1]), (low + high) / 2]).all()
    for axis in (0, 1):
        for corner, away in ((low, -np.inf), (high, np.inf)):
            beyond = corner.copy()
            beyond[axis] = np.nextafter(beyond[axis], away)
            assert not camera.contains([beyond]).any()


@given(st.floats(-2, 9), st.floats(-2, 7))
def test_a_point_is_in_the_picture_where_it_lies_in_one_of_its_pixels(u, v):
    columns, rows = np.meshgrid(np.arange(7), np.arange(5))
    in_a_pixel = (np.abs(columns - u) <= 0.5) & (np.abs(rows - v) <= 0.5)
    assert view(size=(7, 5)).contains([u, v])[0] == in_a_pixel.any()


def test_moved_together_robot_and_points_look_the_same_and_barrel_pulls_the_corners_inwards(rng):
    points = rng.uniform(-3, 3, (40, 2))
    robot, moved = Pose(0.3, -0.2, 0.4), Pose(5.0, -3.0, 2.0)
    v = NAO_V4.view("top", yaw=0.3)
    there = v.project(moved.to_parent(points), moved @ robot)
    assert np.allclose(v.project(points, robot), there, equal_nan=True)
    points = rng.uniform([0.5, -1], [4, 1], (50, 2))
    small, large = view(k1=-0.08).project(points), view(k1=-0.08, size=(1280, 960)).project(points)
    assert np.allclose((small + 0.5) * 4, large + 0.5)
    barrel, straight = view(k1=-0.08), view()
    corner = [0.0, 0.0]
    assert (barrel.distort(corner) > corner).all()
    assert np.allclose(barrel.distort(barrel.centre), [barrel.centre])
    assert np.allclose(straight.undistort(corner), [corner])
    assert np.isnan(view().project([[-1.0, 0.0]])).all()
    assert np.isnan(view(k1=-0.08, pitch=0.0).project([[0.1, 3.0, 0.48]])).all()
    assert view().project([]).shape == (0, 2)
    assert not view().contains([[np.nan, np.nan]])[0]
    bent = view(k1=-0.08)
    assert np.isnan(bent.undistort([[np.nan, 2.0], [3.0, np.nan]])).all()
    assert np.allclose(bent.undistort([bent.centre]), [bent.centre])


@pytest.mark.parametrize(("model", "hfov_deg", "vfov_deg"), [(NAO_V4, 60.97, 47.64), (NAO_V6, 56.3, 43.7)])
def test_the_ray_at_the_edge_of_the_picture_has_the_makers_angle(model, hfov_deg, vfov_deg):
    v = model.view("top")
    right = v.undistort([v.size[0] - 0.5, v.centre[1]])[0, 0]
    below = v.undistort([v.centre[0], v.size[1] - 0.5])[0, 1]
    assert 2 * np.degrees(np.arctan((right - v.centre[0]) / v.focal[0])) == pytest.approx(hfov_deg)
    assert 2 * np.degrees(np.arctan((below - v.centre[1]) / v.focal[1])) == pytest.approx(vfov_deg)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: view(size=(0, 240)), r"size must be .* got \(0, 240\)"),
        (lambda: view(size=(320.5, 240)), "whole pixels"),
        (lambda: view(size=(10**6, 240)), "1 to 8192"),
        (lambda: view(size=(np.inf, 3)), "size must be"),
        (lambda: view(hfov=4.0), "hfov must be between 0 and pi"),
        (lambda: view(height=0.0), "above the ground"),
        (lambda: view(pitch=np.nan), "pitch must be a finite number"),
        (lambda: view(pitch=25.0), "pitch must be in radians"),
        (lambda: view(roll=25.0), "roll must be in radians"),
        (lambda: NAO_V4.view("left"), r"camera must be one of \['bottom', 'top'\], got 'left'"),
        (lambda: NAO_V4.view(pitch=0.6), r"head pitch must be within .*-38.5..29.5 deg"),
        (lambda: NAO_V4.view(yaw=np.nan), "head yaw .* finite"),
        (lambda: NAO_V4.view(stance="lying"), "stance must be"),
        (lambda: view().project([[1, 2, 3, 4]]), r"\(N, 3\)"),
    ],
)
def test_impossible_cameras_are_refused_with_what_was_expected(make, says):
    with pytest.raises(ValueError, match=says):
        make()
