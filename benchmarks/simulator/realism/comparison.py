"""Real pictures and their twins, side by side in every statistic."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any, get_args

import numpy as np

from benchmarks.simulator.realism.geometry import Geometry
from benchmarks.simulator.realism.measuring import STATISTICS, Samples, measure
from benchmarks.simulator.realism.profiles import thinned
from benchmarks.simulator.realism.scenes import RealScene, real_scenes, simulated_twin
from nao_course.datasets import PictureSet
from nao_course.geometry import FloatArray
from nao_course.sim.reality import Reality

# Counts, fractions and lightness of what is mostly absent: the mean over pictures tells more than the median.
_BY_MEAN = ("%", "specks", "left off lines", "false segments")
_MOST_SAMPLES = 60  # of one picture, so that no picture outweighs the rest


@dataclass(frozen=True)
class Summary:
    """One statistic over a set of pictures: its middle, the 10 and 90 % of single pictures, and how many tell it."""

    middle: float
    low: float
    high: float
    pictures: int


def summarise(measured: Iterable[Samples]) -> dict[str, Summary]:
    """Pool the samples of the pictures: mean of counts and fractions, median of all else."""
    found: dict[str, list[FloatArray]] = {}
    for samples in measured:
        for name, values in samples.items():
            values = values[np.isfinite(values)]
            if values.size:
                found.setdefault(name, []).append(values[thinned(len(values), _MOST_SAMPLES)])
    return {name: _summary(name, found[name]) for name in STATISTICS if name in found}


def _summary(name: str, parts: list[FloatArray]) -> Summary:
    quantile = any(name.startswith(each) for each in ("hue", "lightness", "background lightness"))
    middle = np.mean if any(each in name for each in _BY_MEAN) and not quantile else np.median
    single = [float(middle(part)) for part in parts]
    low, high = np.percentile(single, [10, 90]).tolist()
    return Summary(float(middle(np.concatenate(parts))), low, high, len(parts))


QUICK = 7  # every so many pictures: not 8, for the scenes turn by an eighth each


@lru_cache(maxsize=4)
def _real_side(step: int = 1, large: bool = False) -> tuple[tuple[RealScene, ...], tuple[Geometry, ...], Any]:
    """Return scenes, their geometry and statistics, measured only once for a tuning script."""
    scenes = tuple(s for s in real_scenes() if s.picture.has_large) if large else real_scenes()[::step]
    size = LARGE if large else None
    geometry = tuple(scene.geometry(size) for scene in scenes)
    pictures = [scene.picture.read(large=large) for scene in scenes]
    measured = [measure(p, g) for p, g in zip(pictures, geometry, strict=True)]
    return scenes, geometry, measured


LARGE = (1280, 960)


def compare(
    reality_: Reality | None = None, step: int = 1, seed: int = 0, large: bool = False
) -> dict[str, dict[str, Any]]:
    """Measure real pictures and their simulated twins.

    Parameters
    ----------
    reality_ : Reality, optional
        How real the simulator's pictures look; without it the default.
    step : int
        Every so many of the 94 pictures: 1 for all, 7 for a quick look.
    seed : int
        Of everything random.
    large : bool
        The 8 pictures of 1280 x 960 instead (lengths are then in their pixels).

    Returns
    -------
    dict
        By statistic: "real", "simulated" (the `Summary` of each as a dict) and "ratio" of their middles.
    """
    scenes, geometry, measured = _real_side(step, large)
    size = LARGE if large else None
    twins = (
        simulated_twin(scene, reality_ or Reality(), seed + i, size)[0] for i, scene in enumerate(scenes)
    )
    sides = (summarise(measured), summarise(measure(p, g) for p, g in zip(twins, geometry, strict=True)))
    return _side_by_side(*sides)


def _side_by_side(real: Mapping[str, Summary], simulated: Mapping[str, Summary]) -> dict[str, dict[str, Any]]:
    rows: dict[str, dict[str, Any]] = {}
    for name in STATISTICS:
        both = [side.get(name) for side in (real, simulated)]
        if any(both):
            row = {
                k: asdict(side) if side else None for k, side in zip(("real", "simulated"), both, strict=True)
            }
            a, b = (side.middle if side else float("nan") for side in both)
            rows[name] = {**row, "ratio": b / a if a and np.isfinite(a + b) else None}
    return rows


def compare_by_set(reality_: Reality | None = None, seed: int = 0) -> dict[str, dict[str, dict[str, Any]]]:
    """Run `compare` for each of the two sets, which differ in light, white balance and season."""
    scenes, geometry, measured = _real_side()
    results = {}
    for name in get_args(PictureSet):
        chosen = [i for i, scene in enumerate(scenes) if scene.set_name == name]
        twins = [
            measure(simulated_twin(scenes[i], reality_ or Reality(), seed + i)[0], geometry[i])
            for i in chosen
        ]
        results[name] = _side_by_side(summarise(measured[i] for i in chosen), summarise(twins))
    return results
