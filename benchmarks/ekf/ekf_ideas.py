"""The report's ideas for a constant time a step (its 3.3), measured on a loop through 200 landmarks.

Forgetting landmarks, a local map inside the large one (the compressed filter), and a faster search.
Use ``OMP_NUM_THREADS=1 python -m benchmarks ekf_ideas``: with more threads than one the times count them all.
"""

import time
import timeit
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import KDTree

from benchmarks import Result, Table, solution
from nao_course.geometry import FloatArray, Pose, pose_errors, wrap_angle
from nao_course.lessons.ekf_slam.filters import CompressedFilter
from nao_course.metrics import band, squared_distances
from nao_course.sim.drives import FieldOfView, NamedEkf, Sigmas, Step, measure_in_view
from nao_course.slam import Motion

OWN = solution("07")
FUNCTIONS = OWN["predict"], OWN["update_landmarks"], OWN["add_landmark"]

LANDMARKS, RADIUS, ASIDE = 200, 25.0, 2.0  # on a ring so wide to both sides, m
STEP, STEPS = 0.5, 360  # m; a lap takes 314
VIEW = FieldOfView(float(np.radians(60)), 3.0, nearest=0.5)  # rad, m, m
NEAR, MOST_NEAR = 6.0, 40  # m, landmarks: the compressed filter's near part
MEMORY = 40  # steps after which the forgetful filter drops a landmark
SIGMAS = Sigmas(0.02, 0.01, float(np.radians(0.2)), float(np.radians(0.5)), 0.03)
Q, R = SIGMAS.control_covariance, SIGMAS.measurement_covariance
RUNS = 6


class Whole(NamedEkf):
    """The lesson's functions on the whole map."""

    def __init__(self) -> None:
        super().__init__(Pose(), *FUNCTIONS)

    def see(self, step: Step) -> None:
        self.observe(step.numbers, step.measurements, step.covariances)

    def pose(self) -> tuple[FloatArray, FloatArray]:
        return self.state[:3], self.covariance[:3, :3]


class Forgetful(Whole):
    """The same, but what has not been seen for a while is taken off the map: its rows and columns are left out."""

    def __init__(self) -> None:
        super().__init__()
        self.step, self.last = 0, dict[int, int]()

    def see(self, step: Step) -> None:
        self.step += 1
        self.last |= dict.fromkeys(step.numbers.tolist(), self.step)
        super().see(step)
        old = [slot for slot, number in enumerate(self.known) if self.last[number] < self.step - MEMORY]
        if old:
            columns = np.setdiff1d(
                np.arange(len(self.state)), [3 + 2 * slot + axis for slot in old for axis in (0, 1)]
            )
            self.state, self.covariance = self.state[columns], self.covariance[np.ix_(columns, columns)]
            self.known = [number for slot, number in enumerate(self.known) if slot not in set(old)]


class Compressed:
    """The compressed filter; it moves on when what it sees is not near, or what is called near has become much."""

    def __init__(self) -> None:
        self.own, self.on_map = CompressedFilter(*FUNCTIONS), dict[int, int]()
        self.moves = 0

    def move(self, control: FloatArray, covariance: FloatArray) -> None:
        self.own.predict(control, covariance)

    def see(self, step: Step) -> None:
        seen = list(zip(step.numbers.tolist(), step.measurements, strict=True))
        known = [(self.on_map[number], values) for number, values in seen if number in self.on_map]
        if len(self.own.near) > MOST_NEAR or not {index for index, _ in known} <= set(self.own.near):
            state, _ = self.own.whole()
            away = np.hypot(*(state[3:].reshape(-1, 2) - state[:2]).T)
            wanted = set(np.flatnonzero(away < NEAR).tolist()) | {index for index, _ in known}
            self.own.move_to(sorted(wanted))
            self.moves += 1
        if known:
            self.own.update_landmarks(
                [index for index, _ in known], np.concatenate([values for _, values in known]), R
            )
        for number, values in seen:
            if number not in self.on_map:
                self.on_map[number] = self.own.add_landmark(values, R)

    def pose(self) -> tuple[FloatArray, FloatArray]:
        state, covariance = self.own.local
        return state[:3], covariance[:3, :3]


FILTERS = {"whole map": Whole, "forgets after 40 steps": Forgetful, "compressed": Compressed}


