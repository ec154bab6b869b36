"""Three fields of the course, from above and from the camera of a robot on them, as one figure."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import Pose
from nao_course.plotting import Drawing, course_style, plot_field, plot_picture, plot_pose
from nao_course.sim import NAO_V4, Field, Reality, render

_VIEW = NAO_V4.view("bottom", 0.0, float(np.radians(-31.0)))
_SEED = 3
_SHOWN = {
    "2012": ("2012: half the field, yellow goal", Pose(1.1, 0.5, -0.2)),
    "2025": ("2025: 9 x 6 m, white goals", Pose(2.2, 0.9, -0.25)),
    "lab": ("lab: 4.5 x 3 m, no goals", Pose(0.3, -0.9, 0.75)),
}


@course_style()
def draw_fields() -> bytes:
    """Return a PNG: each field's map above a picture of it; the same at every call."""
    figure = Figure(figsize=(12.0, 6.6))
    axes = figure.subplots(2, len(_SHOWN), height_ratios=(1.25, 1))
    for (name, (title, pose)), (above, seen) in zip(_SHOWN.items(), axes.T, strict=True):
        field = Field.from_toml(name)
        plot_field(field, above)
        plot_pose(pose, above, "truth")
        above.set_title(title, fontsize=12)
        pixels, _ = render(field, pose, _VIEW, Reality.lab(_SEED), np.random.default_rng(_SEED))
        plot_picture(pixels, seen, ticks=False)
    return Drawing(figure, "").image()
