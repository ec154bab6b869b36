"""Figures of lesson 00: frames and angles, the views of both cameras, and their resolution on the ground."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Arc, Circle, Ellipse, FancyArrowPatch, Patch, Rectangle, Wedge

from nao_course.datasets import real_walk, recorded_walk
from nao_course.geometry import FloatArray, Pose
from nao_course.plotting.drawing import Drawing, say_angle
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.maps import plot_field, say_field
from nao_course.plotting.paths import plot_path, plot_pose
from nao_course.plotting.pictures import plot_picture
from nao_course.plotting.style import CARPET, STYLES, course_style
from nao_course.sim import NAO_V4, CameraView, Field, SimulatedNao


def _inside(view: CameraView, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the distance in pixels of ground points from the picture's border, negative outside of the picture."""
    pixels = view.project(np.column_stack([x.ravel(), y.ravel()]))
    width, height = view.size
    sides = [pixels[:, 0] + 0.5, width - 0.5 - pixels[:, 0], pixels[:, 1] + 0.5, height - 0.5 - pixels[:, 1]]
    inside: FloatArray = np.clip(np.nan_to_num(np.min(sides, axis=0), nan=-50.0), -50, 50)
    return inside.reshape(x.shape)


_CAMERA_COLOURS = {"top": "#0b5fa5", "bottom": "#c84b00"}


def plot_footprint(
    view: CameraView, ax: Axes, colour: str = STYLES["ekf"].colour, reach: float = 6.0
) -> None:
    """Draw the part of the ground that a camera sees, up to `reach` metres away.

    The figure shows the robot frame from above. Straight ahead is up, so the horizontal axis is y and points left.
    """
    x, y = np.meshgrid(np.linspace(-1.0, reach, 281), np.linspace(-reach, reach, 321))
    values = np.minimum(_inside(view, x, y), (reach - np.hypot(x, y)) * 100)
    if (values > 0).any():
        ax.contourf(y, x, values, levels=[0, 1e9], colors=[colour], alpha=0.22, zorder=2)
        ax.contour(y, x, values, levels=[0], colors=[colour], linewidths=1.6, zorder=3)


@course_style()
def draw_cameras(nao: SimulatedNao) -> Drawing:
    """Draw the pictures of both cameras and the part of the ground that each of them sees.

    Parameters
    ----------
    nao : SimulatedNao
        Robot that takes a picture with each camera, which uses its random numbers.

    Returns
    -------
    Drawing
        The figure.
    """
    pictures = {camera: nao.take_picture(camera) for camera in ("top", "bottom")}
    reach = 4.0
    figure = Figure(figsize=(9.8, 6.2))
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.32))
    for row, (camera, picture) in enumerate(pictures.items()):
        ax = figure.add_subplot(grid[row, 0])
        plot_picture(picture, ax, ticks=False)
        ax.set_title(f"{camera} camera", fontsize=11, color=_CAMERA_COLOURS[camera])
        for spine in ax.spines.values():
            spine.set(visible=True, color=_CAMERA_COLOURS[camera], linewidth=2.5)
    ax = figure.add_subplot(grid[:, 1])
    for radius in range(1, int(reach) + 1):
        ax.add_patch(Circle((0, 0), radius, fill=False, color="#d5d8dc", lw=0.9, zorder=1))
    for camera, picture in pictures.items():
        plot_footprint(picture.view, ax, _CAMERA_COLOURS[camera], reach)
    ax.plot(0, 0, "o", color="#1a1a1a", ms=9, zorder=5)
    ax.plot([0, 0], [0, 0.3], color="#1a1a1a", lw=2.4, zorder=5)
    ax.annotate("robot", (0, 0), (8, -12), textcoords="offset points")
    ax.set(
        aspect="equal",
        xlim=(2.6, -2.6),
        ylim=(-0.6, reach + 0.1),
        xlabel="y (m), left is positive",
        ylabel="x ahead (m)",
    )
    ax.set_title(f"the ground they see, up to {reach:.0f} m", fontsize=11)
    keys = [
        Patch(facecolor=colour, alpha=0.5, label=f"{camera} camera")
        for camera, colour in _CAMERA_COLOURS.items()
    ]
    legend_below(figure, keys)
    yaw, pitch = nao.head
    words = [
        f"Both cameras with the head at yaw {say_angle(yaw)}, pitch {say_angle(pitch)} (positive is down)."
    ]
    words += [say_footprint(camera, picture.view) for camera, picture in pictures.items()]
    return Drawing(figure, " ".join(words), photo=True)


