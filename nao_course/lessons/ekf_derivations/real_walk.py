"""The student's expected measurements beside the measurements of a real NAO's walk."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nao_course.datasets.real_walk import FIELD, recorded_walk
from nao_course.geometry import wrap_angle
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.sim.drives import Function


@course_style()
def draw_real_measurements(expected_measurement: Function) -> Drawing:
    """Draw measured minus expected bearing and range of the landmarks of a real walk, over the distance.

    Parameters
    ----------
    expected_measurement : callable
        The student's function.

    Returns
    -------
    Drawing
        Two plots with a point for each measurement.
    """
    drive = recorded_walk()
    rows = [
        (number, step.pose, measured)
        for step in drive.steps
        for number, measured in zip(step.numbers, step.measurements, strict=True)
    ]
    expected = np.array(
        [
            np.asarray(expected_measurement(pose.copy(), drive.landmarks[number].copy()), dtype=float)
            for number, pose, _ in rows
        ]
    ).reshape(len(rows), 2)
    off = np.array([measured for *_, measured in rows]) - expected
    off[:, 0] = np.degrees(wrap_angle(off[:, 0]))
    kinds = np.array([FIELD.detectable_kinds[number] for number, *_ in rows])
    figure = Figure(figsize=(10.6, 3.4))
    left, right = figure.subplots(1, 2)
    for ax, values, name, unit in ((left, off[:, 0], "Bearing", "°"), (right, off[:, 1], "Range", "m")):
        ax.axhline(0, color=STYLES["truth"].colour, lw=1)
        for kind, marker, colour in (
            ("post", "o", STYLES["ekf"].colour),
            ("corner", "s", STYLES["graph"].colour),
        ):
            shown = kinds == kind
            ax.plot(expected[shown, 1], values[shown], marker, color=colour, ms=5, alpha=0.7, label=kind)
        ax.set(title=name, xlabel="distance (m)", ylabel=f"measured minus expected ({unit})")
    legend_below(figure, left.get_legend_handles_labels()[0])
    said = [
        f"{where} the bearing's median error is {np.median(np.abs(off[chosen, 0])):.1f} degrees and the median range "
        f"is {np.median(off[chosen, 1]):.2f} m off"
        for where, chosen in (("within 3 m", expected[:, 1] < 3), ("beyond 4 m", expected[:, 1] > 4))
    ]
    return Drawing(figure, f"{len(rows)} measurements of a real walk: {'; '.join(said)}.")
