"""The panels of lesson 06: the fusion of two estimates, and the diagnosis lab."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray
from nao_course.lessons.localization.consistency import BAND, median_band
from nao_course.lessons.localization.drives import Trace
from nao_course.lessons.localization.lab import (
    BUGS,
    HEALTHY,
    MEDIAN_NEES,
    MEDIAN_NIS,
    Bug,
    Readings,
    patient,
    read,
)
from nao_course.plotting import STYLES, Drawing, Table, course_style, table
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY, style_of
from nao_course.widgets import Choice, FunctionPanel, Slider
from nao_course.widgets.attempts import newest_definition

PREDICTED = 2.0  # m, the odometry's estimate
NOT_YET = "not yet"
PATIENTS = "ABCDEFGHIJK"
_ORDER = np.random.default_rng(61).permutation(len(PATIENTS))
CASES: dict[str, Bug] = {
    letter: (HEALTHY, *BUGS)[number] for letter, number in zip(PATIENTS, _ORDER.tolist(), strict=True)
}


class FusePanel(FunctionPanel):
    """Show a predicted and a measured distance, and their fusion by a student's `fuse`.

    Parameters
    ----------
    fuse : callable
        ``fuse(mean_a, variance_a, mean_b, variance_b)`` returns (mean, variance).
    """

    def __init__(self, fuse: Callable[..., Any]) -> None:
        """Begin with a measurement of half the prediction's standard deviation."""
        sigma = {"unit": "m", "tooltip": "Standard deviation"}
        super().__init__(
            "Two estimates",
            self._fused,
            [
                Slider("prediction_sigma", "Odometry σ", 0.02, 0.6, 0.01, 0.3, **sigma),
                Slider("measurement_sigma", "Camera σ", 0.02, 0.6, 0.01, 0.15, **sigma),
                Slider(
                    "measured",
                    "Camera",
                    1.0,
                    3.0,
                    0.05,
                    2.5,
                    unit="m",
                    tooltip="Measured distance; 2 m is predicted",
                ),
            ],
            student={"fuse": fuse},
            unfinished="Finish exercise 6.1 to see the fused estimate.",
        )

    def _fused(self, values: Any, student: Any) -> Iterator[Any]:
        """Show both densities, then the fused one."""
        given = (PREDICTED, values.prediction_sigma**2, values.measured, values.measurement_sigma**2)
        yield {"Estimates": draw_estimates(*given)}
        mean, variance = map(float, student.fuse(*given))
        yield {"Estimates": draw_estimates(*given, fused=(mean, variance))}
        moved = values.measured - PREDICTED
        weight = (
            f" The weight of the measurement is {(mean - PREDICTED) / moved:.2f}."
            if abs(moved) > 1e-9
            else ""
        )
        sigma = (
            f"standard deviation {np.sqrt(variance):.3f} m"
            if variance >= 0
            else f"variance {variance:.3g} m²"
        )
        yield f"Fused: {mean:.2f} m, {sigma}.{weight}"


@course_style()
def draw_estimates(
    mean_a: float,
    variance_a: float,
    mean_b: float,
    variance_b: float,
    fused: tuple[float, float] | None = None,
) -> Drawing:
    """Draw the densities of a predicted and a measured distance (m), and of the fused one."""
    x = np.linspace(0.5, 3.5, 601)
    curves = {
        "predicted by odometry": (mean_a, variance_a, STYLES["odometry"].colour, "--"),
        "measured": (mean_b, variance_b, STYLES["truth"].colour, ":"),
    }
    if fused is not None:
        curves["fused"] = (*fused, STYLES["ekf"].colour, "-")
    figure = Figure(figsize=(7.6, 3.4))
    ax = figure.add_subplot()
    for label, (mean, variance, colour, line) in curves.items():
        density = _density(x, mean, variance)
        ax.plot(x, density, color=colour, ls=line, lw=2.2, label=label)
        ax.fill_between(x, density, color=colour, alpha=0.1, lw=0)
    ax.set(xlabel="distance to the goal line (m)", ylabel="density (1/m)", xlim=(0.5, 3.5), ylim=(0, None))
    ax.legend()
    said = "; ".join(
        f"{label}: {mean:.2f} m, variance {variance:.4f} m²" for label, (mean, variance, *_) in curves.items()
    )
    return Drawing(figure, f"Estimates of a distance. {said}.")


