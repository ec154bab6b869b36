"""The same drives mapped by an EKF and by a pose graph: error, honesty and time by the length of the drive."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray, wrap_angle
from nao_course.graphs import LANDMARK, POSE, Graph
from nao_course.lessons.pose_graphs.hall import Drive, Noise, hall_drive
from nao_course.metrics import band, squared_distances
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below, source_key

RECORDED = Path(__file__).with_suffix(".json")

ITERATIONS = 6  # of Gauss-Newton from what the EKF says; after four nothing moves


class Filter(NamedTuple):
    """Lesson 07's functions."""

    predict: Callable[..., tuple[FloatArray, FloatArray]]
    update_landmarks: Callable[..., tuple[FloatArray, FloatArray]]
    add_landmark: Callable[..., tuple[FloatArray, FloatArray]]


class Smoother(NamedTuple):
    """Lesson 09's functions."""

    linearize: Callable[[Graph, FloatArray], tuple[Any, FloatArray]]
    gauss_newton: Callable[[Graph, FloatArray, int], tuple[FloatArray, FloatArray]]
    marginal_covariances: Callable[..., Sequence[FloatArray]]


class Mapped(NamedTuple):
    """What a method says of a drive: all poses (M + 1, 3), landmarks (k, 2), the last pose's covariance, seconds."""

    poses: FloatArray
    landmarks: FloatArray
    covariance: FloatArray
    seconds: float


# --- both methods ---


def run_filter(drive: Drive, ekf: Filter) -> Mapped:
    """Map a drive by the EKF: predict, update what is known, add what is new."""
    Q, R = drive.noise.control_covariance, drive.noise.measurement_covariance
    state, covariance, known = np.zeros(3), np.zeros((3, 3)), 0
    path = []
    begin = time.process_time()
    for number, (indices, measured) in enumerate(drive.looks):
        if number:
            state, covariance = ekf.predict(state, covariance, drive.controls[number - 1], Q, known)
        old = indices < known
        if old.any():
            state, covariance = ekf.update_landmarks(
                state, covariance, indices[old], measured[old].ravel(), R
            )
        for measurement in measured[~old][np.argsort(indices[~old])]:
            state, covariance = ekf.add_landmark(state, covariance, measurement, R)
        known = (len(state) - 3) // 2
        path.append(state[:3])
    seconds = time.process_time() - begin
    return Mapped(np.array(path), state[3:].reshape(-1, 2), covariance[:3, :3], seconds)


def drive_graph(drive: Drive) -> Graph:
    """The graph of a drive: an edge for each step, and one for each look at a landmark."""
    count = len(drive.poses)
    steps = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    z = np.column_stack([drive.controls[:, 0], np.zeros(count - 1), drive.controls[:, 1]])
    c, s = np.cos(z[:, 2]), np.sin(z[:, 2])
    turn = np.zeros((count - 1, 3, 3))
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = c, s, -s, c, 1.0
    covariance = (
        turn @ drive.noise.control_covariance @ turn.mT
    )  # the residual stands in the measured pose's frame
    sights = np.array([(pose, count + each) for pose, (seen, _) in enumerate(drive.looks) for each in seen])
    b, r = np.concatenate([measured for _, measured in drive.looks]).T
    c, s = np.cos(b), np.sin(b)
    slopes = np.stack([np.stack([-r * s, c], axis=-1), np.stack([r * c, s], axis=-1)], axis=-2)
    information = np.zeros((len(sights), 3, 3))
    information[:, :2, :2] = np.linalg.inv(slopes @ drive.noise.measurement_covariance @ slopes.mT)
    return Graph(
        np.concatenate([steps, sights]),
        np.concatenate([z, np.column_stack([r * c, r * s, np.zeros(len(r))])]),
        np.concatenate([np.linalg.inv(covariance), information]),
        np.repeat([POSE, LANDMARK], [count, len(drive.landmarks)]),
    )


def run_smoother(drive: Drive, smoother: Smoother, begin: Mapped) -> Mapped:
    """Map a drive by its graph, all of it at once, from what the EKF says."""
    graph = drive_graph(drive)
    states = np.concatenate([begin.poses.ravel(), begin.landmarks.ravel()])
    start = time.process_time()
    states, _ = smoother.gauss_newton(graph, states, ITERATIONS)
    seconds = time.process_time() - start
    poses, landmarks = graph.split(states)
    last = 3 * (graph.poses - 1) + np.arange(3)
    H, _ = smoother.linearize(graph, states)
    [covariance] = smoother.marginal_covariances(H[3:, 3:], [last - 3])
    return Mapped(poses, landmarks, covariance, seconds)


# --- what comes of it ---


def scores(drive: Drive, mapped: Mapped) -> dict[str, float]:
    """Errors of all poses, of the last one and of the landmarks (m, root mean square), NEES of the last, seconds."""
    error = mapped.poses[-1] - drive.poses[-1]
    error[2] = wrap_angle(error[2])
    away = {
        "path": mapped.poses[:, :2] - drive.poses[:, :2],
        "last": error[None, :2],
        "landmarks": mapped.landmarks - drive.landmarks,
    }
    found = {name: float(np.sqrt(np.mean(np.sum(each**2, axis=1)))) for name, each in away.items()}
    nees = float(squared_distances(error[None], mapped.covariance[None])[0])
    return found | {"nees": nees, "seconds": mapped.seconds}


