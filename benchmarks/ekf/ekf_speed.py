"""What one step of EKF SLAM costs by the size of the map: predict, and an update of one landmark.

``python -m benchmarks ekf_speed`` also writes what the lesson's figure shows.
"""

import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.linalg.blas import dsyrk

from benchmarks import ROOT, Result, Table
from nao_course.geometry import FloatArray, wrap_angle
from nao_course.instructor.authoring.plans import load_solution
from nao_course.lessons.ekf_slam.costs import RECORDED
from nao_course.lessons.ekf_slam.filters import CompressedFilter
from nao_course.slam import range_and_bearing

try:
    from filterpy.kalman import ExtendedKalmanFilter
except ImportError:  # the extra "bench" is not installed
    ExtendedKalmanFilter = None

# The largest first: afterwards, arrays find memory that is there.
SIZES = (1000, 700, 500, 300, 200, 100, 50, 20, 10)
NEAR = 20  # landmarks of the compressed filter's near part, or all if there are fewer
MOST_SECONDS = 0.5  # a way that takes so long is not tried on larger maps
ROUNDS, BUDGET = 5, 0.4  # at least so many, and as many more as fit into so many seconds of the processor
ONE_CORE = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "VECLIB_MAXIMUM")}

CONTROL, Q = np.array([0.1, 0.05]), np.diag([0.02, 0.01, 0.02]) ** 2
R = np.diag([0.03, 0.05]) ** 2
Belief = tuple[FloatArray, FloatArray]
Step = Callable[[], Any]


def a_map(k: int) -> tuple[FloatArray, FloatArray, int, FloatArray]:
    """Return state and covariance of k correlated landmarks, the landmark that is measured, and the measurement."""
    rng = np.random.default_rng(k)
    state = np.concatenate([[0.0, 0.0, 0.1], rng.uniform(-5, 5, 2 * k)])
    root = rng.normal(0, 0.05, (len(state), 6))
    covariance = root @ root.T + 0.01 * np.eye(len(state))
    landmark = k // 2
    seen = range_and_bearing(state[:3], state[3:].reshape(-1, 2)[landmark]) + (0.02, 0.03)
    return state, covariance, landmark, seen


class InPlaceFilter:
    """Pose and known landmarks; only the covariance's lower triangle is kept, column by column.

    An update takes W W' off the covariance, with W = P H' inv(L)' and L L' = S: BLAS does that in one pass over half of
    the numbers, without a new array. It begins with a state (3 + 2k,) and a covariance (3 + 2k, 3 + 2k).
    """

    def __init__(self, state: FloatArray, covariance: FloatArray) -> None:
        self.state = np.array(state, dtype=float)
        self._lower = np.array(covariance, dtype=float, order="F")

    @property
    def covariance(self) -> FloatArray:
        """Both triangles, a new array."""
        lower = np.tril(self._lower)
        return lower + np.tril(lower, -1).T

    def predict(self, control: FloatArray, control_covariance: FloatArray) -> None:
        """Move: three columns change."""
        x, y, theta = self.state[:3].tolist()
        distance, turn = control
        c, s = math.cos(theta), math.sin(theta)
        F = np.array([[1.0, 0.0, -distance * s], [0.0, 1.0, distance * c], [0.0, 0.0, 1.0]])
        G = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        self.state[:3] = x + distance * c, y + distance * s, wrap_angle(theta + turn)
        lower, pose = self._lower, self._columns([0, 1, 2])[:3]
        lower[3:, :3] = lower[3:, :3] @ F.T
        lower[:3, :3] = F @ pose @ F.T + G @ control_covariance @ G.T

    def update_landmark(
        self, index: int, measurement: FloatArray, measurement_covariance: FloatArray
    ) -> None:
        """Take one (bearing, range) in: one pass over the lower triangle."""
        at = 3 + 2 * index
        x, y, theta, lx, ly = self.state[[0, 1, 2, at, at + 1]].tolist()
        dx, dy = lx - x, ly - y
        r = math.hypot(dx, dy)
        u, v = dx / r, dy / r
        H = np.array([[v / r, -u / r, -1.0, -v / r, u / r], [-u, -v, 0.0, u, v]])
        surprise = np.array([wrap_angle(measurement[0] - math.atan2(dy, dx) + theta), measurement[1] - r])
        columns = [0, 1, 2, at, at + 1]
        shared = self._columns(columns) @ H.T
        root = np.linalg.inv(np.linalg.cholesky(H @ shared[columns] + measurement_covariance))
        W = shared @ root.T
        self.state += W @ (root @ surprise)
        self.state[2] = wrap_angle(self.state[2])
        self._lower = dsyrk(-1.0, W, beta=1.0, c=self._lower, overwrite_c=1, lower=1)

    def _columns(self, numbers: list[int]) -> FloatArray:
        """Return columns of the whole covariance, (n, len(numbers))."""
        found = np.empty((len(self.state), len(numbers)))
        for to, column in enumerate(numbers):
            found[:column, to] = self._lower[column, :column]
            found[column:, to] = self._lower[column:, column]
        return found


