"""The drive that runs through lesson 11: by odometry alone, then with each of the student's functions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, assert_never

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.challenges.beliefs import odometry_belief
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.slam_on_the_field.associating import BAD, GOOD, Associate, follow
from nao_course.lessons.slam_on_the_field.gates import watch
from nao_course.lessons.slam_on_the_field.worlds import FIELD, KINDS, LANDMARKS, DrawnDrive, drawn_drive
from nao_course.plotting import Drawing, course_style, plot_ellipse, plot_estimate, plot_field, plot_path
from nao_course.plotting.legends import legend_below, source_key
from nao_course.slam import measured_points

SEED, MOVES, COMPASS_SIGMA = 13, 15, float(np.radians(0.7))
GATE = 4.0
MAP_SIGMA = 0.01  # m: of the true landmarks that odometry's measurements are compared with
START_SIGMA = 1e-4  # m and rad


@dataclass(frozen=True, eq=False)
class Panel:
    """One version of the drive.

    `path` (S, 3) has the estimated pose at each picture and is empty where a method is still missing. `plot` draws what
    else there is into an Axes, and `said` is the result in words.
    """

    title: str
    path: FloatArray
    plot: Callable[[Axes], None]
    said: str


@cache
def the_drive() -> DrawnDrive:
    """Return the drive."""
    return drawn_drive(SEED, MOVES, compass_sigma=COMPASS_SIGMA)


@course_style()
def draw_one_drive(
    associate: Associate | None = None,
    EkfSlam: Callable[..., Any] | None = None,  # noqa: N803 - the students' names
    GraphSlam: Callable[..., Any] | None = None,  # noqa: N803
) -> Drawing:
    """Draw the lesson's drive, one panel for each function that is there.

    Parameters
    ----------
    associate : callable, optional
        Without the classes: it chooses landmarks of the true map, from odometry's pose and covariance.
    EkfSlam : type, optional
        It estimates path and map. Where a method is not written yet, its panel says so.
    GraphSlam : type, optional
        It is drawn beside EkfSlam.
    """
    panels = list(_panels(associate, EkfSlam, GraphSlam))
    # Three panels are so wide that titles, fields and legend need more height than four narrow ones.
    figure = Figure(figsize=(10.4 if len(panels) > 1 else 5.2, 5.3 if len(panels) == 3 else 4.6))
    for number, panel in enumerate(panels, start=1):
        ax = figure.add_subplot(1, len(panels), number)
        plot_field(FIELD, ax)
        if len(panel.path):
            plot_path(the_drive().poses, ax)
        panel.plot(ax)
        ax.set_title(f"{panel.title}\n{panel.said}", fontsize=9.5)
        x0, y0, x1, y1 = FIELD.carpet
        ax.set(xlim=(x0, x1), ylim=(y0, y1))
        if number > 1:
            ax.set_ylabel("")
    legend_below(
        figure, _keys(EkfSlam is not None, GraphSlam is not None), columns=4 if len(panels) > 1 else 2
    )
    said = "; ".join(f"{panel.title}: {panel.said}" for panel in panels).replace("\n", " ")
    return Drawing(figure, f"One drive of {MOVES} moves over the half field. {said}.")


def _keys(ekf: bool, graph: bool) -> list[Any]:
    keys = [source_key("truth", "true path")]
    if ekf or graph:
        keys += [source_key("ekf", "EKF, 95 %")] if ekf else []
        return keys + ([source_key("graph", "graph, 95 %")] if graph else [])
    lines = (("matched with its own landmark", GOOD), ("matched with a wrong one", BAD))
    return [
        *keys,
        source_key("odometry"),
        *(Line2D([], [], color=colour, lw=2, label=name) for name, colour in lines),
    ]


def _panels(associate: Any, ekf: Any, graph: Any) -> Iterator[Panel]:
    """Make the panels for the functions that exist."""
    if ekf is None:
        yield _by_odometry("nearest in metres", _nearest_in_metres)
        if associate is not None:
            yield _by_odometry("your associate", _by_covariance(associate))
            yield _by_odometry("joint compatibility", _by_covariance(associate_jointly))
    elif graph is None:
        yield _in_part(ekf, "move", compass=False)
        yield _in_part(ekf, "move, use_compass", compass=True)
        yield _whole(ekf, "your EkfSlam", "ekf", None)
        yield _whole(ekf, "your EkfSlam, jointly", "ekf", associate_jointly)
    else:
        yield _whole(ekf, "your EkfSlam, jointly", "ekf", associate_jointly)
        yield _whole(graph, "your GraphSlam, jointly", "graph", associate_jointly)


# --- odometry beside the true map ---


def _nearest_in_metres(pose: FloatArray, covariance: FloatArray, seen: Any) -> FloatArray:
    """Choose the landmark of the same kind that is nearest to where odometry's pose puts the measurement."""
    places = measured_points(seen, Pose.from_array(pose))
    away = [np.hypot(LANDMARKS[:, 0] - x, LANDMARKS[:, 1] - y) for x, y in places]
    other_kind = np.array([each.kind for each in seen])[:, None] != np.array(KINDS)
    return np.asarray(np.where(other_kind, np.inf, away).argmin(axis=1))


