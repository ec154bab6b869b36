"""Whether lesson 07's filters are consistent: pose NEES over many drives with its 95 % band, and the time of a step."""

import time
from typing import Any

import numpy as np

from benchmarks import Result, Table, solution
from nao_course.lessons.ekf_slam.consistency import (
    NOISY,
    NOMINAL,
    RUNS,
    compare,
    field_drive,
    follow,
    mean_nees,
    with_first_estimates,
)
from nao_course.lessons.ekf_slam.invariant import LEVELS, compare_invariant
from nao_course.metrics import band
from nao_course.sim.drives import Functions, Sigmas

FIELDS: dict[str, Sigmas] = {"nominal": NOMINAL, "noisy": NOISY}
INVARIANT_RUNS, TIMED_RUNS, ROUNDS = 200, 5, 7


def compare_fields(functions: Functions) -> tuple[dict[str, Any], Table]:
    """Run the variants that the lesson's first figure shows, on both fields."""
    low, high = band(3, RUNS)
    values: dict[str, Any] = {"runs": RUNS, "band": [low, high]}
    rows = []
    for field, sigmas in FIELDS.items():
        found = compare(*functions, sigmas=sigmas, with_nis=True)
        values[field] = {}
        for name, traces in found.items():
            nees = mean_nees(traces)
            nis = float(np.concatenate([trace.nis for trace in traces]).mean())
            error = float(np.mean([np.hypot(*trace.errors[-1, :2]) for trace in traces]))
            inside = "inside" if low <= nees <= high else "outside"
            values[field][name] = {"nees": nees, "nis": nis, "error": error}
            rows.append((field, name, f"{nees:.2f}", inside, f"{nis:.2f}", f"{error:.3f}"))
    columns = ("field", "filter", "mean NEES", f"{low:.2f} to {high:.2f}", "NIS a degree", "last error, m")
    return values, Table(f"pose NEES of {RUNS} drives", columns, tuple(rows))


def compare_levels(functions: Functions, invariant_update: Any) -> tuple[dict[str, Any], Table]:
    """Run the filters of the lesson's second figure at three levels of noise."""
    low, high = band(3, INVARIANT_RUNS)
    values: dict[str, Any] = {"runs": INVARIANT_RUNS, "band": [low, high]}
    for level, sigmas in LEVELS.items():
        for name, traces in compare_invariant(functions, invariant_update, sigmas, INVARIANT_RUNS).items():
            nees = np.mean([trace.nees for trace in traces], axis=0)
            heading = [trace.errors[:, 2] ** 2 / trace.covariances[:, 2, 2] for trace in traces]
            values[f"{level}, {name}"] = {
                "nees": float(nees.mean()),
                "largest of a step": float(nees.max()),
                "steps inside": float(np.mean((low <= nees) & (nees <= high))),
                "heading": float(np.mean(heading)),
                "error": float(np.mean([np.hypot(*trace.errors[-1, :2]) for trace in traces])),
            }
    rows = {name: value for name, value in values.items() if isinstance(value, dict)}
    title = f"pose NEES of {INVARIANT_RUNS} drives, 95 % band {low:.2f} to {high:.2f}"
    return values, Table.of(title, rows, shown=".2f")


def time_steps(functions: Functions, invariant_update: Any) -> dict[str, float]:
    """Return the microseconds of a step of each filter, the best of some rounds."""
    predict, _, add_landmark = functions
    drives = [field_drive(seed, NOISY) for seed in range(TIMED_RUNS)]
    steps = sum(len(drive.steps) - 1 for drive in drives)
    filters = {
        "your filter": lambda: functions,
        "first estimates": lambda: with_first_estimates(functions),
        "invariant filter": lambda: (predict, invariant_update, add_landmark),
    }
    best = dict.fromkeys(filters, np.inf)
    for _ in range(ROUNDS):
        for name, make in filters.items():
            start = time.process_time()
            for drive in drives:
                follow(drive, make())
            best[name] = min(best[name], 1e6 * (time.process_time() - start) / steps)
    return best


def main() -> Result:
    """Run all variants on both fields, and the invariant filter at three levels of noise."""
    own = solution("07")
    functions = own["predict"], own["update_landmarks"], own["add_landmark"]
    values, table = compare_fields(functions)
    values["invariant"], levels = compare_levels(functions, own["invariant_update"])
    values["microseconds"] = time_steps(functions, own["invariant_update"])
    times = ", ".join(f"{name} {us:.0f}" for name, us in values["microseconds"].items())
    return Result("ekf_consistency", values, (table, levels), (f"microseconds of a step: {times}",))
