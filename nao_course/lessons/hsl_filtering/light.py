"""Pictures in another light, their lightnesses, and the limits of the threshold for white in lesson 01."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.plotting.drawing import Drawing
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import label_keys, legend_below
from nao_course.plotting.style import LABEL_COLOURS, course_style
from nao_course.sim import LABELS

Pixels = npt.NDArray[np.uint8]

# Lower and upper end of each mark as fractions of the height, because β and the mean may be equal
SPANS = {"β": (0.0, 0.55), "mean": (0.62, 1.0), "threshold": (0.0, 1.0)}

BINS = 64  # of the lightnesses 0 to 255
MARKS = {  # colour and line style of each mark in a histogram of lightness
    "β": ("#a14566", (0, (1.2, 1.2))),
    "mean": ("#0b5fa5", (0, (5, 2))),
    "threshold": ("#c84b00", "-"),
}


def in_light(picture: npt.ArrayLike, factor: float) -> Pixels:
    """Return a picture in another light: each channel times a factor, clipped at 255.

    Parameters
    ----------
    picture : array_like of uint8, shape (H, W, 3)
        RGB.
    factor : float
        Factor of the light, at least 0.

    Raises
    ------
    ValueError
        If the factor is below 0.

    Examples
    --------
    >>> in_light(np.full((1, 1, 3), 200, dtype=np.uint8), 1.5)[0, 0].tolist()
    [255, 255, 255]
    """
    if not factor >= 0:
        raise ValueError(f"factor must be at least 0, got {factor!r}")
    bytes_ = np.minimum(np.round(np.arange(256) * factor), 255).astype(np.uint8)
    return np.asarray(cv2.LUT(np.asarray(picture), bytes_), dtype=np.uint8)


def lightness_counts(lightness: npt.ArrayLike, labels: npt.ArrayLike) -> npt.NDArray[np.intp]:
    """Count pixels by label and lightness, shape (4, BINS), from lightness (H, W), 0 to 255, and labels (H, W).

    The labels are 0 other, 1 green, 2 yellow and 3 white.
    """
    bins = np.clip(np.asarray(lightness) * (BINS / 256), 0, BINS - 1).astype(np.intp)
    flat = np.asarray(labels).astype(np.intp).ravel() * BINS + bins.ravel()
    return np.bincount(flat, minlength=len(LABELS) * BINS).reshape(len(LABELS), BINS)


@course_style()
def draw_lightness(
    lightness: npt.ArrayLike,
    labels: npt.ArrayLike,
    *,
    beta: float,
    mean: float,
    threshold: float,
    title: str = "Lightness of the pixels",
) -> Drawing:
    """Draw a histogram of lightness for each true label, with the threshold for white.

    Parameters
    ----------
    lightness : array_like, shape (H, W)
        0 to 255.
    labels : array_like of int, shape (H, W)
        True labels of the pixels.
    beta, mean, threshold : float
        The three lightnesses of equation 1.4.
    title : str
        Title of the figure.

    Returns
    -------
    Drawing
        The figure; its text gives the three lightnesses and the fraction of each label above the threshold.
    """
    values, kinds = np.asarray(lightness, dtype=float), np.asarray(labels)
    if values.shape != kinds.shape or values.ndim != 2:
        raise ValueError(
            f"lightness and labels must have one shape (H, W), got {values.shape} and {kinds.shape}"
        )
    counts = lightness_counts(values, kinds)
    left = np.arange(BINS) * (256 / BINS)
    figure = Figure(figsize=(8.4, 3.7))
    ax = figure.add_subplot()
    below = np.zeros(BINS)
    for label in (1, 0, 2, 3):
        ax.bar(left, counts[label], 256 / BINS, bottom=below, align="edge", color=LABEL_COLOURS[label])
        below = below + counts[label]
    ax.step([*left, 256], [*below, below[-1]], where="post", color="#333333", lw=0.8)
    top = 1.22 * float(np.sort(below)[-2])  # the highest bin is cut off because it may be far higher
    for (name, (colour, dashes)), at in zip(MARKS.items(), (beta, mean, threshold), strict=True):
        low, high = SPANS[name]
        ax.axvline(at, low, high, color=colour, ls=dashes, lw=2)
        place, side = (-3, "right") if name == "β" else (3, "left")
        said = f"{name} {at:.0f}"
        ax.text(
            at + place,
            high * top,
            said,
            color=colour,
            va="top",
            ha=side,
            path_effects=HALO,
            fontweight="bold",
        )
    ax.set(xlim=(0, 256), ylim=(0, top), xlabel="lightness (0 to 255)", ylabel="pixels", title=title)
    legend_below(figure, label_keys(LABELS))
    above = ", ".join(
        f"{(values[kinds == label] > threshold).mean():.0%} of {name}"
        for label, name in enumerate(LABELS)
        if (kinds == label).any()
    )
    words = f"{title}: beta {beta:.0f}, mean {mean:.0f}, threshold {threshold:.0f}. Above it: {above}."
    return Drawing(figure, words)


@course_style()
def draw_light_limits(
    factors: npt.ArrayLike,
    recall: npt.ArrayLike,
    false_white: npt.ArrayLike,
    *,
    other_recall: npt.ArrayLike | None = None,
    dark: float | None = None,
    bright: float | None = None,
) -> Drawing:
    """Draw the fractions of lines found and of carpet labelled white over a factor of the light.

    Parameters
    ----------
    factors : array_like, shape (N,)
        Factors of the light, in ascending order.
    recall, false_white : array_like, shape (N,)
        Fractions of the lines and of the carpet that are labelled white, 0 to 1.
    other_recall : array_like, shape (N,), optional
        Fraction of the lines that is found with the largest lightness of the picture as maximum.
    dark, bright : float, optional
        Limits of the factor by equation 1.5.

    Returns
    -------
    Drawing
        The figure; its text gives the factors at which the fractions reach 25 % and 50 %.
    """
    f, found, false = (np.asarray(each, dtype=float) for each in (factors, recall, false_white))
    if f.ndim != 1 or found.shape != f.shape or false.shape != f.shape or (np.diff(f) <= 0).any():
        raise ValueError(
            "factors must grow, with as many values of recall and false_white; "
            f"got {f.shape}, {found.shape}, {false.shape}"
        )
    white, green = "#1a1a1a", LABEL_COLOURS[1]
    figure = Figure(figsize=(8.4, 4.0))
    ax = figure.add_subplot()
    ax.plot(f, found, color=white, marker="o", ms=3.5, lw=1.8)
    ax.plot(f, false, color=green, marker="s", ms=3.5, lw=1.8)
    keys: list[Any] = [
        Line2D([], [], color=white, marker="o", label="lines that are found (recall)"),
        Line2D([], [], color=green, marker="s", label="carpet labelled white"),
    ]
    if other_recall is not None:
        ax.plot(f, np.asarray(other_recall, dtype=float), color="#8a8f98", lw=1.5, ls=(0, (4, 2)))
        keys.append(
            Line2D(
                [],
                [],
                color="#8a8f98",
                ls=(0, (4, 2)),
                label="lines, with the picture's largest lightness as maximum",
            )
        )
    _mark_limits(ax, dark, bright)
    if dark is not None or bright is not None:
        keys.append(Line2D([], [], color="#c84b00", ls=":", lw=2, label="limits by equation 1.5"))
    ax.set(
        xlabel="factor of the light", ylabel="fraction of the pixels", ylim=(-0.03, 1.2), xlim=(f[0], f[-1])
    )
    ax.set_title("In which light the threshold works")
    ax.set_yticks(np.linspace(0, 1, 6))
    ax.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
    ax.grid(color="#e3e5e8")
    legend_below(figure, keys, columns=2)
    return Drawing(figure, _say_limits(f, found, false, dark, bright))


def _mark_limits(ax: Axes, dark: float | None, bright: float | None) -> None:
    for at, side in ((dark, "right"), (bright, "left")):
        if at is not None:
            ax.axvline(at, color="#c84b00", ls=":", lw=2)
            ax.annotate(f" {at:.2f} ", (at, 1.12), ha=side, va="center", color="#c84b00", path_effects=HALO)


def _say_limits(f: Any, found: Any, false: Any, dark: float | None, bright: float | None) -> str:
    words = "Over a factor of the light: lines that are found, and carpet that is labelled white. "
    words += first_words("half of the lines are found from", f, found)
    for part in (0.25, 0.5):
        words += first_words(f"{part:.0%} of the carpet is labelled white from", f, false, part)
    said = [f"{at:.2f}" for at in (dark, bright) if at is not None]
    return words + (f"The limits by equation 1.5 are {' and '.join(said)}." if said else "")


def crossing(factors: npt.ArrayLike, parts: npt.ArrayLike, level: float = 0.5) -> float:
    """Return the factor at which a fraction first reaches a level, by linear interpolation; NaN if it never does.

    Examples
    --------
    >>> crossing([0.5, 0.6, 0.7], [0.0, 0.4, 0.6])
    0.65
    """
    f, values = np.asarray(factors, dtype=float), np.asarray(parts, dtype=float)
    reached = np.flatnonzero(values >= level)
    if not len(reached):
        return float("nan")
    k = int(reached[0])
    if k == 0:
        return float(f[0])
    share = (level - values[k - 1]) / (values[k] - values[k - 1])
    return round(float(f[k - 1] + share * (f[k] - f[k - 1])), 4)


def first_words(what: str, factors: npt.ArrayLike, parts: npt.ArrayLike, level: float = 0.5) -> str:
    """Return a sentence with the factor at which a fraction reaches a level, or an empty string if it never does."""
    at = crossing(factors, parts, level)
    return "" if np.isnan(at) else f"{what[0].upper()}{what[1:]} {at:.2f} on. "
