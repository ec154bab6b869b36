"""The challenge of lesson 08: choose the additional measurement that improves the graph most."""

from __future__ import annotations

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
START_WEIGHT = 1e4  # 1/m^2: the start is known to a centimetre
MOTION_EPSILON = 0.02  # m^2 a step
MEASUREMENT_EPSILON = (0.01, 0.08)  # m^2, from the best to the worst measurement
NEAR = 4  # stops from which a landmark is measured, at most

Candidate = tuple[int, int, float]


@dataclass(frozen=True, eq=False)
class Choices:
    """A graph on one axis, and candidates for one more measurement.

    Omega (N, N) in 1/m^2 has poses first, then landmarks; xi (N,) is in 1/m, and the covariance (N, N) in m^2 is
    omega's inverse. The start has a standard deviation of 1 cm. Each candidate is (pose, landmark, variance epsilon in
    m^2).
    """

    omega: FloatArray
    xi: FloatArray
    candidates: list[Candidate]
    covariance: FloatArray

    def gains(self) -> FloatArray:
        """Return how much each candidate would reduce the sum of all variances, in m^2: (C,)."""
        # The inverse after one more row, by Sherman and Morrison, 1950.
        pose, landmark, epsilon = np.array(self.candidates).T
        row = self.covariance[:, landmark.astype(int)] - self.covariance[:, pose.astype(int)]
        every = np.arange(len(self.candidates))
        spread = row[landmark.astype(int), every] - row[pose.astype(int), every]
        return np.asarray((row**2).sum(axis=0) / (epsilon + spread))

    def worst_after(self, chosen: int | None) -> float:
        """Return the largest standard deviation of a variable in m, now or after a candidate was measured."""
        covariance = self.covariance
        if chosen is not None:
            pose, landmark, epsilon = self.candidates[chosen]
            row = covariance[:, landmark] - covariance[:, pose]
            covariance = covariance - np.outer(row, row) / (epsilon + row[landmark] - row[pose])
        return float(np.sqrt(np.diag(covariance).max()))


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
    """Score a choice: its reduction of the sum of the variances, divided by the reduction by the best candidate."""
    count = len(graph.candidates)
    if answer is None:
        raise TypeError(f"Your choice is None: return the index of a candidate, from 0 to {count - 1}.")
    number = np.asarray(answer)
    if number.shape != () or number.dtype.kind not in "iu":
        raise TypeError(
            f"A choice is the index of a candidate, a whole number from 0 to {count - 1}; got {type(answer).__name__}."
        )
    chosen = int(number)
    if not -1 <= chosen < count:
        raise ValueError(f"There are {count} candidates, 0 to {count - 1}, and -1 for none; got {chosen}.")
    gains = graph.gains()
    score = float(gains[chosen] / gains.max()) if chosen >= 0 else 0.0
    rank = float((gains > gains[chosen]).sum()) if chosen >= 0 else float(count)
    columns = {"better candidates": rank, "worst sigma": graph.worst_after(chosen if chosen >= 0 else None)}
    return CaseScore(score, columns, (gains / gains.max(), chosen))


@course_style()
def draw_choices(run: Run) -> Drawing:
    """Draw the scores of all candidates and of the chosen candidate, for each graph."""
    kept = [(number, each.kept) for number, each in enumerate(run.results, start=1) if each.kept]
    figure = Figure(figsize=(9.6, 4.0))
    ax = figure.add_subplot()
    for number, (gains, chosen) in kept:
        ax.plot(np.full(len(gains), number), gains, ".", color=GREY, ms=3, alpha=0.5)
        score = gains[chosen] if chosen >= 0 else 0.0
        ax.plot(number, score, STYLES["graph"].marker, color=STYLES["graph"].colour, ms=7, mec="white")
    ax.set(xlabel="graph", ylabel="fraction of the best", ylim=(-0.03, 1.05), xlim=(0, len(run.results) + 1))
    ax.set_title("chosen (diamonds), and all other candidates (dots)", fontsize=11)
    best = sum(chosen >= 0 and bool(gains[chosen] == 1.0) for _, (gains, chosen) in kept)
    return Drawing(
        figure, f"The chosen candidates in {len(kept)} graphs: the best candidate in {best} of them."
    )


CHALLENGE = Challenge(
    lesson="08_graph_slam",
    title="Challenge 08: the most useful measurement",
    task=f"In each of {GRAPHS} graphs one more measurement can be made. Write a function of (omega, xi, candidates), "
    "where each candidate is (pose, landmark, epsilon); return the index of the one to make, or -1 for none.",
    scoring="by how much the sum of the variances of all positions falls, as a fraction of what the best candidate "
    "achieves; the mean over all graphs.",
    seeds=range(1, GRAPHS + 1),
    make=make_graph,
    given=lambda graph: (graph.omega, graph.xi, graph.candidates),
    judge=judge,
    figure=draw_choices,
    columns=(Column("better candidates", digits=1), Column("worst sigma", " m")),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    case="graph",
    name_of=lambda seed: f"graph {seed}",
)
