"""Calibration of a camera that points lower than its robot's joints report, and the remaining errors.

Here they are simulated, marks only; of the real ones the course has the statistics alone (docs/real_data.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from nao_course.exercises import register
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.distance.looks import usual_view
from nao_course.sim import CameraView, Field, visible_landmarks

# Real robots' heads hang so much lower than their joints say (docs/real_data.md).
OFFSET = float(np.radians(6.4))
PITCH_SIGMA, ROLL_SIGMA = float(np.radians(0.7)), float(np.radians(0.5))  # per picture, as of the real ones
MARK_SIGMA = 1.0  # px
LARGEST = 0.2  # rad: an offset of exercise 4.7 is at most 10 degrees; a little more for errors of the marks
EDGES = (1.0, 2.0, 3.0, 4.0, 5.0)  # m, of the bins
LEAST = 4  # landmarks of a picture


@register
def small_angle(args: tuple[Any, ...], kwargs: dict[str, Any], answer: Any) -> str:
    """Return a message if the answer of `estimate_pitch` is larger than the text says; otherwise an empty text."""
    if np.abs(answer).max() > LARGEST:
        return "your offset is far larger than 10 degrees, or 0.175 rad. Is it in rad, and is it the offset alone?"
    return ""


@dataclass(frozen=True, eq=False)
class Marked:
    """A picture of which only the marks are kept.

    Parameters
    ----------
    pixels : ndarray, shape (N, 2)
        (u, v) of landmarks.
    ground : ndarray, shape (N, 2)
        Where they are, robot frame, metres.
    view : CameraView
        Assumed view of the camera.
    """

    pixels: FloatArray
    ground: FloatArray
    view: CameraView


def marked_pictures(number: int, rng: int = 0, offset: float = OFFSET) -> list[Marked]:
    """Take pictures on the whole field with a camera that points lower than assumed by `offset` (rad).

    Each picture also has its own tilt, and its marks have errors of about a pixel.
    """
    field, generator = Field(2012, half=False), np.random.default_rng([rng, 7])
    true = usual_view()
    found: list[Marked] = []
    while len(found) < number:
        pose = Pose(*generator.uniform((-2.8, -1.8, -np.pi), (2.8, 1.8, np.pi)))
        pitch, roll = generator.normal(0.0, (PITCH_SIGMA, ROLL_SIGMA))
        view = replace(true, pitch=true.pitch + pitch, roll=true.roll + roll)
        seen = [each for each in visible_landmarks(field, pose, view) if not each.occluded]
        if len(seen) >= LEAST:
            pixels = np.array([each.pixel for each in seen])
            places = pose.to_local([(each.landmark.x, each.landmark.y) for each in seen])
            marks = pixels + MARK_SIGMA * generator.standard_normal(pixels.shape)
            found.append(Marked(marks, places, replace(true, pitch=true.pitch - offset)))
    return found


def range_errors(
    distance: Callable[[FloatArray, CameraView], Any], pictures: Sequence[Marked], offset: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Measure all landmarks of pictures.

    Parameters
    ----------
    distance : callable
        ``distance(pixels, view)`` gives (N,) in metres from the robot.
    pictures : sequence of Marked
        Which.
    offset : float
        Angle that is added to the assumed pitch, in rad.

    Returns
    -------
    true, errors : ndarray, shape (M,)
        In metres; the error is the distance less the true one, NaN where there is none.
    """
    true = [np.hypot(*each.ground.T) for each in pictures]
    views = [replace(each.view, pitch=each.view.pitch + offset) for each in pictures]
    found = [
        np.asarray(distance(each.pixels.copy(), view), dtype=float)
        for each, view in zip(pictures, views, strict=True)
    ]
    away = np.concatenate(true)
    return away, np.concatenate(found) - away


def by_distance(true: FloatArray, errors: FloatArray) -> tuple[tuple[float, float], ...]:
    """Return the median and the 90 % quantile of the size of errors in each bin of `EDGES`."""
    size = np.where(np.isnan(errors), np.inf, np.abs(errors))
    bins = [size[(low <= true) & (true < high)] for low, high in pairwise(EDGES)]
    return tuple(
        (float(np.quantile(each, 0.5, method="higher")), float(np.quantile(each, 0.9, method="higher")))
        for each in bins
    )
