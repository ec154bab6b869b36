"""What lesson 02's search for posts finds on which pictures.

The functions are the lesson's own solution. Its values were chosen on the tuning pictures, before the others were used.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks import Result, Table, solution
from benchmarks.challenges.posts import labels_of
from nao_course.datasets import read_pictures
from nao_course.lessons.goalposts.measuring import Feet, match_feet
from nao_course.metrics import total
from nao_course.sim import Field, Reality, standard_scenes

Pixels = npt.NDArray[np.uint8]
LOOK_DOWN, MIN_HEIGHT, LINKAGE = 10, 0.1, 20.0  # the lesson's values
SEEDS = (0, 1, 2)  # of the standard sets: 90 pictures to choose on, 90 to report on


def search(picture: Pixels, min_green: int) -> Any:
    """Search for feet with at least so much green below a post."""
    own = solution("02")
    candidates = own["post_candidates"](labels_of(picture), min_green, LOOK_DOWN, MIN_HEIGHT)
    return own["cluster_points"](candidates, LINKAGE)


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


def main() -> Result:
    """Report what the lesson's values find, and what is found without the green below a post."""
    notes = list[str]()
    sets = {"simulator, chosen on": simulated("tune"), "simulator, other rooms": simulated("report")}
    try:
        sets |= {"real scenes": real("scenes"), "real walk": real("straightwalk")}
    except FileNotFoundError as error:
        notes.append(f"the real pictures are left out: {error}")
    feet = {}
    for name, pictures in sets.items():
        for rule, green in (("8 of 10", 8), ("no green", 0)):
            match = total(match_feet(search(p, green), feet) for p, feet in pictures)
            feet[f"{name}, {rule}"] = [len(pictures), len(match.found), int(match.found.sum()), match.false]
    columns = ("pictures", "number", "feet", "found", "false")
    table = Table("goal feet within 8 px", columns, tuple((name, *row) for name, row in feet.items()))
    return Result("posts", {"feet": feet}, (table,), tuple(notes))
