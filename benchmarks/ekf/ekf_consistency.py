"""Whether lesson 07's filter is as sure as it may be: pose NEES over a hundred drives, and its 95 % band."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks import Result, Table, solution
from nao_course.lessons.ekf_slam.consistency import NOISY, NOMINAL, RUNS, compare, mean_nees
from nao_course.metrics import band
from nao_course.sim.drives import Sigmas

FIELDS: dict[str, Sigmas] = {"nominal": NOMINAL, "noisy": NOISY}


def main() -> Result:
    """Run all variants on both fields."""
    own = solution("07")
    functions = own["predict"], own["update_landmarks"], own["add_landmark"]
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
    return Result("ekf_consistency", values, (Table(f"pose NEES of {RUNS} drives", columns, tuple(rows)),))
