"""The simulated NAO, which walks, turns its head and takes pictures, with errors that the robot does not know."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from nao_course.codec import register
from nao_course.geometry import FloatArray, Pose, finite, rotation_2d, wrap_angle
from nao_course.sim.camera import NAO_V4, CameraView, NaoModel
from nao_course.sim.field import Field
from nao_course.sim.reality import Reality
from nao_course.sim.render import PictureTruth, VisibleLandmark, render, visible_landmarks
from nao_course.slam import LandmarkKind, Measurement, Motion

# Standard deviations, rad, of the head's rotation about (ahead, left, up) while a picture is read out in 1/30 s during
# a walk. They follow from an assumed sway of 0.3 to 0.5 rad/s, because there is no recording to measure it.
_SWAY = np.array([0.010, 0.015, 0.012])


def _not_negative(values: object) -> None:
    """Check that the standard deviations of a dataclass are finite and not negative."""
    for each in fields(values):  # type: ignore[arg-type]
        name = f"{type(values).__name__}: {each.name}"
        value = finite(name, getattr(values, each.name))
        if value < 0:
            raise ValueError(f"{name} must be 0 (none) or more, got {value}")
        object.__setattr__(values, each.name, value)


def _generator(rng: np.random.Generator | int | None) -> np.random.Generator:
    """Return a random generator unchanged, or make one from a seed."""
    if isinstance(rng, np.random.Generator):
        return rng
    if rng is not None and not isinstance(rng, int | np.integer):
        raise ValueError(f"rng must be a numpy.random.Generator or an integer seed, got {rng!r}")
    return np.random.default_rng(0 if rng is None else int(rng))


@register
@dataclass(frozen=True)
class OdometryNoise:
    """Noise of the odometry: errors along the motion, across it and in the turn, as in the homework's 1.2.

    The variances grow in proportion to the distance, so the sum of twenty steps of 0.1 m has the same distribution as a
    single walk of 2 m.

    Parameters
    ----------
    along, across : float
        Standard deviations of the position ahead and to the left after one metre, m.
    turn : float
        Standard deviation of the heading after one metre, rad.
    turn_per_turn : float
        Standard deviation of the heading after a turn of one radian, rad.
    """

    along: float = 0.06
    across: float = 0.04
    turn: float = 0.08
    turn_per_turn: float = 0.12

    def __post_init__(self) -> None:
        """Check the standard deviations."""
        _not_negative(self)

    def covariance(self, motion: Motion) -> FloatArray:
        """Return the covariance (3, 3) of the errors along, across and in turn, robot frame, m^2 and rad^2."""
        distance, turned = abs(motion.distance), abs(motion.turn)
        turn_variance = self.turn**2 * distance + self.turn_per_turn**2 * turned
        return np.diag([self.along**2 * distance, self.across**2 * distance, turn_variance])


@dataclass(frozen=True)
class TorsoTilt:
    """Standard deviations of the body tilt in a picture, which the robot does not know.

    In real pictures, the pitch varies by 0.5 to 1.2 degrees within a sequence.

    Parameters
    ----------
    pitch, roll : float
        Standard deviations, rad.
    """

    pitch: float = float(np.radians(1.0))
    roll: float = float(np.radians(0.6))

    def __post_init__(self) -> None:
        """Check the standard deviations."""
        _not_negative(self)


@register
@dataclass(frozen=True)
class SensorNoise:
    """Noise of the ideal detector `SimulatedNao.sense`.

    Parameters
    ----------
    bearing : float
        Standard deviation of the bearing, rad.
    range_fraction : float
        Standard deviation of the range as a fraction of the range.
    """

    bearing: float = float(np.radians(1.5))
    range_fraction: float = 0.05

    def __post_init__(self) -> None:
        """Check the standard deviations."""
        _not_negative(self)

    def covariance(self, measurement: Measurement) -> FloatArray:
        """Return the covariance (2, 2) of bearing and range of a measurement, rad^2 and m^2."""
        return np.diag([self.bearing**2, (self.range_fraction * measurement.range) ** 2])

    def disturbed(self, exact: FloatArray, draws: FloatArray) -> FloatArray:
        """Add errors to exact measurements (..., 2), computed from standard normal samples (..., 2)."""
        bearings = wrap_angle(exact[..., 0] + self.bearing * draws[..., 0])
        ranges = exact[..., 1] * np.maximum(1 + self.range_fraction * draws[..., 1], 0.1)
        return np.stack([bearings, ranges], axis=-1)

    def covariances(self, measurements: FloatArray) -> FloatArray:
        """Return the covariances (n, 2, 2) of measurements (n, 2), rad^2 and m^2."""
        found = np.zeros((len(measurements), 2, 2))
        found[:, 0, 0] = self.bearing**2
        found[:, 1, 1] = (self.range_fraction * measurements[:, 1]) ** 2
        return found


@register
@dataclass(frozen=True, eq=False)
class Picture:
    """A picture that was taken by `SimulatedNao.take_picture`.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB picture.
    view : CameraView
        Assumed view of the camera. It differs from the true view, because the robot does not know its body tilt.
    camera : str
        Name of the camera, "top" or "bottom".
    """

    pixels: npt.NDArray[np.uint8]
    view: CameraView
    camera: str

    def __post_init__(self) -> None:
        """Check the values."""
        if self.pixels.dtype != np.uint8 or self.pixels.ndim != 3 or not isinstance(self.view, CameraView):
            raise ValueError("Picture: pixels must be uint8 of shape (H, W, 3), view a CameraView")

    def __repr__(self) -> str:
        """Show the size and the camera."""
        width, height = self.view.size
        return f"Picture({width} x {height}, {self.camera} camera)"


@dataclass
class _World:
    """The true state of the simulation, which the robot does not know."""

    field: Field
    pose: Pose
    rng: np.random.Generator
    path: list[Pose]
    last: PictureTruth | None = None


class SimulatedNao:
    """A simulated NAO on a field.

    Parameters
    ----------
    field : Field, optional
        Field; by default half a field by the rules of 2012, as in the paper by Aliyev et al.
    pose : Pose, optional
        First pose in the world frame; by default on the halfway line, facing the goal.
    rng : numpy.random.Generator or int, optional
        Source of all random numbers, or its seed; by default the seed 0.
    model : NaoModel
        Generation of the robot.
    odometry_noise : OdometryNoise, optional
        Noise of its motions.
    tilt : TorsoTilt, optional
        Standard deviations of its body tilt in each picture.
    sensor_noise : SensorNoise, optional
        Noise of `sense`.
    reality : Reality, optional
        Appearance of its pictures.

    Raises
    ------
    ValueError
        If the start is off the carpet.

    Examples
    --------
    >>> nao = SimulatedNao()
    >>> nao.walk(0.5)
    Motion(distance=0.5, turn=0.0)
    >>> nao.take_picture()
    Picture(320 x 240, bottom camera)
    >>> nao.odometry
    Pose(x=0.50, y=0.00, theta=0.000)
    """

    def __init__(
        self,
        field: Field | None = None,
        pose: Pose | None = None,
        rng: np.random.Generator | int | None = None,
        *,
        model: NaoModel = NAO_V4,
        odometry_noise: OdometryNoise | None = None,
        tilt: TorsoTilt | None = None,
        sensor_noise: SensorNoise | None = None,
        reality: Reality | None = None,
    ) -> None:
        """Put the robot on the field."""
        self.field = field or Field()
        self.model = model
        self.odometry_noise = odometry_noise or OdometryNoise()
        self.tilt = tilt or TorsoTilt()
        self.sensor_noise = sensor_noise or SensorNoise()
        self.reality = reality or Reality()
        start = pose if pose is not None else self.field.pose @ Pose(0.0, 0.0, 0.0)
        if not isinstance(start, Pose):
            raise ValueError(f"pose must be a Pose(x, y, theta), got {start!r}")
        generator = _generator(rng)
        _check_on_carpet(self.field, start)
        self._world = _World(self.field, start, generator, [start])
        self._head = (0.0, float(np.radians(-31.0)))
        self._odometry = [Pose()]

    def __repr__(self) -> str:
        """Show the model, the odometry and the angles of the head."""
        return f"SimulatedNao({self.model.name}, odometry {self.odometry}, head {self.head})"

    # --- values that the robot knows ---

    @property
    def head(self) -> tuple[float, float]:
        """Angles (yaw, pitch) of the head's joints, rad; positive to the left and down."""
        return self._head

    @property
    def odometry(self) -> Pose:
        """Pose that follows from the commanded motions alone, from (0, 0, 0) at the start."""
        return self._odometry[-1]

    @property
    def odometry_path(self) -> tuple[Pose, ...]:
        """Odometry at the start and after each motion."""
        return tuple(self._odometry)

    def view(self, camera: str = "bottom", size: tuple[int, int] = (320, 240)) -> CameraView:
        """Return the assumed view of a camera with the present angles of the head."""
        return self.model.view(camera, *self._head, size=size)

    # --- commands ---

    def walk(self, distance: float) -> Motion:
        """Walk ahead, or backwards for a negative distance.

        Parameters
        ----------
        distance : float
            Distance, m; at most 10 in one command. The robot stops at the edge of the carpet.

        Returns
        -------
        Motion
            Commanded motion. The true motion differs from it.

        Raises
        ------
        ValueError
            If the distance is not finite or too long.
        """
        if abs(finite("distance (m)", distance)) > 10:
            raise ValueError(f"distance must be within -10..10 m in one command, got {distance}")
        return self.move(Motion(distance, 0.0))

    def turn(self, angle: float) -> Motion:
        """Turn on the spot, counterclockwise.

        Parameters
        ----------
        angle : float
            Angle, rad; at most one full turn.

        Returns
        -------
        Motion
            Commanded motion.

        Raises
        ------
        ValueError
            If the angle is not finite or more than a full turn, because it is probably given in degrees.
        """
        if abs(finite("angle (rad)", angle)) > 2 * np.pi + 1e-9:
            raise ValueError(
                f"angle must be within one turn, -6.283..6.283 rad, got {angle}. "
                f"If those are degrees: turn(np.radians({angle}))"
            )
        return self.move(Motion(0.0, angle))

    def look(self, yaw: float = 0.0, pitch: float = 0.0) -> None:
        """Turn the head.

        Parameters
        ----------
        yaw : float
            Angle, rad; positive to the left.
        pitch : float
            Angle, rad; positive down.

        Raises
        ------
        ValueError
            If an angle exceeds the limits of its joint.
        """
        self._head = self.model.check_head(yaw, pitch)

    def take_picture(
        self, camera: str = "bottom", size: tuple[int, int] = (320, 240), walking: bool = False
    ) -> Picture:
        """Take a picture.

        Parameters
        ----------
        camera : "top" or "bottom"
            Name of the camera.
        size : (int, int)
            Width and height, px.
        walking : bool
            Whether the robot is walking. The head then sways, so the picture is blurred, and it is distorted because
            its rows are read out one after the other.

        Returns
        -------
        Picture
            Pixels, and the assumed view of the camera.

        Raises
        ------
        ValueError
            If the camera is unknown or the size impossible.
        """
        assumed = self.view(camera, size)
        world = self._world
        sway = world.rng.normal(0.0, _SWAY) * self.reality.motion if walking else np.zeros(3)
        view = self._true_view(camera, size)
        pixels, world.last = render(self.field, world.pose, view, self.reality, world.rng, sway)
        return Picture(pixels, assumed, camera)

    def stop(self) -> None:
        """Do nothing: a simulated motion is complete when its command returns."""

    def sense(self, camera: str = "bottom", max_range: float = 4.0) -> tuple[Measurement, ...]:
        """Measure the visible corners and posts with noise; this ideal detector replaces the student's detectors.

        Parameters
        ----------
        camera : "top" or "bottom"
            Name of the camera.
        max_range : float
            Largest range of a measured landmark, m.

        Returns
        -------
        tuple of Measurement
            Measurements from right to left, without the identities of the landmarks.

        Raises
        ------
        ValueError
            If the camera is unknown or the range not positive.
        """
        if finite("max_range (m)", max_range) <= 0:
            raise ValueError(f"max_range must be positive (m), got {max_range}")
        seen = visible_landmarks(self.field, self._world.pose, self._true_view(camera, (320, 240)))
        near = [each for each in seen if not each.occluded and each.distance <= max_range]
        found = [self._measured(each, kind) for each in near if (kind := each.landmark.detected_as)]
        return tuple(sorted(found, key=lambda measurement: measurement.bearing))

    # --- simulation ---

    @contextmanager
    def aside(self, rng: np.random.Generator) -> Iterator[None]:
        """Draw the noise of pictures and measurements in the block from `rng`: they do not change later motions.

        The robot's own generator serves its pictures, its measurements and its motions, so an additional picture, which
        is only shown, would otherwise change where the robot drives next.
        """
        own, self._world.rng = self._world.rng, rng
        try:
            yield
        finally:
            self._world.rng = own

    def _true_view(self, camera: str, size: tuple[int, int]) -> CameraView:
        self.model.check_camera(camera)
        rng = self._world.rng
        pitch, roll = rng.normal(0.0, [self.tilt.pitch, self.tilt.roll])
        return self.model.view(camera, *self._head, size=size, torso_pitch=pitch, torso_roll=roll)

    def _measured(self, seen: VisibleLandmark, kind: LandmarkKind) -> Measurement:
        rng, noise = self._world.rng, self.sensor_noise
        distance = seen.distance * (1 + noise.range_fraction * rng.standard_normal())
        return Measurement(seen.bearing + noise.bearing * rng.standard_normal(), max(distance, 0.0), kind)

    def move(self, motion: Motion) -> Motion:
        """Move with random errors by the model of the homework's 1.2, and return the commanded motion."""
        world = self._world
        deviations = np.sqrt(np.diag(self.odometry_noise.covariance(motion)))
        along, across, turn = world.rng.standard_normal(3) * deviations
        step = np.array([motion.distance + along, across])
        old = world.pose
        reach = self._reach(old, step)
        x, y = old.as_array()[:2] + rotation_2d(old.theta) @ (reach * step)
        world.pose = Pose(float(x), float(y), old.theta + motion.turn + turn)
        world.path.append(world.pose)
        self._odometry.append(self.odometry @ motion.as_pose())
        return motion

    def _reach(self, old: Pose, step: FloatArray) -> float:
        """Return the fraction of a step that stays on the carpet, by bisection, because the carpet is convex."""
        if _is_on_carpet(self.field, old @ Pose(step[0], step[1], 0.0)):
            return 1.0
        low, high = 0.0, 1.0
        for _ in range(40):
            half = (low + high) / 2
            if _is_on_carpet(self.field, old @ Pose(half * step[0], half * step[1], 0.0)):
                low = half
            else:
                high = half
        return low