# Each way gives a step that can be repeated, and the estimate after the first.


def new_arrays(k: int) -> tuple[Step, Callable[[], Belief]]:
    """Return a step of the lesson's solution, which continues from its previous estimate, as in a drive."""
    own = load_solution(ROOT / "solutions" / "07_ekf_slam.ipynb")
    predict, update_landmarks = own["predict"], own["update_landmarks"]
    state, covariance, landmark, seen = a_map(k)

    def step() -> Belief:
        nonlocal state, covariance
        state, covariance = predict(state, covariance, CONTROL, Q, k)
        state, covariance = update_landmarks(state, covariance, [landmark], seen, R)
        return state, covariance

    return step, step


def in_place(k: int) -> tuple[Step, Callable[[], Belief]]:
    """Return a step of `InPlaceFilter`."""
    state, covariance, landmark, seen = a_map(k)
    own = InPlaceFilter(state, covariance)

    def step() -> None:
        own.predict(CONTROL, Q)
        own.update_landmark(landmark, seen, R)

    return step, lambda: (step(), (own.state.copy(), own.covariance))[1]


def dense(k: int) -> tuple[Step, Callable[[], Belief]]:
    """Return a step as in the textbook, with whole matrices F, H and I - K H that consist mostly of zeros."""
    state, covariance, landmark, seen = a_map(k)

    def step() -> Belief:
        F = np.eye(len(state))
        F[:3, :3], moved, noise = motion(state)
        P = F @ covariance @ F.T
        P[:3, :3] += noise
        H, expected = sight(moved, landmark)
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        return moved + K @ surprise(seen, expected), (np.eye(len(state)) - K @ H) @ P

    return step, step


def filterpys(k: int) -> tuple[Step, Callable[[], Belief]]:
    """Return a step of filterpy's ExtendedKalmanFilter, with the whole matrices that it requires."""
    state, covariance, landmark, seen = a_map(k)
    own = ExtendedKalmanFilter(dim_x=len(state), dim_z=2)
    own.R, own.Q = R, np.zeros_like(covariance)
    own.x, own.P = state.copy(), covariance.copy()

    def step() -> Belief:
        own.F[:3, :3], moved, own.Q[:3, :3] = motion(own.x)
        own.predict_x = lambda u=0: setattr(own, "x", moved)
        own.predict()
        own.update(seen, lambda x: sight(x, landmark)[0], lambda x: sight(x, landmark)[1], residual=surprise)
        return own.x, own.P

    return step, step


def compressed(k: int) -> tuple[Step, Callable[[], Belief]]:
    """Return a step of the compressed filter among its near landmarks."""
    own, landmark, seen = compressed_filter(k)

    def step() -> None:
        own.predict(CONTROL, Q)
        own.update_landmarks([landmark], seen, R)

    return step, lambda: (step(), own.whole())[1]


def moving_on(k: int) -> tuple[Step, Callable[[], Belief]]:
    """Return the occasional step of the compressed filter that brings the whole map up to date."""
    own = compressed_filter(k)[0]
    return lambda: own.move_to(own.near), own.whole


def compressed_filter(k: int) -> tuple[CompressedFilter, int, FloatArray]:
    """Return the filter of k landmarks, the landmark that is measured, and the measurement."""
    own = load_solution(ROOT / "solutions" / "07_ekf_slam.ipynb")
    state, covariance, landmark, seen = a_map(k)
    near = [(landmark + shift) % k for shift in range(min(NEAR, k))]
    functions = own["predict"], own["update_landmarks"], own["add_landmark"]
    return CompressedFilter(*functions, state, covariance, near), landmark, seen