def _by_covariance(associate: Associate) -> Callable[..., Any]:
    """Choose by a function of the state, its covariance, and a gate."""

    def choose(pose: FloatArray, covariance: FloatArray, seen: Any) -> Any:
        whole = MAP_SIGMA**2 * np.eye(3 + LANDMARKS.size)
        whole[:3, :3] = covariance
        state = np.concatenate([pose, LANDMARKS.ravel()])
        return associate(state, whole, list(KINDS), seen, seen.covariance.copy(), GATE)

    return choose


@cache
def _odometry() -> list[tuple[FloatArray, FloatArray]]:
    """Return the pose and covariance of odometry at each picture of the drive."""
    drive, motions, found = the_drive(), list[Any](), []
    belief = drive.start.as_array(), START_SIGMA**2 * np.eye(3)
    for motion, _ in drive.log:
        if motion is not None:
            motions.append(motion)
            belief = odometry_belief(
                drive.start, motions, [OdometryNoisePerMove().covariance(m) for m in motions]
            )
        found.append(belief)
    return found


def _by_odometry(title: str, choose: Callable[..., Any]) -> Panel:
    """Match each measurement with a landmark of the true map."""
    drive, right, ends = the_drive(), [], []
    for (pose, covariance), (_, seen), origins in zip(_odometry(), drive.log, drive.origins, strict=True):
        if not len(seen):
            continue
        indices = np.asarray(choose(pose, covariance, seen), dtype=int)
        if indices.shape != (len(seen),):
            raise ValueError(f"{len(seen)} measurements need as many numbers, got shape {indices.shape}")
        right += (indices == np.array(origins)).tolist()
        ends += [
            (place, LANDMARKS[index] if index >= 0 else None)
            for place, index in zip(measured_points(seen, Pose.from_array(pose)), indices, strict=True)
        ]
    path = np.array([pose for pose, _ in _odometry()])

    def plot(ax: Axes) -> None:
        plot_path(path, ax, "odometry")
        for is_right, (place, landmark) in zip(right, ends, strict=True):
            if landmark is not None:
                colour, width = (GOOD, 0.8) if is_right else (BAD, 1.6)
                ax.plot(*np.column_stack([place, landmark]), color=colour, lw=width, alpha=0.8, zorder=4.5)

    off = 100 * float(np.hypot(*(path[-1] - drive.poses[-1])[:2]))
    wrong = len(right) - sum(right)
    return Panel(title, path, plot, f"{wrong} of {len(right)} wrong, off by {off:.0f} cm")


# --- the student's classes ---


def _in_part(slam_class: Callable[..., Any], title: str, compass: bool) -> Panel:
    """Let an EkfSlam use its motions, and perhaps its compass, but no landmark."""
    drive = the_drive()
    try:
        slam = slam_class(drive.start, OdometryNoisePerMove(), GATE)
        path = []
        for motion, seen in drive.log:
            if motion is not None:
                slam.move(motion)
            if compass:
                slam.use_compass(seen.direction, seen.direction_sigma)
            path.append(np.array(slam.state[:3], dtype=float))
    except NotImplementedError:
        return _missing(title)
    found, covariance = np.array(path), np.array(slam.covariance)[:2, :2]

    def plot(ax: Axes) -> None:
        plot_path(found[:, :2], ax, "ekf", robot=False)
        plot_ellipse(found[-1, :2], covariance, ax, "ekf")

    off = 100 * float(np.hypot(*(found[-1] - drive.poses[-1])[:2]))
    return Panel(title, found, plot, f"off by {off:.0f} cm")


def _whole(
    slam_class: Callable[..., Any], title: str, source: Literal["ekf", "graph"], match: Associate | None
) -> Panel:
    """Run a whole class over the drive."""
    drive, fates = the_drive(), dict[str, int]()
    try:
        if source == "ekf":
            watched = watch(slam_class, drive, GATE, match)
            outcome, fates = watched.outcome, dict(watched.fates)
        elif source == "graph":
            outcome = follow(slam_class, drive, GATE, match)
        else:
            assert_never(source)
    except NotImplementedError:
        return _missing(title)

    def plot(ax: Axes) -> None:
        plot_path(outcome.path[:, :2], ax, source, robot=False)
        plot_estimate(outcome.estimate, ax, source)

    wrong = sum(count for fate, count in fates.items() if fate != "right")
    counted = f"{wrong} of {sum(fates.values())} wrong or unused,\n" if fates else ""
    return Panel(title, outcome.path, plot, f"{counted}off by {100 * outcome.off:.0f} cm")


def _missing(title: str) -> Panel:
    """Return a panel for what is not written yet."""

    def plot(ax: Axes) -> None:
        ax.text(0.5, 0.5, "not written yet", transform=ax.transAxes, ha="center", fontsize=11)

    return Panel(title, np.zeros((0, 3)), plot, "not written yet")
