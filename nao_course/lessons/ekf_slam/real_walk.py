"""The map that the student's filter makes of a real NAO's walk."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nao_course.datasets.real_walk import FIELD, recorded_walk
from nao_course.geometry import Pose
from nao_course.plotting import STYLES, Drawing, course_style, plot_ellipse, plot_field, plot_landmarks
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.style import GREY
from nao_course.sim.drives import Function, NamedEkf, checked_functions, landmark_blocks

SHOWN = (1, 12, 24)  # numbers of the pictures after which the map is drawn; later ones show no landmark


@course_style()
def draw_real_map(predict: Function, update_landmarks: Function, add_landmark: Function) -> Drawing:
    """Draw the map that grows from the measurements of a real walk, over the true field.

    Parameters
    ----------
    predict, update_landmarks, add_landmark : callable
        The student's functions.

    Returns
    -------
    Drawing
        Three maps with 95 % ellipses.
    """
    drive = recorded_walk()
    slam = NamedEkf(
        Pose.from_array(drive.poses[0]), *checked_functions((predict, update_landmarks, add_landmark))
    )
    figure = Figure(figsize=(11.4, 3.6))
    axes = dict(zip(SHOWN, figure.subplots(1, len(SHOWN), sharey=True), strict=True))
    path, said = [], []
    for picture, step in enumerate(drive.steps, start=1):
        if step.motion is not None:
            slam.move(step.control, step.control_covariance)
        slam.observe(step.numbers, step.measurements, step.covariances)
        path.append(slam.state[:2])
        if picture not in axes:
            continue
        ax, places = axes[picture], slam.state[3:].reshape(-1, 2)
        plot_field(FIELD, ax)
        plot_landmarks(FIELD.detectable_positions, FIELD.detectable_kinds, ax, GREY, size=5)
        ax.plot(*np.array(path).T, ".-", color=STYLES["ekf"].colour, ms=3, lw=1)
        for place, block in zip(places, landmark_blocks(slam.covariance), strict=True):
            plot_ellipse(place, block, ax, "ekf")
        ax.plot(*places.T, "+", color=STYLES["ekf"].colour, ms=8, mew=1.5, zorder=6)
        off = np.hypot(*(places[:2] - drive.landmarks[slam.known[:2]]).T)
        wide = np.hypot(*(places[0] - places[1]))
        ax.set_title(f"After picture {picture}:\nposts {100 * off.mean():.0f} cm off, {wide:.2f} m apart")
        said.append(f"after picture {picture} {100 * off.mean():.0f} cm off and {wide:.2f} m apart")
    for ax in axes.values():
        ax.set(xlim=(-3.3, 3.7), ylim=(-2.3, 2.3))
    legend_below(figure, [source_key("ekf", "estimated path and landmarks with 95 % ellipses")])
    return Drawing(
        figure,
        f"The map of a real walk over the true field. The posts of the goal are {', '.join(said)}; the true distance "
        f"is 1.4 m. The map ends with {len(slam.known)} landmarks.",
    )
