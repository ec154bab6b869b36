"""How quick lesson 02's search for posts is, beside a loop over columns, and what it finds on which pictures.

The functions are the lesson's own solution. Its values were chosen on the tuning pictures by the grid below, before the
others were looked at.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from benchmarks import ROOT, Result, Table
from nao_course.colours import GREEN, mean_lightness
from nao_course.datasets import read_pictures
from nao_course.exercises import load_definitions
from nao_course.lessons.goalposts.measuring import Feet, FootMatch, match_feet
from nao_course.metrics import total
from nao_course.sim import Field, Reality, standard_scenes

Pixels = npt.NDArray[np.uint8]
COLOURS = load_definitions(ROOT / "solutions" / "01_hsl_filtering.ipynb")
OWN = load_definitions(ROOT / "solutions" / "02_goalposts.ipynb")

CHOSEN = (68.0, 8, 10, 20.0)  # the lesson's: yellow up to, min_green of look_down, linkage
YELLOW_UP_TO = (66.0, 68.0, 70.0, 72.0)
GREEN_OF = ((6, 8), (7, 9), (8, 10), (9, 11), (9, 12))
LINKAGES = (10.0, 14.0, 20.0, 24.0)
MIN_HEIGHT = 0.1  # the lower end of what the paper names
SEEDS = (0, 1, 2)  # of the standard sets: 90 pictures to choose on, 90 to report on
MOST_MS = {320: 3.0, 640: 8.0, 1280: 33.0}  # for all of posts and corners, on one core
ROUNDS = 3


def label(picture: Pixels, yellow_up_to: float = CHOSEN[0]) -> Pixels:
    """Return the labels of a picture as in the lesson."""
    threshold = COLOURS["white_threshold"](mean_lightness(picture))
    labels: Pixels = COLOURS["color_labels"](picture, GREEN, (44.0, yellow_up_to), threshold)
    return labels


def loop_over_columns(labels: Pixels) -> list[tuple[int, int]]:
    """Find candidates with a loop over columns and pixels, as in a first attempt."""
    height, width = labels.shape
    min_green, look_down, least = 8 * height / 240, 10 * height // 240, 0.1 * height
    found = []
    for u in range(width):
        v = height - 1
        while v >= 0 and labels[v, u] != 2:
            v -= 1
        green = sum(labels[row, u] == 1 for row in range(v + 1, min(v + 1 + look_down, height)))
        top = v
        while top >= 0 and labels[top, u] == 2:
            top -= 1
        if v >= 0 and green >= min_green and v - top >= least:
            found.append((u, v))
    return found


def milliseconds(function: Callable[[Pixels], Any], pictures: Sequence[Pixels]) -> float:
    """Return the median processor time for one picture, ms."""
    times = []
    for picture in list(pictures) * ROUNDS:
        start = time.process_time()
        function(picture)
        times.append(time.process_time() - start)
    return 1000 * float(np.median(times))


def speeds() -> dict[int, dict[str, float]]:
    """Measure the search and the loop by the width of the picture."""
    scenes = [label(scene.pixels) for scene in standard_scenes("tune")][::3]
    found = {}
    for width in MOST_MS:
        large = [
            cv2.resize(each, (width, width * 3 // 4), interpolation=cv2.INTER_NEAREST) for each in scenes
        ]
        found[width] = {
            "labels to feet": milliseconds(OWN["find_goalposts"], large),
            "candidates by a loop": milliseconds(loop_over_columns, large),
            "most for posts and corners": MOST_MS[width],
        }
    return found


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
    candidates = OWN["post_candidates"](labels, min_green, look_down, MIN_HEIGHT)
    return OWN["cluster_points"](candidates, linkage)


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
    """Time the search, choose the values again, and report what they find."""
    timed = speeds()
    tune = simulated("tune")
    chosen_from = grid(tune)
    ranked = sorted(chosen_from.items(), key=lambda item: item[1].false - item[1].found.sum())
    sets = {"simulator, chosen on": tune, "simulator, other rooms": simulated("report")}
    notes = []
    try:
        sets |= {"real scenes": real("scenes"), "real walk": real("straightwalk")}
    except FileNotFoundError as error:
        notes.append(f"the real pictures are left out: {error}")
    rows = []
    for name, pictures in sets.items():
        for rule, green in (("8 of 10", 8), ("no green", 0)):
            match = total(match_feet(search(label(p), green, 10, CHOSEN[3]), feet) for p, feet in pictures)
            rows.append((name, rule, len(pictures), len(match.found), int(match.found.sum()), match.false))
    tables = (
        Table(
            "posts, ms a picture on one core",
            ("width", *next(iter(timed.values()))),
            tuple((width, *each.values()) for width, each in timed.items()),
        ),
        Table("goal feet within 8 px", ("pictures", "rule", "number", "feet", "found", "false"), tuple(rows)),
        Table(
            f"the ten best of {len(ranked)} settings on the tuning pictures, by found less false",
            ("yellow up to", "min_green", "look_down", "linkage", "found", "false"),
            tuple((*setting, int(match.found.sum()), match.false) for setting, match in ranked[:10]),
        ),
    )
    values = {
        "ms": {str(width): each for width, each in timed.items()},
        "feet": {f"{row[0]}, {row[1]}": list(row[2:]) for row in rows},
        "best found less false": int(ranked[0][1].found.sum()) - ranked[0][1].false,
        "chosen found less false": int(chosen_from[CHOSEN].found.sum()) - chosen_from[CHOSEN].false,
    }
    return Result("posts", values, tables, tuple(notes))
