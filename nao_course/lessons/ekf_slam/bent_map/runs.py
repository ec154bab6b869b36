"""The drive that opens the lesson, and what a filter with two errors estimated along it.

The filter's code is not here. What it computed is recorded in ``recorded.json``, which
``python -m tests.lessons.ekf_slam.make_bent_map`` writes.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray, Pose, pose_errors
from nao_course.lessons.ekf_slam.consistency import NOISY, field_drive
from nao_course.metrics import squared_distances
from nao_course.sim.drives import Drive, FieldOfView, Functions, NamedEkf, checked_functions, landmark_blocks
from nao_course.slam import range_and_bearing

RECORDED = Path(__file__).with_name("recorded.json")
SEED, LAPS = 2, 2
ALL_ROUND = FieldOfView(float(np.pi), 2.0)  # rad, m
TEST_STEP = 16  # of the drive: the covariance before the motion of `draw_covariance_test`
TEST_CONTROL = np.array([1.0, 0.0])  # m, rad
SAMPLES = 20_000
TWO_ERRORS, ONE_ERROR = "two errors", "one error"


@dataclass(frozen=True, eq=False)
class FilterRun:
    """Estimates of one filter along the drive of M steps past k landmarks.

    `path` (M, 3) has the estimated poses, `nees` (M,) is negative where the covariance is not positive definite. At the
    end, the landmarks are estimated as (k, 2) in m with covariances (k, 2, 2) in m^2; the true ones are in the same
    order. `bearings` (N, 2) has the step, and measured minus expected bearing (rad, not wrapped). `map_nees` is the
    NEES of all landmarks with their joint covariance; it is not recorded for the given filter.
    """

    path: FloatArray
    nees: FloatArray
    landmarks: FloatArray
    landmark_covariances: FloatArray
    true_landmarks: FloatArray
    bearings: FloatArray
    map_nees: float | None = None

    @property
    def map_error(self) -> float:
        """Mean distance of the landmarks from the truth at the end, m."""
        return float(np.hypot(*(self.landmarks - self.true_landmarks).T).mean())


@cache
def bent_drive() -> Drive:
    """Drive two circles on the half field and measure all landmarks within two metres, all round."""
    return field_drive(SEED, NOISY, LAPS, ALL_ROUND)


def run_filter(functions: Functions) -> FilterRun:
    """Run a filter along the drive: predict, update with known landmarks, then add the others.

    `functions` are predict, update_landmarks and add_landmark, the student's or others with the same arguments.
    """
    drive = bent_drive()
    slam = NamedEkf(Pose(), *checked_functions(functions))
    path, nees, bearings = [], [], []
    for number, step in enumerate(drive.steps[1:], start=1):
        slam.move(step.control, step.control_covariance)
        again, slots = slam.on_map(step.numbers)
        expected = range_and_bearing(slam.state[:3], slam.state[3:].reshape(-1, 2)[slots])
        bearings += [(number, value) for value in step.measurements[again][:, 0] - expected[:, 0]]
        slam.observe(step.numbers, step.measurements, step.covariances)
        path.append(slam.state[:3])
        nees.append(
            squared_distances(pose_errors(slam.state[:3], step.pose)[None], slam.covariance[None, :3, :3])[0]
        )
    errors = slam.state[3:] - drive.landmarks[slam.known].ravel()
    map_nees = squared_distances(errors[None], slam.covariance[None, 3:, 3:])[0]
    return FilterRun(
        np.array(path),
        np.array(nees),
        slam.state[3:].reshape(-1, 2),
        landmark_blocks(slam.covariance),
        drive.landmarks[slam.known],
        np.array(bearings),
        float(map_nees),
    )


@cache
def _recording() -> dict[str, Any]:
    """Return the recorded values."""
    return dict(json.loads(RECORDED.read_text(encoding="utf-8")))


def recorded_run(name: str) -> FilterRun:
    """Return the recorded run of the filter with `TWO_ERRORS`, or with `ONE_ERROR` after the first is mended."""
    run = _recording()[name]
    drive = bent_drive()
    values: dict[str, Any] = {
        key: np.array(value, dtype=float) for key, value in run.items() if key != "known"
    }
    return FilterRun(**values, true_landmarks=drive.landmarks[run["known"]])


def recorded_test() -> dict[str, Any]:
    """Return state, covariance, and the covariance after `TEST_CONTROL` that the filter with one error predicted."""
    return dict(_recording()["test"])


# --- a covariance, tested with samples ---


def sampled_covariance() -> FloatArray:
    """Return the covariance of many robots after the motion of `TEST_CONTROL`, each moved by the exact motion model."""
    test = recorded_test()
    rng = np.random.default_rng(SEED)
    states = rng.multivariate_normal(test["state"], test["covariance"], SAMPLES, method="cholesky")
    noise = rng.multivariate_normal(np.zeros(3), NOISY.control_covariance, SAMPLES)
    along, across, turn = noise.T + np.array([[TEST_CONTROL[0]], [0.0], [TEST_CONTROL[1]]])
    c, s = np.cos(states[:, 2]), np.sin(states[:, 2])
    states[:, 0] += along * c - across * s
    states[:, 1] += along * s + across * c
    states[:, 2] += turn
    return np.asarray(np.cov(states.T))


def covariance_differences(covariance: FloatArray) -> dict[str, float]:
    """Return the largest difference from the samples, in standard deviations, for "pose", "pose and map" and "map".

    The covariance (n, n) is a filter's after the motion of `TEST_CONTROL`.
    """
    difference = np.abs(scaled_difference(covariance))
    return {
        "pose": float(difference[:3, :3].max()),
        "pose and map": float(max(difference[:3, 3:].max(), difference[3:, :3].max())),
        "map": float(difference[3:, 3:].max()),
    }


def scaled_difference(covariance: FloatArray) -> FloatArray:
    """Return a covariance minus the covariance of the samples, in units of both standard deviations."""
    sampled = sampled_covariance()
    sigma = np.sqrt(np.diag(sampled))
    return np.asarray((covariance - sampled) / np.outer(sigma, sigma))
