"""Evaluate the run of a log: landmarks, also of a personal robot, and NIS with its band."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nao_course._internal.personal_world import PersonalWorld
from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_slam.film import FilterFilm
from nao_course.lessons.ekf_slam.homework_log import (
    OWN_SIGMAS,
    LogRun,
    homework_start,
    landmark_errors,
    own_log,
    record_pentagon,
    run_log,
)
from nao_course.metrics import band
from nao_course.plotting import Drawing, Table, course_style, table
from nao_course.plotting.style import GREY, style_of
from nao_course.sim.drives import Function, Sigmas

BAND = "#e3e5e8"
FACTORS = (1.0, 3.0, 10.0)
DRIVES = 5
_LARGER = "A larger S makes the NIS smaller."
NIS_REMARKS = {  # by typical predictions of the mean NIS with standard deviations that are ten times too large
    **dict.fromkeys((1200.0, 200.0, 120.0, 60.0, 20.0), _LARGER),
    12.0: "S grows, but the innovations hardly change.",
    **dict.fromkeys(
        (1.2, 0.5), "S contains variances, and a tenfold standard deviation is a hundredfold variance."
    ),
}
SMALLEST, LARGEST = 0.6, 1.8  # factors of the standard deviations of turns and bearings


def distances_table(film: FilterFilm, evaluate_landmarks: Function) -> Table:
    """Compare the landmarks of a film with the true ones in a table.

    Parameters
    ----------
    film : FilterFilm
        Film of the lesson's own log.
    evaluate_landmarks : callable
        The student's functions.

    Returns
    -------
    Table
        A row for each landmark: Euclidean distance, Mahalanobis distance, and the distance that the homework calls so.
    """
    run = film.run
    euclidean, mahalanobis = evaluate_landmarks(
        run.landmarks.copy(), run.landmark_covariances.copy(), film.truth.copy()
    )
    printed = landmark_errors(run.landmarks, run.landmark_covariances, film.truth).printed
    rows = [
        (str(number), f"{plain:.4f}", f"{weighed:.2f}", f"{other:.2e}")
        for number, (plain, weighed, other) in enumerate(
            zip(euclidean, mahalanobis, printed, strict=True), start=1
        )
    ]
    rows.append(
        ("mean", f"{np.mean(euclidean):.4f}", f"{np.mean(mahalanobis):.2f}", f"{np.mean(printed):.2e}")
    )
    return table(("landmark", "Euclidean (m)", "Mahalanobis (sigmas)", "the homework's √(d'Pd) (m²)"), rows)


# --- NIS ---


def run_with(factor: float, init_landmarks: Function, predict: Function, update: Function) -> LogRun:
    """Run the own log with all standard deviations assumed too large by a factor."""
    log, sigmas = own_log(), OWN_SIGMAS.times(factor)
    return run_log(log, homework_start(log, init_landmarks, sigmas), predict, update, sigmas)


def mean_nis(factor: float, init_landmarks: Function, predict: Function, update: Function) -> float:
    """Return the mean NIS over the own log with all standard deviations assumed too large by a factor."""
    return float(run_with(factor, init_landmarks, predict, update).nis.mean())


@course_style()
def draw_nis(init_landmarks: Function, predict: Function, update: Function) -> Drawing:
    """Draw the NIS over the own log, with correct standard deviations and with too large ones.

    Parameters
    ----------
    init_landmarks, predict, update : callable
        The student's functions.

    Returns
    -------
    Drawing
        Three curves with the band of one step; the text contains their means.
    """
    runs = {factor: run_with(factor, init_landmarks, predict, update) for factor in FACTORS}
    degrees = 2 * runs[1.0].k
    low, high = band(degrees, 1)
    styles = (("ekf", "correct"), ("graph", "three times too large"), ("odometry", "ten times too large"))
    figure = Figure(figsize=(8.4, 4.2))
    ax = figure.add_subplot()
    ax.axhspan(low, high, color=BAND, zorder=0, label="95 % band of one step")
    ax.axhline(degrees, color=GREY, lw=1, ls="--", label="ideal")
    for run, (source, label) in zip(runs.values(), styles, strict=True):
        style = style_of(source)
        steps = np.arange(1, len(run.nis) + 1)
        ax.semilogy(
            steps,
            run.nis,
            color=style.colour,
            marker=style.marker,
            ms=4,
            lw=1.2,
            label=f"standard deviations {label}",
        )
    ax.set(xlabel="step", ylabel=f"NIS, {degrees} degrees of freedom", ylim=(0.006, 60))
    ax.legend(fontsize=9, ncols=2)
    means = ", ".join(
        f"{run.nis.mean():.2f} with standard deviations times {factor:.0f}" for factor, run in runs.items()
    )
    return Drawing(
        figure,
        f"NIS over the steps of the log, on a logarithmic axis. Its mean is {means}; the band of a single step is "
        f"{low:.1f} to {high:.1f}.",
    )


# --- a personal robot ---


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
    """Return the errors of a student's filter on a personal robot's drives: Euclidean (m) and Mahalanobis, each (5, 6).

    They are the distances of the estimated landmarks from the true ones at the end of each drive.
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


def personal_numbers(
    world: PersonalWorld,
    init_landmarks: Function,
    predict: Function,
    update: Function,
    evaluate_landmarks: Function,
) -> dict[str, float]:
    """Return the numbers of a student's table."""
    euclidean, mahalanobis = personal_distances(world, init_landmarks, predict, update, evaluate_landmarks)
    return {
        "mean Euclidean distance (m)": float(euclidean.mean()),
        "mean Mahalanobis distance": float(mahalanobis.mean()),
    }
