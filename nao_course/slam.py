"""The interface of SLAM algorithms: motions and measurements, estimates, and a loop that runs an algorithm."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from nao_course._internal.lazy_names import list_public
from nao_course.codec import register
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
__dir__ = list_public(__name__)

LandmarkKind = Literal["corner", "post"]
KINDS: tuple[LandmarkKind, ...] = ("corner", "post")


@register
@dataclass(frozen=True)
class Motion:
    """A commanded motion: drive along the present heading, then turn on the spot.

    Parameters
    ----------
    distance : float
        Distance ahead, m; negative for backwards.
    turn : float
        Turn, rad counterclockwise.
    """

    distance: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        """Check that the values are finite numbers."""
        object.__setattr__(self, "distance", finite("Motion: distance (m)", self.distance))
        object.__setattr__(self, "turn", finite("Motion: turn (rad)", self.turn))

    def as_pose(self) -> Pose:
        """Return the new pose in the frame of the old one."""
        return Pose(self.distance, 0.0, self.turn)


@register
@dataclass(frozen=True)
class Measurement:
    """The measurement of one landmark.

    Parameters
    ----------
    bearing : float
        Direction in the robot frame, rad, positive to the left; wrapped into (-pi, pi].
    range : float
        Distance from the robot on the ground, m.
    kind : "corner" or "post"
        Corner of two field lines, or foot of a goal post (the boolean of Aliyev et al. 2014, section 4.4).
    """

    bearing: float
    range: float
    kind: LandmarkKind = "corner"

    def __post_init__(self) -> None:
        """Check the values."""
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
    """The estimate of a SLAM algorithm. Two estimates are equal if all their values are.

    Parameters
    ----------
    pose : Pose
        Estimated pose of the robot in the map frame.
    covariance : ndarray, shape (3, 3)
        Covariance of (x, y, theta), m^2, m rad and rad^2.
    landmarks : ndarray, shape (N, 2)
        Estimated positions of the landmarks in the map frame, m.
    landmark_covariances : ndarray, shape (N, 2, 2)
        Covariance of each position, m^2.
    kinds : tuple of str
        Kind of each landmark, "corner" or "post".

    Raises
    ------
    ValueError
        If the shapes do not fit each other, or if `pose` is not a Pose.
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
        """Return whether all values are equal."""
        if not isinstance(other, Estimate):
            return NotImplemented
        arrays = ("covariance", "landmarks", "landmark_covariances")
        same = (self.pose, self.kinds) == (other.pose, other.kinds)
        return same and all(np.array_equal(getattr(self, name), getattr(other, name)) for name in arrays)

    __hash__ = None  # type: ignore[assignment]  # its arrays can be changed


def measured_points(measurements: Iterable[Measurement], pose: Pose) -> FloatArray:
    """Return the positions of measured landmarks.

    Parameters
    ----------
    measurements : iterable of Measurement
        Measurements of N landmarks.
    pose : Pose
        Pose of the robot when it measured them.

    Returns
    -------
    ndarray, shape (N, 2)
        Positions in the frame in which `pose` is given, m.
    """
    polar = as_points([(each.bearing, each.range) for each in measurements])
    return pose.to_parent(polar[:, 1:] * np.column_stack([np.cos(polar[:, 0]), np.sin(polar[:, 0])]))


def range_and_bearing(poses: npt.ArrayLike, landmarks: npt.ArrayLike) -> FloatArray:
    """Return the true bearings and ranges of landmarks from poses.

    Parameters
    ----------
    poses : array_like, shape (..., 3)
        Positions x, y, m, and headings, rad.
    landmarks : array_like, shape (..., 2)
        Positions in the frame in which `poses` are given, m.

    Returns
    -------
    ndarray, shape (..., 2)
        Bearings, rad in (-pi, pi], and ranges, m.
    """
    pose, landmark = np.asarray(poses, dtype=float), np.asarray(landmarks, dtype=float)
    offset = (landmark[..., 0] - pose[..., 0]) + 1j * (landmark[..., 1] - pose[..., 1])
    return np.stack([wrap_angle(np.angle(offset) - pose[..., 2]), np.abs(offset)], axis=-1)


def place_estimate(estimate: Estimate, frame: Pose | None) -> Estimate:
    """Transform an estimate and its covariances from the map frame to another frame.

    Parameters
    ----------
    estimate : Estimate
        Estimate in the map frame.
    frame : Pose or None
        Pose of the map frame in the new frame; None leaves the estimate unchanged.

    Returns
    -------
    Estimate
        Estimate in the new frame.

    Raises
    ------
    ValueError
        If `estimate` is not an Estimate.
    """
    if not isinstance(estimate, Estimate):
        raise ValueError(f"estimate must be an Estimate, got {type(estimate).__name__}")
    if frame is None:
        return estimate
    c, s = np.cos(frame.theta), np.sin(frame.theta)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    with np.errstate(invalid="ignore", over="ignore"):  # NaN and infinity stay as they are
        return Estimate(
            frame @ estimate.pose,
            turn @ estimate.covariance @ turn.T,
            frame.to_parent(estimate.landmarks),
            turn[:2, :2] @ estimate.landmark_covariances @ turn[:2, :2].T,
            estimate.kinds,
        )


class SlamAlgorithm(ABC):
    """A SLAM algorithm: it gets motions and measurements, and returns an estimate (Aliyev et al. 2014, section 3.3)."""

    @abstractmethod
    def move(self, motion: Motion) -> None:
        """Predict the state after a commanded motion."""

    @abstractmethod
    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Update with the measurements from the present pose; the sequence may be empty."""

    @abstractmethod
    def estimate(self) -> Estimate:
        """Return the current estimate."""


class DeadReckoning(SlamAlgorithm):
    """Dead reckoning: add up the commanded motions and ignore all landmarks. SLAM has to be better than this.

    Parameters
    ----------
    start : Pose
        First pose of the robot; by default the origin.
    """

    def __init__(self, start: Pose | None = None) -> None:
        """Start at the pose `start`."""
        self._pose = start or Pose()

    def move(self, motion: Motion) -> None:
        """Add the commanded motion to the pose."""
        self._pose = self._pose @ motion.as_pose()

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Ignore the measurements."""

    def estimate(self) -> Estimate:
        """Return the sum of the commanded motions, with zero covariance."""
        return Estimate(self._pose, np.zeros((3, 3)), np.empty((0, 2)), np.empty((0, 2, 2)))


def run_slam(
    algorithm: SlamAlgorithm, log: Iterable[tuple[Motion | None, Sequence[Measurement]]]
) -> list[Estimate]:
    """Run an algorithm over a log of motions and measurements.

    Parameters
    ----------
    algorithm : SlamAlgorithm
        Algorithm to run. Its state changes.
    log : iterable of (Motion or None, sequence of Measurement)
        Motion of each step, and the measurements after it. The motion is None if the robot stood still.

    Returns
    -------
    list of Estimate
        Estimate after each step.
    """
    estimates = []
    for motion, measurements in log:
        if motion is not None:
            algorithm.move(motion)
        algorithm.observe(measurements)
        estimates.append(algorithm.estimate())
    return estimates
