"""The simulated NAO: it walks, looks, takes pictures, and does not know exactly where it is."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from nao_course.exercises.codec import register
from nao_course.geometry import FloatArray, Pose, finite, rotation_2d
from nao_course.sim.camera import NAO_V4, CameraView, NaoModel
from nao_course.sim.field import Field
from nao_course.sim.reality import Reality
from nao_course.sim.render import PictureTruth, VisibleLandmark, render, visible_landmarks
from nao_course.slam import LandmarkKind, Measurement, Motion

# How a walking NAO's head turns about (ahead, left, up) while a picture is read, 1/30 s: standard deviations in rad,
# from some 0.3 to 0.5 rad/s of sway. An assumption: no recorded walk tells.
_SWAY = np.array([0.010, 0.015, 0.012])


def _not_negative(values: object) -> None:
    """Refuse a dataclass of standard deviations with one that is none."""
    for each in fields(values):  # type: ignore[arg-type]
        name = f"{type(values).__name__}: {each.name}"
        value = finite(name, getattr(values, each.name))
        if value < 0:
            raise ValueError(f"{name} must be 0 (none) or more, got {value}")
        object.__setattr__(values, each.name, value)


def _generator(rng: np.random.Generator | int | None) -> np.random.Generator:
    """A generator as it is, or one made from a seed."""
    if isinstance(rng, np.random.Generator):
        return rng
    if rng is not None and not isinstance(rng, int | np.integer):
        raise ValueError(f"rng must be a numpy.random.Generator or a whole number (its seed), got {rng!r}")
    return np.random.default_rng(0 if rng is None else int(rng))


@register
@dataclass(frozen=True)
class OdometryNoise:
    """How a walk differs from its command: errors along, across and about the robot, as in the homework's 1.2.

    Variances grow with the way, so that twenty steps of 0.1 m scatter like one walk of 2 m.

    Parameters
    ----------
    along, across : float
        Standard deviation of the position after one metre, in m; ahead and to the left of the robot.
    turn : float
        Standard deviation of the heading after one metre, in rad.
    turn_per_turn : float
        Standard deviation of the heading after a turn of one radian, in rad.
    """

    along: float = 0.06
    across: float = 0.04
    turn: float = 0.08
    turn_per_turn: float = 0.12

    def __post_init__(self) -> None:
        """Refuse negative deviations."""
        _not_negative(self)

    def covariance(self, motion: Motion) -> FloatArray:
        """Covariance (3, 3) of (along, across, turn) for a motion, in the robot frame; m^2 and rad^2."""
        way, turned = abs(motion.distance), abs(motion.turn)
        turn_variance = self.turn**2 * way + self.turn_per_turn**2 * turned
        return np.diag([self.along**2 * way, self.across**2 * way, turn_variance])


@dataclass(frozen=True)
class TorsoTilt:
    """How the body leans when a picture is taken, which the robot does not know: standard deviations in rad.

    On real pictures the pitch varies by 0.5 to 1.2 degrees within a sequence.
    """

    pitch: float = float(np.radians(1.0))
    roll: float = float(np.radians(0.6))

    def __post_init__(self) -> None:
        """Refuse negative deviations."""
        _not_negative(self)


@register
@dataclass(frozen=True)
class SensorNoise:
    """Noise of the ideal detector `SimulatedNao.sense`.

    Parameters
    ----------
    bearing : float
        Standard deviation in rad.
    range_fraction : float
        Standard deviation of the range as a fraction of it.
    """

    bearing: float = float(np.radians(1.5))
    range_fraction: float = 0.05

    def __post_init__(self) -> None:
        """Refuse negative deviations."""
        _not_negative(self)

    def covariance(self, measurement: Measurement) -> FloatArray:
        """Covariance (2, 2) of (bearing, range) of a measurement, in rad^2 and m^2."""
        return np.diag([self.bearing**2, (self.range_fraction * measurement.range) ** 2])


@register
@dataclass(frozen=True, eq=False)
class Picture:
    """What `SimulatedNao.take_picture` gives.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    view : CameraView
        What the robot believes of the camera: it does not know how its body leaned.
    camera : str
        "top" or "bottom".
    """

    pixels: npt.NDArray[np.uint8]
    view: CameraView
    camera: str

    def __post_init__(self) -> None:
        """Refuse what is no picture."""
        if self.pixels.dtype != np.uint8 or self.pixels.ndim != 3 or not isinstance(self.view, CameraView):
            raise ValueError("Picture: pixels must be uint8 of shape (H, W, 3), view a CameraView")

    def __repr__(self) -> str:
        """Name the picture, not its pixels."""
        width, height = self.view.size
        return f"Picture({width} x {height}, {self.camera} camera)"


@dataclass
class _World:
    """What only the simulator knows."""

    field: Field
    pose: Pose
    rng: np.random.Generator
    path: list[Pose]
    last: PictureTruth | None = None


class SimulatedNao:
    """A NAO on a field.

    Parameters
    ----------
    field : Field, optional
        By default the seed paper's: half a field by the rules of 2012.
    pose : Pose, optional
        Where it starts, in the world; by default on the halfway line, looking at the goal.
    rng : numpy.random.Generator or int, optional
        Source of all that is random, or its seed; by default seed 0.
    model : NaoModel
        Generation of the robot.
    odometry_noise, tilt, sensor_noise
        How it errs.
    reality : Reality, optional
        How real its pictures look.

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
        if not self._on_carpet(start):
            raise ValueError(f"pose must be on the carpet, {self.field.carpet} (m), got {start}")
        self._world = _World(self.field, start, generator, [start])
        self._head = (0.0, float(np.radians(-31.0)))
        self._odometry = [Pose()]

    def __repr__(self) -> str:
        """Say what the robot believes."""
        return f"SimulatedNao({self.model.name}, odometry {self.odometry}, head {self.head})"

    # --- what the robot knows of itself ---

    @property
    def head(self) -> tuple[float, float]:
        """The head's joints (yaw, pitch) in rad; positive yaw looks left, positive pitch down."""
        return self._head

    @property
    def odometry(self) -> Pose:
        """The commands added up, from (0, 0, 0) at the start: the robot's belief without any landmark."""
        return self._odometry[-1]

    @property
    def odometry_path(self) -> tuple[Pose, ...]:
        """The odometry at the start and after each command."""
        return tuple(self._odometry)

    def view(self, camera: str = "bottom", size: tuple[int, int] = (320, 240)) -> CameraView:
        """Return what the robot believes of a camera now."""
        return self.model.view(camera, *self._head, size=size)

    # --- commands ---

    def walk(self, distance: float) -> Motion:
        """Walk ahead (negative: backwards).

        Parameters
        ----------
        distance : float
            Metres, at most 10 in one command. The robot stops at the carpet's edge.

        Returns
        -------
        Motion
            What it was told to do; what it did, only the world knows.

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
            Radians, within one full turn.

        Returns
        -------
        Motion
            What it was told to do.

        Raises
        ------
        ValueError
            If the angle is not finite or more than a full turn: degrees, probably.
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
            Radians, positive to the left.
        pitch : float
            Radians, positive down.

        Raises
        ------
        ValueError
            If an angle is beyond its joint.
        """
        self._head = self.model.check_head(yaw, pitch)

    def take_picture(
        self, camera: str = "bottom", size: tuple[int, int] = (320, 240), walking: bool = False
    ) -> Picture:
        """Take a picture.

        Parameters
        ----------
        camera : "top" or "bottom"
            Which camera.
        size : (int, int)
            Width and height in pixels.
        walking : bool
            Whether the robot walks meanwhile: the head sways, the picture smears, and its rows, read one after
            the other, do not fit together.

        Returns
        -------
        Picture
            The pixels, and the view the robot believes.

        Raises
        ------
        ValueError
            For an unknown camera or an impossible size.
        """
        believed = self.view(camera, size)
        world = self._world
        sway = world.rng.normal(0.0, _SWAY) * self.reality.motion if walking else np.zeros(3)
        view = self._true_view(camera, size)
        pixels, world.last = render(self.field, world.pose, view, self.reality, world.rng, sway)
        return Picture(pixels, believed, camera)

    def sense(self, camera: str = "bottom", max_range: float = 4.0) -> tuple[Measurement, ...]:
        """Measure the corners and posts a camera sees, with noise: an ideal detector, in place of a student's.

        Parameters
        ----------
        camera : "top" or "bottom"
            Which camera.
        max_range : float
            Farther landmarks are left out, metres.

        Returns
        -------
        tuple of Measurement
            From right to left; nothing says which landmark one belongs to.

        Raises
        ------
        ValueError
            For an unknown camera or a range that is not positive.
        """
        if finite("max_range (m)", max_range) <= 0:
            raise ValueError(f"max_range must be positive (m), got {max_range}")
        seen = visible_landmarks(self.field, self._world.pose, self._true_view(camera, (320, 240)))
        near = [each for each in seen if not each.occluded and each.distance <= max_range]
        found = [self._measured(each) for each in near if each.landmark.kind != "cross"]
        return tuple(sorted(found, key=lambda measurement: measurement.bearing))

    # --- the world's part ---

    def _true_view(self, camera: str, size: tuple[int, int]) -> CameraView:
        self.model.check_camera(camera)
        rng = self._world.rng
        pitch, roll = rng.normal(0.0, [self.tilt.pitch, self.tilt.roll])
        return self.model.view(camera, *self._head, size=size, torso_pitch=pitch, torso_roll=roll)

    def _measured(self, seen: VisibleLandmark) -> Measurement:
        rng, noise = self._world.rng, self.sensor_noise
        away = seen.distance * (1 + noise.range_fraction * rng.standard_normal())
        kind: LandmarkKind = "post" if seen.landmark.kind == "post" else "corner"
        return Measurement(seen.bearing + noise.bearing * rng.standard_normal(), max(away, 0.0), kind)

    def move(self, motion: Motion) -> Motion:
        """Move as the homework's 1.2 says: along and across the old heading with errors, then turn with an error."""
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
        """Fraction of a step that stays on the carpet: bisection, the carpet being convex."""
        if self._on_carpet(old @ Pose(step[0], step[1], 0.0)):
            return 1.0
        low, high = 0.0, 1.0
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (
                (middle, high)
                if self._on_carpet(old @ Pose(middle * step[0], middle * step[1], 0.0))
                else (low, middle)
            )
        return low

    def _on_carpet(self, pose: Pose) -> bool:
        x0, y0, x1, y1 = self.field.carpet
        x, y = self.field.pose.to_local([pose.x, pose.y])[0]
        return bool(x0 <= x <= x1 and y0 <= y <= y1)


