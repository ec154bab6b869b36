"""What panels, lessons and the demo need of a robot, and what robots on a real field have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from types import MappingProxyType
from typing import Protocol, runtime_checkable

import numpy as np

from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, NAO_V6, CameraView, Field, NaoModel, OdometryNoise, Picture
from nao_course.slam import Motion

# V5 has the cameras and lengths of V4 by the maker's documentation.
MODELS = MappingProxyType({"V4": NAO_V4, "V5": replace(NAO_V4, name="NAO V5"), "V6": NAO_V6})


class RobotError(RuntimeError):
    """A robot that does not do what it was asked to; the message says what to do."""


@runtime_checkable
class Robot(Protocol):
    """A robot that walks, turns its head and takes pictures: a `SimulatedNao`, a `RealNao` or a `RecordedNao`.

    `field` is the field it is on, as far as its user knows, `model` its generation, and `odometry_noise` how inaccurate
    its motions are assumed to be. Its frames and units are the same as `SimulatedNao`'s: metres, radians, x ahead, y to
    the left, z up.
    """

    field: Field
    model: NaoModel
    odometry_noise: OdometryNoise

    @property
    def head(self) -> tuple[float, float]:
        """Angles (yaw, pitch) of the head's joints, rad; positive to the left and down."""

    @property
    def odometry(self) -> Pose:
        """Pose by the robot's own account of its motions, from (0, 0, 0) at the start."""

    @property
    def odometry_path(self) -> tuple[Pose, ...]:
        """Odometry at the start and after each motion."""

    def view(self, camera: str = "bottom", size: tuple[int, int] = (320, 240)) -> CameraView:
        """Return the view of a camera with the present angles of the head, as far as the robot knows it."""

    def walk(self, distance: float) -> Motion:
        """Walk ahead by a distance in m, or backwards if it is negative, and return the commanded motion."""

    def turn(self, angle: float) -> Motion:
        """Turn on the spot by an angle in rad, counterclockwise, and return the commanded motion."""

    def move(self, motion: Motion) -> Motion:
        """Run a motion, and return it."""

    def look(self, yaw: float = 0.0, pitch: float = 0.0) -> None:
        """Turn the head to joint angles in rad, positive to the left and down."""

    def take_picture(
        self, camera: str = "bottom", size: tuple[int, int] = (320, 240), walking: bool = False
    ) -> Picture:
        """Take a picture."""

    def stop(self) -> None:
        """Stop at once; a motion that another thread has begun ends."""

    def aside(self, rng: np.random.Generator) -> AbstractContextManager[None]:
        """Take pictures in the block without an effect on later motions; a simulation's noise comes from `rng`."""


class PlacedNao(Robot):
    """A robot that a person has put on a real field: its true pose is not known.

    Parameters
    ----------
    field : Field, optional
        The field; by default half a field by the rules of 2012.
    model : NaoModel
        Generation of the robot.
    start : Pose, optional
        Where it was put, in the world frame; by default on the halfway line, facing the goal.
    """

    def __init__(self, field: Field | None, model: NaoModel, start: Pose | None) -> None:
        """Begin with the odometry at zeros."""
        self.field, self.model = field or Field(), model
        self.start = self.field.pose if start is None else start
        self.odometry_noise = OdometryNoise()
        self._odometry = [Pose()]

    @property
    @abstractmethod
    def head(self) -> tuple[float, float]:
        """Angles (yaw, pitch) of the head's joints, rad; positive to the left and down."""

    @property
    def odometry(self) -> Pose:
        """Pose by the robot's own odometry after the last motion, from (0, 0, 0) at the start."""
        return self._odometry[-1]

    @property
    def odometry_path(self) -> tuple[Pose, ...]:
        """Odometry at the start and after each motion."""
        return tuple(self._odometry)

    def upright_view(self, camera: str = "bottom", size: tuple[int, int] = (320, 240)) -> CameraView:
        """Return a camera's view for an upright body, as the simulated robot assumes it."""
        low, high = np.array([self.model.yaw_limits, self.model.pitch_limits]).T
        yaw, pitch = np.clip(self.head, low, high)
        return self.model.view(camera, float(yaw), float(pitch), size=size)

    def walk(self, distance: float) -> Motion:
        """Walk ahead by a distance in m, or backwards if it is negative; see `move`."""
        return self.move(Motion(distance))

    def turn(self, angle: float) -> Motion:
        """Turn on the spot by an angle in rad, counterclockwise; see `move`."""
        return self.move(Motion(0.0, angle))

    @contextmanager
    def aside(self, rng: np.random.Generator) -> Iterator[None]:
        """Do nothing: pictures of a real robot have no effect on its motions."""
        yield

    def warnings(self) -> tuple[str, ...]:
        """Return what should be known before the next drive."""
        return ()
