"""Which weight is best: what error a map is to be expected to have, by how unlike measurements are weighted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.drives import Drive, field_drive
from nao_course.lessons.graph_slam.systems import Builders, assemble, inverse_of
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.style import GREY

DRIVES = 25
POWERS = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
NEAR, FAR = 0.02, 0.5  # m, standard deviations of the best and the worst measurement of a drive


def unlike_drive(seed: int) -> Drive:
    """Return a drive each of whose measurements has its own standard deviation, between `NEAR` and `FAR`."""
    clean, rng = field_drive(noise=0.0), np.random.default_rng([seed, 88])
    sigmas = np.exp(rng.uniform(np.log(NEAR), np.log(FAR), len(clean.constraints)))
    made = (
        each if each.kind == "start" else replace(each, epsilon=float(sigma) ** 2)
        for each, sigma in zip(clean.constraints, sigmas, strict=True)
    )
    return replace(clean, constraints=tuple(made))


def expected_error(drive: Drive, builders: Builders, power: float) -> float:
    """Root of the mean square error that a map is to be expected to have, over all errors that may come.

    The answer is linear in what was measured, so its covariance follows from those of the measurements: with the
    weights w, it is the inverse of omega on both sides of the sum that omega is, with w * w * sigma**2 for w.

    Parameters
    ----------
    drive : Drive
        Its constraints have their true variances; the start has no error.
    builders : Builders
        The student's functions.
    power : float
        Each measurement has the weight ``1 / sigma ** power``.

    Returns
    -------
    float
        In metres, of the landmarks.
    """
    used = [replace(each, epsilon=each.epsilon ** (power / 2)) for each in drive.constraints]
    errors = [
        replace(each, epsilon=weighted.epsilon**2 / each.epsilon)
        for each, weighted in zip(drive.constraints, used, strict=True)
        if each.kind != "start"
    ]
    inverse = inverse_of(assemble(used, drive.size, builders, 0)[0])
    covariance = inverse @ assemble(errors, drive.size, builders, 0)[0] @ inverse
    return float(np.sqrt(2 * np.diag(covariance)[len(drive.path) :].mean()))  # two axes


def errors_by_power(builders: Builders) -> FloatArray:
    """Root mean square error of the map to be expected, m, for weights of 1 / sigma ** p: for each p of `POWERS`."""
    drives = [unlike_drive(seed) for seed in range(DRIVES)]
    errors = [[expected_error(each, builders, power) for each in drives] for power in POWERS]
    return np.asarray(np.sqrt(np.mean(np.square(errors), axis=1)))


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
        ax.set(
            xlabel=r"p: each measurement has the weight 1 / $\sigma^p$", ylabel="error to be expected (cm)"
        )
        ax.set_ylim(0, 1.25 * 100 * errors.max())
        ax.grid(color="#e3e5e8")
    said = ", ".join(
        f"{100 * error:.1f} cm for p = {power:g}" for power, error in zip(POWERS, errors, strict=True)
    )
    return Drawing(
        figure,
        f"Error of the map to be expected over {DRIVES} drives by the power of the weight: {said}. "
        f"Least at {POWERS[best]:g}.",
    )
