"""What the saturation floor of lesson 01 brings, on the real pictures and on the simulator's twins of them.

The functions are the lesson's own solution. Where carpet, posts and the background are in a picture is known
from the pictures' fitted geometry (benchmarks/simulator/realism).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from benchmarks import ROOT, Result, Table
from benchmarks.simulator.realism import Geometry, RealScene, compare_detector, real_scenes, simulated_twin
from nao_course.exercises import load_definitions
from nao_course.sim.reality import Reality

FLOORS = (0.0, 0.08, 0.16, 0.24, 0.32)
GREEN, YELLOW = (90.0, 160.0), (44.0, 66.0)  # degrees; carpets and goals of several venues


def shares(pixels: Any, geometry: Geometry, own: Mapping[str, Callable[..., Any]]) -> dict[str, list[float]]:
    """Return the share of each part of a picture that gets each label, for each least saturation."""
    parts = {"carpet": geometry.carpet, "behind": geometry.background, "post": geometry.post_core}
    threshold = own["white_threshold"](own["rgb_to_hsl"](pixels)[2].mean())
    found: dict[str, list[float]] = {}
    for floor in FLOORS:
        labels = own["color_labels"](pixels, GREEN, YELLOW, threshold, floor)
        for name, part, label in (
            ("carpet labelled green", "carpet", 1),
            ("carpet labelled yellow", "carpet", 2),
            ("posts labelled yellow", "post", 2),
            ("background labelled green", "behind", 1),
            ("background labelled yellow", "behind", 2),
        ):
            if parts[part].sum() > 20:
                found.setdefault(name, []).append(float((labels[parts[part]] == label).mean()))
    return {name: values for name, values in found.items() if len(values) == len(FLOORS)}


def pooled(each: list[dict[str, list[float]]]) -> dict[str, list[float]]:
    """Return the mean over pictures."""
    names = dict.fromkeys(name for shares_ in each for name in shares_)
    return {name: np.mean([s[name] for s in each if name in s], axis=0).tolist() for name in names}


def main() -> Result:
    """Measure all pictures and their twins, and the paper's corner detector with and without the floor."""
    own = load_definitions(ROOT / "solutions" / "01_hsl_filtering.ipynb")
    scenes: tuple[RealScene, ...] = real_scenes()
    geometry = [scene.geometry() for scene in scenes]
    real = pooled([shares(s.picture.pixels, g, own) for s, g in zip(scenes, geometry, strict=True)])
    twins = [simulated_twin(scene, Reality(), number)[0] for number, scene in enumerate(scenes)]
    simulated = pooled([shares(p, g, own) for p, g in zip(twins, geometry, strict=True)])
    corners = {f"{floor}": compare_detector(min_saturation=floor)["real"] for floor in (0.0, 0.16)}
    names = ("corners", "hits", "false", "cost")
    kept = {floor: {name: each[name] for name in names} for floor, each in corners.items()}
    tables = [
        Table(
            f"{title}: mean share of {len(scenes)} pictures, %, by saturation floor",
            ("", *(f"{floor:g}" for floor in FLOORS)),
            tuple((name, *(100 * value for value in values)) for name, values in side.items()),
        )
        for title, side in (("real", real), ("simulated", simulated))
    ]
    rows = tuple((floor, *each.values()) for floor, each in kept.items())
    tables.append(Table("the paper's corner detector, real", ("floor", *names), rows))
    values = {"floors": list(FLOORS), "real": real, "simulated": simulated, "corners": kept}
    return Result("colour_filter", values, tuple(tables))