def _density(x: FloatArray, mean: float, variance: float) -> FloatArray:
    if not variance > 0:
        return np.zeros_like(x)
    return np.asarray(np.exp(-((x - mean) ** 2) / (2 * variance)) / np.sqrt(2 * np.pi * variance))


class LabPanel(FunctionPanel):
    """Show the readings of eleven copies of the student's filter, ten of them with one fault.

    Parameters
    ----------
    localize, predict_pose, predict_covariance : callable
        The student's functions.
    """

    def __init__(
        self,
        localize: Callable[..., Any],
        predict_pose: Callable[..., Any],
        predict_covariance: Callable[..., Any],
    ) -> None:
        """Begin with the first patient."""
        self._functions = {
            "localize": localize,
            "predict_pose": predict_pose,
            "predict_covariance": predict_covariance,
        }
        self._seen: dict[Any, tuple[Drawing, Table]] = {}
        self.named: set[str] = set()
        self._patient = next(iter(PATIENTS))
        super().__init__(
            "Diagnosis lab",
            self._examine,
            [
                Choice("patient", "Patient", list(PATIENTS), tooltip="Which filter to examine"),
                Choice(
                    "diagnosis",
                    "Your diagnosis",
                    [NOT_YET, HEALTHY.name, *sorted(bug.name for bug in BUGS)],
                    tooltip="The fault that you suspect",
                ),
            ],
            student=self._functions,
            unfinished={
                "localize": "Finish exercise 6.6: the patients are copies of your filter.",
                "predict_pose": "The patients need your predict_pose from lesson 05.",
                "predict_covariance": "The patients need your predict_covariance from lesson 05.",
            },
        )

    def _examine(self, values: Any, student: Any) -> Iterator[Any]:
        """Run the patient, show its plots and readings, and answer the diagnosis."""
        bug = CASES[values.patient]
        diagnosis = values.diagnosis if values.patient == self._patient else NOT_YET
        self._patient = values.patient
        self._take(self._checked({"diagnosis": diagnosis}))
        plots, readings = self._readings(values.patient, bug, student)
        yield {"Plots": plots}
        yield {"": readings}
        yield self._answer(values.patient, bug, diagnosis)

    def _readings(self, letter: str, bug: Bug, student: Any) -> tuple[Drawing, Table]:
        """Return the plots and readings of a patient; they are computed once for each version of the filter."""
        newest = {name: newest_definition(function) for name, function in self._functions.items()}
        key = (letter, *newest.values())
        if key not in self._seen:
            # The student's own functions run first, so that an error in them is reported as theirs.
            patient(HEALTHY, student, drives=1)
            traces = patient(bug, newest)
            self._seen[key] = draw_readings(traces, letter), readings_table({letter: read(traces)})
        return self._seen[key]

    def _answer(self, letter: str, bug: Bug, diagnosis: str) -> str:
        if diagnosis == NOT_YET:
            return f"Patient {letter}: {len(self.named)} of {len(PATIENTS)} named so far."
        claimed = next(each for each in CASES.values() if each.name == diagnosis)
        if claimed is not bug:
            return f"No: that fault looks different. {claimed.name[0].upper()}{claimed.name[1:]}: {claimed.shows}"
        self.named.add(letter)
        count = f"Named so far: {len(self.named)} of {len(PATIENTS)}."
        return f"Right, the diagnosis of patient {letter} is: {bug.name}. {bug.shows} {count}"


