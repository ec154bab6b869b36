"""The linearisation panel: samples through a student's function, and the ellipse that its Jacobian predicts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.lessons.ekf_derivations.figures import cloud_keys, plot_cloud
from nao_course.lessons.ekf_derivations.samples import Cloud, landmark_cloud, measurement_cloud, motion_cloud
from nao_course.plotting import Drawing, course_style, ellipse_outlines
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY
from nao_course.widgets import Action, Choice, FunctionPanel, Slider

MOTION, LANDMARK, MEASUREMENT = "drive", "landmark position", "expected measurement"
DRIVE_NOISE = np.diag([0.03, 0.03, 0.0]) ** 2  # along, across (m), turn (rad)
MEASUREMENT_NOISE = np.diag([np.radians(1.0), 0.03]) ** 2  # bearing (rad), range (m)
_DEGREES = (180 / np.pi, 1.0)
_CONTROLS = [
    Choice(
        "what",
        "Function",
        (MOTION, LANDMARK, MEASUREMENT),
        tooltip="The function that the samples go through",
    ),
    Slider(
        "heading", "Heading σ", 0, 60, 1, 5, unit="°", tooltip="Standard deviation of the robot's heading"
    ),
    Slider(
        "position", "Position σ", 0.01, 0.5, 0.01, 0.03, unit="m", tooltip="Standard deviation of its x and y"
    ),
    Slider(
        "distance",
        "Distance",
        0.1,
        4.0,
        0.1,
        2.0,
        unit="m",
        tooltip="Length of the drive, or range of the landmark",
    ),
    Slider(
        "direction",
        "Direction",
        -180,
        180,
        5,
        0,
        unit="°",
        tooltip="Heading of the drive, or bearing of the landmark",
    ),
    Action("small", "5 degrees", sets={"heading": 5}),
    Action("large", "30 degrees", sets={"heading": 30}),
]
_UNFINISHED = {
    "predict_pose": "Finish exercise 5.1 to see this.",
    "predict_covariance": "Finish exercises 5.4 and 5.5 to see this.",
    "landmark_position": "Finish exercise 5.3 to see this.",
    "landmark_jacobians": "Finish exercise 5.6 to see this.",
    "expected_measurement": "Finish exercise 5.2 to see this.",
    "measurement_jacobian_pose": "Finish exercise 5.8 to see this.",
}


@course_style()
def draw_cloud(cloud: Cloud, *, polar: bool = False) -> Drawing:
    """Draw samples and the predicted ellipse; with `polar` the axes are bearing (degrees) and range (m)."""
    scale = _DEGREES if polar else (1.0, 1.0)
    figure = Figure(figsize=(7.2, 4.4))
    ax = figure.subplots()
    plot_cloud(cloud, ax, scale=scale)
    names = ("bearing (degrees)", "range (m)") if polar else ("x (m)", "y (m)")
    ax.set(xlabel=names[0], ylabel=names[1])
    if not polar:
        ax.plot(0, 0, "o", color="black", ms=8, mec="white")
        outline = ellipse_outlines(cloud.mean, cloud.covariance)[0]
        reach = max(0.5, np.nanmax(np.abs([*cloud.points, *outline])) + 0.2)
        ax.set(aspect="equal", xlim=(-1.4 * reach, 1.4 * reach), ylim=(-reach, reach))
        ax.axhline(0, color=GREY, lw=0.5, zorder=0)
    legend_below(figure, cloud_keys(f"{len(cloud.points)} samples"))
    return Drawing(figure, say_cloud(cloud, polar=polar))


def say_cloud(cloud: Cloud, *, polar: bool = False) -> str:
    """Compare prediction and samples in words: mean, standard deviations, and the share inside the ellipse."""
    scale = np.array(_DEGREES if polar else (1.0, 1.0))
    names, units = (("bearing", "range"), ("°", " m")) if polar else (("x", "y"), (" m", " m"))
    predicted, sampled = (
        scale * np.sqrt(np.diagonal(each)) for each in (cloud.covariance, cloud.sampled_covariance)
    )
    shift = cloud.shift * scale
    parts = [
        f"{name}: mean off by {off:z.2f}{unit}, σ predicted {one:.2f}{unit}, sampled {other:.2f}{unit}"
        for name, unit, off, one, other in zip(names, units, shift, predicted, sampled, strict=True)
    ]
    inside = f"{100 * cloud.inside():.0f} % of these {len(cloud.points)} samples are in the ellipse"
    return f"{inside} that should hold 95 %. {'; '.join(parts)}."


class LinearisationPanel(FunctionPanel):
    """500 samples through a drive, a landmark's position or a measurement, and the ellipse that your Jacobians predict.

    Parameters
    ----------
    predict_pose, predict_covariance, landmark_position, landmark_jacobians, expected_measurement,
    measurement_jacobian_pose : callable
        The student's functions.
    """

    def __init__(
        self,
        predict_pose: Callable[..., Any],
        predict_covariance: Callable[..., Any],
        landmark_position: Callable[..., Any],
        landmark_jacobians: Callable[..., Any],
        expected_measurement: Callable[..., Any],
        measurement_jacobian_pose: Callable[..., Any],
    ) -> None:
        """Draw the first cloud and build the widgets."""
        super().__init__(
            "Linearisation panel",
            self._show,
            _CONTROLS,
            student={
                "predict_pose": predict_pose,
                "predict_covariance": predict_covariance,
                "landmark_position": landmark_position,
                "landmark_jacobians": landmark_jacobians,
                "expected_measurement": expected_measurement,
                "measurement_jacobian_pose": measurement_jacobian_pose,
            },
            unfinished=_UNFINISHED,
        )

    def _show(self, values: Any, student: Any) -> Iterator[Any]:
        """Draw the samples after the chosen function."""
        cloud = self._cloud(values, student)
        polar = values.what == MEASUREMENT
        yield {"": draw_cloud(cloud, polar=polar)}
        yield say_cloud(cloud, polar=polar)

    def _cloud(self, values: Any, student: Any) -> Cloud:
        covariance = np.diag([values.position, values.position, np.radians(values.heading)]) ** 2
        direction = np.radians(values.direction)
        if values.what == MOTION:
            pose, control = (0.0, 0.0, direction), (values.distance, 0.0)
            functions = student.predict_pose, student.predict_covariance
            return motion_cloud(*functions, pose, covariance, control, DRIVE_NOISE, values.rng)
        if values.what == LANDMARK:
            measurement = (direction, values.distance)
            functions = student.landmark_position, student.landmark_jacobians
            return landmark_cloud(*functions, covariance, measurement, MEASUREMENT_NOISE, values.rng)
        landmark = values.distance * np.array([np.cos(direction), np.sin(direction)])
        functions = student.expected_measurement, student.measurement_jacobian_pose
        return measurement_cloud(*functions, covariance, landmark, values.rng)
