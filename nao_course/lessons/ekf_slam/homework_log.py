"""Run a student's filter along the homework's log or the lesson's own, and evaluate its estimates."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from nao_course.datasets import HomeworkLog, read_homework_log
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.metrics import squared_distances
from nao_course.sim import Field
from nao_course.sim.drives import Belief, Function, Sigmas, as_belief, landmark_blocks, true_path
from nao_course.slam import Motion, range_and_bearing

# The homework's six landmarks (m), and the covariance of its first pose (m^2, rad^2).
HOMEWORK_LANDMARKS = np.array([(3.0, 6.0), (3.0, 12.0), (7.0, 8.0), (7.0, 14.0), (11.0, 6.0), (11.0, 12.0)])
START_COVARIANCE = np.diag([0.02, 0.02, 0.1]) ** 2

OWN_LOG = Path(__file__).with_name("pentagon.txt")
OWN_SEED = 8
OWN_START = Pose(0.75, -0.9, 0.0)  # in the field frame; the origin of the log's own frame
SIDES, STEPS, STEP = 5, 5, 0.3  # of the pentagon: sides, steps to a side, metres to a step
# The field's landmarks in the log: two corners of the half field, two of the box, both posts.
SEEN = (0, 1, 5, 7, 8, 9)


# Of the own log: about the errors of the course's NAO and of its detector.
OWN_SIGMAS = Sigmas(along=0.03, across=0.02, turn=0.04, bearing=0.026, range=0.06)


@dataclass(frozen=True, eq=False)
class LogRun:
    """Estimates along a log of M steps with k landmarks; n = 3 + 2k.

    States (M + 1, n) and covariances (M + 1, n, n) are at the start and after each step, predicted ones (M, n) and
    (M, n, n) after each control. Innovations (M, 2k), measured minus expected, and their S (M, 2k, 2k) also exist for
    steps without an update; `updated` (M,) marks the steps whose measurements were used.
    """

    predicted_states: FloatArray
    predicted_covariances: FloatArray
    states: FloatArray
    covariances: FloatArray
    innovations: FloatArray
    innovation_covariances: FloatArray
    updated: npt.NDArray[np.bool_]

    @property
    def k(self) -> int:
        """Return the number of landmarks."""
        return (self.states.shape[1] - 3) // 2

    @property
    def landmarks(self) -> FloatArray:
        """Return the estimated landmarks at the end, (k, 2), m."""
        return self.states[-1, 3:].reshape(-1, 2)

    @property
    def landmark_covariances(self) -> FloatArray:
        """Return the covariance of each landmark at the end, (k, 2, 2), m^2."""
        return landmark_blocks(self.covariances[-1])

    @property
    def nis(self) -> FloatArray:
        """Return the normalised innovation squared of each update; 2k degrees of freedom each."""
        return squared_distances(self.innovations[self.updated], self.innovation_covariances[self.updated])


# --- initialisation ---


def homework_start(log: HomeworkLog, init_landmarks: Function, sigmas: Sigmas | None = None) -> Belief:
    """Initialise as in the homework: without a covariance between pose and landmarks.

    Return state (3 + 2k,) and covariance (3 + 2k, 3 + 2k) after the log's first measurements; `sigmas` are the
    homework's by default.
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
    """Initialise with a function that propagates the uncertainty of the pose to each landmark.

    Return state (3 + 2k,) and covariance (3 + 2k, 3 + 2k) after the log's first measurements; `sigmas` are the
    homework's by default.
    """
    noise = (sigmas or Sigmas()).measurement_covariance
    state, covariance = np.zeros(3), START_COVARIANCE.copy()
    for measured in log.measurements[0].reshape(-1, 2):
        answer = add_landmark(state, covariance, measured.copy(), noise)
        state, covariance = as_belief(answer, len(state) + 2, "add_landmark")
    return state, covariance


# --- the run ---


def run_log(
    log: HomeworkLog,
    start: Belief,
    predict: Function,
    update: Function,
    sigmas: Sigmas | None = None,
    every: int = 1,
) -> LogRun:
    """Run a student's filter along a log and keep its estimates.

    `start` is state (n,) and covariance (n, n) after the first measurements, and the filter updates only in every
    `every`-th step. Innovations and S are computed here, from the estimates before each update. Raise a ValueError if a
    function returns something of another shape.
    """
    sigmas = sigmas or Sigmas()
    Q, R, k = sigmas.control_covariance, sigmas.measurement_covariance, log.k
    state, covariance = start
    predicted, estimated, innovations = [], [start], []
    updated = np.arange(1, len(log.controls) + 1) % every == 0
    for control, measured, used in zip(log.controls, log.measurements[1:], updated, strict=True):
        answer = predict(state.copy(), covariance.copy(), control.copy(), Q.copy(), k)
        state, covariance = as_belief(answer, len(state), "predict")
        predicted.append((state, covariance))
        innovations.append(innovation_and_covariance(state, covariance, range(k), measured, R))
        if used:
            answer = update(state.copy(), covariance.copy(), measured.copy(), R.copy(), k)
            state, covariance = as_belief(answer, len(state), "update")
        estimated.append((state, covariance))
    return LogRun(*_stacked(predicted), *_stacked(estimated), *_stacked(innovations), updated)


