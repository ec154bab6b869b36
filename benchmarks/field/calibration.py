"""How well a robot finds the constant offset of its camera on simulated drives, after some pictures.

``python -m benchmarks calibration`` uses drives of ``field_slam`` that nothing was tuned on. The view that the robot
assumes is wrong by a random offset of up to 8 degrees in pitch and 3 in roll, and its body sways.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import cv2
import numpy as np
from rich.progress import track
from scipy.stats import chi2

from benchmarks import Result, Table
from benchmarks.field.field_slam.detections import detections, prepare, shots
from benchmarks.field.field_slam.report import FRESH
from nao_course.field_slam.known_shapes.calibration import CameraCalibration
from nao_course.field_slam.lines import read_lines
from nao_course.geometry import FloatArray

SEEDS = FRESH[:40]
LARGEST = np.radians((8.0, 3.0))  # offset in pitch and roll
AFTER = (1, 3, 6, 12, 24, 45)  # pictures; a stop has three


def calibrated(seed: int) -> FloatArray:
    """Return errors and sigmas of pitch and roll, rad, and the NEES after the numbers of pictures in AFTER, (6, 5)."""
    cv2.setNumThreads(1)
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


def main(jobs: int = 2) -> Result:
    """Calibrate on all drives."""
    prepare(SEEDS, jobs=jobs)
    with ProcessPoolExecutor(jobs) as pool:
        runs = np.array(list(track(pool.map(calibrated, SEEDS), "drives", len(SEEDS))))
    degrees = np.degrees(runs[..., :4])
    rms, largest = np.sqrt(np.mean(degrees[..., :2] ** 2, axis=0)), np.abs(degrees[..., :2]).max(axis=0)
    sigma, nees = degrees[..., 2:].mean(axis=0), runs[..., 4].mean(axis=0)
    band = (chi2.ppf((0.025, 0.975), 2 * len(SEEDS)) / len(SEEDS)).tolist()
    values = {
        "drives": len(SEEDS),
        "NEES band": band,
        "after": {
            str(number): {
                "pitch rms": float(rms[k, 0]),
                "roll rms": float(rms[k, 1]),
                "pitch sigma": float(sigma[k, 0]),
                "roll sigma": float(sigma[k, 1]),
                "pitch largest": float(largest[k, 0]),
                "roll largest": float(largest[k, 1]),
                "NEES mean": float(nees[k]),
            }
            for k, number in enumerate(AFTER)
        },
    }
    first = next(iter(values["after"].values()))
    table = Table(
        f"offset of the camera, {len(SEEDS)} drives, degrees",
        ("pictures", *first),
        tuple(
            (number, *(f"{value:.2f}" for value in row.values())) for number, row in values["after"].items()
        ),
    )
    return Result(
        "calibration", values, (table,), (f"NEES of 40 consistent drives: {band[0]:.2f} to {band[1]:.2f}",)
    )