def compare(
    ekf: Filter, smoother: Smoother, noise: Noise, steps: Sequence[int], seeds: Sequence[int]
) -> dict[str, dict[str, FloatArray]]:
    """Map the same drives by both methods.

    Parameters
    ----------
    ekf, smoother : Filter, Smoother
        The functions of lessons 07 and 09.
    noise : Noise
        Of all drives.
    steps, seeds : sequence of int
        Lengths of the drives, and their seeds.

    Returns
    -------
    dict
        "ekf" and "graph"; of each the `scores` by name, arrays of shape (lengths, seeds).
    """
    rows: dict[str, list[list[dict[str, float]]]] = {"ekf": [], "graph": []}
    for count in steps:
        drives = [hall_drive(seed, count, noise) for seed in seeds]
        filtered = [run_filter(drive, ekf) for drive in drives]
        smoothed = [
            run_smoother(drive, smoother, begin) for drive, begin in zip(drives, filtered, strict=True)
        ]
        for name, mapped in (("ekf", filtered), ("graph", smoothed)):
            rows[name].append([scores(drive, each) for drive, each in zip(drives, mapped, strict=True)])
    return {
        name: {score: np.array([[each[score] for each in row] for row in table]) for score in table[0][0]}
        for name, table in rows.items()
    }


def at_every_stop(drive: Drive, smoother: Smoother, begin: Mapped) -> float:
    """Seconds of a graph that is solved anew at each stop, one iteration from what was known before."""
    graph, seconds = drive_graph(drive), 0.0
    known = np.maximum.accumulate([max(seen, default=-1) + 1 for seen, _ in drive.looks])
    for poses in range(2, graph.poses + 1):
        landmarks = int(known[poses - 1])
        shift = np.where(graph.edges >= graph.poses, graph.poses - poses, 0)
        kept = (graph.edges < poses).any(axis=1) & ((graph.edges < poses) | (shift > 0)).all(axis=1)
        part = Graph(
            (graph.edges - shift)[kept],
            graph.measurements[kept],
            graph.information[kept],
            np.repeat([POSE, LANDMARK], [poses, landmarks]),
        )
        states = np.concatenate([begin.poses[:poses].ravel(), begin.landmarks[:landmarks].ravel()])
        start = time.process_time()
        smoother.gauss_newton(part, states, 1)
        seconds += time.process_time() - start
    return seconds


# --- the figure ---


def draw_ekf_and_graph(recorded: Mapping[str, Any] | None = None) -> Drawing:
    """Draw error, NEES and time of both methods by the length of the drive.

    Parameters
    ----------
    recorded : mapping, optional
        What ``python -m benchmarks ekf_and_graph`` measured; without it, the course's own record.

    Returns
    -------
    Drawing
        Three plots.
    """
    recorded = recorded or json.loads(RECORDED.read_text(encoding="utf-8"))
    steps, runs = recorded["steps"], recorded["runs"]
    words = []
    with course_style():
        figure = Figure(figsize=(12.0, 4.2))
        error, nees, seconds = figure.subplots(1, 3)
        for name, rows in recorded["methods"].items():
            look = STYLES[name]
            options: dict[str, Any] = {"color": look.colour, "marker": look.marker, "lw": 2, "ms": 6}
            error.plot(steps, rows["path"], **options)
            nees.plot(steps, rows["nees"], **options)
            seconds.plot(steps, rows["seconds"], **options)
            words.append(
                f"{look.label} after {steps[-1]} steps: {rows['path'][-1]:.1f} m, NEES {rows['nees'][-1]:.1f}, "
                f"{rows['seconds'][-1]:.2g} s"
            )
        _plot_band(nees, runs)
        every = recorded["graph_at_every_stop"]
        seconds.plot(
            steps,
            every,
            color=STYLES["graph"].colour,
            lw=1.3,
            ls=":",
            marker=STYLES["graph"].marker,
            mfc="white",
        )
        seconds.annotate(
            "solved anew at every stop",
            (steps[-1], every[-1]),
            ha="right",
            xytext=(0, 7),
            textcoords="offset points",
            fontsize=9,
        )
        error.set(ylabel="error of the whole path (m)")
        nees.set(ylabel="NEES of the last pose, mean")
        seconds.set(ylabel="seconds for the drive")
        for ax in (error, nees, seconds):
            ax.set(xscale="log", yscale="log", xlabel="steps of a metre")
            ax.set_xticks(steps, [str(count) for count in steps], minor=False)
            ax.minorticks_off()
            ax.grid(color="#e3e5e8")
        legend_below(figure, [source_key(name) for name in recorded["methods"]])
    return Drawing(figure, f"EKF and graph on the same {runs} drives of each length. {'; '.join(words)}.")


def _plot_band(ax: Axes, runs: int) -> None:
    """Between what the mean NEES of an honest pose lies."""
    low, high = band(3, runs)
    ax.axhspan(low, high, color="#b5d1ac", alpha=0.7, lw=0)
    ax.annotate(
        "honest: 95 %", (1, high), xycoords=("axes fraction", "data"), ha="right", va="bottom", fontsize=9
    )
