"""The challenge of lesson 04: how the camera leaned, told by the field's lines of one picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.lessons.distance.challenge_figure import draw_worst_leans
from nao_course.lessons.distance.lines import LinePicture, line_picture_of

CASES = 60
FIRST = 1000  # seeds below are for whoever tunes an entry
LARGEST = np.pi / 2  # rad, of an angle that makes sense


@dataclass(frozen=True)
class Lean:
    """What an entry answers: pitch, roll and the pitch's sigma, rad."""

    pitch: float
    roll: float
    sigma: float


def as_lean(answer: Any) -> Lean:
    """Return an answer as a lean.

    Raises
    ------
    TypeError, ValueError
        If it is something else; the message is for the student.
    """
    if answer is None:
        raise TypeError("Your entry returns None: does it end with return pitch, roll, sigma?")
    try:
        values = np.array(answer, dtype=float, subok=False)
    except (TypeError, ValueError):
        raise TypeError(
            f"Your entry must return (pitch, roll, sigma), got {type(answer).__name__}."
        ) from None
    if values.shape != (3,):
        raise ValueError(
            f"Your entry must return three numbers, pitch, roll and sigma; got shape {values.shape}."
        )
    if not np.isfinite(values).all():
        raise ValueError("Your entry returns numbers that are NaN or infinite.")
    if np.abs(values).max() > LARGEST:
        raise ValueError(
            "Your entry returns an angle of more than 90 degrees: pitch, roll and sigma are in rad."
        )
    if values[2] <= 0:
        raise ValueError(f"Your entry returns a sigma of {values[2]:g}; a standard deviation is more than 0.")
    return Lean(*values.tolist())


def judge(answer: Any, scene: LinePicture) -> CaseScore:
    """Score a lean: how many degrees the pitch is off, and whether its sigma says so."""
    lean = as_lean(answer)
    pitch_error = lean.pitch - scene.true_view.pitch
    columns = {
        "roll off by": float(np.degrees(abs(lean.roll - scene.true_view.roll))),
        "sigma": float(np.degrees(lean.sigma)),
        "within 2 sigma": 100.0 * (abs(pitch_error) <= 2 * lean.sigma),
        "NEES": float((pitch_error / lean.sigma) ** 2),
    }
    return CaseScore(float(np.degrees(abs(pitch_error))), columns, (scene, lean))


CHALLENGE = Challenge(
    lesson="04_distance",
    title="Challenge 04: distance from one picture whose tilt nobody knows",
    task="Tell how the camera leaned in sixty pictures, from segments of the field's lines: a function "
    "tilt_from_lines(segments, view) that returns (pitch, roll, sigma) in rad. segments (N, 4) are (u1, v1, u2, v2) in "
    "pixels, the lens removed; view is what the robot believes: its pitch is known to 1.3 degrees, its roll to 0.8.",
    scoring="how many degrees the pitch is off, the mean over all pictures; smaller is better. NEES, error²/sigma², "
    "is 1 for an honest sigma, and more for one that claims too much.",
    seeds=tuple(range(FIRST, FIRST + CASES)),
    make=line_picture_of,
    given=lambda scene: (scene.segments, scene.view),
    judge=judge,
    figure=draw_worst_leans,
    columns=(
        Column("roll off by", "°"),
        Column("sigma", "°"),
        Column("within 2 sigma", " %", 0),
        Column("NEES", "", 1),
    ),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    nothing=3.0,
    higher_is_better=False,
    unit="°",
    case="picture",
    name_of=lambda seed: f"picture {seed - FIRST + 1}",
)
