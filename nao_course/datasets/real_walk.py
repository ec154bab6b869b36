"""The measurements of a real NAO's walk; the pictures that they are from are not part of the course."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np

from nao_course.geometry import FloatArray, Pose
from nao_course.sim import Field
from nao_course.sim.drives import Drive, Step
from nao_course.slam import Measurement, Motion, measured_points

FILE = Path(__file__).with_suffix(".json")
FIELD = Field(2012, half=False)
# A person put the robot down at each stop, so the next stop is known to about 5 cm and 2 degrees (docs/real_data.md).
PUT_DOWN = np.diag([0.05**2, 0.05**2, np.radians(2.0) ** 2])


@cache
def recorded_walk() -> Drive:
    """Return a walk of 6 m along the axis of a whole field, recorded with a real NAO V4 in Amsterdam in 2013.

    Returns
    -------
    Drive
        Its landmarks are the landmarks of `FIELD`, m, field frame. Each of the 30 steps has the pose at which a person
        put the robot down, and bearing and range of the posts and corners that the course's detectors found in its
        picture, with covariances. Each measurement has the number of the landmark of its kind that fits it best;
        three that fit none are left out. The commands are straight ahead.

    Notes
    -----
    ``python -m benchmarks recorded_walk`` makes the file from the pictures; docs/real_data.md states their source.
    """
    steps = list[Step]()
    before: FloatArray | None = None
    for stop in json.loads(FILE.read_text(encoding="utf-8")):
        pose, seen = np.array(stop["pose"]), np.array(stop["seen"]).reshape(-1, 6)
        motion = None if before is None else Motion(float(pose[0] - before[0]), 0.0)
        steps.append(
            Step(
                pose,
                motion,
                np.zeros((3, 3)) if motion is None else PUT_DOWN,
                seen[:, 0].astype(np.intp),
                seen[:, 1:3],
                seen[:, [3, 4, 4, 5]].reshape(-1, 2, 2),
            )
        )
        before = pose
    return Drive(FIELD.detectable_positions, tuple(steps))


def measured_posts() -> FloatArray:
    """Return where the walk's 47 measurements of goal posts place them, (47, 2), m, in the field frame."""
    placed = list[FloatArray]()
    for step in recorded_walk().steps:
        pairs = zip(step.numbers, step.measurements, strict=True)
        seen = [Measurement(b, r, "post") for i, (b, r) in pairs if FIELD.detectable_kinds[i] == "post"]
        placed.append(measured_points(seen, Pose.from_array(step.pose)))
    return np.concatenate(placed)
