"""Maps of the field from above, with paths, estimates and measurements."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Rectangle, Wedge
from matplotlib.transforms import Affine2D

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray, Pose, as_points
from nao_course.plotting.drawing import Drawing, say_place
from nao_course.plotting.ellipses import estimate_outlines, filled_outlines
from nao_course.plotting.legends import landmark_keys, legend_below, source_key
from nao_course.plotting.paths import PathLike, as_path, plot_path, plot_pose, say_path
from nao_course.plotting.style import (
    CARPET,
    GREY,
    LANDMARK_MARKERS,
    LINE,
    LINE_RIM,
    STYLES,
    YELLOW,
    Style,
    course_style,
    style_of,
)
from nao_course.sim import Field, FieldDimensions
from nao_course.slam import Estimate, Measurement, measured_points, place_estimate

if TYPE_CHECKING:
    from matplotlib.artist import Artist


def plot_field(field: Field, ax: Axes, landmarks: bool = False) -> None:
    """Draw a field from above, with lines of their true width.

    Parameters
    ----------
    field : Field
        The field, drawn at ``field.pose``.
    ax : matplotlib Axes
        Axes in metres; the limits are set to the carpet.
    landmarks : bool
        Whether to mark the corners and posts.
    """
    d = field.dimensions
    frame = _in_world(field.pose, ax)
    x0, y0, x1, y1 = field.carpet

    def add(patch: Patch, colour: str, order: float) -> None:
        patch.set(facecolor=colour, edgecolor="none", zorder=order, transform=frame)
        ax.add_patch(patch)

    def add_line(patch: Patch) -> None:
        rim = copy(patch)
        add(patch, LINE, 0.2)
        add(rim, LINE_RIM, 0.15)  # below all lines, so that it does not divide them where they meet
        rim.set(edgecolor=LINE_RIM, linewidth=1.2, antialiased=False)

    add(Rectangle((x0, y0), x1 - x0, y1 - y0), CARPET, 0.1)
    for strip in _strips(np.vstack([field.lines, field.mark_lines]), d.line_width):
        add_line(strip)
    for x, y, radius, first, last in field.arcs:
        ring = Wedge(
            (x, y), radius + d.line_width / 2, np.degrees(first), np.degrees(last), width=d.line_width
        )
        add_line(ring)
    goal = YELLOW if d.goal_colour == "yellow" else "#d9dde3"
    for bar in field.bars:
        ax.plot(bar[:, 0], bar[:, 1], color=goal, lw=3, transform=frame, zorder=0.3, solid_capstyle="butt")
    for x, y in field.posts:
        post = Circle((x, y), d.post_diameter / 2 + 0.02)
        add(post, goal, 0.4)
        post.set(edgecolor="#6d5600" if d.goal_colour == "yellow" else GREY, linewidth=0.9)
    if landmarks:
        positions = field.pose.to_parent(field.detectable_positions)
        plot_landmarks(positions, field.detectable_kinds, ax, colour=GREY, size=10)
    corners = field.pose.to_parent([(x, y) for x in (x0, x1) for y in (y0, y1)])
    metric_axes(ax, corners)


def metric_axes(ax: Axes, around: FloatArray, margin: float = 0.0) -> None:
    """Set equal scales in metres and limits that contain points (N, 2)."""
    (left, low), (right, high) = np.nanmin(around, axis=0) - margin, np.nanmax(around, axis=0) + margin
    ax.set(aspect="equal", xlim=(left, right), ylim=(low, high), xlabel="x (m)", ylabel="y (m)")
    step = 1.0 if max(right - left, high - low) > 3 else 0.5
    ax.set_xticks(np.arange(np.ceil(left / step) * step, right + 1e-9, step))
    ax.set_yticks(np.arange(np.ceil(low / step) * step, high + 1e-9, step))


def _in_world(pose: Pose, ax: Axes) -> Any:
    """Return the transform from a pose's frame to the axes."""
    return Affine2D().rotate(pose.theta).translate(pose.x, pose.y) + ax.transData


