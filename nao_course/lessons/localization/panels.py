"""The panels of lesson 06: two beliefs that become one, and the diagnosis lab."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray
from nao_course.lessons.localization.drives import Trace
from nao_course.lessons.localization.honesty import BAND, median_band
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
from nao_course.plotting.style import GREY
from nao_course.widgets import Choice, FunctionPanel, Slider
from nao_course.widgets.attempts import newest_definition

PREDICTED = 2.0  # m, where the odometry puts the robot
NOT_YET = "not yet"
PATIENTS = "ABCDEFGHIJK"
_ORDER = np.random.default_rng(61).permutation(len(PATIENTS))
CASES: dict[str, Bug] = {
    letter: (HEALTHY, *BUGS)[number] for letter, number in zip(PATIENTS, _ORDER.tolist(), strict=True)
}


class FusePanel(FunctionPanel):
    """What odometry predicts, what is measured, and what your `fuse` makes of both.

    Parameters
    ----------
    fuse : callable
        ``fuse(mean_a, variance_a, mean_b, variance_b)`` returns (mean, variance).
    """

    def __init__(self, fuse: Callable[..., Any]) -> None:
        """Begin with a measurement that is twice as good as the prediction."""
        sigma = {"unit": "m", "tooltip": "Standard deviation"}
        super().__init__(
            "Two beliefs",
            self._fused,
            [
                Slider("prediction_sigma", "Odometry σ", 0.02, 0.6, 0.01, 0.3, **sigma),
                Slider("measurement_sigma", "Camera σ", 0.02, 0.6, 0.01, 0.15, **sigma),
                Slider(
                    "measured",
                    "Camera says",
                    1.0,
                    3.0,
                    0.05,
                    2.5,
                    unit="m",
                    tooltip="What is measured; 2 m is predicted",
                ),
            ],
            student={"fuse": fuse},
            unfinished="Finish exercise 6.1 to see both beliefs fused.",
        )

    def _fused(self, values: Any, student: Any) -> Iterator[Any]:
        """Show both curves, then the student's."""
        given = (PREDICTED, values.prediction_sigma**2, values.measured, values.measurement_sigma**2)
        yield {"Beliefs": draw_beliefs(*given)}
        mean, variance = map(float, student.fuse(*given))
        yield {"Beliefs": draw_beliefs(*given, fused=(mean, variance))}
        moved = values.measured - PREDICTED
        weight = (
            f" The weight of the measurement is {(mean - PREDICTED) / moved:.2f}."
            if abs(moved) > 1e-9
            else ""
        )
        sigma = f"{np.sqrt(variance):.3f}" if variance >= 0 else "of a negative variance"
        yield f"Fused: {mean:.2f} m, standard deviation {sigma} m.{weight}"


def draw_beliefs(
    mean_a: float,
    variance_a: float,
    mean_b: float,
    variance_b: float,
    fused: tuple[float, float] | None = None,
) -> Drawing:
    """Draw the densities of a prediction and a measurement, and of both together, over a distance (m)."""
    x = np.linspace(0.5, 3.5, 601)
    curves = {
        "predicted by odometry": (mean_a, variance_a, STYLES["odometry"].colour, "--"),
        "measured": (mean_b, variance_b, STYLES["truth"].colour, ":"),
    }
    if fused is not None:
        curves["fused"] = (*fused, STYLES["ekf"].colour, "-")
    with course_style():
        figure = Figure(figsize=(7.6, 3.4))
        ax = figure.add_subplot()
        for label, (mean, variance, colour, line) in curves.items():
            density = _density(x, mean, variance)
            ax.plot(x, density, color=colour, ls=line, lw=2.2, label=label)
            ax.fill_between(x, density, color=colour, alpha=0.1, lw=0)
        ax.set(
            xlabel="distance to the goal line (m)", ylabel="density (1/m)", xlim=(0.5, 3.5), ylim=(0, None)
        )
        ax.legend()
    said = "; ".join(
        f"{label}: {mean:.2f} m, variance {variance:.4f} m²" for label, (mean, variance, *_) in curves.items()
    )
    return Drawing(figure, f"Beliefs about a distance. {said}.")


def _density(x: FloatArray, mean: float, variance: float) -> FloatArray:
    if not variance > 0:
        return np.zeros_like(x)
    return np.asarray(np.exp(-((x - mean) ** 2) / (2 * variance)) / np.sqrt(2 * np.pi * variance))


