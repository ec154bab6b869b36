"""The seed paper's corner detector on real pictures and on their twins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.pictures import paper_detector as paper
from benchmarks.simulator.realism.geometry import FIELD
from benchmarks.simulator.realism.scenes import RealScene, real_scenes, simulated_twin
from nao_course.geometry import FloatArray
from nao_course.sim.reality import Reality
from nao_course.sim.render import PictureTruth, visible_landmarks

REACH = 7.5  # metres


def annotation_reach(scenes: Sequence[RealScene]) -> dict[str, float]:
    """Return the farthest distance of marked corners, and the share of corners in view that are marked by distance."""
    marked, shown = [], []
    for scene in scenes:
        for visible in _corners_in_view(scene):
            near = np.hypot(*(scene.corners - visible.pixel).T).min(initial=99.0) < 8
            shown.append(visible.distance)
            if near:
                marked.append(visible.distance)
    edges = np.array([0, 1, 2, 3, 4, 5, 6, 9])
    counts = [np.histogram(each, edges)[0] for each in (marked, shown)]
    values = {
        f"marked % of those in view, {a}-{b} m": 100 * m / n
        for a, b, m, n in zip(edges[:-1], edges[1:], *counts, strict=True)
        if n
    }
    return {"farthest marked m": float(max(marked)), **{k: float(v) for k, v in values.items()}}


def _corners_in_view(scene: RealScene) -> list[Any]:
    found = visible_landmarks(FIELD, scene.pose, scene.view)
    return [each for each in found if each.landmark.shape in ("L", "T") and not each.occluded]


def simulated_corners(truth: PictureTruth, reach: float = REACH) -> FloatArray:
    """Return the L and T corners (K, 2) of a twin that are in view, not hidden, and not farther than `reach`."""
    found = [
        each.pixel
        for each in truth.landmarks
        if each.landmark.shape in ("L", "T") and not each.occluded and each.distance <= reach
    ]
    return np.array(found, dtype=float).reshape(-1, 2)


def detector_scenes(
    scenes: Sequence[RealScene], reality_: Reality | None, seed: int = 0
) -> tuple[list[paper.Scene], list[paper.Scene]]:
    """Return real scenes with their annotations, and their twins with the renderer's ground truth."""
    real = [paper.Scene(scene.picture.pixels, scene.corners) for scene in scenes]
    twins = (simulated_twin(scene, reality_ or Reality(), seed + i) for i, scene in enumerate(scenes))
    return real, [paper.Scene(pixels, simulated_corners(truth)) for pixels, truth in twins]


def compare_detector(
    reality_: Reality | None = None, step: int = 1, seed: int = 0, min_saturation: float = 0.16
) -> dict[str, Any]:
    """Run the 27 settings of Table A.1 on real scenes and on their twins.

    Returns
    -------
    dict
        "rank correlation" of the mean costs; "real" and "simulated", each with what the paper's best setting
        finds, the 27 costs, and the loss funnel.
    """
    scenes = real_scenes()[::step]
    hues = paper.Hues(min_saturation=255 * min_saturation)
    values: dict[str, Any] = {}
    costs = {}
    for name, chosen in zip(("real", "simulated"), detector_scenes(scenes, reality_, seed), strict=True):
        grid = paper.run_grid(chosen, hues)
        costs[name] = grid.mean_costs
        values[name] = {
            **grid.at(),
            "rank correlation of halves": paper.reliability(grid),
            "costs": costs[name].tolist(),
            "funnel": paper.funnel(chosen, hues),
        }
    values["rank correlation"] = paper.rank_correlation(costs["real"], costs["simulated"])
    table_a1 = np.array(paper.PAPER_COSTS)
    for name, each in costs.items():
        values[name]["rank correlation with Table A.1"] = paper.rank_correlation(each, table_a1)
    return values


SETS_OF_ROOMS = 6  # a set of twins spreads over four rooms; single false corners decide the ranks of one set


def compare_detector_over_rooms(min_saturation: float = 0.16) -> dict[str, Any]:
    """Return rank correlations with the real mean costs, for each set of twins and for the mean over all rooms."""
    real = np.zeros(0)
    sets, each = [], []
    for number in range(SETS_OF_ROOMS):
        values = compare_detector(Reality(seed=4 * number), min_saturation=min_saturation)
        real = np.array(values["real"]["costs"])
        sets.append(values["simulated"]["costs"])
        each.append(values["rank correlation"])
    pooled = paper.rank_correlation(real, np.mean(sets, axis=0))
    return {"rooms": 4 * SETS_OF_ROOMS, "rank correlation": pooled, "of each set": each}
