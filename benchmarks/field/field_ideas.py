"""What each idea of lesson 11 buys on the same drives, with its own filter and graph: writes what its figure shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks import Result, Table, solution, write_json
from benchmarks.field.field_slam import AsMeasured
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.observation import Observation
from nao_course.lessons.slam_on_the_field.associating import GATE, Outcome, follow
from nao_course.lessons.slam_on_the_field.gates import shares_of, watch
from nao_course.lessons.slam_on_the_field.ideas import RECORDED
from nao_course.lessons.slam_on_the_field.worlds import drawn_drive

DRIVES, MOVES, FIRST_SEED = 12, 15, 300
COMPASS_SIGMA = float(np.radians(0.7))
LINE_TILT = (float(np.radians(0.3)), float(np.radians(0.3)))
CONSTANT = (float(np.radians(3.0)), 0.15)  # rad, m

Change = Callable[[Observation], Observation]


def constant(seen: Observation) -> Observation:
    """Return an observation with the same noise for all measurements."""
    return replace(seen, covariance=np.diag(np.tile(np.square(CONSTANT), len(seen))))


def alone(seen: Observation) -> Observation:
    """Return an observation without correlations between the measurements."""
    return replace(seen, covariance=seen.covariance * np.kron(np.eye(len(seen)), np.ones((2, 2))))


def whole(seen: Observation) -> Observation:
    """Return an observation unchanged."""
    return seen


def as_measured(seen: Observation) -> Observation:
    """Return an observation whose ranges are not linearised by equation 11.5."""
    return AsMeasured(seen.measurements, seen.covariance, tilt=seen.tilt)


# Idea: what is done to each picture's measurements, by which association, and what else the drive's lines give.
IDEAS: dict[str, tuple[Change, Any, dict[str, Any]]] = {
    "constant R": (constant, None, {}),
    "tilt in R": (alone, None, {}),
    "the whole R": (whole, None, {}),
    "constant R, jointly": (constant, associate_jointly, {}),
    "jointly, without 11.5": (as_measured, associate_jointly, {}),
    "the whole R, jointly": (whole, associate_jointly, {}),
    "lines as a compass": (whole, associate_jointly, {"compass_sigma": COMPASS_SIGMA}),
    "tilt from lines": (whole, associate_jointly, {"compass_sigma": COMPASS_SIGMA, "tilt": LINE_TILT}),
}
BY_GRAPH = "the last, by the graph"


def record(own: Mapping[str, Any], drives: int = DRIVES) -> list[dict[str, Any]]:
    """Record the final errors (m) and NEES of each idea, and the share of wrong associations."""
    rows = []
    for idea, (change, association, told) in IDEAS.items():
        given = [drawn_drive(seed, MOVES, **told) for seed in range(FIRST_SEED, FIRST_SEED + drives)]
        given = [replace(each, log=[(motion, change(seen)) for motion, seen in each.log]) for each in given]
        watched = [watch(own["EkfSlam"], drive, GATE, association) for drive in given]
        rows.append(_row(idea, [each.outcome for each in watched], shares_of(watched)["wrong"]))
    solved = [follow(own["GraphSlam"], drive, GATE, association) for drive in given]
    rows.append(_row(BY_GRAPH, solved, rows[-1]["wrong"]))  # its association is the filter's
    return rows


def _row(idea: str, outcomes: list[Outcome], wrong: float) -> dict[str, Any]:
    return {
        "idea": idea,
        "off": [round(each.off, 4) for each in outcomes],
        "nees": [round(each.nees, 2) for each in outcomes],
        "wrong": round(wrong, 4),
    }


def main() -> Result:
    """Drive with every idea, and write what the lesson's figure shows."""
    rows = record(solution("11"))
    write_json(RECORDED, rows, 1)
    found = {
        row["idea"]: {
            "median off (cm)": 100 * float(np.median(row["off"])),
            "worst (cm)": 100 * max(row["off"]),
            "median NEES": float(np.median(row["nees"])),
            "wrong (%)": 100 * row["wrong"],
        }
        for row in rows
    }
    values = {name: list(of.values()) for name, of in found.items()}
    return Result("field_ideas", values, (Table.of(f"{DRIVES} drives of {MOVES} moves", found),))
