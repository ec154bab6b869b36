"""What the saturation floor of lesson 01 brings, on the real pictures and on the simulator's twins of them.

The functions are the lesson's own solution. Where carpet, posts and the background are in a picture is known
from the pictures' fitted geometry (benchmarks/simulator/real_scenes).
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from benchmarks import Result, Table, solution
from benchmarks.simulator.real_scenes import Geometry, real_scenes
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
    """Measure all pictures and their twins."""
    own, scenes = solution("01"), real_scenes()
    geometry = [scene.geometry() for scene in scenes]
    twins = [scene.twin(Reality(), number) for number, scene in enumerate(scenes)]
    sides = {"real": [scene.picture.pixels for scene in scenes], "simulated": twins}
    values: dict[str, Any] = {"floors": list(FLOORS)}
    for name, pictures in sides.items():
        values[name] = pooled([shares(p, g, own) for p, g in zip(pictures, geometry, strict=True)])
    tables = tuple(
        Table(
            f"{name}: mean share of {len(scenes)} pictures, %, by saturation floor",
            ("", *(f"{floor:g}" for floor in FLOORS)),
            tuple((part, *(100 * share for share in each)) for part, each in values[name].items()),
        )
        for name in sides
    )
    return Result("colour_filter", values, tables)
