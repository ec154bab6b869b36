"""Entries to lesson 04's challenge: the assumed tilt, the lesson's steps, and a standard deviation for each line."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks import solution
from nao_course.geometry import FloatArray
from nao_course.sim import CameraView

PITCH_SIGMA, ROLL_SIGMA = float(np.radians(1.3)), float(np.radians(0.8))
# of a direction on the ground: the same for all lines, chosen on other pictures.
ANGLE_SIGMA = float(np.radians(3.0))
# Or computed for each line: its ends err by so many px across it, and its direction from other causes besides.
END_SIGMA, OTHER_SIGMA = 0.25, float(np.radians(0.3))
COARSE = PITCH_SIGMA * np.linspace(-2.6, 2.6, 21), ROLL_SIGMA * np.linspace(-2.4, 2.4, 9)
FINE = PITCH_SIGMA * np.linspace(-2.6, 2.6, 27), ROLL_SIGMA * np.linspace(-2.4, 2.4, 11)


def nothing(segments: FloatArray, view: CameraView) -> Any:
    """Return the assumed tilt."""
    return view.pitch, view.roll, PITCH_SIGMA


def _directions(segments: FloatArray, view: CameraView) -> FloatArray:
    """Return the directions (N,) of segments on the ground, rad; NaN above the horizon."""
    ground = solution("04")["pixel_to_ground"](segments.reshape(-1, 2), view).reshape(-1, 2, 2)
    way = ground[:, 1] - ground[:, 0]
    return np.arctan2(way[:, 1], way[:, 0])


def _weighted(
    cost: Callable[[CameraView], float], view: CameraView, pitches: FloatArray, rolls: FloatArray
) -> Any:
    """Weigh each tilt of a grid by its cost: return the means of pitch and roll, and the pitch's standard deviation."""
    leans = np.array([(pitch, roll) for pitch in pitches for roll in rolls])
    costs = np.array([cost(replace(view, pitch=view.pitch + p, roll=view.roll + r)) for p, r in leans])
    costs += (leans[:, 0] / PITCH_SIGMA) ** 2 + (leans[:, 1] / ROLL_SIGMA) ** 2
    weights = np.exp(-(costs - costs.min()) / 2)
    weights /= weights.sum()
    pitch, roll = weights @ leans
    sigma = np.sqrt(weights @ (leans[:, 0] - pitch) ** 2 + (pitches[1] - pitches[0]) ** 2 / 12)
    return view.pitch + pitch, view.roll + roll, sigma


def reference(segments: FloatArray, view: CameraView) -> Any:
    """Judge a tilt by how near to right angles it brings the lines, as the lesson suggests."""

    def cost(tilted: CameraView) -> float:
        turned = 4 * _directions(segments, tilted)
        turned = turned[np.isfinite(turned)]
        common = np.angle(np.exp(1j * turned).sum())
        away = np.angle(np.exp(1j * (turned - common))) / 4
        return float(np.minimum((away / ANGLE_SIGMA) ** 2, 4.0).sum())

    return _weighted(cost, view, *COARSE)


def better(segments: FloatArray, view: CameraView) -> Any:
    """Weigh each line by the standard deviation of its own direction, and try each line as the field's direction."""
    sigmas = _direction_sigmas(segments, view)

    def cost(tilted: CameraView) -> float:
        angle = _directions(segments, tilted)
        known = np.isfinite(angle) & np.isfinite(sigmas)
        if not known.any():
            return 0.0
        away = (angle[known] - angle[known][:, None] + np.pi / 4) % (np.pi / 2) - np.pi / 4
        return float(4 * np.log1p((away / sigmas[known]) ** 2 / 4).sum(axis=1).min())

    return _weighted(cost, view, *FINE)


def _direction_sigmas(segments: FloatArray, view: CameraView) -> FloatArray:
    """Return how well each direction (N,) on the ground is known, rad, from how well the segment's ends are."""
    way = segments[:, 2:] - segments[:, :2]
    aside = END_SIGMA * np.column_stack([-way[:, 1], way[:, 0]]) / np.hypot(*way.T)[:, None]
    straight, variance = _directions(segments, view), np.full(len(segments), OTHER_SIGMA**2)
    for moved in (np.hstack([aside, 0 * aside]), np.hstack([0 * aside, aside])):
        change = _directions(segments + moved, view) - straight
        variance = variance + ((change + np.pi / 2) % np.pi - np.pi / 2) ** 2
    return np.asarray(np.sqrt(variance))


TILT_ENTRIES = {"the assumed tilt": nothing, "the reference": reference, "a sigma for each line": better}
