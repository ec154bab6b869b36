"""What goes into a SLAM algorithm, what comes out of it, and the loop that runs one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from nao_course.exercises.codec import register
from nao_course.geometry import FloatArray, Pose, as_points, finite, wrap_angle

__all__ = [
    "KINDS",
    "DeadReckoning",
    "Estimate",
    "LandmarkKind",
    "Measurement",
    "Motion",
    "SlamAlgorithm",
    "measured_points",
    "place_estimate",
    "range_and_bearing",
    "run_slam",
]

LandmarkKind = Literal["corner", "post"]
KINDS: tuple[LandmarkKind, ...] = ("corner", "post")


@register
@dataclass(frozen=True)
class Motion:
    """A command to the robot: drive along the present heading, then turn on the spot.

    Parameters
    ----------
    distance : float
        Metres ahead; negative backwards. The d of both seeds.
    turn : float
        Radians, counterclockwise. The homework's alpha.
    """

    distance: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is not a number."""
        object.__setattr__(self, "distance", finite("Motion: distance (m)", self.distance))
        object.__setattr__(self, "turn", finite("Motion: turn (rad)", self.turn))

    def as_pose(self) -> Pose:
        """Return the new pose in the frame of the old one."""
        return Pose(self.distance, 0.0, self.turn)


@register
@dataclass(frozen=True)
class Measurement:
    """One landmark as the robot sees it.

    Parameters
    ----------
    bearing : float
        Radians in the robot frame, positive to the left, kept in (-pi, pi].
    range : float
        Metres over the ground from the robot.
    kind : "corner" or "post"
        A field line's corner or a goal post's foot (the boolean of Aliyev et al. 2014, section 4.4).
    """

    bearing: float
    range: float
    kind: LandmarkKind = "corner"

    def __post_init__(self) -> None:
        """Refuse what cannot be a measurement."""
        bearing = finite("Measurement: bearing (rad)", self.bearing)
        object.__setattr__(self, "bearing", float(wrap_angle(bearing)))
        object.__setattr__(self, "range", finite("Measurement: range (m)", self.range))
        if self.range < 0:
            raise ValueError(f"Measurement: range must not be negative (m), got {self.range}")
        if self.kind not in KINDS:
            raise ValueError(f"Measurement: kind must be one of {KINDS}, got {self.kind!r}")


@register
@dataclass(frozen=True, eq=False)
class Estimate:
    """What a SLAM algorithm believes; two are equal where all their values are.

    Parameters
    ----------
    pose : Pose
        The robot, in the frame the algorithm maps in.
    covariance : ndarray, shape (3, 3)
        Of (x, y, theta), in m^2, m rad and rad^2.
    landmarks : ndarray, shape (N, 2)
        Their positions in metres.
    landmark_covariances : ndarray, shape (N, 2, 2)
        In m^2.
    kinds : tuple of str
        N kinds, "corner" or "post".

    Raises
    ------
    ValueError
        If the shapes do not fit each other, or it is no pose.
    """

    pose: Pose
    covariance: FloatArray
    landmarks: FloatArray
    landmark_covariances: FloatArray
    kinds: tuple[LandmarkKind, ...] = ()

    def __post_init__(self) -> None:
        """Check the shapes."""
        if not isinstance(self.pose, Pose):
            raise ValueError(f"Estimate: pose must be a Pose, got {type(self.pose).__name__}")
        n = len(self.landmarks)
        wanted = {"covariance": (3, 3), "landmarks": (n, 2), "landmark_covariances": (n, 2, 2)}
        for name, shape in wanted.items():
            array = np.array(getattr(self, name), dtype=float)
            if array.size == 0:
                array = array.reshape(shape)
            if array.shape != shape:
                raise ValueError(f"Estimate: {name} must have shape {shape}, got {array.shape}")
            object.__setattr__(self, name, array)
        if len(self.kinds) != n:
            raise ValueError(f"Estimate: {n} landmarks need {n} kinds, got {len(self.kinds)}")
        object.__setattr__(self, "kinds", tuple(self.kinds))

    def __eq__(self, other: object) -> bool:
        """Whether all values are equal."""
        if not isinstance(other, Estimate):
            return NotImplemented
        arrays = ("covariance", "landmarks", "landmark_covariances")
        same = (self.pose, self.kinds) == (other.pose, other.kinds)
        return same and all(np.array_equal(getattr(self, name), getattr(other, name)) for name in arrays)

    __hash__ = None  # type: ignore[assignment]  # its arrays can be changed


