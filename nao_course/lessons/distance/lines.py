"""Centre lines of the field lines as segments in a picture, from a camera with an unknown tilt."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.distance.looks import HEAD_PITCH
from nao_course.sim import NAO_V4, CameraView, Field

PITCH_SIGMA, ROLL_SIGMA = float(np.radians(1.3)), float(np.radians(0.8))  # of real pictures, all together
END_SIGMA = 0.25  # px, of a segment's end, across it
SHORTEST = 25.0  # px
REACH = 5.0  # m: farther lines are too thin to be found
FEWEST = 2  # segments in a picture
MOST_ARCS = 2  # arcs of the circle that a detector finds as segments
STRAY = 0.3  # fraction of the pictures with a segment that is not a field line
_FIELD = Field(2012, half=False)


@dataclass(frozen=True, eq=False)
class LinePicture:
    """The segments of a picture, with its assumed and its true view.

    The segments (N, 4) are (u1, v1, u2, v2) in px, the lens removed; both views are without the lens term, and the pose
    is the robot's in the world.
    """

    segments: FloatArray
    view: CameraView
    true_view: CameraView
    pose: Pose


def line_picture_of(seed: int) -> LinePicture:
    """Take one picture somewhere on the field; the same at every call."""
    rng = np.random.default_rng([seed, 404])
    while True:
        pose = Pose(*rng.uniform((-2.8, -1.9, -np.pi), (2.8, 1.9, np.pi)))
        view = replace(NAO_V4.view("bottom", rng.uniform(-0.6, 0.6), HEAD_PITCH), k1=0.0)
        tilt = rng.normal(0.0, (PITCH_SIGMA, ROLL_SIGMA))
        true = replace(view, pitch=view.pitch + tilt[0], roll=view.roll + tilt[1])
        segments = _segments_in(pose, true, rng)
        if len(segments) >= FEWEST:
            break
    if rng.random() < STRAY:
        segments = np.vstack([segments, _stray(view, rng)])
    return LinePicture(rng.permutation(segments), view, true, pose)


def _segments_in(pose: Pose, view: CameraView, rng: np.random.Generator) -> FloatArray:
    """Return the segments of a good detector: the visible lines and parts of the circle."""
    lines = [np.linspace((x1, y1), (x2, y2), 300) for x1, y1, x2, y2 in _FIELD.lines]
    arcs = []
    for x, y, radius, first, last in _FIELD.arcs:
        for begin in np.arange(first, last, np.radians(25)):
            angle = np.linspace(begin, min(begin + np.radians(25), last), 20)
            arcs.append(np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)]))
    straight = [_seen_part(each, pose, view) for each in lines]
    curved = [_seen_part(each, pose, view) for each in arcs]
    kept = [each for each in straight if each is not None]
    kept += [each for each in curved if each is not None][:MOST_ARCS]
    return np.array([_shaken(each, rng) for each in kept]).reshape(-1, 4)


def _seen_part(points: FloatArray, pose: Pose, view: CameraView) -> FloatArray | None:
    """Return both ends (4,) of the near and visible part of a curve (N, 2); None if it is too short."""
    near = np.linalg.norm(points - (pose.x, pose.y), axis=1) < REACH
    pixels = view.project(points, pose)
    inside = near & view.contains(pixels)
    if inside.sum() < 2:
        return None
    first, last = pixels[inside][[0, -1]]
    return np.concatenate([first, last]) if np.linalg.norm(last - first) >= SHORTEST else None


def _shaken(segment: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return the segment with small errors at its ends."""
    first, last = segment.reshape(2, 2)
    way = (last - first) / np.linalg.norm(last - first)
    aside = np.array([-way[1], way[0]])
    return np.concatenate([end + END_SIGMA * rng.standard_normal() * aside for end in (first, last)])


def _stray(view: CameraView, rng: np.random.Generator) -> FloatArray:
    """Return a segment (1, 4) on the carpet that is not a field line, such as a crack or a cable."""
    width, height = view.size
    middle = rng.uniform((40, 0.45 * height), (width - 40, height - 30))
    angle, half = rng.uniform(0, np.pi), rng.uniform(15, 45)
    way = half * np.array([np.cos(angle), np.sin(angle)])
    return np.concatenate([middle - way, middle + way])[None]
