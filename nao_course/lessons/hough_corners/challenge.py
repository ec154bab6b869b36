"""The challenge of lesson 03: corners of the field's lines in pictures that no value was chosen on."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.challenges.answers import as_found_points
from nao_course.challenges.worst_scenes import worst_scenes_of
from nao_course.lessons.hough_corners.scenes import CornerPicture
from nao_course.metrics import CornerTruth, corner_cost
from nao_course.sim import Scene, standard_scenes

PICTURES = 30


@cache
def _scenes() -> tuple[Scene, ...]:
    return standard_scenes("report")


def make_picture(number: int) -> CornerPicture:
    """Take one of the standard set's pictures to report on."""
    scene = _scenes()[number]
    return CornerPicture(scene.pixels, CornerTruth.of(scene.truth))


def judge(answer: Any, picture: CornerPicture) -> CaseScore:
    """Score the corners found in a picture by the paper's costs."""
    points = as_found_points(answer, "corners")
    match = picture.match(points)
    columns = {"found": match.hits, "false": match.false, "missed": match.missed}
    return CaseScore(
        corner_cost(match),
        {name: float(number) for name, number in columns.items()},
        (picture.pixels, points, picture.truth.corners),
    )


CHALLENGE = Challenge(
    lesson="03_hough_corners",
    title="Challenge 03: corners, from the picture alone",
    task="Find the corners of the field's lines, L and T, in thirty pictures of other rooms, with one function of the "
    "picture: points (K, 2), (u, v) in pixels.",
    scoring="the paper's cost of a picture, the mean over all: -1.333 for each corner found, 5 for each false one, 1 "
    "for each missed; less is better. A corner is found by a point within 8 pixels of it, each once; a point at a "
    "crossing X or at a post's foot counts neither way.",
    seeds=range(PICTURES),
    make=make_picture,
    given=lambda picture: (picture.pixels,),
    judge=judge,
    figure=worst_scenes_of("corner"),
    columns=(Column("found"), Column("false"), Column("missed")),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    nothing=5.0,
    higher_is_better=False,
    case="picture",
    name_of=lambda number: f"picture {number + 1}",
)