def _strips(lines: FloatArray, width: float) -> Iterator[Rectangle]:
    """Yield axis-parallel lines (N, 4) of a field as rectangles of their true width."""
    for x1, y1, x2, y2 in lines:
        low = np.minimum([x1, y1], [x2, y2]) - width / 2
        size = np.abs([x2 - x1, y2 - y1]) + width
        yield Rectangle((float(low[0]), float(low[1])), float(size[0]), float(size[1]))


def plot_landmarks(
    positions: npt.ArrayLike,
    kinds: Sequence[str],
    ax: Axes,
    colour: str = STYLES["ekf"].colour,
    size: float = 8,
) -> None:
    """Mark landmarks: a plus for a corner, a disc for a goal post, a thin cross for a crossing.

    Parameters
    ----------
    positions : array_like, shape (N, 2)
        Positions in metres.
    kinds : sequence of str
        Kind of each landmark: "corner", "post" or "cross".
    ax : matplotlib Axes
        Axes in metres.
    colour, size
        Colour, and size in points, of the markers.

    Raises
    ------
    ValueError
        If the numbers of kinds and positions differ, or a kind is unknown.
    """
    points = as_points(positions, name="positions")
    if len(kinds) != len(points):
        raise ValueError(f"{len(points)} landmarks need {len(points)} kinds, got {len(kinds)}")
    if unknown := set(kinds) - set(LANDMARK_MARKERS):
        raise ValueError(f"a landmark's kind must be one of {tuple(LANDMARK_MARKERS)}, got {sorted(unknown)}")
    for kind, marker in LANDMARK_MARKERS.items():
        chosen = points[np.array([each == kind for each in kinds], dtype=bool)] if len(points) else points
        edge = {"mec": colour} if kind == "cross" else {"mec": "white", "mew": 0.9}
        ax.plot(*chosen.T, marker, color=colour, ms=size, ls="", zorder=5, label=f"_{kind}", **edge)


def plot_measurements(measurements: Iterable[Measurement], pose: Pose, ax: Axes, source: str = "ekf") -> None:
    """Draw a robot's measurements: a thin ray to each landmark with an open marker at its end."""
    seen = list(measurements)
    ends = measured_points(seen, pose)
    colour = style_of(source).colour
    for each, (x, y) in zip(seen, ends, strict=True):
        ax.plot([pose.x, x], [pose.y, y], color=colour, lw=0.9, alpha=0.65, zorder=3.6)
        ax.plot(x, y, LANDMARK_MARKERS[each.kind], color="none", mec=colour, ms=9, mew=1.4, zorder=5.2)


def plot_estimate(
    estimate: Estimate, ax: Axes, source: str = "ekf", probability: float = 0.95, frame: Pose | None = None
) -> None:
    """Draw a SLAM algorithm's estimate: the robot and the landmarks, each with its covariance ellipse.

    Parameters
    ----------
    estimate : Estimate
        Estimate with any number of landmarks. An invalid covariance has no ellipse.
    ax : matplotlib Axes
        Axes in metres.
    source : "ekf" or "graph"
        Source whose colours are used.
    probability : float
        Probability inside each ellipse.
    frame : Pose, optional
        Pose of the map frame in the frame of the axes; by default they are equal.
    """
    style = style_of(source)
    placed = place_estimate(estimate, frame)
    ax.add_collection(filled_outlines(estimate_outlines(placed, probability), style.colour))
    plot_landmarks(placed.landmarks, placed.kinds, ax, style.colour)
    plot_pose(placed.pose, ax, source)