def readings_table(readings: dict[str, Readings]) -> Table:
    """Return a table of readings with a row for each patient."""
    columns = ("", "bearing (σ)", "range (σ)", "NIS early", "NIS late", "NIS peak", "NEES early", "NEES late")
    return table(columns, [(name, *map(_short, vars(each).values())) for name, each in readings.items()])


def _short(value: float) -> str:
    """Format a number with two significant digits."""
    if abs(value) >= 1000:
        return f"{value:.0e}".replace("e+0", "e").replace("e+", "e")
    return f"{value:z.1f}" if abs(value) >= 10 else f"{value:z.2f}"


@course_style()
def draw_readings(traces: list[Trace], name: str) -> Drawing:
    """Draw the normalised innovations, NIS and NEES of a patient's drives at each step."""
    steps = np.concatenate([trace.steps for trace in traces])
    scaled = np.concatenate(
        [
            trace.innovations / np.sqrt(np.diagonal(trace.innovation_covariances, axis1=1, axis2=2))
            for trace in traces
        ]
    )
    nis = np.concatenate([trace.nis for trace in traces])
    nees = np.median([trace.nees for trace in traces], axis=0)
    when, counts = np.unique(steps, return_counts=True)
    figure = Figure(figsize=(10.4, 3.5))
    residuals, left, right = figure.subplots(1, 3)
    residuals.axhspan(-2, 2, color=BAND, zorder=0)
    residuals.axhline(0, color=GREY, lw=1)
    for column, (label, source) in enumerate((("bearing", "ekf"), ("range", "odometry"))):
        style = style_of(source)
        shift = 0.22 * (2 * column - 1)
        values = np.clip(scaled[:, column], -9.7, 9.7)
        residuals.plot(
            steps + shift, values, style.marker, color=style.colour, ms=1.8, alpha=0.45, label=label
        )
    residuals.set(
        title="Normalised innovations",
        xlabel="step",
        ylabel="innovation / its standard deviation",
        ylim=(-10, 10),
    )
    medians = np.array([np.median(nis[steps == step]) for step in when]) / MEDIAN_NIS
    _plot_gauge(left, when, medians, median_band(2, counts) / MEDIAN_NIS, "NIS")
    limits = median_band(3, np.full(len(nees), len(traces))) / MEDIAN_NEES
    _plot_gauge(right, np.arange(len(nees)), nees / MEDIAN_NEES, limits, "NEES")
    legend_below(figure, _large(residuals.get_legend_handles_labels()[0]))
    r = read(traces)
    return Drawing(
        figure,
        f"Patient {name}, 20 drives. Median normalised innovation: bearing {r.bearing:.2g}, range "
        f"{r.range:.2g} standard deviations. "
        f"NIS divided by the expected median: {r.nis_early:.2g} early, {r.nis_late:.2g} late, {r.nis_peak:.2g} at "
        "most. "
        f"NEES: {r.nees_early:.2g} early, {r.nees_late:.2g} late.",
    )


def _large(points: list[Any]) -> list[Any]:
    """Return the same markers for a legend, in a readable size."""
    return [
        Line2D([], [], color=each.get_color(), marker=each.get_marker(), ls="", ms=6, label=each.get_label())
        for each in points
    ]


def _plot_gauge(ax: Any, steps: Any, values: FloatArray, limits: FloatArray, name: str) -> None:
    """Plot medians divided by the expected median on a logarithmic axis of fixed limits."""
    ax.fill_between(steps, *limits, color=BAND, zorder=0)
    ax.axhline(1, color=GREY, lw=1)
    shown = np.clip(np.nan_to_num(values, nan=1e4, posinf=1e4), 1e-2, 1e4)
    ax.semilogy(steps, shown, "-", marker=".", ms=4, lw=1.2, color=STYLES["ekf"].colour)
    ax.minorticks_off()
    ax.set(title=f"{name} / expected median", xlabel="step", ylim=(0.8e-2, 1.4e4))