def _stacked(pairs: list[Belief]) -> Belief:
    first, second = zip(*pairs, strict=True)
    return np.array(first), np.array(second)


# --- innovations and errors ---

_STEP = 1e-5  # of central differences, m and rad
_SHIFTS = _STEP * np.vstack([np.eye(5), -np.eye(5)])


def innovation_and_covariance(
    state: FloatArray,
    covariance: FloatArray,
    indices: npt.ArrayLike,
    measurements: FloatArray,
    measurement_covariance: FloatArray,
) -> Belief:
    """Return the innovation (2n,) of n measurements, bearings wrapped, and its covariance S (2n, 2n).

    State (3 + 2k,) and covariance (3 + 2k, 3 + 2k) are from before the measurements (2n,), which are (bearing, range)
    in rad and m with a covariance (2, 2), in rad^2 and m^2, for each. The Jacobians are central differences.
    """
    numbers = np.atleast_1d(np.asarray(indices, dtype=int))
    n = len(numbers)
    landmarks = state[3:].reshape(-1, 2)[numbers]
    innovation = measurements.reshape(n, 2) - range_and_bearing(state[:3], landmarks)
    innovation[:, 0] = wrap_angle(innovation[:, 0])
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
    return innovation.reshape(-1), H @ covariance[np.ix_(columns, columns)] @ H.T + noise


@dataclass(frozen=True, eq=False)
class LandmarkErrors:
    """Errors (k,) of landmarks: `euclidean` in metres, `printed` in m^2, and `mahalanobis` in standard deviations.

    `mahalanobis` is sqrt(d' inv(P) d); `printed` is sqrt(d' P d), which the report calls the Mahalanobis distance.
    """

    euclidean: FloatArray
    printed: FloatArray
    mahalanobis: FloatArray


def landmark_errors(
    landmarks: FloatArray, covariances: FloatArray, truth: npt.ArrayLike = HOMEWORK_LANDMARKS
) -> LandmarkErrors:
    """Compare landmarks with the truth, by the distances of the report's Table 1 and by the Mahalanobis distance.

    Landmarks (k, 2) and covariances (k, 2, 2) are in m and m^2.
    """
    off = np.asarray(landmarks) - np.asarray(truth, dtype=float)
    return LandmarkErrors(
        np.hypot(*off.T),
        np.sqrt(np.einsum("ki,kij,kj->k", off, covariances, off)),
        np.sqrt(squared_distances(off, covariances)),
    )


# --- the lesson's own log ---


@dataclass(frozen=True, eq=False)
class Recording:
    """A log with the true path and landmarks, in the frame of the robot's first pose.

    The path (M + 1, 3) is in m and rad; the six landmarks (6, 2) form a pentagon, in m.
    """

    log: HomeworkLog
    path: FloatArray
    landmarks: FloatArray


def record_pentagon(seed: int = OWN_SEED, sigmas: Sigmas = OWN_SIGMAS) -> Recording:
    """Drive a pentagon on the half field and measure six landmarks from every pose, as in the homework.

    The same seed gives the same recording.
    """
    rng = np.random.default_rng(seed)
    marks = Field(2012).landmarks
    landmarks = OWN_START.to_local([(marks[number].x, marks[number].y) for number in SEEN])
    controls = np.array(
        [(STEP, 2 * np.pi / SIDES if n % STEPS == 0 else 0.0) for n in range(1, SIDES * STEPS + 1)]
    )
    poses = np.array([pose.as_array() for pose in true_path(map(Motion, *controls.T.tolist()), sigmas, rng)])
    exact = range_and_bearing(poses[:, None], landmarks)
    seen = sigmas.disturbed(exact, rng.standard_normal(exact.shape))
    return Recording(HomeworkLog(seen.reshape(len(poses), -1), controls), poses, landmarks)


def own_log() -> HomeworkLog:
    """Return the recorded log of `record_pentagon`, which the course ships in the homework's format."""
    return read_homework_log(OWN_LOG)
