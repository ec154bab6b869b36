"""Scores of nothing, the paper, the reference and better on each challenge's board; code of entries stays in here.

``python -m benchmarks challenges`` writes the rows beside each challenge's declaration, where the board reads them.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import ROOT, Result, Table
from benchmarks.challenges.colours import COLOUR_ENTRIES
from benchmarks.challenges.ekf_slam import EKF_ENTRIES
from benchmarks.challenges.experiments import ROOM_ENTRIES
from benchmarks.challenges.false_closures import FALSE_CLOSURE_ENTRIES
from benchmarks.challenges.field_drives import FIELD_ENTRIES
from benchmarks.challenges.hough_corners import CORNER_ENTRIES
from benchmarks.challenges.jacobians import JACOBIAN_ENTRIES
from benchmarks.challenges.looks import LOOK_ENTRIES
from benchmarks.challenges.measurement_choice import CHOICE_ENTRIES
from benchmarks.challenges.posts import POST_ENTRIES
from benchmarks.challenges.slalom import SLALOM_ENTRIES
from benchmarks.challenges.tilt_entries import TILT_ENTRIES
from benchmarks.challenges.unknown_maps import MAP_ENTRIES
from nao_course.challenges import Challenge, Run
from nao_course.challenges.finding import declared
from nao_course.challenges.running import run

# By lesson: what each row's name enters.
ENTRIES: Mapping[str, Mapping[str, Any]] = {
    "00_meet_the_nao": SLALOM_ENTRIES,
    "01_hsl_filtering": COLOUR_ENTRIES,
    "02_goalposts": POST_ENTRIES,
    "03_hough_corners": CORNER_ENTRIES,
    "04_distance": TILT_ENTRIES,
    "05_ekf_derivations": JACOBIAN_ENTRIES,
    "06_localization": LOOK_ENTRIES,
    "07_ekf_slam": EKF_ENTRIES,
    "08_graph_slam": CHOICE_ENTRIES,
    "09_pose_graphs": FALSE_CLOSURE_ENTRIES,
    "10_experiments": ROOM_ENTRIES,
    "11_slam_on_the_field": FIELD_ENTRIES,
    "12_beyond": MAP_ENTRIES,
}


def row(name: str, came: Run) -> dict[str, Any]:
    """Return the values of a run for the board, rounded to the precision that the board shows."""
    if problems := came.problems():
        raise ValueError(f"{came.challenge.lesson}, {name}: {problems[0]}")
    columns = {key: round(value, 4) for key, value in came.columns.items()}
    cases = [round(each.score, 4) for each in came.results]
    return {"name": name, "score": round(came.score, 4), "columns": columns, "cases": cases}


def rows_file(challenge: Challenge) -> Path:
    """Return the path of the file with a challenge's rows."""
    folder = challenge.lesson.partition("_")[2]
    return ROOT / "nao_course" / "lessons" / folder / "challenge.json"


def margin(better: list[float], worse: list[float]) -> tuple[float, float, float]:
    """Return the mean difference of two entries over the cases, with a 95 % paired bootstrap interval."""
    difference = np.subtract(better, worse)
    draws = np.random.default_rng(0).choice(difference, (10_000, len(difference))).mean(axis=1)
    low, high = np.quantile(draws, [0.025, 0.975])
    return float(difference.mean()), float(low), float(high)


def main() -> Result:
    """Run all entries on all challenges, and write the boards' rows."""
    values, tables, notes = dict[str, Any](), list[Table](), list[str]()
    for lesson, challenge in declared().items():
        rows = [row(name, run(challenge, entry)) for name, entry in ENTRIES[lesson].items()]
        rows_file(challenge).write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
        columns = [column.name for column in challenge.columns]
        cells = tuple(
            (each["name"], each["score"], *(each["columns"][name] for name in columns)) for each in rows
        )
        tables.append(Table(challenge.title, ("", "score", *columns), cells))
        cases = {each["name"]: each["cases"] for each in rows}
        better = list(cases)[-1]
        values[lesson] = {each["name"]: each["score"] for each in rows}
        for other in (name for name in cases if name != better):
            pair = (
                (cases[better], cases[other]) if challenge.higher_is_better else (cases[other], cases[better])
            )
            mean, low, high = margin(*pair)
            values[lesson][f"{better} beats {other} by"] = [mean, low, high]
            notes.append(
                f"{lesson}: {better} beats {other} by {mean:.2f}; 95 % interval {low:.2f} to {high:.2f}"
            )
    return Result("challenges", values, tuple(tables), tuple(notes))
