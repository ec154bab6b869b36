"""Marks of a student's prediction in the figure that answers it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal, Protocol

from matplotlib.axes import Axes
from matplotlib.patches import Circle

from nao_course.plotting.drawing import Drawing
from nao_course.plotting.halo import HALO
from nao_course.plotting.style import course_style

GUESS = "#7a2cff"  # differs from the sources of poses
_LINE: dict[str, Any] = {"color": GUESS, "ls": (0, (6, 3)), "zorder": 8}


class Guess(Protocol):
    """A prediction, such as one of `nao_course.exercises.prediction`: its value, or None if nothing was written."""

    value: float | str | None


def guessed(guess: Guess) -> float | None:
    """Return the predicted number, or None without a prediction or if it is one of several choices."""
    return guess.value if isinstance(guess.value, float) else None


@course_style()
def with_guess(
    drawing: Drawing,
    guess: Guess,
    axis: Literal["x", "y", "radius"],
    *,
    panel: int = 0,
    place: Callable[[float], float] = float,
) -> Drawing:
    """Add a student's prediction to a figure, as a dashed line labelled "you".

    Parameters
    ----------
    drawing : Drawing
        The figure.
    guess : Guess
        The prediction. Without one, the figure stays as it is.
    axis : "x", "y" or "radius"
        The axis on which the predicted number is, or "radius" for a circle around the origin of a map.
    panel : int
        Number of the axes in the figure, from 0.
    place : callable
        Turns the prediction into a number on the axis, for example from metres to centimetres.

    Returns
    -------
    Drawing
        The figure with the line. If the number is outside the axis, the line is at its end, with an arrow.

    Raises
    ------
    ValueError
        If `axis` has another value.
    """
    if axis not in ("x", "y", "radius"):
        raise ValueError(f'axis must be "x", "y" or "radius", got {axis!r}')
    value = guessed(guess)
    if value is None:
        return drawing
    ax = drawing.figure.axes[panel]
    _GUESSES[axis](ax, place(value))
    line = "circle" if axis == "radius" else "line"
    alt = f'{drawing.alt} A dashed {line} labelled "you" marks your prediction, {value:g}.'
    return replace(drawing, alt=alt)


def _on_x(ax: Axes, at: float) -> None:
    low, high = sorted(ax.get_xlim())
    inside = min(max(at, low), high)
    ax.axvline(inside, lw=1.8, **_LINE)
    text = "← you" if at < low else "you →" if at > high else "you"
    to_left = inside > ax.transData.inverted().transform(ax.transAxes.transform((0.85, 0.5)))[0]
    ax.annotate(
        text,
        (inside, 0.98),
        (-4 if to_left else 4, 0),
        xycoords=ax.get_xaxis_transform(),
        ha="right" if to_left else "left",
        va="top",
        **_TEXT,
    )


def _on_y(ax: Axes, at: float) -> None:
    low, high = sorted(ax.get_ylim())
    inside = min(max(at, low), high)
    ax.axhline(inside, lw=1.8, **_LINE)
    text = "you ↓" if at < low else "you ↑" if at > high else "you"
    is_high = ax.transAxes.inverted().transform(ax.transData.transform((ax.get_xlim()[0], inside)))[1] > 0.9
    ax.annotate(
        text,
        (0.99, inside),
        (0, -3 if is_high else 3),
        xycoords=ax.get_yaxis_transform(),
        ha="right",
        va="top" if is_high else "bottom",
        **_TEXT,
    )


def _around(ax: Axes, radius: float) -> None:
    """Draw a circle around the origin; if it is larger than the map, its label is at the map's upper edge."""
    limits = ax.axis()
    ax.add_patch(Circle((0.0, 0.0), radius, fill=False, lw=1.8, **_LINE))
    ax.axis(limits)
    high = max(limits[2:])
    text = "you" if radius < high else "you ↑"
    ax.annotate(
        text,
        (0.0, min(radius, high)),
        (0, -3),
        ha="center",
        va="top" if radius >= high else "bottom",
        **_TEXT,
    )


_TEXT: dict[str, Any] = {
    "textcoords": "offset points",
    "color": GUESS,
    "weight": "bold",
    "path_effects": HALO,
    "zorder": 9,
}
_GUESSES: dict[str, Callable[[Axes, float], None]] = {"x": _on_x, "y": _on_y, "radius": _around}
