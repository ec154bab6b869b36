"""The challenge of lesson 09: twenty false loop closures, some of which agree with each other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.geometry import FloatArray
from nao_course.graphs import Graph
from nao_course.lessons.pose_graphs.challenge_figure import draw_entries
from nao_course.lessons.pose_graphs.worlds import (
    APART,
    CLOSURE_SIGMA,
    CORRIDOR,
    World,
    between,
    building,
    chained,
    moved,
    position_error,
)

GRAPHS = 20
POSES = 240
TRUE_CLOSURES = 24
# Twenty false closures: runs of poses that are matched with poses in another corridor.
FALSE_GROUPS = (5, 4, 3, 2, 1, 1, 1, 1, 1, 1)
ROUGH = 4.0  # factor of the odometry's standard deviations in the lesson's building
FITS = 25.0  # e' Omega e up to which a closure counts as accepted


@dataclass(frozen=True, eq=False)
class Aliased:
    """A drive through a building whose corridors look alike.

    The edges are mixed, `false` (E,) marks the false ones, and the first pose is the truth's.
    """

    world: World
    false: npt.NDArray[np.bool_]


def make_graph(seed: int) -> Aliased:
    """Drive through a building with rough odometry, few true closures and twenty false ones."""
    rng = np.random.default_rng([seed, 909])
    plan = building(int(rng.integers(10_000)), POSES)
    truth = plan.graph.split(plan.truth)[0]
    follows = np.flatnonzero(~plan.closures())
    closures = np.flatnonzero(plan.closures())
    kept = np.sort(rng.choice(closures, min(TRUE_CLOSURES, len(closures)), replace=False))
    steps = _rough_steps(plan.graph, follows, truth, rng)
    pairs, z = _false_closures(truth, rng)
    graph = plan.graph
    edges = np.concatenate([graph.edges[follows], graph.edges[kept], pairs])
    measurements = np.concatenate([steps, graph.measurements[kept], z])
    closing = np.diag(1 / np.square(CLOSURE_SIGMA))
    information = np.concatenate(
        [graph.information[follows] / ROUGH**2, np.broadcast_to(closing, (len(kept) + len(pairs), 3, 3))]
    )
    false = np.arange(len(edges)) >= len(follows) + len(kept)
    order = np.concatenate(
        [np.arange(len(follows)), len(follows) + rng.permutation(len(edges) - len(follows))]
    )
    mixed = replace(
        graph, edges=edges[order], measurements=measurements[order], information=information[order]
    )
    path = chained(truth[0], steps)
    return Aliased(World(mixed, plan.truth, path.ravel()), false[order])


def _rough_steps(graph: Graph, follows: Any, truth: FloatArray, rng: np.random.Generator) -> FloatArray:
    sigma = ROUGH / np.sqrt(np.diagonal(graph.information[follows], axis1=1, axis2=2))
    return moved(between(truth[:-1], truth[1:]), sigma * rng.standard_normal(sigma.shape))


def _false_closures(truth: FloatArray, rng: np.random.Generator) -> tuple[Any, FloatArray]:
    """Return pairs (late, early) of poses in runs along different corridors, and their false measurements."""
    pairs: list[tuple[int, int]] = []
    measured: list[FloatArray] = []
    for count in FALSE_GROUPS:
        while True:
            early, late = sorted(rng.integers(1, len(truth) - 2 * count, 2).tolist())
            runs = early + 2 * np.arange(count), late + 2 * np.arange(count)
            far = np.hypot(*(truth[late] - truth[early])[:2]) > 1.5 * CORRIDOR
            straight = all(np.ptp(truth[run, 2]) < 1e-9 for run in runs)
            if far and straight and late - early > APART + 2 * count:
                break
        shift = rng.normal(0.0, 0.5, 2)
        for first, second in zip(*runs, strict=True):
            pairs.append((int(second), int(first)))
            noise = np.array(CLOSURE_SIGMA) * rng.standard_normal(3)
            measured.append(np.array([*shift, 0.0]) + noise)
    return np.array(pairs), np.array(measured)


def closure_squares(world: World, states: Any) -> FloatArray:
    """Return the weighted squared errors of all edges, (E,)."""
    return world.graph.squared_errors(states, _residual, lambda *ends: np.zeros((0, 2)))


def _residual(first: FloatArray, second: FloatArray, z: FloatArray) -> FloatArray:
    """Return poses in the frames of the poses that z predicts."""
    return between(moved(first, z), second)


def judge(answer: Any, case: Aliased) -> CaseScore:
    """Score states by their distance from the truth, and count the closures that they accept."""
    world = case.world
    if answer is None:
        raise TypeError("Your answer is None: return the states.")
    if isinstance(answer, tuple | list) and len(answer) == 2:
        raise TypeError("Return the states only: gauss_newton gives (states, history), take its first.")
    states = np.array(answer, dtype=float, subok=False)
    if states.shape != (world.graph.size,):
        raise ValueError(f"Your states must have the shape ({world.graph.size},), got {states.shape}.")
    if not np.isfinite(states).all():
        raise ValueError("Your states contain NaN or infinity.")
    states = _moved_to_the_truth(world, states)
    squares, closing = closure_squares(world, states), world.closures()
    accepted = squares < FITS
    columns = {
        "false accepted": 100.0 * float(accepted[case.false].mean()),
        "true rejected": 100.0 * float(1 - accepted[closing & ~case.false].mean()),
    }
    return CaseScore(position_error(world, states), columns, (world, states, case.false, accepted))


def _moved_to_the_truth(world: World, states: FloatArray) -> FloatArray:
    """Move the whole answer so that its first pose is the true one."""
    poses, true = states.reshape(-1, 3), world.truth[:3]
    turn = true[2] - poses[0, 2]
    c, s = np.cos(turn), np.sin(turn)
    places = (poses[:, :2] - poses[0, :2]) @ np.array([[c, s], [-s, c]]) + true[:2]
    return np.column_stack([places, poses[:, 2] + turn]).ravel()


CHALLENGE = Challenge(
    lesson="09_pose_graphs",
    title="Challenge 09: twenty false loop closures",
    task=f"In each of {GRAPHS} drives through a building twenty closures are false, and about as many are true. "
    "Write a function of (graph, states), states being the odometry's; return the states that you estimate, flat.",
    scoring="the root mean square distance of all poses from the truth, in metres; the mean over all drives; smaller "
    "is better.",
    seeds=range(1, GRAPHS + 1),
    make=make_graph,
    given=lambda case: (case.world.graph, case.world.odometry),
    judge=judge,
    figure=draw_entries,
    columns=(Column("false accepted", " %", 0), Column("true rejected", " %", 0)),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    nothing=20.0,
    higher_is_better=False,
    unit=" m",
    case="drive",
    name_of=lambda seed: f"drive {seed}",
)