class Truth:
    """What the simulator knows and the robot does not: for plots and scores, never for a student's algorithm.

    Parameters
    ----------
    nao : SimulatedNao
        Whose truth.

    Examples
    --------
    >>> nao = SimulatedNao(rng=1)
    >>> motion = nao.walk(1.0)
    >>> Truth(nao).pose != nao.odometry
    True
    """

    def __init__(self, nao: SimulatedNao) -> None:
        """Look behind the scenes."""
        self._world = nao._world

    @property
    def field(self) -> Field:
        """The field the robot is on."""
        return self._world.field

    @property
    def pose(self) -> Pose:
        """Where the robot is, in the world."""
        return self._world.pose

    @property
    def path(self) -> tuple[Pose, ...]:
        """Where it was: its start, and its pose after each command."""
        return tuple(self._world.path)

    @property
    def odometry_start(self) -> Pose:
        """The odometry's origin in the world: ``truth.odometry_start @ nao.odometry`` compares with `pose`."""
        return self._world.path[0]

    @property
    def picture(self) -> PictureTruth | None:
        """What the latest picture really shows; None before the first."""
        return self._world.last

    def place(self, pose: Pose) -> None:
        """Carry the robot to another pose; its odometry does not notice."""
        self._world.pose = pose
        self._world.path.append(pose)


def repeat_drive(
    commands: list[Motion], robots: int, rng: np.random.Generator, noise: OdometryNoise | None = None
) -> FloatArray:
    """Send many robots the same commands, without pictures.

    Parameters
    ----------
    commands : list of Motion
        M commands.
    robots : int
        How many robots, N.
    rng : numpy.random.Generator
        Their errors.
    noise : OdometryNoise, optional
        Its size.

    Returns
    -------
    ndarray, shape (N, M + 1, 3)
        Each robot's (x, y, theta) at the start and after each command, from (0, 0, 0).
    """
    noise = noise or OdometryNoise()
    paths = np.zeros((robots, len(commands) + 1, 3))
    for step, motion in enumerate(commands):
        errors = rng.standard_normal((robots, 3)) * np.sqrt(np.diag(noise.covariance(motion)))
        old = paths[:, step]
        along, across = motion.distance + errors[:, 0], errors[:, 1]
        c, s = np.cos(old[:, 2]), np.sin(old[:, 2])
        turned = old[:, 2] + motion.turn + errors[:, 2]
        paths[:, step + 1] = np.column_stack(
            [old[:, 0] + c * along - s * across, old[:, 1] + s * along + c * across, turned]
        )
    return paths