def _is_on_carpet(field: Field, pose: Pose) -> bool:
    x0, y0, x1, y1 = field.carpet
    x, y = field.pose.to_local([pose.x, pose.y])[0]
    return bool(x0 <= x <= x1 and y0 <= y <= y1)


def _check_on_carpet(field: Field, pose: Pose) -> None:
    if not _is_on_carpet(field, pose):
        raise ValueError(f"pose must be on the carpet, {field.carpet} (m), got {pose}")


class Truth:
    """The ground truth of a simulation, for plots and scores. A student's algorithm must not use it.

    Parameters
    ----------
    nao : SimulatedNao
        Robot whose truth is needed.

    Examples
    --------
    >>> nao = SimulatedNao(rng=1)
    >>> motion = nao.walk(1.0)
    >>> Truth(nao).pose != nao.odometry
    True
    """

    def __init__(self, nao: SimulatedNao) -> None:
        """Get the true state of a robot's simulation."""
        self._world = nao._world

    @property
    def field(self) -> Field:
        """Field on which the robot is."""
        return self._world.field

    @property
    def pose(self) -> Pose:
        """True pose of the robot in the world frame."""
        return self._world.pose

    @property
    def path(self) -> tuple[Pose, ...]:
        """True poses at the start and after each motion."""
        return tuple(self._world.path)

    @property
    def odometry_start(self) -> Pose:
        """Origin of the odometry in the world frame: compare ``truth.odometry_start @ nao.odometry`` with `pose`."""
        return self._world.path[0]

    @property
    def picture(self) -> PictureTruth | None:
        """Ground truth of the latest picture; None before the first picture."""
        return self._world.last

    def place(self, pose: Pose) -> None:
        """Put the robot at another pose on the carpet without changing its odometry: a kidnapping.

        Raises
        ------
        ValueError
            If the pose is off the carpet, from where no motion leads back.
        """
        _check_on_carpet(self._world.field, pose)
        self._world.pose = pose
        self._world.path.append(pose)