@course_style()
def draw_map(
    field: Field,
    truth: PathLike | None = None,
    odometry: PathLike | None = None,
    estimate: Estimate | None = None,
    measurements: Iterable[Measurement] = (),
    title: str | None = None,
    *,
    landmarks: bool = False,
    source: str = "ekf",
    frame: Pose | None = None,
    probability: float = 0.95,
) -> Drawing:
    """Draw a map of the field with true, odometry and estimated poses and measurements.

    Parameters
    ----------
    field : Field
        The field.
    truth, odometry : Pose, sequence of Pose, or array_like of shape (N, 2) or (N, 3), optional
        Paths in world coordinates (m, rad).
    estimate : Estimate, optional
        Estimate of a SLAM algorithm, in the frame `frame`.
    measurements : iterable of Measurement
        Measurements, drawn from the estimated pose, else from the last odometry pose, else from the last true pose.
    title : str, optional
        Title of the figure.
    landmarks : bool
        Whether to mark the field's corners and posts.
    source : "ekf" or "graph"
        Source whose colours the estimate has.
    frame : Pose, optional
        Pose in the world of the estimate's frame; by default they are equal. For a map that begins at zeros, give
        the robot's start: ``frame=Truth(nao).odometry_start``.
    probability : float
        Probability inside each ellipse.

    Returns
    -------
    Drawing
        The figure.

    Raises
    ------
    ValueError
        If a shape is wrong, or measurements are given without a pose to draw them from.

    Examples
    --------
    >>> draw_map(Field(), odometry=[Pose(), Pose(1.0, 0.0, 0.5)])
    Drawing('Map of the half field by the rules of 2012, x towards the goal, y to the left. \
    odometry: 2 poses from (0.00, 0.00) m, heading 0 deg to (1.00, 0.00) m, heading 29 deg.')
    """
    seen = list(measurements)
    paths = {
        name: as_path(path, name)
        for name, path in (("truth", truth), ("odometry", odometry))
        if path is not None
    }
    placed = None if estimate is None else place_estimate(estimate, frame)
    words = [f"Map of {say_field(field)}."]
    keys: list[Artist] = []
    figure = Figure(figsize=(6.4, 6.9) if field.half else (9.2, 6.6))
    ax = figure.add_subplot()
    plot_field(field, ax, landmarks)
    if landmarks:
        keys += landmark_keys(set(field.detectable_kinds), GREY, "the field's")
    for name, path in paths.items():
        plot_path(path, ax, name)
        keys.append(source_key(name))
        words.append(say_path(style_of(name).label, path))
    if placed is not None:
        style = style_of(source)
        plot_estimate(placed, ax, source, probability)
        keys += [
            source_key(source, f"{style.label}, {100 * probability:.0f} % ellipse"),
            *landmark_keys(placed.kinds, style.colour, style.label),
        ]
        words.append(_say_estimate(placed, style, probability))
    if seen:
        whose, pose = _observer(paths, placed, source)
        plot_measurements(seen, pose, ax, whose)
        words.append(
            f"{say_count(len(seen), 'measurement')} from there: {_say_kinds(each.kind for each in seen)}."
        )
        keys.append(Line2D([], [], color=style_of(whose).colour, lw=0.9, label="measurement"))
    ax.set_title(title or "")
    legend_below(figure, keys, columns=3 if field.half else 5)
    return Drawing(figure, " ".join([f"{title}.", *words] if title else words))


def _observer(paths: Mapping[str, FloatArray], placed: Estimate | None, source: str) -> tuple[str, Pose]:
    """Return the source of the measurements and the pose from which they are drawn."""
    if placed is not None:
        return source, placed.pose
    for name in ("odometry", "truth"):
        if len(path := paths.get(name, np.empty((0, 3)))) and np.isfinite(path[-1]).all():
            return name, Pose.from_array(path[-1])
    raise ValueError("measurements need a pose to be drawn from: give an estimate or a path with headings")


def _say_estimate(estimate: Estimate, style: Style, probability: float) -> str:
    sigmas = np.sqrt(np.maximum(np.diagonal(estimate.covariance)[:2], 0))
    deviations = (
        f" (standard deviations {sigmas[0]:.2f} and {sigmas[1]:.2f} m)" if np.isfinite(sigmas).all() else ""
    )
    missing = int(np.isnan(estimate_outlines(estimate, probability)).any(axis=(1, 2)).sum())
    note = f" Without an ellipse, because the covariance is invalid: {missing}." if missing else ""
    place = say_place(estimate.pose.as_array())
    return f"{style.label}: robot at {place}{deviations}; landmarks: {_say_kinds(estimate.kinds)}.{note}"


def _say_kinds(kinds: Iterable[str]) -> str:
    names = list(kinds)
    return " and ".join(say_count(names.count(kind), kind) for kind in dict.fromkeys(names)) or "none"


def say_field(field: Field) -> str:
    """Return the name of a field and the directions of its axes."""
    part = "the half field" if field.half else "the field"
    rules = "" if isinstance(field.rules, FieldDimensions) else f" by the rules of {field.rules}"
    return f"{part}{rules}, x towards the goal, y to the left"
