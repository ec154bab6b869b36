"""What panels, lessons and the demo need of a robot."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from nao_course.geometry import Pose
from nao_course.sim import CameraView, Field, NaoModel, Picture
from nao_course.slam import Motion


class RobotError(RuntimeError):
    """A robot that does not do what it was asked to; the message says what to do."""


@runtime_checkable
class Robot(Protocol):
    """A robot that walks, turns its head and takes pictures: a `SimulatedNao`, a `RealNao` or a `RecordedNao`.

    `field` is the field it is on, as far as its user knows, and `model` its generation. Its frames and units are the
    same as `SimulatedNao`'s: metres, radians, x ahead, y to the left, z up.
    """

    field: Field
    model: NaoModel

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
