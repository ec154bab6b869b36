"""The challenge of lesson 02: goal feet in dark and harsh rooms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.challenges.answers import as_found_points
from nao_course.challenges.rooms import Place, places
from nao_course.challenges.worst_scenes import worst_scenes_of
from nao_course.lessons.goalposts.scenes import PostScene
from nao_course.sim import Field, Scene

ROOMS = {"dark": (621, 622, 623), "harsh": (624, 625, 626)}  # by preset; parameters are tuned in others
SCENES_PER_ROOM = 5


def with_feet(scene: Scene) -> PostScene:
    """Return a picture with its feet."""
    return PostScene.of(scene.pixels, scene.truth, Field(2012))


def make_scene(place: Place) -> PostScene:
    """Return a picture of a room that shows the foot of a post."""
    return with_feet(place.scene(lambda scene: len(with_feet(scene).feet.pixels) > 0, stream=[2]))


def judge(answer: Any, scene: PostScene) -> CaseScore:
    """Score the feet found in a scene: F1 of points within 8 pixels of a true foot, each foot once."""
    points = as_found_points(answer, "feet")
    match = scene.match(points)
    columns = {"feet missed": float(match.missed), "false points": float(match.false)}
    return CaseScore(match.f1, columns, (scene.pixels, points, scene.feet.pixels))


CHALLENGE = Challenge(
    lesson="02_goalposts",
    title="Challenge 02: goal feet in dark and harsh rooms",
    task="Find the feet of the goal posts in thirty pictures, fifteen in dark rooms and fifteen in harsh ones, with "
    "one function of the picture: points (K, 2), (u, v) in pixels.",
    scoring="the mean F1 over all scenes, the harmonic mean of precision and recall. A foot is found if a point is "
    "within 8 pixels of it; each foot counts once. Every scene shows a foot. Hidden feet and feet outside the picture "
    "do not count.",
    seeds=places(ROOMS, SCENES_PER_ROOM),
    make=make_scene,
    given=lambda scene: (scene.pixels,),
    judge=judge,
    figure=worst_scenes_of("foot"),
    columns=(Column("feet missed"), Column("false points")),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
)
