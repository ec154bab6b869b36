"""The effect of the minimum saturation on pictures of a real NAO, or recorded numbers if they are absent."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course import datasets
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import legend_below
from nao_course.plotting.pictures import draw_pictures, painted
from nao_course.plotting.style import LABEL_COLOURS, course_style

GREEN, YELLOW = (90.0, 160.0), (44.0, 66.0)  # degrees; carpets and goals of several venues
# Mean parts of 94 pictures, by `python -m benchmarks colour_filter`; a test compares them.
FLOORS = (0.0, 0.08, 0.16, 0.24, 0.32)
PARTS = {
    "carpet labelled green": (0.9939, 0.9926, 0.9894, 0.8155, 0.2559),
    "posts labelled yellow": (0.9082, 0.9076, 0.9071, 0.9066, 0.9054),
    "background labelled green": (0.0456, 0.014, 0.004, 0.0015, 0.0007),
    "background labelled yellow": (0.0365, 0.0209, 0.0082, 0.004, 0.0027),
}
_PICTURE = 2  # of the set "scenes": chairs, walls and a bag behind the goal


def draw_real_pictures(label: Callable[..., Any]) -> Drawing:
    """Draw the effect of the minimum saturation on pictures of a real NAO.

    Parameters
    ----------
    label : callable
        ``label(picture, green, yellow, min_saturation=...)`` returns labels (H, W); called if there are recordings.

    Returns
    -------
    Drawing
        One real picture and its labels without and with a minimum saturation of 0.16; if the recordings
        are absent, numbers that were measured on 94 of them.
    """
    try:
        picture = datasets.read_pictures("scenes")[_PICTURE].pixels
    except FileNotFoundError:
        return draw_real_floors()
    shown = [painted(label(picture, GREEN, YELLOW, min_saturation=floor)) for floor in (0.0, 0.16)]
    return draw_pictures(
        [picture, *shown], ("a real picture", "no minimum saturation", "minimum saturation 0.16")
    )


@course_style()
def draw_real_floors() -> Drawing:
    """Draw the fractions of 94 real pictures labelled green and yellow over the minimum saturation."""
    figure = Figure(figsize=(9.0, 3.8))
    for ax, names in zip(figure.subplots(1, 2), (list(PARTS)[:2], list(PARTS)[2:]), strict=True):
        for name in names:
            colour = LABEL_COLOURS[1 if name.endswith("green") else 2]
            ax.plot(FLOORS, PARTS[name], "o-", color=colour, mec="#333333", lw=2)
        ax.axvline(0.16, color="#6b7280", ls=":", lw=1.5)
        ax.set(xlabel="minimum saturation", ylim=(0, None), xticks=FLOORS)
        ax.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
        ax.grid(color="#e3e5e8")
    figure.axes[0].set_title("right: carpet and posts", fontsize=11)
    figure.axes[1].set_title("wrong: background", fontsize=11)
    keys = [
        Line2D([], [], color=LABEL_COLOURS[k], marker="o", mec="#333333", label=f"labelled {name}")
        for k, name in ((1, "green"), (2, "yellow"))
    ]
    legend_below(figure, keys)
    said = "; ".join(
        f"{name} {', '.join(f'{100 * part:.1f}' for part in parts)} %" for name, parts in PARTS.items()
    )
    floors = ", ".join(f"{floor:g}" for floor in FLOORS)
    return Drawing(figure, f"94 pictures of a real NAO, minimum saturations {floors}: {said}.")
