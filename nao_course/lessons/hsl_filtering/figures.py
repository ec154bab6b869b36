"""Figures of lesson 01: channels of a picture, hues on the circle, and the effect of a stray pixel."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.colors import hsv_to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course._internal.counts import say_count
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import label_keys, legend_below
from nao_course.plotting.pictures import as_pixels, painted, plot_picture
from nao_course.plotting.style import STYLES, YELLOW, course_style
from nao_course.sim import LABELS

if TYPE_CHECKING:
    from matplotlib.artist import Artist

_PIXEL_TEXT: Any = {"color": "#c84b00", "ha": "center"}


@course_style()
def draw_hsl(
    picture: npt.ArrayLike, hue: npt.ArrayLike, saturation: npt.ArrayLike, lightness: npt.ArrayLike
) -> Drawing:
    """Draw a picture and its hue, saturation and lightness.

    Parameters
    ----------
    picture : array_like of uint8, shape (H, W, 3)
        RGB.
    hue, saturation, lightness : array_like, shape (H, W)
        Hue in degrees [0, 360), saturation from 0 to 1, and lightness from 0 to 255. Hues are shown as pure colours.

    Returns
    -------
    Drawing
        The figure; its text gives the medians.

    Raises
    ------
    ValueError
        If a channel does not have the shape of the picture.
    """
    array = as_pixels(picture)
    channels = [np.asarray(each, dtype=float) for each in (hue, saturation, lightness)]
    for name, channel in zip(("hue", "saturation", "lightness"), channels, strict=True):
        if channel.shape != array.shape[:2]:
            raise ValueError(
                f"{name} must have shape {array.shape[:2]} as the picture has; got {channel.shape}"
            )
    painted = hsv_to_rgb(
        np.dstack([channels[0] % 360 / 360, np.ones_like(channels[0]), 0.9 + 0 * channels[0]])
    )
    shown = (array, np.round(255 * painted).astype(np.uint8), channels[1], channels[2])
    titles = ("picture", "hue (degrees, as pure colours)", "saturation (0 to 1)", "lightness (0 to 255)")
    figure = Figure(figsize=(5.8, 4.7))
    for ax, image, title, largest in zip(
        figure.subplots(2, 2).flat, shown, titles, (None, None, 1.0, 255.0), strict=True
    ):
        grey = {} if largest is None else {"cmap": "gray", "vmin": 0, "vmax": largest}
        plot_picture(image, ax, ticks=False, **grey)
        ax.set_title(title, fontsize=11)
    middle = [float(np.median(channel)) for channel in channels]
    words = (
        f"A picture of {array.shape[1]} x {array.shape[0]} pixels beside its hue, saturation and lightness; "
        f"their medians are {middle[0]:.0f} degrees, {middle[1]:.2f} and {middle[2]:.0f}."
    )
    return Drawing(figure, words, photo=True)


@course_style()
def draw_hue_circle(
    hues: Mapping[str, npt.ArrayLike],
    limits: Mapping[str, tuple[float, float]] | None = None,
    title: str = "",
) -> Drawing:
    """Draw hues and intervals of hues on the colour circle.

    Parameters
    ----------
    hues : mapping of str to array_like
        Hues in degrees by the name of the object. Each object has its own ring, in this order from the inside.
    limits : mapping of str to (low, high), optional
        Intervals in degrees, counterclockwise from low to high, by the same names; low > high goes through 0.
    title : str
        Title of the figure.

    Returns
    -------
    Drawing
        The figure; its text gives the intervals.

    Raises
    ------
    ValueError
        If there is nothing to draw, or a limit belongs to no ring.
    """
    if not hues:
        raise ValueError("hues must have at least one entry, got none")
    if unknown := sorted((limits or {}).keys() - hues.keys()):
        raise ValueError(f"limits must have the keys {list(hues)}, got also {unknown}")
    angles = {name: np.asarray(values, dtype=float).ravel() % 360 for name, values in hues.items()}
    figure = Figure(figsize=(5.4, 5.6))
    ax: Any = figure.add_subplot(projection="polar")
    outer = np.radians(np.arange(0, 360, 2.0))
    colours = hsv_to_rgb(
        np.column_stack([outer / (2 * np.pi), np.ones_like(outer), np.full_like(outer, 0.9)])
    )
    ax.bar(outer, 0.25, width=np.radians(2.2), bottom=len(angles) + 3.0, color=colours)
    keys: list[Artist] = []
    for ring, (name, values) in enumerate(angles.items(), start=3):
        style = list(STYLES.values())[(ring - 3) % len(STYLES)]
        middle = float(np.degrees(np.angle(np.exp(1j * np.radians(values)).sum()))) % 360
        colour = colorsys.hsv_to_rgb(middle / 360, 1.0, 0.6)  # the object's own hue
        spread = ring + 0.35 * np.sin(12.9898 * np.arange(len(values)))  # apart, but the same each time
        ax.plot(np.radians(values), spread, style.marker, ms=4, color=colour, alpha=0.6, mec="none")
        keys.append(Line2D([], [], color=colour, marker=style.marker, ls="", label=name))
        if limits and name in limits:
            low, high = limits[name]
            arc = np.radians(np.linspace(low, low + (high - low) % 360, 200))
            ax.plot(arc, np.full_like(arc, ring + 0.47), color=colour, lw=3)
    ax.set_rlim(0, len(angles) + 3.25)
    ax.set_rticks([])
    ax.grid(color="#e3e5e8")
    ax.spines["polar"].set_visible(False)
    ax.set_thetagrids(range(0, 360, 30), [f"{degrees}°" for degrees in range(0, 360, 30)])
    ax.set_title(title)
    legend_below(figure, keys, columns=2)
    said = "; ".join(
        f"{name}: {say_count(len(values), 'hue')}"
        + (
            f", limits from {limits[name][0]:.1f} to {limits[name][1]:.1f} degrees"
            if limits and name in limits
            else ""
        )
        for name, values in angles.items()
    )
    return Drawing(figure, f"{title or 'Hues on the colour circle'}. {said}.")


@course_style()
def draw_stray_pixel(
    before: npt.ArrayLike, after: npt.ArrayLike, pixel: tuple[int, int], shares: npt.ArrayLike, share: float
) -> Drawing:
    """Draw labels without and with a stray pixel in the calibration, and the effect of other stray pixels.

    Parameters
    ----------
    before, after : array_like of int, shape (H, W)
        Labels.
    pixel : (int, int)
        Row and column of the stray pixel.
    shares : array_like, shape (N,)
        Fractions of the carpet that are labelled yellow, 0 to 1, for each of N other pixels.
    share : float
        The same for this pixel.

    Returns
    -------
    Drawing
        The figure; its text gives the shares.
    """
    parts = np.asarray(shares, dtype=float)
    figure = Figure(figsize=(9.9, 3.4))
    axes = figure.subplots(1, 3, width_ratios=(1, 1, 0.95))
    titles = ("clean example", "with one pixel of the carpet")
    for ax, labels, title in zip(axes, (before, after), titles, strict=False):
        plot_picture(painted(labels), ax, ticks=False)
        ax.set_title(title, fontsize=11)
    axes[1].plot(pixel[1], pixel[0], "o", ms=11, mew=2, mfc="none", mec="#c84b00")
    ax = axes[2]
    ax.hist(100 * parts, bins=np.arange(0, 101, 10), color=YELLOW, ec="white")
    ax.axvline(100 * share, ymax=0.88, color="#c84b00", lw=2)
    ax.text(100 * share, 0.91, f"this pixel: {share:.0%}", transform=ax.get_xaxis_transform(), **_PIXEL_TEXT)
    ax.set(ylim=(0, ax.get_ylim()[1] * 1.2), xlim=(0, 100))
    ax.set(xlabel="carpet labelled yellow (%)", ylabel=f"stray pixels (of {len(parts)})")
    ax.set_title("other pixels of the carpet", fontsize=11)
    legend_below(figure, label_keys(LABELS))
    low, middle, high = np.percentile(100 * parts, (5, 50, 95))
    words = (
        f"Labels with a clean example of the goal and with one pixel of the carpet in it: {share:.0%} of the carpet is "
        f"labelled yellow. For {len(parts)} other pixels it is {low:.0f} % to {high:.0f} % (5 % and 95 % of "
        f"them), with a median of {middle:.0f} %."
    )
    return Drawing(figure, words)
