"""Paths of poses, drawn with the robot at their end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from nao_course.geometry import FloatArray, Pose
from nao_course.plotting.drawing import say_place
from nao_course.plotting.halo import HALO
from nao_course.plotting.style import style_of

PathLike = Pose | Sequence[Pose] | npt.ArrayLike


def as_path(poses: PathLike, name: str = "path") -> FloatArray:
    """Return poses in any accepted form as an array of shape (N, 3).

    Parameters
    ----------
    poses : Pose, sequence of Pose, or array_like of shape (N, 2) or (N, 3)
        Positions in metres and, in a third column, headings in radians.
    name : str
        Name of the argument for error messages.

    Returns
    -------
    ndarray, shape (N, 3)
        x, y, theta; theta is NaN if no heading was given.

    Raises
    ------
    ValueError
        If the poses have none of these forms.
    """
    if isinstance(poses, Pose):
        return poses.as_array()[None]
    values: Any = poses
    if isinstance(values, Sequence) and any(isinstance(pose, Pose) for pose in values):
        values = [pose.as_array() if isinstance(pose, Pose) else pose for pose in values]
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        array = np.empty((1, 1))
    if array.size == 0:
        return np.empty((0, 3))
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise ValueError(
            f"{name} must be poses or an array of shape (N, 2) or (N, 3) in metres; got {poses!r:.80}"
        )
    if array.shape[1] == 2:
        array = np.column_stack([array, np.full(len(array), np.nan)])
    return array


def plot_pose(pose: Pose, ax: Axes, source: str = "truth", length: float = 0.35, size: float = 9.0) -> None:
    """Draw a robot: the marker of its source, `size` points wide, and a line of `length` metres in its heading."""
    style = style_of(source)
    tip = pose.to_parent([length, 0.0])[0]
    ax.plot(
        [pose.x, tip[0]], [pose.y, tip[1]], color=style.colour, lw=2.4 * size / 9, zorder=6, path_effects=HALO
    )
    ax.plot(
        pose.x,
        pose.y,
        style.marker,
        color=style.colour,
        ms=size,
        mec="white",
        mew=1.2 * size / 9,
        zorder=6.1,
        label=f"_{style.label}",
    )


def plot_path(path: PathLike, ax: Axes, source: str = "truth", robot: bool = True) -> None:
    """Draw a robot's path; an empty path draws nothing.

    Parameters
    ----------
    path : Pose, sequence of Pose, or array_like of shape (N, 2) or (N, 3)
        Path in metres and radians.
    ax : matplotlib Axes
        Axes in metres.
    source : str
        A key of `STYLES`.
    robot : bool
        Whether to draw the robot at the last pose, if it has a heading.
    """
    style, poses = style_of(source), as_path(path)
    if not len(poses):
        return
    ax.plot(
        poses[:, 0], poses[:, 1], color=style.colour, ls=style.line, lw=1.9, zorder=4, label=f"_{style.label}"
    )
    every = poses[:: max(1, len(poses) // 12)]
    ax.plot(
        every[:, 0], every[:, 1], style.marker, color=style.colour, ms=4, zorder=4.1, label=f"_{style.label}"
    )
    if robot and np.isfinite(poses[-1]).all():
        plot_pose(Pose.from_array(poses[-1]), ax, source)


def say_path(label: str, path: FloatArray) -> str:
    """Return a path's number of poses (N, 3), its first and its last pose as text."""
    if not len(path):
        return f"{label}: no poses."
    if len(path) == 1:
        return f"{label}: at {say_place(path[0])}."
    return f"{label}: {len(path)} poses from {say_place(path[0])} to {say_place(path[-1])}."