def say_footprint(camera: str, view: CameraView) -> str:
    """Return the part of the ground that a camera sees along its direction, in words."""
    if (ground := view.visible_ground()) is None:
        return f"The {camera} camera sees no ground."
    near, end = ground
    far = "the horizon" if np.isinf(end) else f"{end:.1f} m"
    yaw = np.degrees(view.yaw)
    where = " ahead" if abs(yaw) < 0.5 else f", {abs(yaw):.0f}° to the {'left' if yaw > 0 else 'right'}"
    return f"The {camera} camera sees the ground from {near:.1f} m to {far}{where}."


@course_style()
def draw_ground_steps(view: CameraView, title: str | None = None) -> Drawing:
    """Draw the number of pixels that 10 cm on the ground cover, over the distance straight ahead.

    Parameters
    ----------
    view : CameraView
        View of a camera with yaw 0. The curve is drawn where the camera sees the ground.
    title : str, optional
        Title of the figure.

    Returns
    -------
    Drawing
        The figure; its text gives the numbers for 1, 2 and 3 m.
    """
    ahead = np.arange(0.3, 4.01, 0.05)
    near, far = (view.project(np.column_stack([ahead + more, 0 * ahead])) for more in (0.0, 0.1))
    steps = near[:, 1] - far[:, 1]
    seen = view.contains(near) & view.contains(far)
    figure = Figure(figsize=(7.4, 3.6))
    ax = figure.add_subplot()
    ax.plot(ahead[seen], steps[seen], color=_CAMERA_COLOURS["bottom"], lw=2)
    for distance in (1.0, 2.0, 3.0):
        height = float(np.interp(distance, ahead, steps))
        ax.plot(distance, height, "o", color=_CAMERA_COLOURS["bottom"], ms=7, mec="white")
        ax.annotate(f"{height:.1f}", (distance, height), (6, 6), textcoords="offset points")
    ax.set(xlabel="distance straight ahead (m)", ylabel="pixels for 10 cm", ylim=0)
    ax.grid(color="#e3e5e8")
    ax.set_title(title or "")
    at = ", ".join(f"{np.interp(each, ahead, steps):.1f} at {each:.0f} m" for each in (1, 2, 3))
    return Drawing(
        figure, f"{title or 'Ground and pixels'}. 10 cm on the ground cover this number of pixels: {at}."
    )


@course_style()
def draw_real_posts() -> Drawing:
    """Draw where a real NAO was put down on its walk, and where its measurements place the posts of the goal."""
    walk, posts = recorded_walk(), real_walk.measured_posts()
    true = walk.landmarks[-2:][(posts[:, 1] > 0).astype(int)]
    figure = Figure(figsize=(7.4, 4.4))
    ax = figure.add_subplot()
    plot_field(real_walk.FIELD, ax)
    plot_path([step.pose for step in walk.steps if len(step.numbers)], ax)
    ax.plot(*posts.T, "o", mfc="none", mec=STYLES["ekf"].colour, ms=7, mew=1.2, zorder=5)
    measured = Line2D(
        [], [], color=STYLES["ekf"].colour, marker="o", mfc="none", ls="", label="measured post"
    )
    legend_below(figure, [source_key("truth", "where it was put down"), measured])
    ax.set_ylim(-1.8, 1.8)
    off = posts - true
    return Drawing(
        figure,
        f"A real NAO's {len(posts)} measurements of the posts of a goal, on the map. Along the walk they are "
        f"{off[:, 0].min():.2f} to {off[:, 0].max():.2f} m off, and across it {np.abs(off[:, 1]).max():.2f} m at most.",
    )


def _arrow(
    ax: Axes, start: npt.ArrayLike, end: npt.ArrayLike, colour: str, width: float = 2.2, line: Any = "-"
) -> None:
    """Draw an arrow between two points of the axis."""
    ax.add_patch(
        FancyArrowPatch(
            tuple(np.asarray(start, dtype=float)),
            tuple(np.asarray(end, dtype=float)),
            arrowstyle="-|>",
            mutation_scale=14,
            shrinkA=0,
            shrinkB=0,
            color=colour,
            lw=width,
            ls=line,
            zorder=5,
        )
    )


