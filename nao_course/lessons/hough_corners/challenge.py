"""The challenge of lesson 03: find corners in thirty pictures that were not used for tuning."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.challenges.answers import as_found_points
from nao_course.challenges.worst_scenes import worst_scenes_of
from nao_course.lessons.hough_corners.scenes import CornerPicture, other_rooms
from nao_course.metrics import corner_cost

PICTURES = 30


def make_picture(number: int) -> CornerPicture:
    """Return one of the thirty pictures of the simulator's reporting set."""
    return other_rooms()[number]


def judge(answer: Any, picture: CornerPicture) -> CaseScore:
    """Score the corners that were found in a picture with the paper's costs."""
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
    title="Challenge 03: find corners in rooms you have not seen",
    task="Write one function that takes a picture and returns the corners of the field's lines (L and T) as points "
    "(K, 2), (u, v) in pixels. It is run on thirty pictures from other rooms.",
    scoring="the mean of the paper's cost over all pictures; lower is better. Each corner that is found counts -1.333, "
    "each false one 5 and each missed one 1. A corner is found if a point lies within 8 pixels of it, and each point "
    "finds at most one corner. A point at an X crossing or at the foot of a post is ignored.",
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
