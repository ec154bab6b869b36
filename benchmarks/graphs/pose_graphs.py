"""Lesson 09's Gauss-Newton beside GTSAM's, in one run and on one core, and what solving costs by the graph's size.

``python -m benchmarks pose_graphs`` also writes what the lesson's figure shows. GTSAM and qdldl are in the extra
``bench``; what is not installed is said and left out, and so are the standard graphs where there is no data folder.
"""

import importlib
import importlib.util
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse.linalg
import scipy.spatial

from benchmarks import Result, Table, digits, solution
from nao_course.datasets import data_folder, read_g2o
from nao_course.geometry import FloatArray
from nao_course.graphs import LANDMARK, POSE, Graph
from nao_course.lessons.pose_graphs.worlds import between

OWN = solution("09")
STANDARD = {"intel": "openslam_intel", "M3500": "input_M3500_g2o", "city10000": "city10000"}
ROUNDS = 5
SIZES = (100, 300, 1000, 3000, 10_000, 30_000, 100_000)
STEPS = 3  # of Gauss-Newton, for the cost by size
SHOWN = ("iterations", "chi2_before", "chi2_own", "chi2_gtsam", "ms_own", "ms_gtsam", "ms_qdldl")
MOST_SECONDS = {"dense": 0.5}  # once a way has taken so long, or else 2 s, larger graphs are left out

STEP_SIGMA = np.array([0.02, 0.02, 0.01])  # m, m, rad; as large along as across, so the frame does not matter
SIGHT_SIGMA = np.array([0.001, 0.001])  # rad, m: so good that bearing and range have the optimum of x and y
NEAREST, FARTHEST = 1.0, 3.5  # m within which a landmark is seen
HEADINGS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])

Problem = tuple[Graph, FloatArray]
Solved = tuple[FloatArray, int]  # states, iterations


def streets(poses: int, rng: np.random.Generator) -> FloatArray:
    """Return a random walk on a grid inside a square, with steps of a metre, as (poses, 3)."""
    side = max(int(np.sqrt(poses) / 2), 3)
    at, heading = np.zeros(2, dtype=int), 0
    truth = np.zeros((poses, 3))
    draws = rng.random(poses)
    for step in range(1, poses):
        while draws[step] < 0.25 or np.abs(at + HEADINGS[heading]).max() > side:
            heading, draws[step] = int(rng.integers(4)), 1.0
        at = at + HEADINGS[heading]
        truth[step] = *at, heading * np.pi / 2
    return truth


def town(poses: int, seed: int = 9) -> tuple[Graph, FloatArray]:
    """Return a graph of poses that revisit places, and states near the truth.

    What is measured is time, so nobody has to find the way from far off: odometry over 100,000 m would be too far.
    """
    rng = np.random.default_rng([seed, poses])
    truth = streets(poses, rng)
    steps = np.column_stack([np.arange(poses - 1), np.arange(1, poses)])
    pairs = np.concatenate([steps, _met_again(truth, rng)])
    z = between(truth[pairs[:, 0]], truth[pairs[:, 1]]) + rng.normal(0.0, STEP_SIGMA, (len(pairs), 3))
    information = np.broadcast_to(np.diag(STEP_SIGMA**-2.0), (len(pairs), 3, 3))
    return Graph(pairs, z, information, np.full(poses, POSE)), _near(truth, rng).ravel()


