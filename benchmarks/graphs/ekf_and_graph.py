"""Lesson 07's EKF and lesson 09's graph on the same simulated drives: error, NEES and time by the drive's length.

``python -m benchmarks ekf_and_graph`` also writes what the lesson's figure shows.
"""

from typing import Any

from benchmarks import Result, Table, digits, solution, write_json
from nao_course.lessons.pose_graphs.measured.ekf_and_graph import (
    NOISES,
    Filter,
    Smoother,
    at_every_stop,
    compare,
    hall_drive,
    run_filter,
)
from nao_course.lessons.pose_graphs.measured.recorded import EKF_AND_GRAPH

STEPS = (25, 50, 100, 200, 400, 800)
SEEDS = range(30)
SHOWN = "3° a step, 5° bearing"  # in the lesson's figure


def methods() -> tuple[Filter, Smoother]:
    """Return the reference functions of both lessons."""
    ekf, graph = solution("07"), solution("09")
    return Filter(*(ekf[name] for name in Filter._fields)), Smoother(
        *(graph[name] for name in Smoother._fields)
    )


def main() -> Result:
    """Compare them with both noises, and write what the lesson shows."""
    ekf, smoother = methods()
    values: dict[str, Any] = {}
    rows = dict[str, dict[str, str]]()
    for name, noise in NOISES.items():
        found = compare(ekf, smoother, noise, STEPS, SEEDS)
        means = {
            method: {score: each.mean(axis=1).tolist() for score, each in of.items()}
            for method, of in found.items()
        }
        drives = [hall_drive(0, steps, noise) for steps in STEPS]
        every = [at_every_stop(drive, smoother, run_filter(drive, ekf)) for drive in drives]
        values[name] = {"steps": STEPS, "runs": len(SEEDS), "methods": means, "graph_at_every_stop": every}
        for i, steps in enumerate(STEPS):
            for method, of in means.items():
                scores = {
                    score: f"{of[score][i]:.3g}" for score in ("path", "last", "landmarks", "nees", "seconds")
                }
                rows[f"{name}, {method}, {steps} steps"] = scores
    write_json(EKF_AND_GRAPH, digits(values[SHOWN]), 1)
    table = Table.of(
        f"EKF and graph on the same {len(SEEDS)} drives of each length, means: m, NEES (3), s", rows
    )
    last = values[SHOWN]
    note = (
        f"a graph solved anew at each of {STEPS[-1]} stops, one iteration each: "
        f"{last['graph_at_every_stop'][-1]:.2f} s; the EKF: {last['methods']['ekf']['seconds'][-1]:.2f} s"
    )
    return Result("ekf_and_graph", values, (table,), (note,))
