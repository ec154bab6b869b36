"""What the course's detectors measure in the pictures of the real walk: writes the file of `recorded_walk`."""

import numpy as np

from benchmarks import ROOT, Result, Table, write_json
from nao_course.datasets import read_pictures
from nao_course.datasets.real_walk import FIELD, FILE
from nao_course.field_slam.demo.drive import demo_functions, see_all
from nao_course.field_slam.observation import Observation
from nao_course.field_slam.walk import real_walk
from nao_course.geometry import Pose, wrap_angle
from nao_course.metrics import squared_distances
from nao_course.slam import range_and_bearing

# The robot was put down by hand, so bearing and range of a landmark from its pose are known to 2 degrees and 5 cm.
PLACED = np.diag([np.radians(2.0) ** 2, 0.05**2])
MOST = (
    16.0  # largest squared distance from the nearest landmark; beyond it the detectors found something else
)


def main() -> Result:
    """Measure the walk's landmarks with the functions of the solutions and write what was found."""
    functions = demo_functions((), ROOT / "solutions")
    frames = list(real_walk(read_pictures("straightwalk"), 0))
    observed = [each.observation for each in see_all(functions, frames)]
    stops = [recorded(frame.pose, seen) for frame, seen in zip(frames, observed, strict=True)]
    write_json(FILE, stops)
    rows = [row for stop in stops for row in stop["seen"]]
    kinds = [FIELD.detectable_kinds[int(row[0])] for row in rows]
    counts = {
        "pictures": len(stops),
        "pictures with a measurement": sum(bool(stop["seen"]) for stop in stops),
        "posts": kinds.count("post"),
        "corners": kinds.count("corner"),
        "left out": sum(map(len, observed)) - len(rows),
    }
    return Result("recorded_walk", counts, (Table.of("The real walk", {"number": counts}),))


def recorded(pose: Pose, seen: Observation) -> dict[str, list[object]]:
    """Return a stop as the file has it: the pose, and number, bearing, range and covariance of each landmark."""
    rows: list[object] = []
    for i, number in identified(pose, seen).items():
        (bearing, distance), R = seen.values[i], seen.part([i]).covariance
        rows.append(
            [number, *(float(f"{value:.4g}") for value in (bearing, distance, R[0, 0], R[0, 1], R[1, 1]))]
        )
    return {"pose": [round(value, 4) for value in pose.as_array().tolist()], "seen": rows}


def identified(pose: Pose, seen: Observation) -> dict[int, int]:
    """Return the number of the nearest landmark by the index of each measurement that fits one from the true pose."""
    found = {}
    for i, measurement in enumerate(seen):
        same = [n for n, kind in enumerate(FIELD.detectable_kinds) if kind == measurement.kind]
        off = (measurement.bearing, measurement.range) - range_and_bearing(
            pose.as_array(), FIELD.detectable_positions[same]
        )
        off[:, 0] = wrap_angle(off[:, 0])
        S = seen.part([i]).covariance + PLACED
        squares = squared_distances(off, np.tile(S, (len(same), 1, 1)))
        nearest = int(squares.argmin())
        if squares[nearest] <= MOST:
            found[i] = same[nearest]
    return found
