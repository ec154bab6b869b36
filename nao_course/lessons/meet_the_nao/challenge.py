"""The challenge of lesson 00: a slalom that twenty robots drive by odometry alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.geometry import FloatArray
from nao_course.lessons.meet_the_nao.slalom import GATES, passed
from nao_course.lessons.meet_the_nao.slalom_figure import draw_slalom
from nao_course.sim import repeat_drive
from nao_course.slam import Motion

ROBOTS = 20
OTHERS = 10  # additional robots for each of these, which show whether a plan was lucky
MOST_COMMANDS = 200


@dataclass(frozen=True)
class Robot:
    """A robot with its own odometry errors, given by their seed."""

    seed: int

    def drive(self, plan: Sequence[Motion]) -> FloatArray:
        """Return its true poses from (0, 0, 0), shape (M + 1, 3)."""
        path: FloatArray = repeat_drive(list(plan), 1, np.random.default_rng(self.seed))[0]
        return path

    def others(self, plan: Sequence[Motion]) -> FloatArray:
        """Return the true poses of robots with other errors, shape (N, M + 1, 3)."""
        return repeat_drive(list(plan), OTHERS, np.random.default_rng([self.seed, 1]))


def as_plan(answer: Any) -> list[Motion]:
    """Return a student's answer as a list of commands.

    Raise a TypeError or ValueError with a message for the student if it is not a list of at most 200 motions.
    """
    if answer is None:
        raise TypeError("Your plan is None. A plan is a list of Motion(distance, turn).")
    if isinstance(answer, Motion) or not isinstance(answer, list | tuple):
        raise TypeError(f"A plan is a list of Motion(distance, turn), got {type(answer).__name__}.")
    for number, each in enumerate(answer, start=1):
        if type(each) is not Motion:
            raise TypeError(
                f"Command {number} of your plan is of type {type(each).__name__}. It must be a Motion(distance, turn)."
            )
        if abs(each.turn) > 2 * np.pi:
            raise ValueError(
                f"Command {number} of your plan turns by {each.turn:g} radians, which is more than a full turn. If you "
                f"mean degrees, write np.radians({each.turn:g})."
            )
    if len(answer) > MOST_COMMANDS:
        raise ValueError(f"A plan has at most {MOST_COMMANDS} commands, got {len(answer)}.")
    return list(answer)


def judge(answer: Any, robot: Robot) -> CaseScore:
    """Drive a plan with one robot and count the gates that it passes, in any order and from either side."""
    plan = as_plan(answer)
    path, planned = robot.drive(plan), without_errors(plan)
    through = passed(path[:, :2])
    columns = {
        "planned": float(passed(planned[:, :2]).sum()),
        "distance": float(sum(abs(motion.distance) for motion in plan)),
        "off at the end": float(np.hypot(*(path[-1, :2] - planned[-1, :2]))),
        "with 200 other robots": float(np.mean([passed(each[:, :2]).sum() for each in robot.others(plan)])),
    }
    return CaseScore(float(through.sum()), columns, (path, planned, through))


def without_errors(plan: Sequence[Motion]) -> FloatArray:
    """Return the poses that a plan leads to without errors, shape (M + 1, 3)."""
    pose, poses = np.zeros(3), [np.zeros(3)]
    for motion in plan:
        x, y, theta = pose
        pose = np.array(
            [x + motion.distance * np.cos(theta), y + motion.distance * np.sin(theta), theta + motion.turn]
        )
        poses.append(pose)
    return np.array(poses)


CHALLENGE = Challenge(
    lesson="00_meet_the_nao",
    title="Challenge 00: the blind slalom",
    task="Write one list of Motion(distance, turn), from the midpoint of the halfway line, that leads "
    f"{ROBOTS} robots through as many of {len(GATES)} gates as possible. The robots do not "
    "use their cameras, and each of them makes its own errors.",
    scoring="the number of gates passed, averaged over all robots. Each gate counts once, in any order and from "
    "either side.",
    seeds=tuple(Robot(seed) for seed in range(1, ROBOTS + 1)),
    make=lambda robot: robot,
    judge=judge,
    figure=draw_slalom,
    columns=(
        Column("planned", digits=0),
        Column("distance", " m", 1),
        Column("off at the end", " m"),
        Column("with 200 other robots"),
    ),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    takes_values=True,
    case="robot",
    name_of=lambda robot: f"robot {robot.seed}",
)
