"""The homework's drive through a student's filter: its log, what is believed at every step, and what judges it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.datasets import HomeworkLog, read_homework_log
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.metrics import squared_distances
from nao_course.sim import Field
from nao_course.slam import range_and_bearing

Function = Callable[..., Any]
Belief = tuple[FloatArray, FloatArray]

# The homework's: where its six landmarks are (m), and how sure its robot is of its first pose (m^2, rad^2).
HOMEWORK_LANDMARKS = np.array([(3.0, 6.0), (3.0, 12.0), (7.0, 8.0), (7.0, 14.0), (11.0, 6.0), (11.0, 12.0)])
START_COVARIANCE = np.diag([0.02, 0.02, 0.1]) ** 2

OWN_LOG = Path(__file__).with_name("pentagon.txt")
OWN_SEED = 8
OWN_START = Pose(0.75, -0.9, 0.0)  # in the field's frame; the log's own begins here
SIDES, STEPS, STEP = 5, 5, 0.3  # of the pentagon: sides, steps to a side, metres to a step
SEEN = (
    0,
    1,
    5,
    7,
    8,
    9,
)  # which of the field's marks: two corners of the half field, two of the box, both posts


@dataclass(frozen=True)
class Sigmas:
    """Standard deviations that a filter assumes, or a simulator uses; the homework's by default.

    Parameters
    ----------
    along, across : float
        Of a step, ahead and to the left of the robot, m: sigma_x and sigma_y.
    turn : float
        Of a step, rad: sigma_alpha.
    bearing : float
        Of a measurement, rad: sigma_beta.
    range : float
        Of a measurement, m: sigma_r.
    """

    along: float = 0.25
    across: float = 0.1
    turn: float = 0.1
    bearing: float = 0.01
    range: float = 0.08

    @property
    def control_covariance(self) -> FloatArray:
        """Of (along, across, turn) in the robot frame, (3, 3), m^2 and rad^2."""
        return np.diag([self.along, self.across, self.turn]) ** 2

    @property
    def measurement_covariance(self) -> FloatArray:
        """Of (bearing, range), (2, 2), rad^2 and m^2."""
        return np.diag([self.bearing, self.range]) ** 2

    def scaled(self, name: str, factor: float) -> Sigmas:
        """The same with one of them multiplied."""
        return replace(self, **{name: factor * getattr(self, name)})


# Of the own log: a robot that walks about as well as the course's NAO, a detector about as good.
OWN_SIGMAS = Sigmas(along=0.03, across=0.02, turn=0.04, bearing=0.026, range=0.06)


@dataclass(frozen=True, eq=False)
class LogRun:
    """All that was believed along a log of M steps with k landmarks; n = 3 + 2k.

    Parameters
    ----------
    predicted_states, predicted_covariances : ndarray, shapes (M, n) and (M, n, n)
        After each control, before the measurements.
    states, covariances : ndarray, shapes (M + 1, n) and (M + 1, n, n)
        At the start, and after each step.
    innovations, spreads : ndarray, shapes (M, 2k) and (M, 2k, 2k)
        Measured less expected, and what it should vary by, S; also of steps whose measurements are not used.
    updated : ndarray of bool, shape (M,)
        In which steps the measurements were used.
    """

    predicted_states: FloatArray
    predicted_covariances: FloatArray
    states: FloatArray
    covariances: FloatArray
    innovations: FloatArray
    spreads: FloatArray
    updated: npt.NDArray[np.bool_]

    @property
    def k(self) -> int:
        """How many landmarks."""
        return (self.states.shape[1] - 3) // 2

    @property
    def landmarks(self) -> FloatArray:
        """Where they are believed to be at the end, (k, 2), m."""
        return self.states[-1, 3:].reshape(-1, 2)

    @property
    def landmark_covariances(self) -> FloatArray:
        """Of each landmark at the end, (k, 2, 2), m^2."""
        return landmark_blocks(self.covariances[-1])

    @property
    def nis(self) -> FloatArray:
        """Normalised innovation squared of each step that was updated; 2k degrees of freedom each."""
        return squared_distances(self.innovations[self.updated], self.spreads[self.updated])


def landmark_blocks(covariance: FloatArray) -> FloatArray:
    """The covariance (2, 2) of each landmark, (k, 2, 2), of a state's (3 + 2k, 3 + 2k)."""
    k = (len(covariance) - 3) // 2
    each = np.arange(k)
    return covariance[3:, 3:].reshape(k, 2, k, 2)[each, :, each]


# --- how a log begins ---


