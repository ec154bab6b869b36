"""How well a robot finds the constant offset of its camera on simulated drives, after some pictures.

``python -m benchmarks calibration`` uses drives of ``field_slam`` that nothing was tuned on. The view that the robot
assumes is wrong by a random offset of up to 8 degrees in pitch and 3 in roll, and its body sways.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from benchmarks import Result, Table, in_processes
from benchmarks.field.detections import detections, prepare, shots
from benchmarks.field.field_slam import FRESH
from nao_course.field_slam.known_shapes.calibration import CameraCalibration
from nao_course.field_slam.lines import read_lines
from nao_course.geometry import FloatArray

SEEDS = FRESH[:40]
LARGEST = np.radians((8.0, 3.0))  # offset in pitch and roll
AFTER = (1, 3, 6, 12, 24, 45)  # pictures; a stop has three


def calibrated(seed: int) -> FloatArray:
    """Return errors and sigmas of pitch and roll, rad, and the NEES after the numbers of pictures in AFTER, (6, 5)."""
    offset = np.random.default_rng([seed, 17]).uniform(-LARGEST, LARGEST)
    pitch, roll = offset.tolist()
    own, found = CameraCalibration(), []
    for number, (shot, seen) in enumerate(zip(shots(seed), detections(seed), strict=True), start=1):
        assumed = shot.picture.view
        view = replace(assumed, pitch=assumed.pitch - pitch, roll=assumed.roll - roll)
        own.update(read_lines(shot.picture.pixels, own.reading_view(view)), seen.posts, view)
        if number in AFTER:
            error = own.mean - offset
            nees = error @ np.linalg.solve(own.covariance, error)
            found.append([*error, *np.sqrt(np.diag(own.covariance)), nees])
        if number == AFTER[-1]:
            break
    return np.array(found)


def main() -> Result:
    """Calibrate on all drives."""
    prepare(SEEDS)
    runs = np.array(in_processes(calibrated, SEEDS, "drives"))
    degrees = np.degrees(runs[..., :4])
    rms = np.sqrt(np.mean(degrees[..., :2] ** 2, axis=0))
    columns = np.column_stack([rms, degrees[..., 2:].mean(axis=0), runs[..., 4].mean(axis=0)])
    names = ("pitch rms", "roll rms", "pitch sigma", "roll sigma", "NEES mean")
    after = {
        str(number): dict(zip(names, row, strict=True))
        for number, row in zip(AFTER, columns.tolist(), strict=True)
    }
    low, high = (chi2.ppf((0.025, 0.975), 2 * len(SEEDS)) / len(SEEDS)).tolist()
    return Result(
        "calibration",
        {"drives": len(SEEDS), "NEES band": [low, high], "after": after},
        (Table.of(f"offset of the camera after some pictures, {len(SEEDS)} drives, degrees", after),),
        (f"NEES of {len(SEEDS)} consistent drives: {low:.2f} to {high:.2f}",),
    )
