"""Entries to lesson 04's challenge: the assumed tilt, the lesson's steps, and a standard deviation for each line."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from benchmarks import ROOT
from benchmarks.challenges.tilt import tilt_from_lines
from nao_course.exercises import Definitions, load_definitions
from nao_course.geometry import FloatArray
from nao_course.sim import CameraView

PITCH_SIGMA, ROLL_SIGMA = float(np.radians(1.3)), float(np.radians(0.8))
# of a direction on the ground: the same for all lines, chosen on other pictures.
ANGLE_SIGMA = float(np.radians(3.0))
PITCHES, ROLLS = PITCH_SIGMA * np.linspace(-2.6, 2.6, 21), ROLL_SIGMA * np.linspace(-2.4, 2.4, 9)


@cache
def lesson_functions() -> Definitions:
    """Return the functions of the lesson's solution."""
    return load_definitions(ROOT / "solutions" / "04_distance.ipynb")


def nothing(segments: FloatArray, view: CameraView) -> Any:
    """Return the assumed tilt."""
    return view.pitch, view.roll, PITCH_SIGMA


def reference(segments: FloatArray, view: CameraView) -> Any:
    """Weigh each tilt of a grid by how near to right angles it brings the lines, as the lesson suggests."""
    leans = np.array([(p, r) for p in PITCHES for r in ROLLS])
    costs = np.array(
        [_cost(segments, replace(view, pitch=view.pitch + p, roll=view.roll + r)) for p, r in leans]
    )
    costs += (leans[:, 0] / PITCH_SIGMA) ** 2 + (leans[:, 1] / ROLL_SIGMA) ** 2
    weights = np.exp(-(costs - costs.min()) / 2)
    weights /= weights.sum()
    pitch, roll = weights @ leans
    sigma = np.sqrt(weights @ (leans[:, 0] - pitch) ** 2 + (PITCHES[1] - PITCHES[0]) ** 2 / 12)
    return view.pitch + pitch, view.roll + roll, sigma


def _cost(segments: FloatArray, view: CameraView) -> float:
    """Return the sum of squared deviations of lines from right angles, in standard deviations."""
    ground = lesson_functions()["pixel_to_ground"](segments.reshape(-1, 2), view).reshape(-1, 2, 2)
    way = ground[:, 1] - ground[:, 0]
    way = way[np.isfinite(way).all(axis=1)]
    turned = 4 * np.arctan2(way[:, 1], way[:, 0])
    common = np.angle(np.exp(1j * turned).sum())
    away = np.angle(np.exp(1j * (turned - common))) / 4
    return float(np.minimum((away / ANGLE_SIGMA) ** 2, 4.0).sum())


def better(segments: FloatArray, view: CameraView) -> Any:
    """Weigh each line by the standard deviation of its own direction."""
    return tilt_from_lines(segments, view)


TILT_ENTRIES = {"the assumed tilt": nothing, "the reference": reference, "a sigma for each line": better}
