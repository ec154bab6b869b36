"""Lines as a compass: how many lines have one of the field's directions, and how short segments affect a drive.

``python -m benchmarks compass`` uses the drives of ``field_slam``. A line counts as an outlier if its direction,
computed with the true camera, differs from both directions of the field by more than three standard deviations and
2 degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from benchmarks import Result, Table, in_processes
from benchmarks.field.detections import Seen, detections, prepare
from benchmarks.field.field_slam import FRESH, SEEN
from benchmarks.field.variants import BEST, ENDS, FILTER, Read, Score, run, summary, surest_first
from nao_course.field_slam.compass import (
    LEAST_LENGTH,
    direction_sigmas,
    ground_lengths,
    line_directions,
    line_normals,
    wrap_quarter,
)
from nao_course.geometry import FloatArray

LOOKED_AT = SEEN[:30]  # drives whose lines are counted
LENGTHS = (0.0, 0.1, 0.2, 0.3, 0.45, 0.7, np.inf)  # m
FALSE = 0.3  # false corners per picture
ASKED = {"all pieces": 0.0, f"from {100 * LEAST_LENGTH:.0f} cm on": LEAST_LENGTH}


def lines_of(seen: Seen) -> FloatArray:
    """Return for each line of a picture its estimated length on the ground, m, and whether it is an outlier."""
    ends = np.reshape(seen.lines, (-1, 4))
    sigma = direction_sigmas(ends, seen.view)
    true = line_directions(line_normals(ends, seen.true_view), 0.0, 0.0) + seen.pose.theta
    usable = np.isfinite(sigma)
    outlier = np.abs(wrap_quarter(true)) > np.maximum(3 * np.where(usable, sigma, 0.0), np.radians(2))
    return np.column_stack([ground_lengths(ends, seen.view), outlier])[usable]


def readings(reads: Sequence[Read]) -> FloatArray:
    """Return the error and the stated sigma of each compass reading, rad."""
    usable = [read for read in reads if np.isfinite(read.tilt.direction_sigma)]
    errors = [float(wrap_quarter(read.tilt.direction + read.seen.pose.theta)) for read in usable]
    return np.column_stack([errors, [read.tilt.direction_sigma for read in usable]])


def looked_at(seed: int) -> tuple[FloatArray, dict[str, FloatArray], int]:
    """Return the lines of a drive, its compass readings by variant, and its number of pictures."""
    seen = detections(seed)
    read = {name: [Read.of(each, least_length=length) for each in seen] for name, length in ASKED.items()}
    lines = np.vstack([lines_of(each) for each in seen])
    return lines, {name: readings(each) for name, each in read.items()}, len(seen)


def driven(seed: int) -> dict[str, Score]:
    """Run the variants on a drive, with and without false corners, in the usual order and with the surest first."""
    scores = {}
    for name, length in ASKED.items():
        reads = [Read.of(each, least_length=length) for each in detections(seed)]
        scores[f"{name}, usual order"] = run(reads, FILTER, BEST, seed)
        scores[f"{name}, surest first"] = run(reads, surest_first(FILTER), BEST, seed)
        scores[f"{name}, false corners"] = run(reads, FILTER, replace(BEST, false_corners=FALSE), seed)
    return scores


def main() -> Result:
    """Count lines and readings, and run the drives."""
    prepare([*LOOKED_AT, *FRESH])
    counted = in_processes(looked_at, LOOKED_AT, "lines and readings")
    drives = in_processes(driven, FRESH, "drives")
    length, outlier = np.vstack([each for each, _, _ in counted]).T
    pictures = sum(number for _, _, number in counted)
    by_length = {}
    for low, high in pairwise(LENGTHS):
        here = (length >= low) & (length < high)
        by_length[f"{low:g} to {high:g} m"] = {"lines": int(here.sum()), "none": float(outlier[here].mean())}
    read = {}
    for name in ASKED:
        error, sigma = np.vstack([each[name] for _, each, _ in counted]).T
        read[name] = {
            "share of pictures": len(error) / pictures,
            "median error (degrees)": float(np.degrees(np.median(np.abs(error)))),
            "beyond 4 sigma": float((np.abs(error) > 4 * sigma).mean()),
            "5 degrees off and sure to 1": int(
                ((np.abs(error) > np.radians(5)) & (sigma < np.radians(1))).sum()
            ),
            "mean square over variance": float(np.mean((error / sigma) ** 2)),
        }
    ends = {name: summary([each[name] for each in drives]) for name in drives[0]}
    tables = (
        Table.of(f"lines of {len(LOOKED_AT)} drives by their length on the ground", by_length, shown=".5g"),
        Table.of("readings", read, shown=".3g"),
        Table.of(f"ends of {len(FRESH)} drives", ends, *ENDS, shown=".3g"),
    )
    return Result("compass", {"lines": by_length, "readings": read, "drives": ends}, tables)
