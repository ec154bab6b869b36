"""The robot of lesson 00, whose head the student moves to see what its cameras see."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from nao_course.geometry import Pose
from nao_course.lessons.meet_the_nao.figures import say_footprint
from nao_course.sim import Field, Reality, SimulatedNao, TorsoTilt, Truth
from nao_course.widgets import Slider, WorldPanel, WorldView

START = Pose(0.7, -0.6, 0.25)


class HeadPanel(WorldPanel):
    """A NAO on the field with the view cones of its cameras, and a slider for each joint of its head.

    Parameters
    ----------
    field : Field, optional
        The field; by default half a field of 2012.
    """

    def __init__(self, field: Field | None = None) -> None:
        """Put the robot on the field, with a level head."""
        self._nao = SimulatedNao(
            field, START, rng=3, tilt=TorsoTilt(0.0, 0.0), reality=Reality(motion=0.0, seed=0)
        )
        (yaw_low, yaw_high), (pitch_low, pitch_high) = (
            np.degrees(limits).tolist()
            for limits in (self._nao.model.yaw_limits, self._nao.model.pitch_limits)
        )
        super().__init__(
            "The NAO and its cameras",
            WorldView(self._nao.field, reality=self._nao.reality),
            self._move_head,
            [
                Slider("yaw", "Yaw to the left", yaw_low, yaw_high, 0.5, 0.0, unit="°"),
                Slider("pitch", "Pitch down", pitch_low, pitch_high, 0.5, 0.0, unit="°"),
            ],
        )

    def _move_head(self, values: Any, student: Any) -> Iterator[str]:
        """Turn the head, take a picture with each camera, and say what part of the ground they see."""
        self._nao.look(float(np.radians(values.yaw)), float(np.radians(values.pitch)))
        pictures = {camera: self._nao.take_picture(camera) for camera in ("top", "bottom")}
        self.world.update(
            Truth(self._nao).pose,
            head=self._nao.head,
            pictures={camera: picture.pixels for camera, picture in pictures.items()},
        )
        for camera, picture in pictures.items():
            yield say_footprint(camera, picture.view)
