"""Five drives of a student's personal robot, whose errors and seeds follow from the student's name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from nao_course._internal.personal_world import PersonalWorld
from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS, homework_start, record_pentagon, run_log
from nao_course.plotting import Table, table
from nao_course.sim.drives import Function, Sigmas

DRIVES = 5
SMALLEST, LARGEST = 0.6, 1.8  # factors of the standard deviations of turns and bearings


def personal_sigmas(world: PersonalWorld) -> Sigmas:
    """Return the standard deviations of a personal robot, which its filter knows."""
    turn, bearing = world.rng("07: sigmas").uniform(SMALLEST, LARGEST, 2).round(2).tolist()
    return OWN_SIGMAS.scaled("turn", turn).scaled("bearing", bearing)


def personal_distances(
    world: PersonalWorld,
    init_landmarks: Function,
    predict: Function,
    update: Function,
    evaluate_landmarks: Function,
) -> tuple[FloatArray, FloatArray]:
    """Run a student's filter on the drives of a personal robot.

    Parameters
    ----------
    world : PersonalWorld
        Of the student.
    init_landmarks, predict, update, evaluate_landmarks : callable
        The student's functions.

    Returns
    -------
    euclidean, mahalanobis : ndarray, shape (5, 6)
        Distances of the estimated landmarks from the true ones at the end of each drive, m and standard deviations.
    """
    sigmas, first = personal_sigmas(world), world.seed("07: drives")
    found = []
    for seed in range(first, first + DRIVES):
        recording = record_pentagon(seed, sigmas)
        start = homework_start(recording.log, init_landmarks, sigmas)
        run = run_log(recording.log, start, predict, update, sigmas)
        distances = evaluate_landmarks(
            run.landmarks.copy(), run.landmark_covariances.copy(), recording.landmarks.copy()
        )
        found.append([np.array(each, dtype=float) for each in distances])
    euclidean, mahalanobis = np.stack(found, axis=1)
    return euclidean, mahalanobis


def personal_table(
    world: PersonalWorld,
    init_landmarks: Function,
    predict: Function,
    update: Function,
    evaluate_landmarks: Function,
) -> Table:
    """Return the mean distances of the drives of a personal robot as a table; see `personal_distances`."""
    sigmas = personal_sigmas(world)
    distances = personal_distances(world, init_landmarks, predict, update, evaluate_landmarks)
    means = [*zip(*(of.mean(axis=1) for of in distances), strict=True), [of.mean() for of in distances]]
    names = [*(f"drive {number}" for number in range(1, DRIVES + 1)), "all five"]
    rows = [(name, f"{mean[0]:.3f}", f"{mean[1]:.2f}") for name, mean in zip(names, means, strict=True)]
    robot = f"robot of {world}: {np.degrees(sigmas.turn):.1f}° per turn, {np.degrees(sigmas.bearing):.1f}° per bearing"
    return table((robot, "mean Euclidean distance (m)", "mean Mahalanobis distance"), rows)


def personal_numbers(world: PersonalWorld, solution: Mapping[str, Callable[..., Any]]) -> dict[str, float]:
    """Return the numbers of a student's table; the functions of the solution give the same as any right functions."""
    names = ("init_landmarks", "predict", "update", "evaluate_landmarks")
    euclidean, mahalanobis = personal_distances(world, *(solution[name] for name in names))
    return {
        "mean Euclidean distance (m)": float(euclidean.mean()),
        "mean Mahalanobis distance": float(mahalanobis.mean()),
    }
