"""How well the field's lines tell the tilt, and how well that is known: on simulated pictures and on a real robot's.

``python -m benchmarks tilt`` reads the lines in the simulator's reporting sets and in the real pictures, as the demo
does, and compares the camera's pitch and roll from them with the truth. That of a real picture is what fits its marked
points best (benchmarks/simulator/reality.py); it depends on where the robot stood, which was set by hand to a few
centimetres.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks import Result, Table
from benchmarks.simulator.reality import Freedom, corrected_walk, fit_set, fitted_view
from nao_course.datasets import RealPicture, read_pictures
from nao_course.field_slam.compass import estimate_body_tilt
from nao_course.field_slam.lines import read_lines, to_ground
from nao_course.field_slam.observation import tilted
from nao_course.geometry import FloatArray
from nao_course.sim import CameraView, Reality, standard_scenes
from nao_course.sim.scenes import Scene

SIGMAS = np.radians((1.3, 0.8))  # pitch and roll before the picture is used
SURE = float(np.radians(0.5))  # of the pitch: a picture that says it knows it better than this
# How the truth of real pictures is fitted: positions free to 5 cm, or as they were set, to see how sure it is.
FREE, AS_SET = Freedom(position_sd=0.05, square=True), Freedom(square=True)
RANGES = ((1.5, 2.5), (2.5, 3.5), (3.5, 5.5))  # m


def corrected(pixels: Any, believed: CameraView) -> tuple[CameraView, float]:
    """Return the view that a picture's lines tell, and the standard deviation of its pitch, rad."""
    found = estimate_body_tilt(read_lines(pixels, believed), believed, SIGMAS)
    return tilted(believed, found.pitch, found.roll), float(np.sqrt(found.covariance[0, 0]))


def summary(cases: Sequence[tuple[Any, CameraView, CameraView]]) -> dict[str, float]:
    """Return errors in degrees, shares and errors over sigma; a case is pixels, the assumed and the true view."""
    rows = []
    for pixels, believed, true in cases:
        after, sigma = corrected(pixels, believed)
        rows.append((believed.pitch - true.pitch, after.pitch - true.pitch, sigma))
    before, after, sigmas = np.array(rows).T
    sure = sigmas < SURE
    return {
        "pictures": len(rows),
        "pitch rms before": _rms(before),
        "pitch rms after": _rms(after),
        "share sure": float(sure.mean()),
        "pitch rms where sure": _rms(after[sure]),
        "error / sigma, rms": float(np.sqrt(((after / sigmas) ** 2).mean())),
        "within 2 sigma": float((np.abs(after / sigmas) < 2).mean()),
    }


def _rms(angles: FloatArray) -> float:
    return float(np.degrees(np.sqrt((angles**2).mean()))) if len(angles) else 0.0


def of_scenes(scenes: Sequence[Scene]) -> list[tuple[Any, CameraView, CameraView]]:
    """Return simulated pictures with their views."""
    return [(scene.pixels, scene.view, scene.truth.view) for scene in scenes]


def real(pictures: Sequence[RealPicture]) -> list[tuple[Any, CameraView, CameraView]]:
    """Return real pictures with enough marked points; the assumed view has the set's mean tilt."""
    fit = fit_set(pictures, FREE)
    return [
        (
            item.picture.pixels,
            fitted_view(item.picture, fit.values, np.zeros_like(correction))[0],
            fitted_view(item.picture, fit.values, correction)[0],
        )
        for item, correction in zip(fit.matched, fit.corrections, strict=True)
    ]


def truth_spread(pictures: Sequence[RealPicture]) -> float:
    """Return the difference (degrees, rms) of two fits of the real pictures' pitch, which limits the ground truth."""
    fits = fit_set(pictures, FREE), fit_set(pictures, AS_SET)
    one, other = (fit.values[-1] + fit.corrections[:, 0] for fit in fits)
    return _rms(one - other)


def range_errors(scenes: Sequence[Scene]) -> dict[str, dict[str, float]]:
    """Return the median range error (m) of the true corners' pixels, before and after correcting the tilt."""
    rows: list[tuple[Any, ...]] = []
    for scene in scenes:
        corners = [m.pixel for m in scene.truth.landmarks if m.landmark.kind == "corner"]
        pixels = scene.view.undistort(np.reshape(corners, (-1, 2)))
        after, sigma = corrected(scene.pixels, scene.view)
        views = scene.truth.view, scene.view, after
        true, before, then = (np.hypot(*to_ground(pixels, view).T) for view in views)
        rows += zip(true, abs(before - true), abs(then - true), [sigma < SURE] * len(true), strict=True)
    table, found = np.array(rows), {}
    for low, high in RANGES:
        inside = table[(table[:, 0] >= low) & (table[:, 0] < high)]
        sure = inside[inside[:, 3] > 0]
        found[f"{low:g} to {high:g} m"] = {
            "corners": len(inside),
            "before": float(np.nanmedian(inside[:, 1])),
            "after": float(np.nanmedian(inside[:, 2])),
            "after, where sure": float(np.nanmedian(sure[:, 2])) if len(sure) else 0.0,
        }
    return found


def main() -> Result:
    """Compare tilts on the simulator's reporting sets in laboratories and on the real pictures."""
    near, whole = list(standard_scenes("report")), list(standard_scenes("whole", reality=Reality.lab()))
    sets = {
        "half field, near": summary(of_scenes(near)),
        "whole field, laboratory": summary(of_scenes(whole)),
    }
    pictures = {
        "real scenes": read_pictures("scenes"),
        "real straight walk": corrected_walk(read_pictures("straightwalk")),
    }
    sets |= {name: summary(real(each)) for name, each in pictures.items()}
    spread = {name: truth_spread(each) for name, each in pictures.items()}
    notes = [f"{name}: two fits of the true pitch differ by {each:.2f}° rms" for name, each in spread.items()]
    ranges = range_errors([*near, *whole])
    tables = (
        Table.of("tilt before and after its lines are asked: degrees, rms", sets),
        Table.of("range of a corner, median error in metres", ranges),
    )
    values = {"tilt": sets, "ranges": ranges, "spread of the truth": spread}
    return Result("tilt", values, tables, tuple(notes))
