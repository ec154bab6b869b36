"""Standard sets of pictures with truth, to tune a detector on and to report what it does: made, not stored."""

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
_ROOMS = 5  # of each set
_WHOLE_SCENES, _WHOLE_ROOMS, _FIRST_WHOLE_ROOM = 60, 10, 10**9
# The real pictures' head was told -31 degrees, but they look 6.4 degrees lower than that.
_HEAD_PITCH, _PITCH_SPREAD = np.radians(-31.0 + 6.4), np.radians(1.0)
_REACH = 4.0  # metres: a picture must show a corner or post no farther than this


@dataclass(frozen=True, eq=False)
class Scene:
    """A picture taken somewhere on the field.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    view : CameraView
        What the robot believes of its camera: it does not know how its body leaned.
    truth : PictureTruth
        What the picture really shows, and from where.
    """

    pixels: npt.NDArray[np.uint8]
    view: CameraView
    truth: PictureTruth

    def __repr__(self) -> str:
        """Name the scene, not its pixels."""
        width, height = self.view.size
        return f"Scene({width} x {height}, {self.truth.pose})"


def standard_scenes(
    which: SceneSet, size: tuple[int, int] = (320, 240), reality: Reality | None = None
) -> tuple[Scene, ...]:
    """Make one of the standard sets: pictures from random places on a field of 2012.

    "tune" and "report" are 30 pictures each of half a field, and each shows a corner or a post near by. "whole_tune"
    and "whole" are 60 each from anywhere on a whole field to anywhere, with paper on the carpet and a full room behind
    it: a corner is as far away as it may be, and many pictures show none.

    Parameters
    ----------
    which : "tune", "report", "whole_tune" or "whole"
        Tune parameters on the one, report results on the other: no two share a place or a room.
    size : (int, int)
        Width and height of the pictures; their places do not depend on it.
    reality : Reality, optional
        How real they look; by default like the laboratory's, those of the whole field as `Reality.messy`. Its seed
        chooses other rooms and places.

    Returns
    -------
    tuple of Scene
        The same at every call.

    Raises
    ------
    ValueError
        If there is no such set.
    """
    number = _WHOLE_SCENES if which in ("whole_tune", "whole") else _SCENES
    return tuple(standard_scene(which, i, size, reality) for i in range(number))


def standard_scene(
    which: SceneSet, number: int, size: tuple[int, int] = (320, 240), reality: Reality | None = None
) -> Scene:
    """Make one picture of a standard set, for who does not need all at once; `number` counts from 0.

    Examples
    --------
    >>> standard_scene("tune", 0, size=(64, 48)).pixels.shape
    (48, 64, 3)
    """
    if which not in get_args(SceneSet):
        raise ValueError(f'which set of scenes? "tune", "report", "whole_tune" or "whole", got {which!r}')
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
    """Take a picture of some place on half a field of 2012 from another; it shows a corner or a post.

    Parameters
    ----------
    size : (int, int)
        Width and height.
    reality : Reality
        How real it looks, and which room.
    rng : numpy.random.Generator
        Where from and where to.

    Returns
    -------
    Scene
        With its truth.
    """
    field = Field(2012)
    while True:
        (x, y), towards = rng.uniform((0.0, -1.9), (2.9, 1.9), (2, 2))
        yaw = rng.uniform(-0.5, 0.5)
        pose = Pose(x, y, float(np.arctan2(*(towards - (x, y))[::-1])) - yaw)
        believed, true = _views(yaw, size, rng)
        if _shows_something(field, pose, true):
            pixels, truth = render(field, pose, true, reality, rng)
            return Scene(pixels, believed, truth)


def whole_field_scene(size: tuple[int, int], reality: Reality, rng: np.random.Generator) -> Scene:
    """Take a picture from any place on a whole field of 2012 to any side, whatever it shows.

    Parameters
    ----------
    size : (int, int)
        Width and height.
    reality : Reality
        How real it looks, and which room.
    rng : numpy.random.Generator
        Where from and where to.

    Returns
    -------
    Scene
        With its truth.
    """
    x, y, heading, yaw = rng.uniform((-2.9, -1.9, -np.pi, -0.5), (2.9, 1.9, np.pi, 0.5))
    believed, true = _views(yaw, size, rng)
    pixels, truth = render(Field(2012, half=False), Pose(x, y, heading), true, reality, rng)
    return Scene(pixels, believed, truth)


def _views(yaw: float, size: tuple[int, int], rng: np.random.Generator) -> tuple[CameraView, CameraView]:
    """The view that a robot believes in with its head turned by `yaw` (rad), and the true one: its body leans."""
    lean = TorsoTilt()
    pitch = rng.normal(_HEAD_PITCH, _PITCH_SPREAD)
    torso_pitch, torso_roll = rng.normal(0.0, (lean.pitch, lean.roll))
    believed = NAO_V4.view("bottom", yaw, pitch, size)
    return believed, NAO_V4.view("bottom", yaw, pitch, size, torso_pitch=torso_pitch, torso_roll=torso_roll)


def _shows_something(field: Field, pose: Pose, view: CameraView) -> bool:
    seen = visible_landmarks(field, pose, view)
    return any(mark.landmark.kind != "cross" and mark.distance < _REACH for mark in seen)