def _angle(
    ax: Axes, at: npt.ArrayLike, first: float, last: float, radius: float, colour: str, label: str
) -> None:
    """Draw an arc from one direction to another (rad, in the frame of the axis), with its name beside its midpoint."""
    x, y = np.asarray(at, dtype=float)
    low, high = np.degrees(sorted((first, last)))
    ax.add_patch(Arc((x, y), 2 * radius, 2 * radius, theta1=low, theta2=high, color=colour, lw=2, zorder=5))
    end, back = last, last - np.sign(last - first) * 0.12
    tip, tail = ((x + radius * np.cos(a), y + radius * np.sin(a)) for a in (end, back))
    _arrow(ax, tail, tip, colour, 1.0)
    middle = (first + last) / 2
    _name(ax, (x + radius * 1.12 * np.cos(middle), y + radius * 1.12 * np.sin(middle)), label, colour)


def _name(ax: Axes, at: npt.ArrayLike, label: str, colour: str, **options: Any) -> None:
    x, y = np.asarray(at, dtype=float)
    ax.text(x, y, label, color=colour, zorder=8, path_effects=HALO, **({"va": "center"} | options))


_FIELD_FRAME, _ROBOT_FRAME, _MEASURED = "#1a1a1a", "#0b5fa5", "#a14566"


@course_style()
def draw_frames(field: Field | None = None, title: str | None = None) -> Drawing:
    """Draw the course's frames and angles: field, robot, bearing and range, head yaw and pitch.

    Parameters
    ----------
    field : Field, optional
        Field, of which one half is drawn. The default is the field of 2012.
    title : str, optional
        Title of the figure.

    Returns
    -------
    Drawing
        The figure; its text explains the frames and angles.
    """
    field = Field(2012 if field is None else field.rules)
    figure = Figure(figsize=(10.2, 6.4))
    grid = figure.add_gridspec(2, 2, width_ratios=(1.18, 1.0))
    landmark = _frames_on_field(figure.add_subplot(grid[:, 0]), field)
    _head_from_above(figure.add_subplot(grid[0, 1]))
    _head_from_the_side(figure.add_subplot(grid[1, 1]))
    if title:
        figure.suptitle(title, fontweight="bold", fontsize=12, x=0.01, ha="left")
    words = (
        f"The frames of the course on {say_field(field)}, seen from above. The field frame's x axis points to "
        "the goal, its y axis to the left; the robot's x axis points ahead and its y axis to its left, rotated by "
        f"the heading theta relative to the field frame. A {landmark} is measured by its range, the distance over the "
        "ground, and its bearing, the angle from straight ahead, positive to the left. The head's yaw is "
        "positive to the left, its pitch positive downwards from the horizon."
    )
    return Drawing(figure, f"{title}. {words}" if title else words)


def _frames_on_field(ax: Axes, field: Field) -> str:
    """Draw field frame, robot frame and one measurement, and return the measurement in words."""
    d = field.dimensions
    plot_field(field, ax)
    ax.set_title("on the field, from above", fontsize=11)
    unit = 0.8 * d.length / 6
    for axis, label, where in (((unit, 0), "x", (0, -9)), ((0, unit), "y", (-11, 0))):
        _arrow(ax, (0, 0), axis, _FIELD_FRAME)
        ax.annotate(
            label, axis, where, textcoords="offset points", ha="center", va="center", color=_FIELD_FRAME
        )
    _name(ax, (-0.05, -0.2), "field frame", _FIELD_FRAME, ha="left", va="top")
    robot = Pose(0.14 * d.length, -0.33 * d.width, np.radians(18))
    corners = [mark for mark in field.detectable if mark.shape == "L" and mark.x > 0 and mark.y > 0]
    target = min(corners, key=lambda corner: corner.x)
    local = robot.to_local([target.x, target.y])[0]
    bearing, distance = float(np.arctan2(local[1], local[0])), float(np.hypot(*local))
    ahead, left = robot.to_parent([[1.7 * unit, 0], [0, unit]])
    ax.plot(
        [robot.x, robot.x + 1.65 * unit],
        [robot.y, robot.y],
        color=_FIELD_FRAME,
        lw=1,
        ls=(0, (4, 3)),
        zorder=4,
    )
    ax.plot([robot.x, target.x], [robot.y, target.y], color=_MEASURED, lw=1.8, ls=(0, (1.5, 1.5)), zorder=4)
    ax.plot(target.x, target.y, "s", color="none", mec=_MEASURED, ms=13, mew=2.2, zorder=6)
    for end, label in ((ahead, "x"), (left, "y")):
        _arrow(ax, (robot.x, robot.y), end, _ROBOT_FRAME)
        outwards = end + 0.14 * unit * (end - (robot.x, robot.y)) / np.hypot(*(end - (robot.x, robot.y)))
        _name(ax, outwards, label, _ROBOT_FRAME, ha="center")
    plot_pose(robot, ax, "ekf", length=0.05)
    _name(ax, (robot.x, robot.y - 0.2), "robot frame", _ROBOT_FRAME, ha="center", va="top")
    _angle(ax, (robot.x, robot.y), 0.0, robot.theta, 1.4 * unit, _FIELD_FRAME, r" heading $\theta$")
    _angle(
        ax, (robot.x, robot.y), robot.theta, robot.theta + bearing, 1.2 * unit, _MEASURED, r" bearing $\beta$"
    )
    middle = robot.to_parent(0.62 * local)[0]
    _name(ax, middle + (-0.1, 0.05), "range $r$", _MEASURED, ha="right")
    _name(ax, (target.x - 0.12, target.y + 0.24), "landmark", _MEASURED, ha="center")
    return f"corner at bearing {say_angle(bearing)} and range {distance:.1f} m"