class LabPanel(FunctionPanel):
    """The diagnosis lab: eleven filters, all your own, ten of them with one thing wrong.

    Parameters
    ----------
    localize, predict_pose, predict_covariance : callable
        The student's.
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
        super().__init__(
            "Diagnosis lab",
            self._examine,
            [
                Choice("patient", "Patient", list(PATIENTS), tooltip="Which filter drives"),
                Choice(
                    "diagnosis",
                    "Your diagnosis",
                    [NOT_YET, HEALTHY.name, *sorted(bug.name for bug in BUGS)],
                    tooltip="What is wrong with it",
                ),
            ],
            student=self._functions,
            unfinished={
                "localize": "Finish exercise 6.7: the patients are made of your filter.",
                "predict_pose": "The patients need your predict_pose of lesson 05.",
                "predict_covariance": "The patients need your predict_covariance of lesson 05.",
            },
        )

    def _examine(self, values: Any, student: Any) -> Iterator[Any]:
        """Let the patient drive, show its instruments, and answer the diagnosis."""
        bug = CASES[values.patient]
        instruments, readings = self._instruments(values.patient, bug, student)
        yield {"Instruments": instruments}
        yield {"": readings}
        yield self._answer(values.patient, bug, values.diagnosis)

    def _instruments(self, letter: str, bug: Bug, student: Any) -> tuple[Drawing, Table]:
        """What a patient's drives show; of the same filter they are made only once."""
        newest = {name: newest_definition(function) for name, function in self._functions.items()}
        key = (letter, *newest.values())
        if key not in self._seen:
            patient(HEALTHY, student, drives=1)  # what the student's code raises is said as theirs
            traces = patient(bug, newest)
            self._seen[key] = draw_instruments(traces, letter), readings_table({letter: read(traces)})
        return self._seen[key]

    def _answer(self, letter: str, bug: Bug, diagnosis: str) -> str:
        if diagnosis == NOT_YET:
            return f"Patient {letter}: {len(self.named)} of {len(PATIENTS)} named so far."
        claimed = next(each for each in CASES.values() if each.name == diagnosis)
        if claimed is not bug:
            return f"No. {claimed.name[0].upper()}{claimed.name[1:]} would show otherwise. {claimed.shows}"
        self.named.add(letter)
        count = f"Named so far: {len(self.named)} of {len(PATIENTS)}."
        return f"Right, patient {letter} has it: {bug.name}. {bug.shows} {count}"


def readings_table(readings: dict[str, Readings]) -> Table:
    """What the instruments show, a row for each patient."""
    columns = ("", "bearing (σ)", "range (σ)", "NIS early", "NIS late", "NIS peak", "NEES early", "NEES late")
    return table(columns, [(name, *map(_short, vars(each).values())) for name, each in readings.items()])


def _short(value: float) -> str:
    """A number with two digits that count."""
    if abs(value) >= 1000:
        return f"{value:.0e}".replace("e+0", "e").replace("e+", "e")
    return f"{value:z.1f}" if abs(value) >= 10 else f"{value:z.2f}"


def draw_instruments(traces: list[Trace], name: str) -> Drawing:
    """Draw residuals, NIS and NEES of a patient's drives, step by step.

    Parameters
    ----------
    traces : list of Trace
        Its drives.
    name : str
        Whose.

    Returns
    -------
    Drawing
        Three plots; its text has the readings.
    """
    steps = np.concatenate([trace.steps for trace in traces])
    scaled = np.concatenate(
        [trace.innovations / np.sqrt(np.diagonal(trace.spreads, axis1=1, axis2=2)) for trace in traces]
    )
    nis = np.concatenate([trace.nis for trace in traces])
    nees = np.median([trace.nees for trace in traces], axis=0)
    when, counts = np.unique(steps, return_counts=True)
    with course_style():
        figure = Figure(figsize=(10.4, 3.5))
        residuals, left, right = figure.subplots(1, 3)
        residuals.axhspan(-2, 2, color=BAND, zorder=0)
        residuals.axhline(0, color=GREY, lw=1)
        for column, (label, source) in enumerate((("bearing", "ekf"), ("range", "odometry"))):
            style = STYLES[source]
            shift = 0.22 * (2 * column - 1)
            values = np.clip(scaled[:, column], -9.7, 9.7)
            residuals.plot(
                steps + shift, values, style.marker, color=style.colour, ms=1.8, alpha=0.45, label=label
            )
        residuals.set(title="Residuals", xlabel="step", ylabel="standard deviations, by S", ylim=(-10, 10))
        medians = np.array([np.median(nis[steps == step]) for step in when]) / MEDIAN_NIS
        _plot_gauge(left, when, medians, median_band(2, counts) / MEDIAN_NIS, "NIS")
        limits = median_band(3, np.full(len(nees), len(traces))) / MEDIAN_NEES
        _plot_gauge(right, np.arange(len(nees)), nees / MEDIAN_NEES, limits, "NEES")
        legend_below(figure, _large(residuals.get_legend_handles_labels()[0]))
    r = read(traces)
    return Drawing(
        figure,
        f"Instruments of patient {name}, 20 drives. Median residual: bearing {r.bearing:.2g}, range "
        f"{r.range:.2g} standard deviations. "
        f"NIS over its healthy value: {r.nis_early:.2g} early, {r.nis_late:.2g} late, {r.nis_peak:.2g} at "
        "most. "
        f"NEES: {r.nees_early:.2g} early, {r.nees_late:.2g} late.",
    )


def _large(points: list[Any]) -> list[Any]:
    """The same points for a legend, large enough to be told apart."""
    return [
        Line2D([], [], color=each.get_color(), marker=each.get_marker(), ls="", ms=6, label=each.get_label())
        for each in points
    ]


def _plot_gauge(ax: Any, steps: Any, values: FloatArray, limits: FloatArray, name: str) -> None:
    """Medians over what they should be, on an axis that ends where nothing more is to be learnt."""
    ax.fill_between(steps, *limits, color=BAND, zorder=0)
    ax.axhline(1, color=GREY, lw=1)
    shown = np.clip(np.nan_to_num(values, nan=1e4, posinf=1e4), 1e-2, 1e4)
    ax.semilogy(steps, shown, "-", marker=".", ms=4, lw=1.2, color=STYLES["ekf"].colour)
    ax.minorticks_off()
    ax.set(title=f"{name}, over its healthy value", xlabel="step", ylim=(0.8e-2, 1.4e4))
