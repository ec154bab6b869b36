"""Laws of angles and poses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nao_course.geometry import Pose, as_points, finite, pose_errors, rotation_3d, wrap_angle, yaw_pitch_roll

metres = st.floats(-20, 20)
angles = st.floats(-10, 10)
poses = st.builds(Pose, metres, metres, angles)


def close(a: Pose, b: Pose) -> bool:
    return bool(np.allclose([a.x, a.y], [b.x, b.y]) and abs(wrap_angle(a.theta - b.theta)) < 1e-9)


any_angle = st.floats(-1e6, 1e6) | st.sampled_from(
    [-0.0, np.pi, -np.pi, 1e-300, *np.nextafter(np.pi, [0, 9])]
)


@given(any_angle | any_angle.map(lambda angle: -angle))
def test_a_wrapped_angle_is_the_same_direction_in_the_half_open_range(angle):
    wrapped = float(wrap_angle(angle))
    assert -np.pi < wrapped <= np.pi
    assert np.isclose(np.exp(1j * wrapped), np.exp(1j * angle))
    assert wrap_angle(wrapped) == wrapped


@given(st.floats(-np.pi, np.pi, exclude_min=True))
def test_an_angle_in_the_range_comes_back_bit_for_bit(angle):
    assert np.float64(wrap_angle(angle)).tobytes() == np.float64(angle).tobytes()
    assert Pose(0, 0, angle).theta == angle


@given(st.lists(any_angle, max_size=6))
def test_an_array_is_wrapped_angle_by_angle_and_keeps_its_shape(angles):
    wrapped = wrap_angle([angles, angles])
    assert wrapped.shape == (2, len(angles)) and wrapped.dtype == float
    assert wrapped.tolist() == [[float(wrap_angle(angle)) for angle in angles]] * 2


def test_pi_stays_minus_pi_becomes_pi_and_what_is_no_angle_stays_none():
    assert isinstance(wrap_angle(1), np.float64)
    assert wrap_angle([]).shape == (0,)
    assert wrap_angle([np.pi, -np.pi]).tolist() == [np.pi, np.pi]
    assert np.isnan(wrap_angle(np.nan))
    with np.errstate(invalid="ignore"):
        assert np.isnan(wrap_angle([np.inf, -np.inf, np.nan])).all()


def test_a_pose_shows_no_negative_zero():
    assert repr(Pose(0.3, 0.0, 0.0).inverse()) == "Pose(x=-0.30, y=0.00, theta=0.000)"
    assert repr(Pose(-0.001, 0.0, -0.0001)) == "Pose(x=0.00, y=0.00, theta=0.000)"


@given(poses, poses, poses)
def test_composition_is_associative_and_a_pose_and_its_inverse_cancel_on_both_sides(a, b, c):
    assert close((a @ b) @ c, a @ (b @ c))
    assert close(a @ a.inverse(), Pose()) and close(a.inverse() @ a, Pose())


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


def test_the_axes_turn_the_way_the_conventions_say_and_straight_up_has_angles_despite_rounding():
    ahead, left, up = np.eye(3)
    assert np.allclose(rotation_3d(np.pi / 2, 0, 0) @ ahead, left)
    assert np.allclose(rotation_3d(0, np.pi / 2, 0) @ ahead, -up)
    assert np.allclose(rotation_3d(0, 0, np.pi / 2) @ left, up)
    for down in (1.0, -1.0):
        rotation = (1 + 1e-15) * np.array([[0.0, 0.0, down], [0.0, 1.0, 0.0], [-down, 0.0, 0.0]])
        assert yaw_pitch_roll(rotation)[1] == pytest.approx(down * np.pi / 2)


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


def test_pose_errors_wrap_the_heading_and_leave_the_poses_as_they_are():
    estimated, true = np.array([[1.0, 2.0, 3.1], [0.0, 0.0, -3.1]]), np.array([0.5, 2.5, -3.1])
    assert np.allclose(pose_errors(estimated, true), [[0.5, -0.5, 6.2 - 2 * np.pi], [-0.5, -2.5, 0.0]])
    assert estimated[0, 2] == 3.1
