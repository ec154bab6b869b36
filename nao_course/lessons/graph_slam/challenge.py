"""The challenge of lesson 08: choose three additional measurements that improve the graph's worst variable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.challenges import CaseScore, Challenge, Column, Run, recorded_rows
from nao_course.geometry import FloatArray
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.style import GREY

GRAPHS = 40
POSES, LANDMARKS, CANDIDATES = 40, 14, 60
MOST = 3  # measurements: one after the other is not the best choice of three
START_WEIGHT = 1e4  # 1/m^2: the start is known to a centimetre
MOTION_EPSILON = 0.02  # m^2 a step
MEASUREMENT_EPSILON = (0.01, 0.08)  # m^2, from the best to the worst measurement
NEAR = 4  # stops from which a landmark is measured, at most

Candidate = tuple[int, int, float]


@dataclass(frozen=True, eq=False)
class Choices:
    """A graph on one axis, and candidates for more measurements.

    Omega (N, N) in 1/m^2 has poses first, then landmarks; xi (N,) is in 1/m, and the covariance (N, N) in m^2 is
    omega's inverse. The start has a standard deviation of 1 cm. Each candidate is (pose, landmark, variance epsilon in
    m^2).
    """

    omega: FloatArray
    xi: FloatArray
    candidates: list[Candidate]
    covariance: FloatArray

    def worst_after(self, chosen: Sequence[int]) -> float:
        """Return the largest standard deviation of a variable in m after some candidates were measured."""
        pose, landmark, epsilon = np.array([self.candidates[each] for each in chosen]).reshape(-1, 3).T
        rows = self.covariance[:, landmark.astype(int)] - self.covariance[:, pose.astype(int)]
        spread = rows[landmark.astype(int)] - rows[pose.astype(int)] + np.diag(epsilon)
        return float(
            np.sqrt((np.diag(self.covariance) - (rows * np.linalg.solve(spread, rows.T).T).sum(axis=1)).max())
        )


def make_graph(seed: int) -> Choices:
    """Make the graph of a walk there and back along an axis; some landmarks are measured only once, and badly."""
    rng = np.random.default_rng([seed, 808])
    size = POSES + LANDMARKS
    position = np.cumsum(np.where(np.arange(POSES) < rng.integers(22, 34), 0.5, -0.5)) - 0.5
    places = rng.uniform(position.min(), position.max(), LANDMARKS)
    omega, xi = np.zeros((size, size)), np.zeros(size)
    omega[0, 0] += START_WEIGHT
    xi[0] += START_WEIGHT * position[0]

    def add(first: int, second: int, difference: float, epsilon: float) -> None:
        ends, signs = np.array([first, second]), np.array([-1.0, 1.0])
        omega[np.ix_(ends, ends)] += np.outer(signs, signs) / epsilon
        xi[ends] += signs * (difference + np.sqrt(epsilon) * rng.standard_normal()) / epsilon

    for step in range(1, POSES):
        add(step - 1, step, position[step] - position[step - 1], MOTION_EPSILON * rng.uniform(0.3, 3.0))
    for number, place in enumerate(places):
        order = np.argsort(np.abs(position - place) + 10.0 * (np.arange(POSES) > POSES // 2))
        times = 1 if number % 3 == 0 else int(rng.integers(2, NEAR + 1))
        for pose in order[:times]:
            factor = 12.0 if times == 1 else 1.0
            add(int(pose), POSES + number, place - position[pose], factor * rng.uniform(*MEASUREMENT_EPSILON))
    return Choices(omega, xi, _candidates(position, places, rng), np.linalg.inv(omega).astype(float))


def _candidates(position: FloatArray, places: FloatArray, rng: np.random.Generator) -> list[Candidate]:
    """Draw different pairs of pose and landmark; the variance grows with their distance."""
    pairs = rng.permutation(POSES * LANDMARKS)[:CANDIDATES]
    found = []
    for pose, number in zip(*np.divmod(pairs, LANDMARKS), strict=True):
        away = abs(float(places[number] - position[pose]))
        epsilon = float(rng.uniform(*MEASUREMENT_EPSILON)) * (1.0 + away**2)
        found.append((int(pose), POSES + int(number), epsilon))
    return found


def judge(answer: Any, graph: Choices) -> CaseScore:
    """Score a choice of at most three candidates: the largest standard deviation that is left, in m."""
    count = len(graph.candidates)
    if answer is None:
        raise TypeError(f"Your choice is None: return a list of at most {MOST} indices of candidates.")
    numbers = np.asarray(answer if np.size(answer) else np.zeros(0, int))
    if numbers.ndim != 1 or numbers.dtype.kind not in "iu":
        raise TypeError(
            f"A choice is a list of whole numbers from 0 to {count - 1}, the indices of candidates; got "
            f"{type(answer).__name__}."
        )
    chosen = [int(each) for each in numbers[: MOST + 1]]
    if len(chosen) > MOST or len(set(chosen)) < len(chosen):
        raise ValueError(f"Choose at most {MOST} different candidates; got {len(numbers)}: {chosen}.")
    if not all(0 <= each < count for each in chosen):
        raise ValueError(f"There are {count} candidates, 0 to {count - 1}; got {chosen}.")
    now, left = graph.worst_after([]), graph.worst_after(chosen)
    return CaseScore(left, {"measurements": float(len(chosen))}, (now, left))


@course_style()
def draw_choices(run: Run) -> Drawing:
    """Draw the largest standard deviation of each graph without and with the chosen measurements."""
    kept = [(number, *each.kept) for number, each in enumerate(run.results, start=1) if each.kept]
    figure = Figure(figsize=(9.6, 4.0))
    ax = figure.add_subplot()
    for number, now, left in kept:
        ax.plot([number, number], [now, left], color=GREY, lw=1)
        ax.plot(number, now, ".", color=GREY, ms=7)
        ax.plot(number, left, STYLES["graph"].marker, color=STYLES["graph"].colour, ms=7, mec="white")
    ax.set(
        xlabel="graph",
        ylabel="largest standard deviation (m)",
        ylim=(0, None),
        xlim=(0, len(run.results) + 1),
    )
    ax.set_title("with your measurements (diamonds), and without them (dots)", fontsize=11)
    now, left = np.array([each[1:] for each in kept]).mean(axis=0)
    return Drawing(
        figure,
        f"Largest standard deviations of {len(kept)} graphs: {now:.2f} m without and {left:.2f} m with the choices.",
    )


CHALLENGE = Challenge(
    lesson="08_graph_slam",
    title="Challenge 08: the most useful measurements",
    task=f"In each of {GRAPHS} graphs you may add three measurements. Write a function of (omega, xi, candidates), "
    "where each candidate is (pose, landmark, epsilon); return a list of the indices of your choices.",
    scoring="the largest standard deviation of all variables, with your measurements; the mean over all graphs.",
    seeds=range(1, GRAPHS + 1),
    make=make_graph,
    given=lambda graph: (graph.omega, graph.xi, graph.candidates),
    judge=judge,
    figure=draw_choices,
    columns=(Column("measurements", digits=1),),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    version=2,
    nothing=3.0,
    higher_is_better=False,
    unit=" m",
    case="graph",
    name_of=lambda seed: f"graph {seed}",
)
