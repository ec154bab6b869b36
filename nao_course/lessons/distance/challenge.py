"""The challenge of lesson 04: estimate the tilt of the camera from the field lines in one picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.lessons.distance.challenge_figure import draw_worst_tilts
from nao_course.lessons.distance.lines import LinePicture, line_picture_of

CASES = 60
FIRST = 1000  # seeds below are for whoever tunes an entry
LARGEST = np.pi / 2  # rad, of an angle that makes sense


@dataclass(frozen=True)
class TiltEstimate:
    """The answer of an entry: pitch, roll and the standard deviation of the pitch, rad."""

    pitch: float
    roll: float
    sigma: float


def as_tilt(answer: Any) -> TiltEstimate:
    """Return a student's answer as a tilt; refuse, with a message, anything but three numbers that make sense."""
    if answer is None:
        raise TypeError(
            "Your entry returns None, but should return pitch, roll and sigma. Is a return missing?"
        )
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
        raise ValueError(
            f"Your entry returns a sigma of {values[2]:g}, but a standard deviation must be more than 0."
        )
    return TiltEstimate(*values.tolist())


def judge(answer: Any, scene: LinePicture) -> CaseScore:
    """Score a tilt by the error of its pitch in degrees, with the NEES of its sigma."""
    estimate = as_tilt(answer)
    pitch_error = estimate.pitch - scene.true_view.pitch
    columns = {
        "roll error": float(np.degrees(abs(estimate.roll - scene.true_view.roll))),
        "sigma": float(np.degrees(estimate.sigma)),
        "within 2 sigma": 100.0 * (abs(pitch_error) <= 2 * estimate.sigma),
        "NEES": float((pitch_error / estimate.sigma) ** 2),
    }
    return CaseScore(float(np.degrees(abs(pitch_error))), columns, (scene, estimate))


CHALLENGE = Challenge(
    lesson="04_distance",
    title="Challenge 04: the tilt of a single picture",
    task="Estimate the tilt of the camera in sixty pictures from segments of field lines: a function "
    "tilt_from_lines(segments, view) that returns (pitch, roll, sigma) in rad. segments (N, 4) are (u1, v1, u2, v2) in "
    "pixels, without lens distortion; view is the assumed view. The error of its pitch has a standard deviation of 1.3 "
    "degrees, and the error of its roll of 0.8.",
    scoring="the mean error of the pitch in degrees over all pictures; smaller is better. NEES, error²/sigma², "
    "should be 1 in the mean; it is larger if your sigmas are too small.",
    seeds=tuple(range(FIRST, FIRST + CASES)),
    make=line_picture_of,
    given=lambda scene: (scene.segments, scene.view),
    judge=judge,
    figure=draw_worst_tilts,
    columns=(
        Column("roll error", "°"),
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