def homework_start(log: HomeworkLog, init_landmarks: Function, sigmas: Sigmas | None = None) -> Belief:
    """Begin as the homework does: pose and landmarks know nothing of each other.

    Parameters
    ----------
    log : HomeworkLog
        Its first measurements place the landmarks.
    init_landmarks : callable
        The student's.
    sigmas : Sigmas, optional
        By default the homework's.

    Returns
    -------
    (ndarray (3 + 2k,), ndarray (3 + 2k, 3 + 2k))
        State and covariance.
    """
    noise = (sigmas or Sigmas()).measurement_covariance
    k, landmarks, own = init_landmarks(
        log.measurements[0].copy(), noise, np.zeros(3), START_COVARIANCE.copy()
    )
    state, covariance = np.zeros(3 + 2 * log.k), np.zeros((3 + 2 * log.k,) * 2)
    if k != log.k or np.shape(landmarks) != (2 * k,) or np.shape(own) != (2 * k, 2 * k):
        raise ValueError(
            f"init_landmarks must return ({log.k}, ({2 * log.k},), ({2 * log.k}, {2 * log.k})) for this log, got "
            f"{k} and the shapes {np.shape(landmarks)} and {np.shape(own)}"
        )
    state[3:], covariance[:3, :3], covariance[3:, 3:] = landmarks, START_COVARIANCE, own
    return state, covariance


def textbook_start(log: HomeworkLog, add_landmark: Function, sigmas: Sigmas | None = None) -> Belief:
    """Begin as the textbook does: each landmark is as wrong as the pose from which it was seen.

    Parameters
    ----------
    log : HomeworkLog
        Its first measurements place the landmarks.
    add_landmark : callable
        The student's.
    sigmas : Sigmas, optional
        By default the homework's.

    Returns
    -------
    (ndarray (3 + 2k,), ndarray (3 + 2k, 3 + 2k))
        State and covariance.
    """
    noise = (sigmas or Sigmas()).measurement_covariance
    state, covariance = np.zeros(3), START_COVARIANCE.copy()
    for measured in log.measurements[0].reshape(-1, 2):
        answer = add_landmark(state, covariance, measured.copy(), noise)
        state, covariance = as_belief(answer, len(state) + 2, "add_landmark")
    return state, covariance


# --- along it ---


def run_log(
    log: HomeworkLog,
    start: Belief,
    predict: Function,
    update: Function,
    sigmas: Sigmas | None = None,
    every: int = 1,
) -> LogRun:
    """Run a student's filter along a log and keep what it believes.

    Parameters
    ----------
    log : HomeworkLog
        Controls and measurements.
    start : (ndarray (n,), ndarray (n, n))
        State and covariance after the first measurements.
    predict, update : callable
        The student's.
    sigmas : Sigmas, optional
        What the filter assumes; by default the homework's.
    every : int
        Only in every so many steps the measurements are used.

    Returns
    -------
    LogRun
        Innovations and their covariances are computed here, from what is believed before each update.

    Raises
    ------
    ValueError
        If a function returns something of another shape.
    """
    sigmas = sigmas or Sigmas()
    Q, R, k = sigmas.control_covariance, sigmas.measurement_covariance, log.k
    state, covariance = start
    predicted, believed, judged = [], [start], []
    updated = np.arange(1, len(log.controls) + 1) % every == 0
    for control, measured, used in zip(log.controls, log.measurements[1:], updated, strict=True):
        answer = predict(state.copy(), covariance.copy(), control.copy(), Q.copy(), k)
        state, covariance = as_belief(answer, len(state), "predict")
        predicted.append((state, covariance))
        judged.append(innovation_and_spread(state, covariance, range(k), measured, R))
        if used:
            answer = update(state.copy(), covariance.copy(), measured.copy(), R.copy(), k)
            state, covariance = as_belief(answer, len(state), "update")
        believed.append((state, covariance))
    return LogRun(*_stacked(predicted), *_stacked(believed), *_stacked(judged), updated)


def _stacked(pairs: list[Belief]) -> Belief:
    first, second = zip(*pairs, strict=True)
    return np.array(first), np.array(second)


def as_belief(answer: Any, size: int, name: str) -> Belief:
    """Take state (size,) and covariance (size, size) from what a student's function returns.

    Raises
    ------
    ValueError
        If it returned something else; it names the function.
    """
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise ValueError(f"{name} must return (state, covariance), got {type(answer).__name__}")
    state, covariance = (np.array(each, dtype=float) for each in answer)
    if state.shape != (size,) or covariance.shape != (size, size):
        raise ValueError(
            f"{name} must return shapes ({size},) and ({size}, {size}), got {state.shape} and {covariance.shape}"
        )
    return state, covariance


# --- what judges it ---

_STEP = 1e-5  # of central differences, m and rad
_SHIFTS = _STEP * np.vstack([np.eye(5), -np.eye(5)])


