"""Estimate how a table of costs would change with other pictures: which setting wins, and by how much."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises.trying import made
from nao_course.geometry import FloatArray
from nao_course.lessons.experiments.paper_table import Setting

CostTable = Mapping[Setting, FloatArray]  # costs (S,) of each scene, by the setting
DRAWS = 4000


def as_table(answer: Any) -> dict[Setting, FloatArray]:
    """Return a student's table as costs (S,) of floats by setting, the best mean first.

    If an earlier cell could not make the table, its message is shown again. Anything else raises a TypeError or
    ValueError with a message for the student.
    """
    answer = made(answer)
    if not isinstance(answer, Mapping) or not answer:
        raise TypeError(
            f"grid_search must return a dict of costs by (beta, gap, length), got {type(answer).__name__}"
        )
    costs = {key: np.array(each, dtype=float, subok=False) for key, each in answer.items()}
    shapes = {each.shape for each in costs.values()}
    if len(shapes) != 1 or len(next(iter(shapes))) != 1:
        raise ValueError(
            f"every setting must have one cost per scene, shape (S,); got shapes {sorted(shapes)}"
        )
    return dict(sorted(costs.items(), key=lambda item: float(item[1].mean())))


def shares_won(table: CostTable, draws: int = DRAWS) -> dict[Setting, float]:
    """Return how often each setting has the lowest mean when the scenes are resampled with replacement."""
    costs = np.array(list(table.values()))
    counts = np.random.default_rng(0).multinomial(
        costs.shape[1], np.full(costs.shape[1], 1 / costs.shape[1]), draws
    )
    winners = (counts @ costs.T).argmin(axis=1)
    wins = np.bincount(winners, minlength=len(costs)) / draws
    return dict(zip(table, wins.tolist(), strict=True))


def called_different(costs: FloatArray, rng: np.random.Generator, draws: int = 2000) -> int:
    """Count the settings whose 95 % bootstrap interval of the paired difference from the best does not contain 0.

    `costs` (K, S) has a row for each setting and a column for each scene.
    """
    scenes = costs.shape[1]
    apart = costs - costs[costs.mean(axis=1).argmin()]
    counts = rng.multinomial(scenes, np.full(scenes, 1 / scenes), draws)
    low, high = np.quantile(counts @ apart.T / scenes, (0.025, 0.975), axis=0)
    return int(np.count_nonzero((low > 0) | (high < 0)))


def placebo(table: CostTable, runs: int = 200) -> npt.NDArray[np.int64]:
    """Return for each run how many settings are called different from the best in a table in which all are equal.

    The costs of each scene are permuted among the settings.
    """
    costs, rng = np.array(list(table.values())), np.random.default_rng(0)
    return np.array([called_different(rng.permuted(costs, axis=0), rng) for _ in range(runs)])


@dataclass(frozen=True)
class Optimism:
    """Mean costs of a setting that was chosen on one half of the scenes, over many random halves.

    `promised` (M,) is on the half on which it was the best, `kept` (M,) on the other, and `any_setting` is the mean of
    all settings.
    """

    promised: npt.NDArray[np.float64]
    kept: npt.NDArray[np.float64]
    any_setting: float


def optimism(table: CostTable, halvings: int = 1000) -> Optimism:
    """Choose a setting on one random half and compute its cost on both halves, many times."""
    costs = np.array(list(table.values()))
    rng, scenes = np.random.default_rng(0), costs.shape[1]
    promised, kept = [], []
    for _ in range(halvings):
        order = rng.permutation(scenes)
        one, other = order[: scenes // 2], order[scenes // 2 :]
        chosen = int(costs[:, one].mean(axis=1).argmin())
        promised.append(costs[chosen, one].mean())
        kept.append(costs[chosen, other].mean())
    return Optimism(np.array(promised), np.array(kept), float(costs.mean()))


def rank_correlation(first: Mapping[Setting, float], second: Mapping[Setting, float]) -> float:
    """Return Spearman's rank correlation of two tables' means, which is 1 if both rank the settings alike."""
    from scipy.stats import spearmanr  # takes long to import

    return float(spearmanr([first[key] for key in first], [second[key] for key in first]).statistic)
