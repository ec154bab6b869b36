"""The robot's links: its cameras are where the simulator has them, and its feet are on the ground."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nao_course.sim import NAO_V4, NAO_V6
from nao_course.widgets.world.meshes import triangles
from nao_course.widgets.world.robot import STRIDE, camera_in_head, forward_kinematics, gait, links, posture
from nao_course.widgets.world.shells import shells

ANGLE = st.floats(-0.05, 0.05)


@pytest.mark.parametrize("model", [NAO_V4, NAO_V6], ids=["V4", "V6"])
@given(
    camera=st.sampled_from(["top", "bottom"]),
    yaw=st.floats(-2.08, 2.08),
    pitch=st.floats(-0.67, 0.51),
    tilt=st.tuples(ANGLE, ANGLE),
)
def test_a_camera_is_where_the_simulator_has_it(model, camera, yaw, pitch, tilt):
    head = forward_kinematics(posture((yaw, pitch), model=model), model, tilt)["HeadPitch"]
    pose = head @ camera_in_head(camera, model)
    view = model.view(camera, yaw, pitch, torso_pitch=tilt[0], torso_roll=tilt[1])
    np.testing.assert_allclose(pose[:3, 3], view.position, atol=1e-9)  # far below a millimetre
    np.testing.assert_allclose(pose[:3, :3], view.rotation, atol=1e-9)


def test_it_stands_on_both_feet_with_its_real_height():
    frames = forward_kinematics(posture())
    for side, sign in (("L", 1), ("R", -1)):
        foot = frames[f"{side}AnklePitch"]
        np.testing.assert_allclose(foot[:3, 3], [0.0, sign * 0.05, NAO_V4.foot], atol=1e-9)
        np.testing.assert_allclose(foot[:3, :3], np.eye(3), atol=1e-9)
    placed = [(shape.points(), frames[shape.link]) for shape in shells()]
    corners = np.vstack([points @ frame[:3, :3].T + frame[:3, 3] for points, frame in placed])
    assert abs(corners[:, 2].min()) < 0.001
    # The maker gives a height of 573 mm; bent knees take 18 mm.
    assert corners[:, 2].max() == pytest.approx(0.573 - NAO_V4.crouch, abs=0.01)
    # And a width of 275 mm.
    assert np.ptp(corners[:, 1]) == pytest.approx(0.275, abs=0.04)


@given(st.floats(0, 2 * np.pi))
def test_in_a_walk_one_foot_is_on_the_ground_flat_and_moves_backwards_as_fast_as_the_body_walks(phase):
    step = 1e-4
    here, after = (forward_kinematics(posture(phase=phase + each)) for each in (0.0, step))
    feet = {side: here[f"{side}AnklePitch"] for side in "LR"}
    heights = {side: foot[2, 3] for side, foot in feet.items()}
    lowest = min(heights, key=heights.get)
    assert heights[lowest] == pytest.approx(NAO_V4.foot, abs=1e-9)
    assert all(height >= NAO_V4.foot - 1e-9 for height in heights.values())
    for foot in feet.values():
        np.testing.assert_allclose(foot[:3, :3], np.eye(3), atol=1e-9)
    near_the_change = min(phase % np.pi, np.pi - phase % np.pi) < 2 * step
    if not near_the_change:
        moved = after[f"{lowest}AnklePitch"][0, 3] - feet[lowest][0, 3]
        assert moved == pytest.approx(-STRIDE * step / (2 * np.pi), rel=1e-6)


def test_the_gait_is_the_posture_at_each_phase_and_every_link_comes_after_its_parent():
    names, table = gait()
    number = 5
    angles = posture(phase=number * 2 * np.pi / len(table))
    assert [angles[name] for name in names] == table[number].tolist()
    assert {name[1:] for name in names} >= {"HipPitch", "KneePitch", "AnklePitch", "ShoulderPitch"}
    names = [link.name for link in links()]
    assert len(set(names)) == len(names)
    for number, link in enumerate(links()):
        assert link.parent in ("", *names[:number])
    assert {shape.link for shape in shells()} <= set(names)
    with pytest.raises(ValueError, match="no joint 'Tail'"):
        forward_kinematics({"Tail": 0.1})
    with pytest.raises(ValueError, match="HeadYaw"):
        forward_kinematics({"HeadYaw": np.nan})


def test_left_and_right_are_mirror_images_and_every_surface_is_closed_and_faces_outwards():
    frames = forward_kinematics(posture())
    for shape in shells():
        if shape.link[0] != "L":
            continue
        left = shape.points() @ frames[shape.link][:3, :3].T + frames[shape.link][:3, 3]
        other = shape.mirrored(f"R{shape.link[1:]}")
        assert other in shells()
        right = other.points() @ frames[other.link][:3, :3].T + frames[other.link][:3, 3]
        np.testing.assert_allclose(np.sort(left[:, 1]), np.sort(-right[:, 1]), atol=1e-9)
    edges = np.concatenate([triangles()[:, [0, 1]], triangles()[:, [1, 2]], triangles()[:, [2, 0]]])
    forward = set(map(tuple, edges.tolist()))
    assert len(forward) == len(edges)  # each edge once in each direction
    assert {(b, a) for a, b in forward} == forward
    for shape in shells():
        a, b, c = (shape.points()[triangles()[:, i]] for i in range(3))
        volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
        assert 0.3 < volume / np.prod(shape.size) < 1.5
