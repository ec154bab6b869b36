"""Draw the README's picture: what a NAO sees, what is really there, and where it believes it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from nao_course.geometry import Pose
from nao_course.plotting import (
    LABEL_COLOURS,
    Drawing,
    course_style,
    plot_field,
    plot_measurements,
    plot_path,
    plot_picture,
)
from nao_course.sim import Field, SimulatedNao, Truth

HERE = Path(__file__).resolve().parent


def first_light(folder: Path = HERE) -> Path:
    """Write first_light.png into a folder."""
    field = Field(2012)
    nao = SimulatedNao(field, Pose(0.1, -1.5, 0.4), rng=11)
    truth = Truth(nao)
    for turn, way in ((0.3, 0.8), (-0.6, 0.3), (0.5, 0.2)):
        nao.turn(turn)
        nao.walk(way)
    nao.look(np.radians(2), np.radians(-31))
    picture = nao.take_picture("bottom", (640, 480))
    odometry = [truth.odometry_start @ pose for pose in nao.odometry_path]
    with course_style():
        figure = Figure(figsize=(12.6, 3.9))
        seen, labelled, above = figure.subplots(1, 3, width_ratios=[1.33, 1.33, 1])
        plot_picture(picture, seen, ticks=False)
        seen.set_title("what the NAO sees")
        labelled.imshow(truth.picture.labels, cmap=ListedColormap(LABEL_COLOURS), vmin=0, vmax=3)
        for mark in truth.picture.landmarks:
            if mark.landmark.kind != "cross" and not mark.occluded:
                labelled.plot(*mark.pixel, "o", mfc="none", mec="#cc2288", ms=11, mew=2)
        labelled.set(xticks=[], yticks=[], title="what is really there")
        plot_field(field, above)
        plot_path(truth.path, above, "truth")
        plot_path(odometry, above, "odometry")
        plot_measurements(nao.sense(), odometry[-1], above, "odometry")
        above.set_title("where it is, and thinks it is")
    return Drawing(figure, "A NAO's picture, its labels, and its map.").save(folder / "first_light.png")


if __name__ == "__main__":
    first_light()
