"""The challenge of lesson 02: goal feet in dark and harsh rooms."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.geometry import FloatArray
from nao_course.lessons.goalposts.challenge_figure import draw_worst_scenes
from nao_course.lessons.goalposts.scenes import PostScene
from nao_course.sim import Field, Reality
from nao_course.sim.scenes import random_scene

SIZE = (320, 240)
ROOMS = {"dark": (621, 622, 623), "harsh": (624, 625, 626)}  # by preset; parameters are tuned in others
SCENES_PER_ROOM = 5
MOST_POINTS = 1000  # of an entry in one picture


@dataclass(frozen=True)
class Place:
    """Which scene: a preset of `Reality`, the seed of its room, and its number in that room."""

    preset: str
    room: int
    number: int

    def __str__(self) -> str:
        """Such as "dark 7": the seventh of the dark scenes."""
        before = ROOMS[self.preset].index(self.room) * SCENES_PER_ROOM
        return f"{self.preset} {before + self.number + 1}"


def make_scene(place: Place) -> PostScene:
    """Take the picture of a place: one of those that show a goal foot."""
    reality = getattr(Reality, place.preset)(seed=place.room)
    rng = np.random.default_rng([place.room, place.number, 2])
    while True:
        scene = random_scene(SIZE, reality, rng)
        found = PostScene.of(scene.pixels, scene.truth, Field(2012))
        if len(found.feet.pixels):
            return found


def as_feet(answer: Any) -> FloatArray:
    """Return an answer as points (K, 2).

    Raises
    ------
    TypeError, ValueError
        If it is something else; the message is for the student.
    """
    if answer is None:
        raise TypeError("Your entry returns None: does it end with return feet?")
    try:
        points = np.array(answer, dtype=float, subok=False)
    except (TypeError, ValueError):
        raise TypeError(f"Your entry must return points (K, 2), got {type(answer).__name__}.") from None
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"Your entry must return points (K, 2), none as (0, 2); got shape {points.shape}.")
    if not np.isfinite(points).all():
        raise ValueError("Your entry returns points that are NaN or infinite.")
    if len(points) > MOST_POINTS:
        raise ValueError(f"Your entry returns {len(points)} points; at most {MOST_POINTS} are looked at.")
    return points


def judge(answer: Any, scene: PostScene) -> CaseScore:
    """Score the feet found in a scene: F1 of points within 8 pixels of a true foot, each foot once."""
    points = as_feet(answer)
    match = scene.match(points)
    columns = {"feet missed": float((~match.found).sum()), "false points": float(match.false)}
    return CaseScore(match.f1, columns, (scene.pixels, points, scene.feet.pixels))


CHALLENGE = Challenge(
    lesson="02_goalposts",
    title="Challenge 02: goal feet in dark and harsh rooms",
    task="Find the feet of the goal posts in thirty pictures, fifteen in dark rooms and fifteen in harsh ones, with "
    "one function of the picture: points (K, 2), (u, v) in pixels.",
    scoring="F1, 2 found / (feet + points), the mean over all scenes. A foot is found by a point within 8 pixels of "
    "it, each foot once. Every scene shows a foot; one that is hidden or outside counts neither way.",
    seeds=tuple(
        Place(preset, room, number)
        for preset, rooms in ROOMS.items()
        for room in rooms
        for number in range(SCENES_PER_ROOM)
    ),
    make=make_scene,
    given=lambda scene: (scene.pixels,),
    judge=judge,
    figure=draw_worst_scenes,
    columns=(Column("feet missed"), Column("false points")),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    name_of=str,
)
