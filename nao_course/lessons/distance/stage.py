"""What lesson 04 adds to the student's robot: posts and corners of each picture as points on the map, live."""

from __future__ import annotations

import numpy as np

from nao_course.geometry import as_points
from nao_course.robot import Robot
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction

FOUND_BEFORE = ("goal posts", "corners")  # stages of lessons 02 and 03 whose result is pixels (K, 2)


def _put_on_map(student: StudentCode, nao: Robot) -> StageFunction:
    """Turn the pixels that the stages before have found into points of the robot frame."""

    def look(frame: Frame) -> Overlay:
        found = {name: as_points(frame.results[name]) for name in FOUND_BEFORE if name in frame.results}
        pixels = np.vstack([np.zeros((0, 2)), *found.values()])
        points = as_points(student.pixel_to_ground(pixels, frame.picture.view), name="points on the ground")
        if len(points) != len(pixels):
            raise ValueError(f"{len(pixels)} pixels need as many points on the ground, got {len(points)}")
        if not found:
            return Overlay(points, text="no posts and no corners to put on it: lessons 02 and 03 find them")
        said, ends = [], np.cumsum([len(each) for each in found.values()])
        for name, part in zip(found, np.split(points, ends[:-1]), strict=True):
            ranges = [f"{away:.1f} m" for away in np.hypot(*part.T) if np.isfinite(away)]
            said.append(f"{name}: {', '.join(ranges) or 'none'}")
        below = points[np.isfinite(points).all(axis=1)]
        return Overlay(below, points=below, text="; ".join(said))

    return look


STAGE = Stage(name="points on the map", lesson="04_distance", uses=("pixel_to_ground",), wire=_put_on_map)
