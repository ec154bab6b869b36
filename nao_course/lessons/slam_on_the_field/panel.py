"""The panel of lesson 11: one look from a place that is in doubt, and which landmark each measurement is taken for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.slam_on_the_field.associating import BAD, GOOD
from nao_course.lessons.slam_on_the_field.system.association import associate_jointly
from nao_course.lessons.slam_on_the_field.worlds import FIELD, KINDS, LANDMARKS, Riddle, riddle
from nao_course.plotting import LANDMARK_MARKERS, Drawing, course_style, plot_ellipse, plot_field, plot_pose
from nao_course.plotting.legends import legend_below, source_key
from nao_course.slam import measured_points
from nao_course.widgets import FunctionPanel, Slider, Toggle

LANDMARK_SIGMA = 0.04  # m


class AssociationPanel(FunctionPanel):
    """A look from a place in doubt: lines lead from each measurement to the landmark that it is taken for.

    Parameters
    ----------
    associate : callable
        ``associate(state, covariance, kinds, measurements, measurement_covariance, gate)`` returns a number for each
        measurement.
    """

    def __init__(self, associate: Callable[..., Any]) -> None:
        """Begin with a heading in doubt by 8 degrees."""
        super().__init__(
            "Which landmark is it?",
            _shown,
            [
                Slider("look", "Look", 0, 29, 1, 4, tooltip="Another place, another error"),
                Slider("heading", "Heading doubt", 0.5, 20, 0.5, 8, unit="°", tooltip="Standard deviation"),
                Slider(
                    "position",
                    "Position doubt",
                    0.01,
                    0.5,
                    0.01,
                    0.15,
                    unit="m",
                    tooltip="Standard deviation along each axis",
                ),
                Slider("gate", "Gate", 0.5, 10, 0.5, 3, unit="σ", tooltip="Largest distance of a pair"),
                Toggle("together", "Judge them together"),
            ],
            student={"associate": associate},
            unfinished="Finish exercises 11.3 and 11.4 to see which landmarks are taken.",
        )


def _shown(values: Any, student: Any) -> Iterator[Any]:
    """Draw the look, then what is made of it."""
    each = riddle(int(values.look), values.position, float(np.radians(values.heading)), LANDMARK_SIGMA)
    yield {"The map, and one look": draw_riddle(each, None)}
    given = (
        each.state,
        each.covariance,
        list(KINDS),
        each.observation,
        each.observation.covariance,
        values.gate,
    )
    indices = np.asarray(associate_jointly(*given) if values.together else student.associate(*given))
    if indices.shape != (len(each.origins),):
        raise ValueError(f"{len(each.origins)} measurements need as many numbers, got shape {indices.shape}")
    yield {"The map, and one look": draw_riddle(each, indices.astype(int))}
    how = "Together" if values.together else "Each alone"
    new = int(np.count_nonzero(indices < 0))
    yield f"{how}: {each.right(indices)} of {len(each.origins)} right, {new} taken for new."


def draw_riddle(each: Riddle, indices: Any) -> Drawing:
    """Draw map, believed pose, and a line from each measurement to its landmark; green where it is right."""
    believed = Pose.from_array(each.state[:3])
    ends = measured_points(each.observation, believed)
    marks: FloatArray = np.reshape(each.state[3:], (-1, 2))
    with course_style():
        figure = Figure(figsize=(6.2, 5.6))
        ax = figure.add_subplot()
        plot_field(FIELD, ax)
        for place, kind in zip(marks, KINDS, strict=True):
            plot_ellipse(place, LANDMARK_SIGMA**2 * np.eye(2), ax, "ekf")
            ax.plot(*place, LANDMARK_MARKERS[kind], color="none", mec="#0b5fa5", ms=8, mew=1.4, zorder=5)
        for n, end in enumerate(ends):
            kind = each.observation[n].kind
            ax.plot([believed.x, end[0]], [believed.y, end[1]], color="#444", lw=0.7, alpha=0.5, zorder=3)
            ax.plot(*end, LANDMARK_MARKERS[kind], color="#222", ms=7, zorder=5.5)
            if indices is not None and 0 <= indices[n] < len(marks):
                colour = GOOD if indices[n] == each.origins[n] else BAD
                ax.plot(*np.column_stack([end, marks[indices[n]]]), color=colour, lw=3, zorder=4.5)
            elif indices is not None:
                ax.annotate("new", end, (4, 4), textcoords="offset points", color=BAD, fontsize=9, zorder=6)
        plot_pose(each.pose, ax)
        plot_pose(believed, ax, "ekf")
        plot_ellipse((believed.x, believed.y), each.covariance[:2, :2], ax, "ekf")
        keys = [source_key("truth", "true pose"), source_key("ekf", "believed, 95 %")]
        keys += [
            Line2D([], [], color=colour, lw=3, label=name)
            for name, colour in (("right", GOOD), ("wrong", BAD))
        ]
        legend_below(figure, keys)
    off = np.hypot(believed.x - each.pose.x, believed.y - each.pose.y)
    said = f"{len(each.origins)} measurements from a believed pose that is off by {off:.2f} m"
    if indices is not None:
        said += f"; {each.right(indices)} of them are taken for the right landmark"
    return Drawing(figure, f"The half field with {len(LANDMARKS)} landmarks on the map: {said}.")
