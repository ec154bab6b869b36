"""The benchmark's cases, tables and results."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks import BUILD, Result, Table
from benchmarks.simulator.reality.figure import draw_pictures
from benchmarks.simulator.reality.fit import (
    SET_VALUES,
    SETS,
    Case,
    Freedom,
    Prediction,
    SetFit,
    corrected_walk,
    errors_of,
    fit_residuals,
    run_case,
    summary,
)
from nao_course.datasets import read_pictures
from nao_course.geometry import FloatArray

DISTANCES = (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0)  # metres, edges of the table's rows


def main() -> Result:
    """Run every case, draw the figure, and return tables and values.

    Raises
    ------
    FileNotFoundError
        If the recorded data is not there; it says what to do.
    """
    scenes, given = read_pictures("scenes"), read_pictures("straightwalk")
    walk = corrected_walk(given)
    judged = (run_case("scenes", scenes), run_case("straightwalk", walk))
    as_given = run_case("straightwalk, poses as given", given)
    variants = (
        run_case("scenes, square pixels", scenes, Freedom(square=True)),
        run_case("straightwalk, square pixels", walk, Freedom(square=True)),
        run_case("scenes, positions free (5 cm)", scenes, Freedom(position_sd=0.05)),
        run_case("straightwalk, positions free (5 cm)", walk, Freedom(position_sd=0.05)),
    )
    cases = (*judged, as_given, *variants)
    both = tuple(p for case in judged for p in case.predictions)
    both_as_given = (*judged[0].predictions, *as_given.predictions)
    figure = draw_pictures({name: case.fit for name, case in zip(SETS, judged, strict=True)}, judged)
    tables = (
        _fit_table(cases),
        _error_table(
            [
                *((c.title, c.predictions) for c in cases),
                ("both", both),
                ("both, poses as given", both_as_given),
            ]
        ),
        _kind_table(judged),
        _distance_table(judged),
        _correction_table(judged),
    )
    values: dict[str, Any] = {
        case.title: {
            "pictures": len(case.fit.matched),
            "points": len(case.predictions),
            **dict(zip(SET_VALUES, _readable(case.fit.values), strict=True)),
            "error_px": summary(errors_of(case.predictions)),
            "sd_deg": dict(zip(("pitch", "roll", "heading"), _spread(case.fit), strict=True)),
        }
        for case in cases
    }
    values["both"] = {"points": len(both), "error_px": summary(errors_of(both))}
    values["both, poses as given"] = {
        "points": len(both_as_given),
        "error_px": summary(errors_of(both_as_given)),
    }
    notes = (
        "Each point is predicted from its picture's other points, with set values fitted to other pictures.",
        "No point is left out of the errors. straightwalk: the first seven pictures stand one stop (0.2 m)",
        "farther back than their poses say (docs/real_data.md); all other poses as given.",
        f"Figure: {figure.relative_to(BUILD.parent).as_posix()} (real pictures: not ours to pass on)",
    )
    return Result("reality", values, tables, notes)


def _readable(values: FloatArray) -> list[float]:
    """Return a set's values with angles in degrees."""
    height, hfov, vfov, k1, offset = values.tolist()
    return [height, *np.degrees([hfov, vfov]).tolist(), k1, float(np.degrees(offset))]


def _spread(fit: SetFit) -> list[float]:
    """Return the standard deviations of pitch, roll and heading corrections over pictures, degrees."""
    found: list[float] = np.degrees(fit.corrections[:, :3].std(axis=0, ddof=1)).tolist()
    return found


def _spread_within_places(fit: SetFit) -> list[float]:
    """Return the same about the mean of each position at which more than one picture was taken."""
    places: dict[tuple[float, float], list[FloatArray]] = {}
    for item, correction in zip(fit.matched, fit.corrections, strict=True):
        places.setdefault((item.picture.pose.x, item.picture.pose.y), []).append(correction[:3])
    groups = [np.array(group) for group in places.values() if len(group) > 1]
    if not groups:
        return []
    off = np.concatenate([group - group.mean(axis=0) for group in groups])
    freedom = len(off) - len(groups)
    found: list[float] = np.degrees(np.sqrt((off**2).sum(axis=0) / freedom)).tolist()
    return found


def _fit_table(cases: Iterable[Case]) -> Table:
    rows = []
    for case in cases:
        height, hfov, vfov, k1, offset = _readable(case.fit.values)
        fitted = (f"{height:.3f}", f"{hfov:.1f}", f"{vfov:.1f}", f"{k1:+.3f}", f"{offset:+.1f}")
        rows.append((case.title, len(case.fit.matched), *fitted))
    heads = ("fitted once per set", "pictures", "height m", "hfov deg", "vfov deg", "k1", "pitch off deg")
    return Table("Camera", heads, tuple(rows))


def _error_table(named: Iterable[tuple[str, Sequence[Prediction]]]) -> Table:
    rows = tuple((name, len(found), *summary(errors_of(found)).values()) for name, found in named)
    return Table(
        "Error of left-out points, pixels at 320 x 240",
        ("set", "points", "median", "90%", "95%", "max"),
        rows,
    )


def _kind_table(cases: Iterable[Case]) -> Table:
    rows = []
    for case in cases:
        residuals = fit_residuals(case.fit)
        for kind, off in residuals.items():
            errors = summary(errors_of(p for p in case.predictions if p.kind == kind))
            bias = (f"{value:+.2f}" for value in np.median(off, axis=0))
            rows.append((f"{case.title}: {kind}", len(off), errors["median"], errors["90%"], *bias))
    heads = ("kind", "points", "median", "90%", "bias right", "bias down")
    return Table("By kind (bias: median of marked minus fitted)", heads, tuple(rows))


def _distance_table(cases: Iterable[Case]) -> Table:
    rows = []
    for case in cases:
        for near, far in pairwise(DISTANCES):
            found = [p for p in case.predictions if near <= p.distance < far]
            if found:
                errors = summary(errors_of(found))
                rows.append(
                    (f"{case.title}: {near:.0f}-{far:.0f} m", len(found), errors["median"], errors["90%"])
                )
    return Table("By distance from the robot", ("distance", "points", "median", "90%"), tuple(rows))


def _correction_table(cases: Iterable[Case]) -> Table:
    rows: list[tuple[object, ...]] = []
    for case in cases:
        rows.append((case.title, *_spread(case.fit), float(np.degrees(case.fit.corrections[:, 1].mean()))))
        if within := _spread_within_places(case.fit):
            rows.append((f"{case.title}, within a place", *within, ""))
    heads = ("set", "pitch sd", "roll sd", "heading sd", "mean roll")
    return Table("Corrections per picture, degrees", heads, tuple(rows))