def measured_points(measurements: Iterable[Measurement], pose: Pose) -> FloatArray:
    """Where measurements put their landmarks.

    Parameters
    ----------
    measurements : iterable of Measurement
        N of them.
    pose : Pose
        From where they were taken.

    Returns
    -------
    ndarray, shape (N, 2)
        Metres, in the frame in which `pose` is given.
    """
    polar = as_points([(each.bearing, each.range) for each in measurements])
    return pose.to_parent(polar[:, 1:] * np.column_stack([np.cos(polar[:, 0]), np.sin(polar[:, 0])]))


def range_and_bearing(poses: npt.ArrayLike, landmarks: npt.ArrayLike) -> FloatArray:
    """How landmarks are seen from poses.

    Parameters
    ----------
    poses : array_like, shape (..., 3)
        x, y (m) and heading (rad).
    landmarks : array_like, shape (..., 2)
        Metres, in the frame in which `poses` are given.

    Returns
    -------
    ndarray, shape (..., 2)
        (bearing, range): rad in (-pi, pi], and m.
    """
    at, there = np.asarray(poses, dtype=float), np.asarray(landmarks, dtype=float)
    away = (there[..., 0] - at[..., 0]) + 1j * (there[..., 1] - at[..., 1])
    return np.stack([wrap_angle(np.angle(away) - at[..., 2]), np.abs(away)], axis=-1)


def place_estimate(estimate: Estimate, frame: Pose | None) -> Estimate:
    """Turn and shift an estimate into another frame, its covariances too.

    Parameters
    ----------
    estimate : Estimate
        In the frame its algorithm maps in.
    frame : Pose or None
        That frame's pose in the new one; None leaves the estimate as it is.

    Returns
    -------
    Estimate
        In the frame in which `frame` is given.

    Raises
    ------
    ValueError
        If it is no Estimate.
    """
    if not isinstance(estimate, Estimate):
        raise ValueError(f"estimate must be an Estimate, got {type(estimate).__name__}")
    if frame is None:
        return estimate
    c, s = np.cos(frame.theta), np.sin(frame.theta)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    with np.errstate(invalid="ignore", over="ignore"):  # what is no number stays none
        return Estimate(
            frame @ estimate.pose,
            turn @ estimate.covariance @ turn.T,
            frame.to_parent(estimate.landmarks),
            turn[:2, :2] @ estimate.landmark_covariances @ turn[:2, :2].T,
            estimate.kinds,
        )


class SlamAlgorithm(ABC):
    """The abstract class of Aliyev et al. 2014, section 3.3: motions and measurements in, an estimate out."""

    @abstractmethod
    def move(self, motion: Motion) -> None:
        """Take in that the robot was told to move by `motion`."""

    @abstractmethod
    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Take in what the robot sees from where it is now; an empty sequence is allowed."""

    @abstractmethod
    def estimate(self) -> Estimate:
        """Return what is believed now."""


class DeadReckoning(SlamAlgorithm):
    """Believe every command and ignore every landmark: the estimate that SLAM has to beat.

    Parameters
    ----------
    start : Pose
        Where the robot begins; zeros in both seeds.
    """

    def __init__(self, start: Pose | None = None) -> None:
        """Begin at `start`."""
        self._pose = start or Pose()

    def move(self, motion: Motion) -> None:
        """Add the commanded motion to the pose."""
        self._pose = self._pose @ motion.as_pose()

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Ignore what is seen."""

    def estimate(self) -> Estimate:
        """Return the pose that the commands add up to, with no uncertainty stated."""
        return Estimate(self._pose, np.zeros((3, 3)), np.empty((0, 2)), np.empty((0, 2, 2)))


def run_slam(
    algorithm: SlamAlgorithm, log: Iterable[tuple[Motion | None, Sequence[Measurement]]]
) -> list[Estimate]:
    """Run an algorithm over a log.

    Parameters
    ----------
    algorithm : SlamAlgorithm
        It is changed: it has seen the log afterwards.
    log : iterable of (Motion or None, sequence of Measurement)
        In each step the motion comes first (None: the robot stood still), then what was seen.

    Returns
    -------
    list of Estimate
        One for each step.
    """
    estimates = []
    for motion, measurements in log:
        if motion is not None:
            algorithm.move(motion)
        algorithm.observe(measurements)
        estimates.append(algorithm.estimate())
    return estimates


def __dir__() -> list[str]:
    """What tab completion shows: not what this module imports."""
    return __all__
