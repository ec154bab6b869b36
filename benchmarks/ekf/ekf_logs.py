"""Lesson 07's functions on the logs of others: the homework's Table 1, and Freiburg's drive to its end."""

from typing import Any, NamedTuple

import numpy as np

from benchmarks import Result, Table, solution
from nao_course.datasets import FreiburgLog, read_freiburg_log, read_homework_log
from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_slam.homework_log import (
    LandmarkErrors,
    LogRun,
    homework_start,
    innovation_and_covariance,
    landmark_errors,
    run_log,
    textbook_start,
)
from nao_course.metrics import band, squared_distances
from nao_course.sim.drives import Sigmas, landmark_blocks

OWN = solution("07")

# What Freiburg's exercise assumes of each step and measurement; and less of a step, so that NIS comes near its mean.
COURSE = Sigmas(along=0.1**0.5, across=0.1**0.5, turn=0.1, bearing=0.1, range=0.1)
SMALLER = Sigmas(along=0.005, across=0.005, turn=0.005, bearing=0.05, range=0.1)


def homework_rows() -> tuple[list[tuple[str, LandmarkErrors]], LogRun]:
    """Return the errors of the landmarks with the homework's and the textbook's initialisation, and the first run."""
    log = read_homework_log()
    starts = {
        "the homework's start": homework_start(log, OWN["init_landmarks"]),
        "the textbook's start": textbook_start(log, OWN["add_landmark"]),
    }
    runs = {name: run_log(log, start, OWN["predict"], OWN["update"]) for name, start in starts.items()}
    rows = [(name, landmark_errors(run.landmarks, run.landmark_covariances)) for name, run in runs.items()]
    return rows, runs["the homework's start"]


class FreiburgRun(NamedTuple):
    """What is believed at the end: the state, its covariance, which landmark is which, and NIS by degree of freedom."""

    state: FloatArray
    covariance: FloatArray
    on_map: list[int]
    nis: float


def run_freiburg(log: FreiburgLog, sigmas: Sigmas) -> FreiburgRun:
    """Turn, drive and turn again: two predictions a step; landmarks are added as they come into view."""
    R, still = sigmas.measurement_covariance, Sigmas(0.0, 0.0, sigmas.turn).control_covariance
    state, covariance, on_map = np.zeros(3), np.zeros((3, 3)), list[int]()
    squares, degrees = 0.0, 0
    for (first, distance, second), (seen, measured) in zip(log.odometry, log.observations, strict=True):
        state, covariance = OWN["predict"](state, covariance, np.array([0.0, first]), still, len(on_map))
        control = np.array([distance, second])
        state, covariance = OWN["predict"](state, covariance, control, sigmas.control_covariance, len(on_map))
        values = measured.reshape(-1, 2)
        known = [number for number, landmark in enumerate(seen) if landmark in on_map]
        if known:
            indices, again = [on_map.index(seen[number]) for number in known], values[known].reshape(-1)
            innovation, S = innovation_and_covariance(state, covariance, indices, again, R)
            squares += float(squared_distances(innovation[None], S[None])[0])
            degrees += len(again)
            state, covariance = OWN["update_landmarks"](state, covariance, indices, again, R)
        for number in sorted(set(range(len(seen))) - set(known)):
            state, covariance = OWN["add_landmark"](state, covariance, values[number], R)
            on_map.append(int(seen[number]))
    return FreiburgRun(state, covariance, on_map, squares / degrees)


def aligned(points: FloatArray, truth: FloatArray) -> tuple[FloatArray, float]:
    """Align points (k, 2) with the truth by a rotation and a shift; return them and the angle (rad)."""
    own, true = points - points.mean(axis=0), truth - truth.mean(axis=0)
    u, _, v = np.linalg.svd(own.T @ true)
    turn = u @ np.diag([1.0, np.sign(np.linalg.det(u @ v))]) @ v
    return own @ turn + truth.mean(axis=0), float(np.arctan2(turn[0, 1], turn[0, 0]))


def freiburg_values(log: FreiburgLog, sigmas: Sigmas) -> dict[str, Any]:
    """Return the errors of the landmarks at the end of the log, before and after aligning the map with the truth."""
    run = run_freiburg(log, sigmas)
    landmarks, truth = run.state[3:].reshape(-1, 2), log.landmarks[run.on_map]
    errors = landmark_errors(landmarks, landmark_blocks(run.covariance), truth)
    shape, turn = aligned(landmarks, truth)
    return {
        "landmarks": len(landmarks),
        "error": float(errors.euclidean.mean()),
        "worst": float(errors.euclidean.max()),
        "mahalanobis": float(errors.mahalanobis.max()),
        "shape": float(np.hypot(*(shape - truth).T).mean()),
        "turned_degrees": float(np.degrees(turn)),
        "nis": run.nis,
    }


def main() -> Result:
    """Run both logs."""
    rows, run = homework_rows()
    low, high = band(12, len(run.nis))
    log = read_freiburg_log()
    freiburg = {name: freiburg_values(log, each) for name, each in (("course", COURSE), ("smaller", SMALLER))}
    errors = {
        f"{name}, {number + 1}": {
            "euclidean, m": f"{found.euclidean[number]:.7f}",
            "sqrt(d' P d)": f"{found.printed[number]:.4e}",
            "sqrt(d' inv(P) d)": f"{found.mahalanobis[number]:.5f}",
        }
        for name, found in rows
        for number in range(6)
    }
    tables = (
        Table.of("the homework's log, Table 1", errors),
        Table.of(f"Freiburg's log to its end, {len(log.odometry)} steps", freiburg, shown=".3f"),
    )
    values = {
        "homework": {name: found.euclidean.tolist() for name, found in rows},
        "nis": float(run.nis.mean()),
        "freiburg": freiburg,
    }
    note = (
        f"homework: mean NIS {run.nis.mean():.3f}; 12 degrees of freedom, 95 % band {low:.1f} to {high:.1f}"
    )
    return Result("ekf_logs", values, tables, (note,))