class Loop(NamedTuple):
    """One filter's way round: ms (M,), errors (M, 3) and NEES (M,) of each step."""

    ms: FloatArray
    errors: FloatArray
    nees: FloatArray


def world(seed: int) -> list[Step]:
    """Drive round the ring: a step for each command."""
    rng = np.random.default_rng(seed)
    angles = rng.uniform(0, 2 * np.pi, LANDMARKS)
    radii = RADIUS + rng.uniform(-ASIDE, ASIDE, LANDMARKS)
    landmarks = np.column_stack([radii * np.sin(angles), RADIUS - radii * np.cos(angles)])
    steps = []
    for pose, motion in along_the_ring(rng):
        numbers, seen = measure_in_view(pose, landmarks, SIGMAS, VIEW, rng, draw_unseen=True)
        steps.append(Step(pose, motion, Q, numbers, seen, SIGMAS.covariances(seen)))
    return steps


def along_the_ring(rng: np.random.Generator) -> list[tuple[FloatArray, Motion]]:
    """Return true poses (3,) and commands of a robot that stays on the ring, as if it followed a wall."""
    pose, path = Pose(), []
    for errors in rng.standard_normal((STEPS, 3)) * np.sqrt(np.diag(Q)):
        away = complex(pose.x, pose.y - RADIUS)
        slant = float(wrap_angle(np.angle(away) + np.pi / 2 - pose.theta))
        turn = STEP / RADIUS + 0.3 * slant + 0.1 * (abs(away) - RADIUS)
        pose = pose @ Pose(STEP + errors[0], errors[1], turn + errors[2])
        path.append((pose.as_array(), Motion(STEP, turn)))
    return path


def go_round(own: Whole | Compressed, steps: Sequence[Step]) -> Loop:
    """Run one filter along the loop."""
    ms, errors, covariances = [], [], []
    for step in steps:
        start = time.process_time()
        own.move(step.control, step.control_covariance)
        own.see(step)
        ms.append(1000 * (time.process_time() - start))
        pose, covariance = own.pose()
        errors.append(pose_errors(pose, step.pose))
        covariances.append(covariance)
    return Loop(np.array(ms), np.array(errors), squared_distances(np.array(errors), np.array(covariances)))


def search_times(landmarks: int = 1000, queries: int = 10) -> dict[str, float]:
    """Return the microseconds to find the landmarks nearest to ten points by search and by a tree."""
    rng = np.random.default_rng(3)
    points, asked = rng.uniform(0, 50, (landmarks, 2)), rng.uniform(0, 50, (queries, 2))
    tree = KDTree(points)

    def best(step: Callable[[], Any]) -> float:
        return 1e6 / 100 * min(timeit.repeat(step, time.process_time, number=100))

    return {
        "all": best(lambda: ((asked[:, None] - points) ** 2).sum(axis=2).argmin(axis=1)),
        "tree": best(lambda: tree.query(asked)),
    }


def main() -> Result:
    """Drive the loops, and search."""
    worlds = [world(seed) for seed in range(RUNS)]
    loops = {name: [go_round(make(), each) for each in worlds] for name, make in FILTERS.items()}
    low, high = band(3, RUNS)
    found = {
        name: {
            "ms_early": float(np.median([loop.ms[20:60] for loop in each])),
            "ms_late": float(np.median([loop.ms[260:300] for loop in each])),
            "ms_mean": float(np.mean([loop.ms for loop in each])),
            "last_error": float(np.mean([np.hypot(*loop.errors[-1, :2]) for loop in each])),
            "nees": float(np.mean([loop.nees for loop in each])),
        }
        for name, each in loops.items()
    }
    values = {"runs": RUNS, "band": [low, high], "search": search_times(), **found}
    search = ", ".join(f"{name} {us:.0f}" for name, us in values["search"].items())
    notes = (
        f"nearest of 1000 landmarks to 10 points, microseconds: {search}",
        f"95 % band of the NEES of one step over {RUNS} loops: {low:.2f} to {high:.2f}",
    )
    title = f"{RUNS} loops of {STEPS} steps through {LANDMARKS} landmarks; early: steps 20-60, late: 260-300"
    return Result("ekf_ideas", values, (Table.of(title, found, shown=".3f"),), notes)
