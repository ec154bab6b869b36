"""Lesson 10's search of 27 settings on other pictures, in other sizes and on real ones, by the lesson's own solution.

``python -m benchmarks experiments`` writes the means beside the lesson, where its figures read them.
"""

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from benchmarks import Result, Table, solution, write_json
from benchmarks.challenges.posts import labels_of
from nao_course.lessons.experiments.paper_table import BEST, BETAS, GAPS, LENGTHS, PAPER_MEANS, SETTINGS
from nao_course.lessons.experiments.reading import RECORDED, SIZES, impossible_means
from nao_course.lessons.experiments.resampling import optimism, rank_correlation, shares_won
from nao_course.lessons.experiments.scenes import (
    COSTS,
    CornerScene,
    nothing_costs,
    real_scenes,
    simulated_scenes,
)
from nao_course.metrics import mean_interval

OWN, CORNERS = solution("10"), solution("03")


def search(scenes: Sequence[CornerScene], scale: float = 1.0) -> dict[Any, Any]:
    """Return the 27 settings, with gap and length multiplied by a scale, by the settings' own names."""
    table: dict[Any, list[float]] = {setting: [] for setting in SETTINGS}
    for (picture, corners), beta in product(scenes, BETAS):
        labels = labels_of(picture, beta=beta)
        for gap, length in product(GAPS, LENGTHS):
            found = CORNERS["find_corners"](labels, scale * gap, scale * length)
            table[beta, gap, length].append(OWN["detection_cost"](found, corners, 8 * len(picture) / 240))
    return {setting: np.array(costs) for setting, costs in table.items()}


def measured(table: dict[Any, Any], scenes: Sequence[CornerScene]) -> dict[str, Any]:
    """Return the means in the order of SETTINGS, and the cost of finding nothing."""
    return {
        "pictures": len(scenes),
        "nothing": round(float(nothing_costs(scenes).mean()), 4),
        "means": [round(float(table[setting].mean()), 4) for setting in SETTINGS],
        "sigmas": [round(float(table[setting].std(ddof=1)), 4) for setting in SETTINGS],
    }


def main() -> Result:
    """Search on all sets, and write what the lesson shows of them."""
    tune = search(simulated_scenes())
    sets: dict[str, dict[str, Any]] = {}
    for size, scale in SIZES.items():
        scenes = simulated_scenes("tune", (round(320 * scale), round(240 * scale)))
        for name, factor in (("the same pixels", 1.0), ("in proportion", scale)):
            table = search(scenes, factor)
            ends = np.round(mean_interval(table[BEST]), 4).tolist()
            sets[f"{size}, {name}"] = measured(table, scenes) | {"the paper's best, 95 %": ends}
    others = {
        "simulator, other rooms": simulated_scenes("report"),
        "a real NAO, eight places": real_scenes("scenes"),
        "a real NAO, a walk": real_scenes("straightwalk"),
    }
    if not all(others.values()):
        raise FileNotFoundError("the real pictures are not here")
    tables = {name: search(scenes) for name, scenes in others.items()}
    sets |= {name: measured(tables[name], scenes) for name, scenes in others.items()}
    write_json(RECORDED, sets, 1)
    write_json(COSTS, [np.round(tune[setting], 4).tolist() for setting in SETTINGS])
    found, shares = optimism(tune), shares_won(tune)
    best = min(tune, key=lambda setting: float(tune[setting].mean()))
    values: dict[str, Any] = {
        "sets": sets,
        "best": list(best),
        "best, 95 %": list(mean_interval(tune[best])),
        "best in": shares[best],
        "promised": float(found.promised.mean()),
        "kept": float(found.kept.mean()),
        "any": found.any_setting,
        "impossible": len(impossible_means(OWN["possible_hits"])),
        "impossible with four thirds": sum(_with_thirds(mean) for mean in PAPER_MEANS.values()),
        "by chance possible": _possible_by_chance(),
        "rank correlation": {
            name: rank_correlation(PAPER_MEANS, dict(zip(SETTINGS, each["means"], strict=True)))
            for name, each in sets.items()
        },
    }
    shown = {
        name: {
            "pictures": each["pictures"],
            "nothing": each["nothing"],
            "120, 5, 40": each["means"][SETTINGS.index(BEST)],
            "lowest": min(each["means"]),
            "highest": max(each["means"]),
        }
        for name, each in sets.items()
    }
    return Result("experiments", values, (Table.of("mean costs of 27 settings", shown),))


def _with_thirds(mean: float, pictures: int = 30) -> bool:
    """Return whether no integer number of thirds is near enough to thirty times a mean."""
    thirds = 3 * pictures * mean
    return bool(abs(thirds - round(thirds)) > 3 * pictures * 0.0005 + 1e-9)


def _possible_by_chance() -> float:
    """Return the share of all three-digit numbers from 2 to 10 that pass the test."""
    means = np.round(np.arange(2.0, 10.0, 0.001), 3)
    return float(np.mean([len(OWN["possible_hits"](mean, 30, 240)) > 0 for mean in means]))
