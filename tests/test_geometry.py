"""Laws of angles and poses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nao_course.geometry import Pose, as_points, finite, rotation_3d, wrap_angle, yaw_pitch_roll

metres = st.floats(-20, 20)
angles = st.floats(-10, 10)
poses = st.builds(Pose, metres, metres, angles)


def close(a: Pose, b: Pose) -> bool:
    return bool(np.allclose([a.x, a.y], [b.x, b.y]) and abs(wrap_angle(a.theta - b.theta)) < 1e-9)


@given(angles)
def test_a_wrapped_angle_is_the_same_direction_in_the_half_open_range(angle):
    wrapped = float(wrap_angle(angle))
    assert -np.pi < wrapped <= np.pi
    assert np.isclose(np.exp(1j * wrapped), np.exp(1j * angle))


def test_pi_stays_and_minus_pi_becomes_pi():
    assert wrap_angle([np.pi, -np.pi]).tolist() == [np.pi, np.pi]


@given(poses)
def test_a_pose_and_its_inverse_cancel_on_both_sides(pose):
    assert close(pose @ pose.inverse(), Pose())
    assert close(pose.inverse() @ pose, Pose())


@given(poses, poses, poses)
def test_composition_is_associative(a, b, c):
    assert close((a @ b) @ c, a @ (b @ c))


@given(poses, poses, st.lists(st.tuples(metres, metres), max_size=4))
def test_points_follow_composed_poses(a, b, points):
    assert np.allclose((a @ b).to_parent(points), a.to_parent(b.to_parent(points)))
    assert np.allclose(a.to_local(a.to_parent(points)), as_points(points))


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_angles_come_back_out_of_a_rotation(yaw, pitch, roll):
    rotation = rotation_3d(yaw, pitch, roll)
    assert np.allclose(rotation @ rotation.T, np.eye(3))
    assert np.isclose(np.linalg.det(rotation), 1)
    assert np.allclose(yaw_pitch_roll(rotation), (yaw, pitch, roll))


def test_the_axes_turn_the_way_the_conventions_say():
    ahead, left, up = np.eye(3)
    assert np.allclose(rotation_3d(np.pi / 2, 0, 0) @ ahead, left)
    assert np.allclose(rotation_3d(0, np.pi / 2, 0) @ ahead, -up)
    assert np.allclose(rotation_3d(0, 0, np.pi / 2) @ left, up)


@pytest.mark.parametrize(
    "values", [(np.nan, 0, 0), (0, np.inf, 0), (0, 0, np.nan), ("a", 0, 0), (None, 0, 0)]
)
def test_a_pose_refuses_what_is_no_finite_number(values):
    with pytest.raises(ValueError, match="Pose: .* must be a (finite )?number"):
        Pose(*values)


def test_wrong_shapes_are_named():
    with pytest.raises(ValueError, match=r"\(N, 2\), got \(3,\)"):
        as_points([1, 2, 3])
    with pytest.raises(ValueError, match=r"shape \(3,\)"):
        Pose.from_array([1, 2])
    assert as_points([]).shape == (0, 2)
    assert finite("x", np.float32(2)) == 2.0
