"""Standard sets of rendered pictures with ground truth, for tuning detectors and for reporting their results."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from nao_course.geometry import Pose
from nao_course.sim.camera import NAO_V4, CameraView
from nao_course.sim.field import Field
from nao_course.sim.nao import TorsoTilt
from nao_course.sim.reality import Reality
from nao_course.sim.render import PictureTruth, render, visible_landmarks

SceneSet = Literal["tune", "report", "whole_tune", "whole"]

_SCENES = 30  # as many as the seed paper's "random locations on the soccer field"
_ROOMS = 5  # different rooms in each set
_WHOLE_SCENES, _WHOLE_ROOMS, _FIRST_WHOLE_ROOM = 60, 10, 10**9
# The head of the real pictures' robot was commanded to -31 degrees, but the pictures look 6.4 degrees lower.
_HEAD_PITCH, _PITCH_SPREAD = np.radians(-31.0 + 6.4), np.radians(1.0)
_REACH = 4.0  # m: each picture of half a field shows a corner or post within this distance


@dataclass(frozen=True, eq=False)
class Scene:
    """A picture from a random place on the field, with its ground truth.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB picture.
    view : CameraView
        Assumed view of the camera. It differs from the true view, because the robot does not know its body tilt.
    truth : PictureTruth
        Ground truth of the picture, with the true pose and view.
    """

    pixels: npt.NDArray[np.uint8]
    view: CameraView
    truth: PictureTruth

    def __repr__(self) -> str:
        """Show the size and the pose."""
        width, height = self.view.size
        return f"Scene({width} x {height}, {self.truth.pose})"


def standard_scenes(
    which: SceneSet, size: tuple[int, int] = (320, 240), reality: Reality | None = None
) -> tuple[Scene, ...]:
    """Render one of the standard sets of pictures from random places on a field of 2012.

    The sets "tune" and "report" have 30 pictures of half a field, and each of them shows a corner or a post nearby. The
    sets "whole_tune" and "whole" have 60 pictures in all directions from anywhere on a whole field, with paper on the
    carpet and a full room behind it. Their corners may be far away, and many of the pictures show no corner.

    Parameters
    ----------
    which : "tune", "report", "whole_tune" or "whole"
        Name of the set. Use one set for tuning parameters and the other one for reporting results. They share no
        places and no rooms.
    size : (int, int)
        Width and height of the pictures, px. The places do not depend on it.
    reality : Reality, optional
        Appearance of the pictures; by default `Reality.lab`, and `Reality.messy` for the whole field. Its seed selects
        other rooms and places.

    Returns
    -------
    tuple of Scene
        Pictures, which are the same at every call.

    Raises
    ------
    ValueError
        If the name of the set is unknown.
    """
    number = _WHOLE_SCENES if which in ("whole_tune", "whole") else _SCENES
    return tuple(standard_scene(which, i, size, reality) for i in range(number))


def standard_scene(
    which: SceneSet, number: int, size: tuple[int, int] = (320, 240), reality: Reality | None = None
) -> Scene:
    """Render a single picture of a standard set; `number` counts from 0.

    >>> standard_scene("tune", 0, size=(64, 48)).pixels.shape
    (48, 64, 3)
    """
    if which not in get_args(SceneSet):
        raise ValueError(
            f'the set of scenes must be "tune", "report", "whole_tune" or "whole", got {which!r}'
        )
    second = which in ("report", "whole")
    if which in ("tune", "report"):
        reality, take, scenes, rooms, first_room = reality or Reality(), random_scene, _SCENES, _ROOMS, 0
    else:
        reality, take = reality or Reality.messy(), whole_field_scene
        scenes, rooms, first_room = _WHOLE_SCENES, _WHOLE_ROOMS, _FIRST_WHOLE_ROOM
    first_room += rooms * (2 * reality.seed + second)
    room = replace(reality, seed=first_room + number * rooms // scenes)
    return take(size, room, np.random.default_rng([first_room, number, 5]))


def random_scene(size: tuple[int, int], reality: Reality, rng: np.random.Generator) -> Scene:
    """Render a picture of (width, height) px from one random place on half a field of 2012 to another.

    A corner or a post is in it; `reality` is its appearance and its room.
    """
    field = Field(2012)
    while True:
        (x, y), towards = rng.uniform((0.0, -1.9), (2.9, 1.9), (2, 2))
        yaw = rng.uniform(-0.5, 0.5)
        pose = Pose(x, y, float(np.arctan2(*(towards - (x, y))[::-1])) - yaw)
        assumed, true = _views(yaw, size, rng)
        if _shows_something(field, pose, true):
            pixels, truth = render(field, pose, true, reality, rng)
            return Scene(pixels, assumed, truth)


def whole_field_scene(size: tuple[int, int], reality: Reality, rng: np.random.Generator) -> Scene:
    """Render a picture of (width, height) px from a random place on a whole field of 2012 in a random direction.

    `reality` is its appearance and its room.
    """
    x, y, heading, yaw = rng.uniform((-2.9, -1.9, -np.pi, -0.5), (2.9, 1.9, np.pi, 0.5))
    assumed, true = _views(yaw, size, rng)
    pixels, truth = render(Field(2012, half=False), Pose(x, y, heading), true, reality, rng)
    return Scene(pixels, assumed, truth)


def _views(yaw: float, size: tuple[int, int], rng: np.random.Generator) -> tuple[CameraView, CameraView]:
    """Return the assumed and the true view, with a random body tilt, if the head is turned by `yaw` (rad)."""
    tilt = TorsoTilt()
    pitch = rng.normal(_HEAD_PITCH, _PITCH_SPREAD)
    torso_pitch, torso_roll = rng.normal(0.0, (tilt.pitch, tilt.roll))
    assumed = NAO_V4.view("bottom", yaw, pitch, size)
    return assumed, NAO_V4.view("bottom", yaw, pitch, size, torso_pitch=torso_pitch, torso_roll=torso_roll)


def _shows_something(field: Field, pose: Pose, view: CameraView) -> bool:
    seen = visible_landmarks(field, pose, view)
    return any(mark.landmark.detected_as is not None and mark.distance < _REACH for mark in seen)
