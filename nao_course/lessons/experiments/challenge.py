"""The challenge of lesson 10: find corners in unseen rooms and predict the mean cost."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.challenges import CaseScore, Challenge, Column, Run, recorded_rows
from nao_course.challenges.answers import as_found_points
from nao_course.challenges.rooms import places
from nao_course.geometry import FloatArray
from nao_course.lessons.experiments.scenes import CornerScene
from nao_course.metrics import CornerTruth, corner_cost, match_points
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below

ROOMS = {"lab": (1010, 1011), "dark": (1020, 1021), "harsh": (1030, 1031)}
IN_EACH = 6  # pictures of a room
STREAM = (10,)
OUTSIDE = 10.0  # what it costs to be outside an interval of 80 %, for each unit: 2 / (1 - 0.8)
WEIGHT = 0.25  # of the interval's score beside the cost
LARGEST = 1000.0  # of an interval's end
MISSED = 5.0  # in place of the 1 of Table 6.1: a robot without a pose needs landmarks


@dataclass(frozen=True, eq=False)
class Room:
    """The pictures of one room, such as "dark 2", with their corners."""

    name: str
    scenes: tuple[CornerScene, ...]


@dataclass(frozen=True, eq=False)
class Claim:
    """An entry's answer: the corners of each picture and an interval for their mean cost."""

    corners: tuple[FloatArray, ...]
    low: float
    high: float


def make_room(seed: tuple[str, int]) -> Room:
    """Take the pictures of a room; `seed` contains its preset and its own seed."""
    preset, room = seed
    each = places({preset: (room,)}, IN_EACH)
    scenes = [place.scene(lambda scene: True, STREAM) for place in each]
    pairs = tuple((scene.pixels, CornerTruth.of(scene.truth).corners) for scene in scenes)
    return Room(name_of(seed), pairs)


def name_of(seed: tuple[str, int]) -> str:
    """Return a room's name: its preset and its number within the preset."""
    preset, room = seed
    return f"{preset} {ROOMS[preset].index(room) + 1}"


def as_claim(answer: Any, pictures: int) -> Claim:
    """Return an answer as a claim.

    Raise a TypeError or ValueError with a message for the student if it is something else.
    """
    if answer is None:
        raise TypeError("Your entry returns None: does it end with return found, low, high?")
    if not isinstance(answer, tuple) or len(answer) != 3:
        raise TypeError(
            "Your entry must return (found, low, high): the corners of each picture and two numbers; got "
            f"{type(answer).__name__}."
        )
    found, *ends = answer
    if not isinstance(found, list | tuple) or len(found) != pictures:
        raise ValueError(f"found must be a list of {pictures} sets of corners, one for each picture.")
    try:
        low, high = (float(each) for each in ends)
    except (TypeError, ValueError):
        raise TypeError("low and high must be numbers.") from None
    if not (np.isfinite([low, high]).all() and low <= high and max(abs(low), abs(high)) <= LARGEST):
        raise ValueError(f"low and high must be numbers with low <= high, got {low:g} and {high:g}.")
    return Claim(tuple(as_found_points(each, "corners") for each in found), low, high)


def interval_score(low: float, high: float, value: float) -> float:
    """Return the interval score of an 80 % interval: its width plus ten times the distance of the value outside it.

    See T. Gneiting, A. E. Raftery, *Strictly proper scoring rules, prediction, and estimation*, Journal of the American
    Statistical Association 102, 2007, section 6.2.
    """
    return high - low + OUTSIDE * (max(low - value, 0.0) + max(value - high, 0.0))


def judge(answer: Any, room: Room) -> CaseScore:
    """Score a room: its mean cost, by Table 6.1 except for missed corners, and the interval score of the prediction."""
    claim = as_claim(answer, len(room.scenes))
    matches = [
        match_points(each, corners) for each, (_, corners) in zip(claim.corners, room.scenes, strict=True)
    ]
    cost = float(np.mean([corner_cost(match) + (MISSED - 1) * match.missed for match in matches]))
    columns = {
        "mean cost": cost,
        "false": float(np.mean([match.false for match in matches])),
        "interval width": claim.high - claim.low,
        "inside": 100.0 * (claim.low <= cost <= claim.high),
    }
    score = cost + WEIGHT * interval_score(claim.low, claim.high, cost)
    return CaseScore(score, columns, (room.name, cost, claim.low, claim.high))


@course_style()
def draw_rooms(run: Run) -> Drawing:
    """Draw the rooms of a run from (name, cost, low, high) of each."""
    kept = [each.kept for each in run.results if each.kept]
    outside = [name for name, cost, low, high in kept if not low <= cost <= high]
    figure = Figure(figsize=(8.6, 0.32 * len(kept) + 1.3))
    ax = figure.add_subplot()
    for row, (name, cost, low, high) in enumerate(kept):
        colour = STYLES["odometry"].colour if name in outside else STYLES["ekf"].colour
        ax.plot([low, high], [row, row], color=colour, lw=4, alpha=0.45, solid_capstyle="butt")
        ax.plot(cost, row, "o", color=STYLES["truth"].colour, ms=7)
    ax.set_yticks(range(len(kept)), [name for name, *_ in kept])
    ax.set(xlabel="mean cost of a room", ylim=(len(kept) - 0.5, -0.5))
    said = ax.plot([], [], color=STYLES["ekf"].colour, lw=4, alpha=0.45, label="your 80 % interval")
    wrong = ax.plot([], [], color=STYLES["odometry"].colour, lw=4, alpha=0.45, label="your interval, wrong")
    came = ax.plot([], [], "o", color=STYLES["truth"].colour, ls="", label="mean cost")
    legend_below(figure, [*said, *wrong, *came])
    return Drawing(
        figure,
        f"Mean cost of {len(kept)} rooms with the predicted intervals; outside are {', '.join(outside) or 'none'}.",
    )


CHALLENGE = Challenge(
    lesson="10_experiments",
    title="Challenge 10: corners in unseen rooms, and their predicted cost",
    task=f"A function of the {IN_EACH} pictures of a room, a list, that returns (found, low, high). found is a list "
    "with the corners of each picture, (K, 2), (u, v) in pixels. low and high are the ends of an interval that "
    "contains their mean cost with a probability of 80 %.",
    scoring="a room's mean cost, -1.333 for each hit, 5 for each false report and 5 for each missed corner, plus a "
    "quarter of the interval's cost: its width, and ten times the distance if the mean cost is outside. The score is "
    "the mean over six rooms; less is better.",
    seeds=tuple((preset, room) for preset, rooms in ROOMS.items() for room in rooms),
    make=make_room,
    given=lambda room: ([pixels for pixels, _ in room.scenes],),
    judge=judge,
    figure=draw_rooms,
    columns=(Column("mean cost"), Column("false"), Column("interval width"), Column("inside", " %", 0)),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    version=2,
    nothing=30.0,
    higher_is_better=False,
    case="room",
    name_of=name_of,
    seconds=10.0,
)
