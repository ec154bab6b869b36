"""The NAO's links and joints, its posture while it walks, and forward kinematics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, finite, rotation_3d
from nao_course.sim import NAO_V4, NaoModel

# Lengths of NAO H25 V4 from the maker's documentation (NAO documentation 1.14, "Links" of H25), m. `NaoModel` has the
# others.
SHOULDER_Y, SHOULDER_Z, ELBOW_Y = 0.098, 0.100, 0.015
UPPER_ARM, LOWER_ARM, HAND_X, HAND_Z = 0.105, 0.05595, 0.05775, 0.01231
HIP_Y = 0.050

STRIDE = 0.12  # m that the body advances during one cycle of two steps
_LIFT = 0.022  # m that a foot is lifted
_PHASES = 24
_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Link:
    """A rigid part of the robot, named after the joint that carries it.

    The joint is on the link `parent`, "" for the torso, whose parent is the robot frame, at `origin` in the parent's
    frame, m; a positive angle turns counterclockwise about `axis`.
    """

    name: str
    parent: str
    origin: tuple[float, float, float]
    axis: tuple[float, float, float] = _Z


def links(model: NaoModel = NAO_V4) -> tuple[Link, ...]:
    """Return the links of the robot, each after its parent; all frames have the axes ahead, left, up at zero angles.

    The joints HipYawPitch, which both legs share, and the fingers are left out, because nothing in this course moves
    them.
    """
    torso = model.neck_height("walking") - model.neck_offset
    found = [
        Link("Torso", "", (0.0, 0.0, torso)),
        Link("HeadYaw", "Torso", (0.0, 0.0, model.neck_offset), _Z),
        Link("HeadPitch", "HeadYaw", (0.0, 0.0, 0.0), _Y),
    ]
    for side, sign in (("L", 1.0), ("R", -1.0)):
        found += [
            Link(f"{side}ShoulderPitch", "Torso", (0.0, sign * SHOULDER_Y, SHOULDER_Z), _Y),
            Link(f"{side}ShoulderRoll", f"{side}ShoulderPitch", (0.0, 0.0, 0.0), _Z),
            Link(f"{side}ElbowYaw", f"{side}ShoulderRoll", (UPPER_ARM, sign * ELBOW_Y, 0.0), _X),
            Link(f"{side}ElbowRoll", f"{side}ElbowYaw", (0.0, 0.0, 0.0), _Z),
            Link(f"{side}WristYaw", f"{side}ElbowRoll", (LOWER_ARM, 0.0, 0.0), _X),
            Link(f"{side}HipRoll", "Torso", (0.0, sign * HIP_Y, -model.hip_offset), _X),
            Link(f"{side}HipPitch", f"{side}HipRoll", (0.0, 0.0, 0.0), _Y),
            Link(f"{side}KneePitch", f"{side}HipPitch", (0.0, 0.0, -model.thigh), _Y),
            Link(f"{side}AnklePitch", f"{side}KneePitch", (0.0, 0.0, -model.tibia), _Y),
        ]
    return tuple(found)


def posture(
    head: tuple[float, float] = (0.0, 0.0), phase: float | None = None, model: NaoModel = NAO_V4
) -> dict[str, float]:
    """Return the angles, rad, of the joints that are not at zero.

    `head` is yaw and pitch, rad, positive to the left and down; `phase` is the phase of the walk, rad, where 2 pi is a
    cycle of two steps. Without a phase, the robot stands with bent knees.
    """
    angles = {"HeadYaw": head[0], "HeadPitch": head[1]}
    for side, sign, shift in (("L", 1.0, 0.0), ("R", -1.0, np.pi)):
        ahead, up = (0.0, 0.0) if phase is None else _foot(phase + shift)
        hip, knee = _leg(ahead, up, model)
        angles |= {f"{side}HipPitch": hip, f"{side}KneePitch": knee, f"{side}AnklePitch": -hip - knee}
        angles |= {
            # The arm swings against the leg of its side.
            f"{side}ShoulderPitch": 1.50 + 5.0 * ahead,
            f"{side}ShoulderRoll": sign * 0.07,
            f"{side}ElbowYaw": -sign * 1.35,
            f"{side}ElbowRoll": -sign * 0.62,
        }
    return angles


def gait(model: NaoModel = NAO_V4) -> tuple[tuple[str, ...], FloatArray]:
    """Return the joints that move in a walk, and their angles (phases, joints), rad, over one cycle."""
    rows = [posture(phase=phase, model=model) for phase in np.arange(_PHASES) * 2 * np.pi / _PHASES]
    names = tuple(name for name in rows[0] if np.ptp([row[name] for row in rows]) > 1e-6)
    return names, np.array([[row[name] for name in names] for row in rows])


def _foot(phase: float) -> tuple[float, float]:
    """Return how far a foot is ahead of its hip, and how high, m: on the ground in the first half of a cycle."""
    part = (phase / np.pi) % 2
    if part < 1:
        return float(STRIDE / 4 - part * STRIDE / 2), 0.0
    return float(-STRIDE / 4 * np.cos((part - 1) * np.pi)), float(_LIFT * np.sin((part - 1) * np.pi))


def _leg(ahead: float, up: float, model: NaoModel) -> tuple[float, float]:
    """Return the angles of hip and knee that put the ankle ahead of the hip and over the standing foot, rad."""
    down = model.thigh + model.tibia - model.crouch - up
    reach = min(float(np.hypot(ahead, down)), model.thigh + model.tibia)
    a, b = model.thigh, model.tibia
    knee = np.pi - np.arccos((a**2 + b**2 - reach**2) / (2 * a * b))
    bend = np.arccos((a**2 + reach**2 - b**2) / (2 * a * reach))
    return float(-np.arctan2(ahead, down) - bend), float(knee)


def forward_kinematics(
    angles: Mapping[str, float], model: NaoModel = NAO_V4, tilt: tuple[float, float] = (0.0, 0.0)
) -> Mapping[str, FloatArray]:
    """Return matrices (4, 4) that transform homogeneous points, m, from each link's frame to the robot frame.

    Joints without an angle, rad, are at zero. `tilt` is pitch and roll of the whole body about the point on the ground
    below it, rad, positive to the front and to the right, as in `NaoModel.view`. An unknown joint or an angle that is
    not finite raises a ValueError.
    """
    chain = links(model)
    if unknown := set(angles) - {link.name for link in chain}:
        raise ValueError(f"the robot has no joint {sorted(unknown)[0]!r}")
    root = _matrix(rotation_3d(0.0, *tilt), (0.0, 0.0, 0.0))
    poses: dict[str, FloatArray] = {}
    for link in chain:
        turned = rotation_about(link.axis, finite(f"{link.name} (rad)", angles.get(link.name, 0.0)))
        poses[link.name] = (poses[link.parent] if link.parent else root) @ _matrix(turned, link.origin)
    return MappingProxyType(poses)


def camera_in_head(camera: str, model: NaoModel = NAO_V4) -> FloatArray:
    """Return the pose (4, 4) of a camera (axes ahead, left, up) in the frame of the link HeadPitch."""
    mount = model.cameras[model.check_camera(camera)]
    return _matrix(rotation_3d(0.0, mount.pitch, 0.0), (mount.x, 0.0, mount.z))


def rotation_about(axis: npt.ArrayLike, angle: float) -> FloatArray:
    """Return the (3, 3) matrix of a rotation about a unit axis, counterclockwise by `angle` in rad."""
    x, y, z = np.asarray(axis, dtype=float)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross))


def _matrix(rotation: FloatArray, origin: tuple[float, float, float]) -> FloatArray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, origin
    return pose
