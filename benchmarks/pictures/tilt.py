"""How well the field's lines tell the tilt, and how well that is known: on simulated pictures and on a real robot's.

``python -m benchmarks tilt`` finds middle lines in the simulator's reporting sets and in the real pictures, and
compares the camera's pitch and roll from them with the truth. That of a real picture is what fits its marked points
best (benchmarks/simulator/reality); it depends on where the robot stood, which was set by hand to a few centimetres.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks import Result, Table
from benchmarks.challenges.corners import middle_lines
from benchmarks.challenges.tilt import QUARTER, align, to_ground
from benchmarks.simulator.reality import Freedom, corrected_walk, fit_set, fitted_view
from nao_course.datasets import RealPicture, read_pictures
from nao_course.geometry import FloatArray
from nao_course.sim import CameraView, Reality, standard_scenes
from nao_course.sim.scenes import Scene

SURE = float(np.radians(0.5))  # of the pitch: a picture that says it knows it better than this
SHOWN = {  # by its column's heading
    "": "pictures",
    "pitch": "pitch rms before",
    "then": "pitch rms after",
    "sure": "share sure",
    "then, sure": "pitch rms where sure",
    "roll": "roll rms before",
    "then ": "roll rms after",
    "error/sigma": "error / sigma, rms",
}
# How the truth of real pictures is fitted: positions free to 5 cm, or as they were set, to see how sure it is.
FREE, AS_SET = Freedom(position_sd=0.05, square=True), Freedom(square=True)
RANGES = ((1.5, 2.5), (2.5, 3.5), (3.5, 5.5))  # metres


@dataclass(frozen=True, eq=False)
class Tilts:
    """Errors of many pictures (N,), rad: of what the robot believes, and of what the lines say.

    Parameters
    ----------
    pitch_before, pitch_after, roll_before, roll_after : ndarray, shape (N,)
        Of the camera's pitch and roll.
    sigma : ndarray, shape (N,)
        What the estimate says of its own pitch.
    heading : ndarray, shape (N,)
        Of the lines' direction, modulo 90 degrees; NaN where the truth is not known.
    """

    pitch_before: FloatArray
    pitch_after: FloatArray
    roll_before: FloatArray
    roll_after: FloatArray
    sigma: FloatArray
    heading: FloatArray

    @classmethod
    def of(cls, cases: Sequence[tuple[FloatArray, CameraView, CameraView, float]]) -> Tilts:
        """Ask each picture's lines; a case is lines, what the robot believes, the truth, and the robot's heading."""
        rows = []
        for lines, believed, true, heading in cases:
            found = align(lines, believed)
            away = found.heading + heading + true.yaw
            rows.append(
                (
                    *(believed.pitch - true.pitch, found.pitch - true.pitch),
                    *(believed.roll - true.roll, found.roll - true.roll),
                    *(found.sigma, (away + QUARTER / 2) % QUARTER - QUARTER / 2),
                )
            )
        return cls(*np.array(rows).T)

    def summary(self) -> dict[str, float]:
        """Return the errors in degrees, except for shares and for errors divided by sigma."""
        sure = self.sigma < SURE
        away = self.pitch_after / self.sigma
        return {
            "pictures": len(self.sigma),
            "pitch rms before": _rms(self.pitch_before),
            "pitch rms after": _rms(self.pitch_after),
            "pitch median before": _median(self.pitch_before),
            "pitch median after": _median(self.pitch_after),
            "share sure": float(sure.mean()),
            "pitch rms where sure": _rms(self.pitch_after[sure]),
            "roll rms before": _rms(self.roll_before),
            "roll rms after": _rms(self.roll_after),
            "error / sigma, rms": float(np.sqrt((away**2).mean())),
            "error / sigma where sure, rms": float(np.sqrt((away[sure] ** 2).mean())) if sure.any() else 0.0,
            "within 2 sigma": float((np.abs(away) < 2).mean()),
            "heading median": _median(self.heading),
            "heading median where sure": _median(self.heading[sure]),
        }


def _rms(angles: FloatArray) -> float:
    return float(np.degrees(np.sqrt((angles**2).mean()))) if len(angles) else 0.0


def _median(angles: FloatArray) -> float:
    known = np.abs(angles[np.isfinite(angles)])
    return float(np.degrees(np.median(known))) if len(known) else 0.0


def simulated(scenes: Sequence[Scene]) -> list[tuple[FloatArray, CameraView, CameraView, float]]:
    """Return the lines, views and headings of simulated pictures."""
    return [(middle_lines(s.pixels, s.view), s.view, s.truth.view, s.truth.pose.theta) for s in scenes]


def real(pictures: Sequence[RealPicture]) -> list[tuple[FloatArray, CameraView, CameraView, float]]:
    """Return lines and views of real pictures with enough marked points; the assumed view has the set's mean tilt."""
    fit = fit_set(pictures, FREE)
    cases = []
    for item, correction in zip(fit.matched, fit.corrections, strict=True):
        believed, _ = fitted_view(item.picture, fit.values, np.zeros_like(correction))
        true, pose = fitted_view(item.picture, fit.values, correction)
        cases.append((middle_lines(item.picture.pixels, believed), believed, true, pose.theta))
    return cases


