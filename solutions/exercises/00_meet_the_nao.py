"""Lesson 00, Meet the NAO: its one exercise, for practice, is worth no points."""

from __future__ import annotations

import math

import numpy as np

from nao_course.exercises import Case, Exercise, LessonPlan, Sibling
from nao_course.instructor.authoring.mistakes import catalogue

# --- 0.1 to_radians ---
ANGLES = {
    "a quarter turn": 90.0,
    "no turn": 0.0,
    "a turn to the right": -30.0,
    "a whole turn": 360.0,
    "a sixteenth of a turn": 22.5,
}
TO_RADIANS = Exercise(
    name="to_radians",
    points=0,
    public=lambda: [Case((angle,), name) for name, angle in ANGLES.items()],
    hidden=lambda rng: [Case((float(angle),)) for angle in rng.uniform(-720, 720, 6)],
    hints=(
        "A full turn is 360 degrees or 2 pi radians. How many radians is one degree?",
        "Multiply by pi and divide by 180; `np.pi` is pi.",
    ),
    sibling=Sibling(
        "If you know how much one unit is, you multiply by it: here a clock's hand turns 360 degrees in 60 minutes.",
        """
        degrees_of_one_minute = 360 / 60
        for minutes in (15, 25):
            print(f"{minutes} minutes are {minutes * degrees_of_one_minute:g} degrees")
        """,
        """
        15 minutes are 90 degrees
        25 minutes are 150 degrees
        """,
    ),
    mistakes=catalogue("""
        inverted fraction: np.pi / 180.0 => 180.0 / np.pi
            Your fraction is inverted, so it converts radians to degrees. A turn has fewer radians than degrees.
        degrees returned: * np.pi / 180.0 =>
            You return the angle as it was given, in degrees. Multiply it by pi / 180.
        multiplied by pi only: / 180.0 =>
            Your results are 180 times too large. Divide by 180 as well, because 180 degrees are pi radians.
        divided by 180 only: * np.pi / 180.0 => / 180.0
            Your results are fractions of half a turn. Multiply them by pi, because half a turn is pi radians.
        sign reversed: return angle_deg => return -angle_deg
            Your results have the wrong sign. A turn to the left is positive in degrees and in radians.
        half a turn instead of a whole one: 180.0 => 360.0
            Your results are half as large as they should be. A full turn is 2 pi radians, not pi.
        two pi to half a turn: angle_deg * np.pi => angle_deg * 2 * np.pi
            Your results are twice as large as they should be. 360 degrees are 2 pi radians, so 180 degrees are pi radians.
        whole degrees: return angle_deg => return int(angle_deg)
            You drop the decimals of the angle: 22.5 degrees become 22. Use angle_deg as it is.
        rounded down: angle_deg * np.pi / 180.0 => angle_deg // 180.0 * np.pi
            You round down to whole half turns, because // drops the remainder. Divide with /.
        whole radians: angle_deg * np.pi / 180.0 => int(angle_deg * np.pi / 180.0)
            You round the result to a whole number. A quarter of a turn is 1.5708 radians, so leave out int.
        whole radians by a division: / 180.0 => // 180.0
            You round down to whole radians, because // drops the remainder. Divide with /.
        the factor only: angle_deg * np.pi / 180.0 => np.pi / 180.0
            Your result is the same for each angle: one degree in radians. Multiply it by angle_deg.
        pi in the denominator: angle_deg * np.pi / 180.0 => angle_deg / (180.0 * np.pi)
            You divide by pi, perhaps because of your brackets. Multiply by pi, and divide by 180 only.
        wrapped: angle_deg * np.pi / 180.0 => (angle_deg + 180.0) % 360.0 * np.pi / 180.0 - np.pi
            You wrap the result to (-pi, pi]. That is right for directions, but this is an amount of turning: a whole turn is 2 pi, not 0.
        modulo a whole turn: / 180.0 => / 180.0 % (2 * np.pi)
            You take the result modulo 2 pi, which changes amounts of turning: -30 degrees become +330, and a whole turn becomes 0.
        pi is about 3: np.pi => 3
            You use 3 for pi, so your results are 5 % too small. Use np.pi.
        pi is about 3.14: np.pi => 3.14
            You use 3.14 for pi, but the result has to be right to four digits. Use np.pi, which has sixteen.
        sign lost: return angle_deg => return abs(angle_deg)
            You drop the sign. Turns to the right are negative and stay negative.
    """),
    alternatives={
        "math.radians": math.radians,
        "np.deg2rad": np.deg2rad,
        "a fraction of a turn": lambda angle_deg: angle_deg / 360 * math.tau,
    },
)

PLAN = LessonPlan(exercises=[TO_RADIANS])
