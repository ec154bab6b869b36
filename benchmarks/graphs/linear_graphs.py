"""What it costs to solve lesson 08's linear graphs, by their size: dense, sparse as numbered, sparse in a good order.

``python -m benchmarks linear_graphs`` also writes what the lesson's figure shows.
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse.linalg

from benchmarks import ROOT, Result, Table, digits, write_json
from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.costs import System, corridor_system

RECORDED = ROOT / "nao_course" / "lessons" / "graph_slam" / "costs.json"
SIZES = (100, 300, 1000, 3000, 10_000, 30_000, 100_000)
MOST_SECONDS = 0.3  # once a way of solving has taken so long, it is not tried on larger systems
ROUNDS = 3


def dense(omega: Any, xi: FloatArray) -> int:
    """Solve as `np.linalg.solve` does, and return how many numbers the factor has."""
    np.linalg.solve(omega.toarray(), xi)
    return int(omega.shape[0]) ** 2


def sparse(order: str) -> Callable[[Any, FloatArray], int]:
    """Solve by a sparse factor in an order, and return how many numbers the factor has."""

    def solve(omega: Any, xi: FloatArray) -> int:
        options = {"SymmetricMode": True}
        factor = scipy.sparse.linalg.splu(omega, permc_spec=order, diag_pivot_thresh=0.0, options=options)
        factor.solve(xi)
        return int(factor.L.nnz)

    return solve


WAYS: dict[str, Callable[[Any, FloatArray], int]] = {
    "dense": dense,
    "sparse, as numbered": sparse("NATURAL"),
    "sparse, a good ordering": sparse("MMD_AT_PLUS_A"),
}


def measure(way: Callable[[Any, FloatArray], int], systems: dict[int, System]) -> list[dict[str, Any]]:
    """Measure the processor time (the best of several runs) and the megabytes by size, until it takes too long."""
    rows: list[dict[str, Any]] = []
    for variables, (omega, xi) in systems.items():
        best, entries = np.inf, 0
        for _ in range(ROUNDS):
            start = time.process_time()
            entries = way(omega, xi)
            best = min(best, time.process_time() - start)
        rows.append({"variables": variables, "seconds": float(best), "megabytes": 8 * entries / 1e6})
        if best > MOST_SECONDS:
            break
    return rows


def main() -> Result:
    """Measure all ways, and write what the lesson shows."""
    rng = np.random.default_rng(8)
    systems = {size: corridor_system(size, rng) for size in SIZES}
    found = {name: measure(way, systems) for name, way in WAYS.items()}
    rounded = digits(found)
    write_json(RECORDED, rounded, 1)
    rows = {
        f"{name}, {row['variables']} variables": {
            "ms": 1000 * row["seconds"],
            "MB of the factor": row["megabytes"],
        }
        for name, each in rounded.items()
        for row in each
    }
    return Result("linear_graphs", rounded, (Table.of("solving a corridor, one core", rows),))
