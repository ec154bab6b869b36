"""The map that the student's filter makes of a log of the MRCLAM data set, which is not part of the course."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from nao_course.datasets import MrclamLog, read_mrclam_log
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.ekf_slam.homework_log import innovation_and_covariance
from nao_course.plotting import STYLES, Drawing, course_style, plot_ellipse
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.maps import metric_axes
from nao_course.sim.drives import Function, NamedEkf, checked_functions, landmark_blocks

# Assumed noise: of a motion in parts of the distance and of the turn, and of a measurement in rad and m.
ALONG, ACROSS, TURN = 0.1, 0.05, 0.2
LEAST = 0.01  # m and rad: standard deviations of a motion of any length
MEASUREMENT = np.diag([0.04, 0.12]) ** 2
LONGEST_STEP = 0.5  # s

WHERE = "asrl.utias.utoronto.ca/datasets/mrclam"


@course_style()
def draw_mrclam(
    folder: Path | str,
    predict: Function,
    update_landmarks: Function,
    add_landmark: Function,
    *,
    robot: int = 1,
    minutes: float = 10.0,
) -> Drawing:
    """Draw the map that a student's filter makes of a robot's log in a folder of the MRCLAM data set.

    Parameters
    ----------
    folder : path
        Unpacked folder, such as MRCLAM_Dataset3.
    predict, update_landmarks, add_landmark : callable
        The student's functions.
    robot : int
        Number of the robot, 1 to 5.
    minutes : float
        Length of the part of the log that is used, from its beginning.

    Returns
    -------
    Drawing
        The map with 95 % ellipses, over the true path and landmarks.

    Raises
    ------
    FileNotFoundError
        If there is no such folder. The message says where to get it.
    ValueError
        If a file in the folder is malformed, or if nothing is measured in this time.
    """
    if not Path(folder).is_dir():
        raise FileNotFoundError(
            f"There is no folder {folder} here. The course does not contain this data set: download it from {WHERE} "
            "and unpack it beside this notebook."
        )
    log = read_mrclam_log(folder, robot)
    begin = log.odometry[0, 0]
    start = Pose.from_array(log.truth[np.argmin(np.abs(log.truth[:, 0] - begin)), 1:])
    slam = NamedEkf(start, *checked_functions((predict, update_landmarks, add_landmark)))
    path, squares, count = [slam.state[:2]], 0.0, 0
    for steps, rows in _pictures(log, begin + 60 * minutes):
        for duration, control in steps:
            slam.move(control, _motion_noise(control, duration))
        numbers, measured = log.indices[rows], log.measurements[rows]
        again, slots = slam.on_map(numbers)
        if again:
            innovation, S = innovation_and_covariance(
                slam.state, slam.covariance, slots, measured[again].ravel(), MEASUREMENT
            )
            squares, count = (
                squares + float(innovation @ np.linalg.solve(S, innovation)),
                count + len(innovation),
            )
        slam.observe(numbers, measured, np.tile(MEASUREMENT, (len(rows), 1, 1)))
        path.append(slam.state[:2])
    if not slam.known:
        raise ValueError(f"{folder}: robot {robot} measures no landmark in the first {minutes:g} minutes")
    return _map(log, slam, np.array(path), squares / max(count, 1), begin + 60 * minutes)


def _pictures(
    log: MrclamLog, end: float
) -> Iterator[tuple[list[tuple[float, FloatArray]], npt.NDArray[np.intp]]]:
    """Yield the motions before each picture, as durations and controls, and the rows of its measurements.

    `predict` drives straight and then turns, so the robot drives each step along its heading in the middle of the step.
    A landmark that is measured several times at one time is used once.
    """
    times, speeds, turns = log.odometry.T
    duration = np.append(np.diff(times), 0.0)
    driven = np.append(0.0, np.cumsum(speeds * duration)[:-1])
    turned = np.append(0.0, np.cumsum(turns * duration)[:-1])
    last = times[0]
    for now in np.unique(log.times[(log.times >= times[0]) & (log.times <= end)]):
        rows = np.flatnonzero(log.times == now)
        rows = rows[np.sort(np.unique(log.indices[rows], return_index=True)[1])]
        knots = np.linspace(last, now, 1 + max(1, int(np.ceil((now - last) / LONGEST_STEP))))
        middles = np.concatenate([[last], (knots[:-1] + knots[1:]) / 2, [now]])
        straight = np.append(0.0, np.diff(np.interp(knots, times, driven)))
        controls = np.column_stack([straight, np.diff(np.interp(middles, times, turned))])
        yield list(zip(np.diff(middles).tolist(), controls, strict=True)), rows
        last = now


def _motion_noise(control: FloatArray, duration: float) -> FloatArray:
    """Return the covariance (3, 3) of the errors of a motion (distance, turn) along, across and in the turn."""
    distance, turn = np.abs(control)
    least = LEAST * np.sqrt(duration)
    return np.diag(np.hypot([ALONG * distance, ACROSS * distance, TURN * turn], least)) ** 2


def _map(log: MrclamLog, slam: NamedEkf, path: FloatArray, nis: float, end: float) -> Drawing:
    places, true = slam.state[3:].reshape(-1, 2), log.landmarks[slam.known]
    off = np.hypot(*(places - true).T)
    figure = Figure(figsize=(6.4, 6.4))
    ax = figure.subplots()
    truth = log.truth[log.truth[:, 0] <= end, 1:3]
    ax.plot(*truth.T, color=STYLES["truth"].colour, lw=1, alpha=0.5)
    ax.plot(*log.landmarks.T, "o", mfc="none", mec=STYLES["truth"].colour, ms=9)
    ax.plot(*path.T, color=STYLES["ekf"].colour, lw=0.8)
    for place, block in zip(places, landmark_blocks(slam.covariance), strict=True):
        plot_ellipse(place, block, ax, "ekf")
    ax.plot(*places.T, "+", color=STYLES["ekf"].colour, ms=8, mew=1.5, zorder=6)
    metric_axes(ax, np.concatenate([truth, log.landmarks, path, places]), 0.5)
    said = f"{len(places)} landmarks: median error {100 * np.median(off):.0f} cm, largest {100 * off.max():.0f} cm"
    ax.set_title(f"{said}\nNIS per degree of freedom: {nis:.2f}")
    keys = [source_key("ekf", "estimated path and landmarks, 95 %"), source_key("truth", "truth")]
    legend_below(figure, keys)
    return Drawing(
        figure,
        f"The map of a log of the MRCLAM data set over the true landmarks. {said}; the NIS per degree of freedom is "
        f"{nis:.2f}.",
    )
