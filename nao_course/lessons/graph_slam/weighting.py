"""Which weight is best: maps of many drives whose measurements are unlike, weighted by powers of their deviation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.drives import Constraint, Drive, field_drive
from nao_course.lessons.graph_slam.systems import Builders, Function, map_error, solve_axes
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.style import GREY

DRIVES = 25
POWERS = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
NEAR, FAR = 0.02, 0.5  # m, standard deviations of the best and the worst measurement of a drive


def unlike_drive(seed: int) -> Drive:
    """Return a drive each of whose measurements has its own standard deviation, between `NEAR` and `FAR`."""
    clean, rng = field_drive(seed, noise=0.0), np.random.default_rng([seed, 88])
    made: list[Constraint] = []
    for each in clean.constraints:
        sigma = float(np.exp(rng.uniform(np.log(NEAR), np.log(FAR)))) if each.kind != "start" else 0.0
        noise = sigma * rng.standard_normal(2)
        made.append(replace(each, value=each.value + noise, epsilon=sigma**2 or each.epsilon))
    return replace(clean, constraints=tuple(made))


def errors_by_power(builders: Builders, solve: Function) -> FloatArray:
    """Root mean square error of the map, m, for weights of 1 / sigma ** p: for each p of `POWERS`."""
    drives = [unlike_drive(seed) for seed in range(DRIVES)]
    found = []
    for power in POWERS:
        errors = []
        for drive in drives:
            used = [replace(each, epsilon=each.epsilon ** (power / 2)) for each in drive.constraints]
            errors.append(map_error(drive, solve_axes(used, drive.size, builders, solve)[0]))
        found.append(float(np.sqrt(np.mean(np.square(errors)))))
    return np.array(found)


def draw_powers(errors: FloatArray) -> Drawing:
    """Draw the error of the map over the power of the standard deviation that weights it, for each of `POWERS`."""
    best = int(np.argmin(errors))
    with course_style():
        figure = Figure(figsize=(7.4, 3.9))
        ax = figure.add_subplot()
        look = STYLES["graph"]
        ax.axvline(2, color=GREY, lw=0.8)
        ax.plot(POWERS, 100 * errors, color=look.colour, marker=look.marker, lw=2, ms=7, mec="white")
        for power, words in (
            (0, "all alike"),
            (1, r"1 / $\sigma$"),
            (2, r"1 / $\sigma^2$"),
            (4, r"1 / $\sigma^4$"),
        ):
            ax.annotate(
                words,
                (power, 100 * errors[POWERS.index(power)]),
                (0, 10),
                textcoords="offset points",
                ha="center",
            )
        ax.set(xlabel=r"p: each measurement has the weight 1 / $\sigma^p$", ylabel="error of the map (cm)")
        ax.set_ylim(0, 1.25 * 100 * errors.max())
        ax.grid(color="#e3e5e8")
    said = ", ".join(
        f"{100 * error:.1f} cm for p = {power:g}" for power, error in zip(POWERS, errors, strict=True)
    )
    return Drawing(
        figure,
        f"Error of the map over {DRIVES} drives by the power of the weight: {said}. Least at {POWERS[best]:g}.",
    )
