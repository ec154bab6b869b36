"""What lesson 02's search for posts finds on which pictures, and its values chosen again.

The functions are the lesson's own solution. Its values were chosen on the tuning pictures by the grid below, before the
others were looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks import Result, Table, solution
from nao_course.colours import GREEN, mean_lightness
from nao_course.datasets import read_pictures
from nao_course.lessons.goalposts.measuring import Feet, FootMatch, match_feet
from nao_course.metrics import total
from nao_course.sim import Field, Reality, standard_scenes

Pixels = npt.NDArray[np.uint8]
CHOSEN = (68.0, 8, 10, 20.0)  # the lesson's: yellow up to, min_green of look_down, linkage
YELLOW_UP_TO = (66.0, 68.0, 70.0, 72.0)
GREEN_OF = ((6, 8), (7, 9), (8, 10), (9, 11), (9, 12))
LINKAGES = (10.0, 14.0, 20.0, 24.0)
MIN_HEIGHT = 0.1  # the lower end of what the paper names
SEEDS = (0, 1, 2)  # of the standard sets: 90 pictures to choose on, 90 to report on


def label(picture: Pixels, yellow_up_to: float = CHOSEN[0]) -> Pixels:
    """Return the labels of a picture as in the lesson."""
    own = solution("01")
    threshold = own["white_threshold"](mean_lightness(picture))
    labels: Pixels = own["color_labels"](picture, GREEN, (44.0, yellow_up_to), threshold)
    return labels


def simulated(which: Any) -> list[tuple[Pixels, Feet]]:
    """Return simulated pictures with the feet of their posts."""
    scenes = [scene for seed in SEEDS for scene in standard_scenes(which, reality=Reality(seed=seed))]
    return [(scene.pixels, Feet.of(scene.truth, Field(2012))) for scene in scenes]


def real(which: Any) -> list[tuple[Pixels, Feet]]:
    """Return pictures of a real robot with the feet that were marked by hand."""
    pairs = []
    for picture in read_pictures(which):
        marked = np.array([(p.u, p.v) for p in picture.points if p.kind == "post_foot"]).reshape(-1, 2)
        pairs.append((picture.pixels, Feet(marked, np.full(len(marked), np.nan), np.zeros((0, 2)))))
    return pairs


def search(labels: Pixels, min_green: int, look_down: int, linkage: float) -> Any:
    """Return the lesson's two functions with other parameters."""
    own = solution("02")
    return own["cluster_points"](own["post_candidates"](labels, min_green, look_down, MIN_HEIGHT), linkage)


def grid(pictures: Sequence[tuple[Pixels, Feet]]) -> dict[tuple[Any, ...], FootMatch]:
    """Return the results of each setting."""
    found = {}
    for up_to in YELLOW_UP_TO:
        labels = [(label(pixels, up_to), feet) for pixels, feet in pictures]
        for (green, down), linkage in product(GREEN_OF, LINKAGES):
            matches = (match_feet(search(each, green, down, linkage), feet) for each, feet in labels)
            found[up_to, green, down, linkage] = total(matches)
    return found


def main() -> Result:
    """Choose the values again, and report what the chosen ones find."""
    tune, notes = simulated("tune"), list[str]()
    gains = {setting: int(match.found.sum()) - match.false for setting, match in grid(tune).items()}
    sets = {"simulator, chosen on": tune, "simulator, other rooms": simulated("report")}
    try:
        sets |= {"real scenes": real("scenes"), "real walk": real("straightwalk")}
    except FileNotFoundError as error:
        notes.append(f"the real pictures are left out: {error}")
    feet = {}
    for name, pictures in sets.items():
        for rule, green in (("8 of 10", 8), ("no green", 0)):
            match = total(match_feet(search(label(p), green, 10, CHOSEN[3]), feet) for p, feet in pictures)
            feet[f"{name}, {rule}"] = [len(pictures), len(match.found), int(match.found.sum()), match.false]
    ranked = sorted(gains.items(), key=lambda item: -item[1])[:10]
    tables = (
        Table(
            "goal feet within 8 px",
            ("pictures", "number", "feet", "found", "false"),
            tuple((name, *row) for name, row in feet.items()),
        ),
        Table(
            f"the ten best of {len(gains)} settings on the tuning pictures",
            ("yellow up to", "min_green", "look_down", "linkage", "found less false"),
            tuple((*setting, gain) for setting, gain in ranked),
        ),
    )
    values = {"feet": feet, "best found less false": ranked[0][1], "chosen found less false": gains[CHOSEN]}
    return Result("posts", values, tables, tuple(notes))