def _met_again(truth: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return pairs (late, early): half of the poses on a crossing that was passed before recognise it."""
    last: dict[tuple[float, float], int] = {}
    pairs = []
    for late, (x, y, _) in enumerate(truth):
        early = last.get((x, y))
        if early is not None and late - early > 3 and rng.random() < 0.5:
            pairs.append((late, early))
        last[x, y] = late
    return np.array(pairs, dtype=int).reshape(-1, 2)


def town_with_landmarks(poses: int = 5000, landmarks: int = 500, seed: int = 9) -> tuple[Graph, FloatArray]:
    """Return a graph of poses that measure bearing and range of all landmarks nearby, and states near the truth."""
    rng = np.random.default_rng([seed, poses, landmarks])
    truth = streets(poses, rng)
    marks = rng.uniform(truth[:, :2].min(axis=0) - 1, truth[:, :2].max(axis=0) + 1, (landmarks, 2))
    tree = scipy.spatial.cKDTree(marks)
    far, too_near = (tree.query_ball_point(truth[:, :2], distance) for distance in (FARTHEST, NEAREST))
    near = [sorted(set(each) - set(less)) for each, less in zip(far, too_near, strict=True)]
    pose = np.repeat(np.arange(poses), [len(each) for each in near])
    seen, mark = np.unique(np.concatenate([np.array(each, dtype=int) for each in near]), return_inverse=True)
    away = between(truth[pose], np.column_stack([marks[seen][mark], np.zeros(len(mark))]))[:, :2]
    bearing = np.arctan2(away[:, 1], away[:, 0]) + rng.normal(0.0, SIGHT_SIGMA[0], len(mark))
    distance = np.hypot(*away.T) + rng.normal(0.0, SIGHT_SIGMA[1], len(mark))
    sight, information = cartesian(bearing, distance)
    z = between(truth[:-1], truth[1:]) + rng.normal(0.0, STEP_SIGMA, (poses - 1, 3))
    graph = Graph(
        np.concatenate(
            [
                np.column_stack([np.arange(poses - 1), np.arange(1, poses)]),
                np.column_stack([pose, poses + mark]),
            ]
        ),
        np.concatenate([z, sight]),
        np.concatenate([np.broadcast_to(np.diag(STEP_SIGMA**-2.0), (poses - 1, 3, 3)), information]),
        np.repeat([POSE, LANDMARK], [poses, len(seen)]),
    )
    return graph, np.concatenate(
        [_near(truth, rng).ravel(), (marks[seen] + rng.normal(0.0, 0.1, (len(seen), 2))).ravel()]
    )


def _near(truth: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return poses near the true ones; the first is exact."""
    away = rng.normal(0.0, (0.1, 0.1, 0.03), truth.shape)
    away[0] = 0.0
    return np.asarray(truth + away)


def cartesian(bearing: FloatArray, distance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Convert bearings and ranges (N,) to measurements (N, 3) and information (N, 3, 3) of a graph's edges."""
    c, s = np.cos(bearing), np.sin(bearing)
    z = np.column_stack([distance * c, distance * s, np.zeros(len(bearing))])
    across, along = np.stack([-s, c], axis=-1), np.stack([c, s], axis=-1)
    weights = (distance * SIGHT_SIGMA[0]) ** -2.0, np.full(len(bearing), SIGHT_SIGMA[1] ** -2.0)
    information = np.zeros((len(bearing), 3, 3))
    for weight, axis in zip(weights, (across, along), strict=True):
        information[:, :2, :2] += weight[:, None, None] * axis[:, :, None] * axis[:, None, :]
    return z, information


def own(graph: Graph, states: FloatArray, iterations: int) -> FloatArray:
    """Solve with the lesson's functions, with the order and the pattern computed anew for a new graph."""
    return np.asarray(OWN["gauss_newton"](graph, states, iterations)[0])


def stepwise(solve: Callable[[Graph, Any, FloatArray], FloatArray]) -> Callable[..., FloatArray]:
    """Run Gauss-Newton with the lesson's `linearize` and another solver for each system."""

    def run(graph: Graph, states: FloatArray, iterations: int) -> FloatArray:
        states = states.copy()
        for _ in range(iterations):
            H, b = OWN["linearize"](graph, states)
            states -= solve(graph, H, b)
        return states

    return run


def _dense(graph: Graph, H: Any, b: FloatArray) -> FloatArray:
    return np.concatenate([np.zeros(3), np.linalg.solve(H[3:, 3:].toarray(), b[3:])])


def _ordered_by(order: str) -> Callable[[Graph, Any, FloatArray], FloatArray]:
    options: dict[str, Any] = (
        {} if order == "COLAMD" else {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    )

    def solve(graph: Graph, H: Any, b: FloatArray) -> FloatArray:
        factor = scipy.sparse.linalg.splu(H[3:, 3:], permc_spec=order, **options)
        return np.concatenate([np.zeros(3), factor.solve(b[3:])])

    return solve


def with_qdldl(graph: Graph, states: FloatArray, iterations: int) -> FloatArray:
    """Solve with `qdldl`, which needs half the numbers because H is symmetric; its ordering is also computed once."""
    solver, states = None, states.copy()
    for _ in range(iterations):
        H, b = OWN["linearize"](graph, states)
        upper = scipy.sparse.triu(H[3:, 3:], format="csc")
        if solver is None:
            solver = importlib.import_module("qdldl").Solver(upper, upper=True)
        else:
            solver.update(upper, upper=True)
        states[3:] -= solver.solve(b[3:])
    return states


WAYS: dict[str, Callable[..., FloatArray]] = {
    "dense": stepwise(_dense),
    "sparse, in scipy's own order": stepwise(_ordered_by("COLAMD")),
    "sparse, numbers ordered at each step": stepwise(_ordered_by("MMD_AT_PLUS_A")),
    "sparse, poses ordered once": own,
}


def gtsam_problem(graph: Graph, states: FloatArray) -> Any:
    """Return the graph and guess as GTSAM objects; landmarks have bearing and range, which is equal to first order."""
    gtsam = importlib.import_module("gtsam")
    poses, landmarks = graph.split(states)
    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for key, pose in enumerate(poses):
        values.insert(key, gtsam.Pose2(*pose))
    for key, place in enumerate(landmarks, start=len(poses)):
        values.insert(key, place)
    gaussian = gtsam.noiseModel.Gaussian.Information
    for (first, second), z, information in zip(
        graph.edges.tolist(), graph.measurements, graph.information, strict=True
    ):
        if second < len(poses):
            factors.add(gtsam.BetweenFactorPose2(first, second, gtsam.Pose2(*z), gaussian(information)))
            continue
        x, y, r = z[0], z[1], float(np.hypot(z[0], z[1]))
        slopes = np.array([[-y, x / r], [x, y / r]])
        polar = slopes.T @ information[:2, :2] @ slopes
        bearing = gtsam.Rot2(float(np.arctan2(y, x)))
        factors.add(gtsam.BearingRangeFactor2D(first, second, bearing, r, gaussian(polar)))
    factors.add(gtsam.PriorFactorPose2(0, values.atPose2(0), gtsam.noiseModel.Constrained.All(3)))
    return factors, values


def gtsam_solve(problem: Any, iterations: int | None = None) -> tuple[Any, int]:
    """Run GTSAM's Gauss-Newton with its defaults, or with a number of iterations."""
    gtsam = importlib.import_module("gtsam")
    parameters = gtsam.GaussNewtonParams()
    if iterations is not None:
        parameters.setMaxIterations(iterations)
        parameters.setRelativeErrorTol(0.0)
        parameters.setAbsoluteErrorTol(0.0)
    optimizer = gtsam.GaussNewtonOptimizer(*problem, parameters)
    return optimizer.optimize(), int(optimizer.iterations())


def gtsam_states(graph: Graph, values: Any) -> FloatArray:
    """Return GTSAM's values as the lesson's states."""
    poses = [values.atPose2(key) for key in range(graph.poses)]
    landmarks = [values.atPoint2(graph.poses + key) for key in range(graph.landmarks)]
    flat = [[each.x(), each.y(), each.theta()] for each in poses] + [list(each) for each in landmarks]
    return np.concatenate([np.asarray(each, dtype=float) for each in flat])


@contextmanager
def one_core() -> Iterator[None]:
    """Keep all threads of this process on one core, where the system can do that."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def installed(name: str) -> bool:
    """Return whether an optional package is there."""
    return importlib.util.find_spec(name) is not None


def timed(function: Callable[[], Any]) -> tuple[float, Any]:
    """Return the processor time, s, and the result of a call."""
    begin = time.process_time()
    result = function()
    return time.process_time() - begin, result


def chi2(graph: Graph, states: FloatArray) -> float:
    """Return the sum of all weighted squared errors, by the lesson's residuals."""
    return float(graph.squared_errors(states, OWN["pose_residual"], OWN["landmark_residual"]).sum())


def problems() -> tuple[dict[str, Problem], list[str]]:
    """Return the standard graphs that are available, a simulated graph, and notes about missing ones."""
    found: dict[str, Problem] = {}
    notes = []
    try:
        folder = data_folder() / "slam" / "g2o"
        found = {name: read_g2o(folder / f"{file}.g2o") for name, file in STANDARD.items()}
    except FileNotFoundError as error:
        notes.append(f"without the standard graphs: {error}")
    found["simulated, landmarks"] = town_with_landmarks()
    return found, notes


def beside_gtsam(graph: Graph, states: FloatArray) -> dict[str, Any]:
    """Return the best of some alternating runs of each; the lesson's solver takes as many iterations as GTSAM."""
    problem = gtsam_problem(graph, states) if installed("gtsam") else None
    iterations = gtsam_solve(problem)[1] if problem else 6
    ways: dict[str, Callable[[], Any]] = {"own": lambda: own(replace(graph), states, iterations)}
    if problem:
        ways["gtsam"] = lambda: gtsam_solve(problem)[0]
    if installed("qdldl"):
        ways["qdldl"] = lambda: with_qdldl(replace(graph), states, iterations)
    seconds: dict[str, float] = dict.fromkeys(ways, np.inf)
    results: dict[str, Any] = {}
    for _ in range(ROUNDS):
        for name, way in ways.items():
            taken, results[name] = timed(way)
            seconds[name] = min(seconds[name], taken)
    row = {"poses": graph.poses, "landmarks": graph.landmarks, "edges": len(graph.edges)}
    row["iterations"] = iterations
    row |= {"chi2_before": chi2(graph, states), "chi2_own": chi2(graph, results["own"])}
    if problem:
        row["chi2_gtsam"] = chi2(graph, gtsam_states(graph, results["gtsam"]))
    return row | {f"ms_{name}": 1000 * taken for name, taken in seconds.items()}


def by_size() -> dict[str, list[dict[str, float]]]:
    """Return the seconds of a few steps for each method and size, until a method takes too long."""
    rows: dict[str, list[dict[str, float]]] = {}
    given_up: set[str] = set()
    for size in SIZES:
        for name, run in _runs(*town(size)).items():
            if name in given_up:
                continue
            seconds = min(timed(run)[0] for _ in range(3 if size <= 10_000 else 1))
            rows.setdefault(name, []).append({"poses": size, "seconds": seconds})
            if seconds > MOST_SECONDS.get(name, 2.0):
                given_up.add(name)
    return rows


def _runs(graph: Graph, states: FloatArray) -> dict[str, Callable[[], Any]]:
    """Return a few steps with each method that is installed."""
    ways: dict[str, Callable[..., Any]] = dict(WAYS)
    if installed("qdldl"):
        ways["with the wheel qdldl"] = with_qdldl
    runs: dict[str, Callable[[], Any]] = {
        name: lambda way=way: way(replace(graph), states, STEPS) for name, way in ways.items()
    }
    if installed("gtsam"):
        runs["GTSAM"] = partial(gtsam_solve, gtsam_problem(graph, states), STEPS)
    return runs


def main() -> Result:
    """Measure both."""
    with one_core():
        graphs, notes = problems()
        rows = {name: beside_gtsam(*problem) for name, problem in graphs.items()}
        costs = by_size()
    rounded = digits(costs)
    missing = [name for name in ("gtsam", "qdldl") if not installed(name)]
    notes += [f"without {name}, which is not installed: the extra bench has it" for name in missing]
    beside = {
        name: {key: f"{row[key]:.6g}" if key in row else "-" for key in SHOWN} for name, row in rows.items()
    }
    by_way = {
        name: {f"{size:,}": "-" for size in SIZES}
        | {f"{row['poses']:,}": f"{1000 * row['seconds']:.4g}" for row in each}
        for name, each in rounded.items()
    }
    tables = (
        Table.of("Gauss-Newton to the optimum, files read beforehand, one core", beside),
        Table.of(f"{STEPS} steps of Gauss-Newton by the number of poses, one core, ms", by_way),
    )
    return Result("pose_graphs", {"graphs": rows, "costs": costs}, tables, tuple(notes))
