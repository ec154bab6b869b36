"""Two standard sets of pictures with truth, to tune a detector on and to report what it does: made, not stored."""

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

SceneSet = Literal["tune", "report"]

_SCENES = 30  # as many as the seed paper's "random locations on the soccer field"
_ROOMS = 5  # of each set
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
    """Make one of the two standard sets: 30 pictures from random places on half a field of 2012.

    Parameters
    ----------
    which : "tune" or "report"
        Tune parameters on the one, report results on the other: they share neither a place nor a room.
    size : (int, int)
        Width and height of the pictures; their places do not depend on it.
    reality : Reality, optional
        How real they look; by default like the laboratory's. Its seed chooses other rooms and places.

    Returns
    -------
    tuple of Scene
        The same at every call.

    Raises
    ------
    ValueError
        If there is no such set.

    Examples
    --------
    >>> standard_scenes("tune", size=(64, 48))[0].pixels.shape
    (48, 64, 3)
    """
    if which not in get_args(SceneSet):
        raise ValueError(f'which set of scenes? "tune" or "report", got {which!r}')
    first_room = 2 * _ROOMS * (reality or Reality()).seed + _ROOMS * get_args(SceneSet).index(which)
    scenes = []
    for i in range(_SCENES):
        room = replace(reality or Reality(), seed=first_room + i * _ROOMS // _SCENES)
        scenes.append(random_scene(size, room, np.random.default_rng([first_room, i, 5])))
    return tuple(scenes)


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
    field, lean = Field(2012), TorsoTilt()
    while True:
        (x, y), towards = rng.uniform((0.0, -1.9), (2.9, 1.9), (2, 2))
        yaw = rng.uniform(-0.5, 0.5)
        pose = Pose(x, y, float(np.arctan2(*(towards - (x, y))[::-1])) - yaw)
        pitch = rng.normal(_HEAD_PITCH, _PITCH_SPREAD)
        torso_pitch, torso_roll = rng.normal(0.0, (lean.pitch, lean.roll))
        believed = NAO_V4.view("bottom", yaw, pitch, size)
        true = NAO_V4.view("bottom", yaw, pitch, size, torso_pitch=torso_pitch, torso_roll=torso_roll)
        if _shows_something(field, pose, true):
            pixels, truth = render(field, pose, true, reality, rng)
            return Scene(pixels, believed, truth)


def _shows_something(field: Field, pose: Pose, view: CameraView) -> bool:
    seen = visible_landmarks(field, pose, view)
    return any(mark.landmark.kind != "cross" and mark.distance < _REACH for mark in seen)