def innovation_and_spread(
    state: FloatArray,
    covariance: FloatArray,
    indices: npt.ArrayLike,
    measurements: FloatArray,
    measurement_covariance: FloatArray,
) -> Belief:
    """What measurements tell anew, and how far that should spread.

    Parameters
    ----------
    state, covariance : ndarray, shapes (3 + 2k,) and (3 + 2k, 3 + 2k)
        Believed before these measurements.
    indices : array_like of int, shape (n,)
        Which landmarks are measured.
    measurements : ndarray, shape (2n,)
        (bearing, range) of each, rad and m.
    measurement_covariance : ndarray, shape (2, 2)
        Of each, rad^2 and m^2.

    Returns
    -------
    (ndarray (2n,), ndarray (2n, 2n))
        Measured less expected, bearings wrapped; and its covariance S. Slopes are central differences.
    """
    numbers = np.atleast_1d(np.asarray(indices, dtype=int))
    n = len(numbers)
    landmarks = state[3:].reshape(-1, 2)[numbers]
    surprise = measurements.reshape(n, 2) - range_and_bearing(state[:3], landmarks)
    surprise[:, 0] = wrap_angle(surprise[:, 0])
    near = range_and_bearing(state[:3] + _SHIFTS[:, None, :3], landmarks + _SHIFTS[:, None, 3:])
    change = near[:5] - near[5:]  # (5, n, 2): by x, y, theta, and the landmark's x and y
    change[..., 0] = wrap_angle(change[..., 0])
    H = np.zeros((n, 2, 3 + 2 * n))
    H[..., :3] = np.moveaxis(change[:3], 0, -1)
    for number in range(n):
        H[number, :, 3 + 2 * number : 5 + 2 * number] = change[3:, number].T
    H = H.reshape(2 * n, -1) / (2 * _STEP)
    columns = np.concatenate([np.arange(3), (3 + 2 * numbers[:, None] + np.arange(2)).reshape(-1)])
    noise = np.kron(np.eye(n), measurement_covariance)
    return surprise.reshape(-1), H @ covariance[np.ix_(columns, columns)] @ H.T + noise


@dataclass(frozen=True, eq=False)
class LandmarkErrors:
    """How far each of k landmarks is from the truth.

    Parameters
    ----------
    euclidean : ndarray, shape (k,)
        Metres.
    printed : ndarray, shape (k,)
        sqrt(d' P d), which the report calls the Mahalanobis distance; m^2.
    mahalanobis : ndarray, shape (k,)
        sqrt(d' inv(P) d): standard deviations.
    """

    euclidean: FloatArray
    printed: FloatArray
    mahalanobis: FloatArray


def landmark_errors(
    landmarks: FloatArray, covariances: FloatArray, truth: npt.ArrayLike = HOMEWORK_LANDMARKS
) -> LandmarkErrors:
    """Compare landmarks with the truth, as the report's Table 1 does and as it should.

    Parameters
    ----------
    landmarks, covariances : ndarray, shapes (k, 2) and (k, 2, 2)
        Believed: m and m^2.
    truth : array_like, shape (k, 2)
        By default the homework's.

    Returns
    -------
    LandmarkErrors
        Three distances of each.
    """
    off = np.asarray(landmarks) - np.asarray(truth, dtype=float)
    return LandmarkErrors(
        np.hypot(*off.T),
        np.sqrt(np.einsum("ki,kij,kj->k", off, covariances, off)),
        np.sqrt(squared_distances(off, covariances)),
    )


# --- an own log ---


@dataclass(frozen=True, eq=False)
class Recording:
    """A log and what the simulator knows of it, in the log's own frame: that of the robot's first pose.

    Parameters
    ----------
    log : HomeworkLog
        Six landmarks, a pentagon.
    path : ndarray, shape (M + 1, 3)
        True poses, m and rad.
    landmarks : ndarray, shape (6, 2)
        True, m.
    """

    log: HomeworkLog
    path: FloatArray
    landmarks: FloatArray


def true_path(controls: FloatArray, sigmas: Sigmas, rng: np.random.Generator) -> list[Pose]:
    """Where a robot truly goes that is given M controls (M, 2): M + 1 poses from (0, 0, 0)."""
    deviations = np.sqrt(np.diag(sigmas.control_covariance))
    path = [Pose()]
    for (distance, turn), error in zip(controls, rng.standard_normal((len(controls), 3)), strict=True):
        along, across, turned = error * deviations
        path.append(path[-1] @ Pose(distance + along, across, turn + turned))
    return path


def record_pentagon(seed: int = OWN_SEED, sigmas: Sigmas = OWN_SIGMAS) -> Recording:
    """Drive a pentagon on the half field and measure six of its marks from every pose, all round, as the homework does.

    Parameters
    ----------
    seed : int
        Of all errors.
    sigmas : Sigmas
        Their size: what a filter that is told so may assume.

    Returns
    -------
    Recording
        The same seed gives the same one.
    """
    rng = np.random.default_rng(seed)
    marks = Field(2012).landmarks
    landmarks = OWN_START.to_local([(marks[number].x, marks[number].y) for number in SEEN])
    controls = np.array(
        [(STEP, 2 * np.pi / SIDES if n % STEPS == 0 else 0.0) for n in range(1, SIDES * STEPS + 1)]
    )
    poses = np.array([pose.as_array() for pose in true_path(controls, sigmas, rng)])
    seen = range_and_bearing(poses[:, None], landmarks) + rng.standard_normal(
        (len(poses), len(landmarks), 2)
    ) * (
        sigmas.bearing,
        sigmas.range,
    )
    seen[..., 0] = wrap_angle(seen[..., 0])
    return Recording(HomeworkLog(seen.reshape(len(poses), -1), controls), poses, landmarks)


def own_log() -> HomeworkLog:
    """The log that `record_pentagon` made and the course ships, in the homework's format."""
    return read_homework_log(OWN_LOG)