def _bare(ax: Axes, title: str, x: tuple[float, float], y: tuple[float, float]) -> None:
    ax.set_title(title, fontsize=11)
    ax.set(aspect="equal", xlim=x, ylim=y)
    ax.set_axis_off()


def _head_from_above(ax: Axes) -> None:
    """Draw the yaw of the head from above, with straight ahead to the right."""
    _bare(ax, "head yaw, from above", (-0.45, 2.0), (-0.5, 1.15))
    yaw, half = np.radians(32), NAO_V4.hfov / 2
    ax.add_patch(
        Wedge((0, 0), 1.12, *np.degrees([yaw - half, yaw + half]), color=_MEASURED, alpha=0.14, lw=0)
    )
    ax.add_patch(Ellipse((0, 0), 0.24, 0.62, color="#c9ced6", zorder=2))
    ax.add_patch(Circle((0, 0), 0.14, color="#8b94a3", zorder=3))
    _arrow(ax, (0, 0), (1.2, 0), _ROBOT_FRAME)
    _name(ax, (1.25, 0), "x: straight ahead", _ROBOT_FRAME)
    direction = np.array([np.cos(yaw), np.sin(yaw)])
    _arrow(ax, (0, 0), 1.2 * direction, _MEASURED)
    _name(ax, 1.26 * direction, "camera", _MEASURED)
    _angle(ax, (0, 0), 0.0, yaw, 0.62, _MEASURED, "  yaw: positive left")


def _head_from_the_side(ax: Axes) -> None:
    """Draw the pitch of the camera from the side, with straight ahead to the right and heights to scale."""
    height, pitch = NAO_V4.view("top").height, np.radians(20)
    _bare(ax, "pitch, from the side", (-0.35, 1.65), (-0.16, 0.78))
    ax.fill_between([-0.3, 1.6], -0.05, 0, color=CARPET, lw=0)
    for corner, width, tall in (
        ((-0.05, 0), 0.15, 0.05),
        ((-0.03, 0.04), 0.07, 0.2),
        ((-0.06, 0.2), 0.13, 0.22),
    ):
        ax.add_patch(Rectangle(corner, width, tall, color="#c9ced6", zorder=2))
    ax.add_patch(Ellipse((0.0, 0.5), 0.17, 0.15, color="#8b94a3", zorder=3))
    eye = np.array([0.06, height])
    ax.plot([eye[0], 1.3], [height, height], color=_FIELD_FRAME, lw=1, ls=(0, (4, 3)))
    _name(ax, (1.3, height + 0.05), "horizon", _FIELD_FRAME, ha="right")
    reach = height / np.tan(pitch)
    ax.plot([eye[0], eye[0] + reach], [height, 0], color=_MEASURED, lw=1.2, ls=(0, (1.5, 1.5)))
    axis = np.array([np.cos(pitch), -np.sin(pitch)])
    _arrow(ax, eye, eye + 0.85 * axis, _MEASURED)
    _name(ax, eye + 0.86 * axis + (0.02, 0.06), "camera", _MEASURED, ha="left")
    _angle(ax, eye, 0.0, -pitch, 0.45, _MEASURED, " pitch: positive down")
    _arrow(ax, (-0.2, 0.0), (-0.2, height), _ROBOT_FRAME, 1.4)
    ax.plot([-0.22, eye[0]], [height, height], color=_ROBOT_FRAME, lw=0.8)
    _name(ax, (-0.23, height / 2), f"height\n{height:.2f} m", _ROBOT_FRAME, ha="right")
    _name(ax, (eye[0] + reach, -0.1), "where the axis meets the ground", _MEASURED, ha="center")