def truth_spread(pictures: Sequence[RealPicture]) -> float:
    """Return the difference (degrees, rms) of two fits of the real pictures' pitch, which limits the ground truth."""
    one, other = (
        fit.values[-1] + fit.corrections[:, 0] for fit in (fit_set(pictures, FREE), fit_set(pictures, AS_SET))
    )
    return _rms(one - other)


def range_errors(scenes: Sequence[Scene]) -> dict[str, dict[str, float]]:
    """Return the median range error (m) of the true corners' pixels, before and after correcting the tilt."""
    rows = []
    for scene in scenes:
        corners = np.array([m.pixel for m in scene.truth.landmarks if m.landmark.kind == "corner"]).reshape(
            -1, 2
        )
        pixels = scene.view.undistort(corners)
        found = align(middle_lines(scene.pixels, scene.view), scene.view)
        corrected = replace(scene.view, pitch=found.pitch, roll=found.roll)
        true, before, after = (
            np.hypot(*to_ground(pixels, view).T) for view in (scene.truth.view, scene.view, corrected)
        )
        sure = np.full(len(pixels), found.sigma < SURE)
        rows += list(zip(true, np.abs(before - true), np.abs(after - true), sure, strict=True))
    table = np.array(rows)
    values = {}
    for low, high in RANGES:
        inside = table[(table[:, 0] >= low) & (table[:, 0] < high)]
        sure = inside[inside[:, 3] > 0]
        values[f"{low:g} to {high:g} m"] = {
            "corners": len(inside),
            "before": float(np.nanmedian(inside[:, 1])),
            "after": float(np.nanmedian(inside[:, 2])),
            "after, where sure": float(np.nanmedian(sure[:, 2])) if len(sure) else 0.0,
        }
    return values


def main() -> Result:
    """Compare tilts on the simulator's reporting sets in laboratories and on the real pictures."""
    scenes = (*standard_scenes("report"), *standard_scenes("whole", reality=Reality.lab()))
    sets: dict[str, Mapping[str, float]] = {
        "half field, near": Tilts.of(simulated(scenes[:30])).summary(),
        "whole field, laboratory": Tilts.of(simulated(scenes[30:])).summary(),
        "whole field, paper": Tilts.of(simulated(standard_scenes("whole"))).summary(),
    }
    notes, spread = [], {}
    try:
        pictures = {
            "real scenes": read_pictures("scenes"),
            "real straight walk": corrected_walk(read_pictures("straightwalk")),
        }
        sets |= {name: Tilts.of(real(each)).summary() for name, each in pictures.items()}
        spread = {name: truth_spread(each) for name, each in pictures.items()}
        notes = [
            f"{name}: two ways to fit the true pitch differ by {each:.2f} degrees rms"
            for name, each in spread.items()
        ]
    except FileNotFoundError as error:
        notes.append(f"the real pictures are left out: {error}")
    ranges = range_errors(scenes)
    tables = (
        Table(
            "tilt before and after its lines are asked: degrees, rms",
            ("pictures", *SHOWN),
            tuple((name, *(each[key] for key in SHOWN.values())) for name, each in sets.items()),
        ),
        Table(
            "range of a corner, median error in metres",
            ("range", *next(iter(ranges.values()))),
            tuple((name, *each.values()) for name, each in ranges.items()),
        ),
    )
    values: dict[str, Any] = {"tilt": sets, "ranges": ranges, "spread of the truth": spread}
    return Result("tilt", values, tables, tuple(notes))
