"""What came of a demo: its errors and times as numbers and in words, and a folder with all of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np

from nao_course.geometry import Pose, wrap_angle
from nao_course.lessons.slam_on_the_field.system.demo.drive import Story
from nao_course.plotting.style import style_of
from nao_course.sim import Field
from nao_course.slam import Estimate

UNITS = "way, position, landmarks_median: m; heading: degrees; ms a picture. Errors are those at the end of the way."


def results(story: Story, field_: Field) -> dict[str, Any]:
    """All errors and times, as JSON can hold them: m, degrees, milliseconds."""
    places = np.array([(mark.x, mark.y) for mark in field_.landmarks])
    found: dict[str, Any] = {
        "units": UNITS,
        "pictures": len(story.poses),
        "way": way_of(story.poses),
        "odometry": errors_of(story.odometry[-1], story.poses[-1]),
        "vision_ms": _milliseconds(story.vision),
    }
    for name, estimates in story.estimates.items():
        last = estimates[-1]
        away = np.linalg.norm(last.landmarks[:, None] - places, axis=2)
        found[name] = {
            **errors_of(last.pose, story.poses[-1]),
            "nees": _nees(last, story.poses[-1]),
            "landmarks": len(last.landmarks),
            "landmarks_median": float(np.median(away.min(axis=1))) if len(away) else None,
            "slam_ms": _milliseconds(story.slam[name]),
            "position_at_each_picture": [
                round(errors_of(each.pose, true)["position"], 4)
                for each, true in zip(estimates, story.poses, strict=True)
            ],
        }
    return found


def in_words(story: Story, field_: Field) -> list[str]:
    """The errors at the end, a line for odometry and for each algorithm."""
    found = results(story, field_)
    lines = [
        f"{found['pictures']} pictures, {found['way']:.1f} m; odometry ends {found['odometry']['position']:.2f} m off"
    ]
    for name in story.estimates:
        each = found[name]
        spent = found["vision_ms"]["median"] + each["slam_ms"]["median"]
        lines.append(
            f"{style_of(name).label}: {each['position']:.3f} m and {each['heading']:.2f} degrees off, "
            f"NEES {each['nees']:.1f}, {each['landmarks']} landmarks, {spent:.0f} ms a picture"
        )
    return lines


def way_of(poses: Sequence[Pose]) -> float:
    """How long a path is, m."""
    path = np.array([(pose.x, pose.y) for pose in poses])
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def errors_of(pose: Pose, true: Pose) -> dict[str, float]:
    """By what a pose is off: its position in m, its heading in degrees."""
    return {
        "position": float(np.hypot(pose.x - true.x, pose.y - true.y)),
        "heading": float(np.degrees(abs(wrap_angle(pose.theta - true.theta)))),
    }


def _nees(estimate: Estimate, true: Pose) -> float:
    away = estimate.pose.as_array() - true.as_array()
    away[2] = wrap_angle(away[2])
    return float(away @ np.linalg.pinv(estimate.covariance) @ away)


def _milliseconds(seconds: Sequence[float]) -> dict[str, float]:
    each = 1000 * np.array(seconds)
    return {"median": float(np.median(each)), "95 %": float(np.quantile(each, 0.95))}


def make_folder(folder: Path) -> Path:
    """Make a folder in which files can be written, before anything takes its time.

    Raises
    ------
    ValueError
        If there is none to be had.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        raise ValueError(f"--out {folder}: nothing can be written there ({error.strerror})") from None