def motion(state: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return F of the pose (3, 3), the predicted state, and the noise of the control in the field frame (3, 3)."""
    distance, turn = CONTROL
    c, s = np.cos(state[2]), np.sin(state[2])
    G = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    moved = state.copy()
    moved[:3] += distance * c, distance * s, turn
    return np.array([[1, 0, -distance * s], [0, 1, distance * c], [0, 0, 1]]), moved, G @ Q @ G.T


def sight(state: FloatArray, landmark: int) -> tuple[FloatArray, FloatArray]:
    """Return H of one landmark (2, n), and the expected measurement (2,)."""
    at = 3 + 2 * landmark
    dx, dy = state[at : at + 2] - state[:2]
    expected = range_and_bearing(state[:3], state[None, at : at + 2])[0]
    r = expected[1]
    by_place = np.array([[-dy / r**2, dx / r**2], [dx / r, dy / r]])
    H = np.zeros((2, len(state)))
    H[:, :2], H[0, 2], H[:, at : at + 2] = -by_place, -1.0, by_place
    return H, expected


def surprise(seen: FloatArray, expected: FloatArray) -> FloatArray:
    """Return the innovation: measured minus expected, with a wrapped bearing."""
    return np.array([wrap_angle(seen[0] - expected[0]), seen[1] - expected[1]])


WAYS = {
    "dense textbook": dense,
    "filterpy": filterpys,
    "new arrays": new_arrays,
    "in place": in_place,
    "compressed": compressed,
    "compressed, moving on": moving_on,
}


def milliseconds(step: Step) -> float:
    """Return the processor time that nine in ten runs exceed, ms; the fastest run may be an error of the clock."""
    took: list[float] = []
    while len(took) < ROUNDS or sum(took) < BUDGET:
        start = time.process_time()
        step()
        took.append(time.process_time() - start)
    return 1000 * float(np.percentile(took, 10))


def costs(name: str) -> list[dict[str, float]]:
    """Return the milliseconds of a method by the number of landmarks."""
    rows = []
    for k in SIZES[::-1] if name in ("dense textbook", "filterpy") else SIZES:  # these may take too long
        cost = milliseconds(WAYS[name](k)[0])
        rows.append({"landmarks": k, "ms": float(f"{cost:.3g}")})
        if cost > 1000 * MOST_SECONDS:
            break
    return sorted(rows, key=lambda row: row["landmarks"])


def in_a_process_of_its_own(call: str) -> Any:
    """Return the result of a call on one core, in a fresh process with unused memory."""
    command = [sys.executable, "-c", f"from benchmarks.ekf.ekf_speed import *; print(json.dumps({call}))"]
    done = subprocess.run(
        command, env=os.environ | ONE_CORE, cwd=ROOT, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


def apart(names: list[str], k: int = 50) -> float:
    """Return the largest difference of any state or covariance from the lesson's after one step."""
    state, covariance = WAYS["new arrays"](k)[1]()
    worst = 0.0
    for name in names:
        if name != "compressed, moving on":
            other, spread = WAYS[name](k)[1]()
            worst = max(worst, np.abs(other - state).max(), np.abs(spread - covariance).max())
    return float(worst)


def main() -> Result:
    """Measure all ways on one core, each in a process of its own; write what the lesson shows."""
    names = [name for name in WAYS if name != "filterpy" or ExtendedKalmanFilter]
    found = {name: in_a_process_of_its_own(f"costs({name!r})") for name in names}
    measured = {"ms": found, "apart": in_a_process_of_its_own(f"apart({names!r})")}
    RECORDED.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    columns = ("landmarks", *found)
    by_size = {name: {row["landmarks"]: row["ms"] for row in rows} for name, rows in found.items()}
    rows = tuple((str(k), *(f"{by_size[name].get(k, '-')}" for name in found)) for k in sorted(SIZES))
    notes = [f"all ways agree to {measured['apart']:.0e} after a step with 50 landmarks"]
    if "filterpy" not in found:
        notes.append("filterpy is not here (the extra bench installs it): not measured")
    title = "one predict and one update of one landmark, ms on one core"
    return Result("ekf_speed", measured, (Table(title, columns, rows),), tuple(notes))
