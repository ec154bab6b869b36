"""Lesson 00, Meet the NAO: its one exercise, for practice, is worth no points."""

from __future__ import annotations

import math

import numpy as np

from nao_course.exercises import Case, Exercise, LessonPlan, Mistake


def _public() -> list[Case]:
    angles = {"a quarter turn": 90.0, "no turn": 0.0, "a turn to the right": -30.0, "a whole turn": 360.0}
    return [Case((angle,), name) for name, angle in angles.items()]


def _hidden(rng: np.random.Generator) -> list[Case]:
    return [Case((float(angle),)) for angle in rng.uniform(-720, 720, 6)]


TO_RADIANS = Exercise(
    name="to_radians",
    points=0,
    public=_public,
    hidden=_hidden,
    hints=(
        "A full turn is 360 degrees, and it is 2 pi radians. How many radians is one degree?",
        "Multiply by pi and divide by 180; `np.pi` is pi.",
    ),
    mistakes=[
        Mistake(
            "inverted fraction",
            lambda angle_deg: angle_deg * 180.0 / np.pi,
            "The fraction is upside down: that turns radians into degrees. There are fewer radians than degrees in a turn.",
        ),
        Mistake(
            "degrees returned",
            lambda angle_deg: angle_deg,
            "What comes out is what went in, still in degrees.",
        ),
        Mistake(
            "half a turn for a whole one",
            lambda angle_deg: angle_deg * np.pi / 360.0,
            "It is half of what it should be: a full turn is 2 pi radians, not pi.",
        ),
        Mistake(
            "wrapped",
            lambda angle_deg: (angle_deg + 180.0) % 360.0 * np.pi / 180.0 - np.pi,
            "You have put it into (-pi, pi]. That is for directions; this is an amount of turning, and a whole turn is 2 pi.",
        ),
        Mistake(
            "pi is about 3",
            lambda angle_deg: angle_deg * 3 / 180.0,
            "That is nearly right. Take pi with all its digits: np.pi.",
        ),
        Mistake(
            "pi is about 3.14",
            lambda angle_deg: angle_deg * 3.14 / 180.0,
            "3.14 is pi with three digits, and an answer has to be right to four: np.pi has sixteen.",
        ),
        Mistake(
            "sign lost",
            lambda angle_deg: abs(angle_deg) * np.pi / 180.0,
            "Turns to the right are negative, and stay negative.",
        ),
    ],
    alternatives={
        "math.radians": math.radians,
        "np.deg2rad": np.deg2rad,
        "a share of a turn": lambda angle_deg: angle_deg / 360 * math.tau,
    },
)

PLAN = LessonPlan(exercises=[TO_RADIANS])
