"""The results of a demo: errors and computing times as numbers and as text."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.field_slam.demo.drive import Story
from nao_course.field_slam.walk import WalkFrame
from nao_course.geometry import Pose, pose_errors, wrap_angle
from nao_course.plotting.style import style_of
from nao_course.robot import write_offsets
from nao_course.sim import Field
from nao_course.slam import Estimate

UNITS = (
    "way, position, sigma, landmarks_median: m; pose: m and rad; heading: degrees; times: ms per picture. "
    "Errors are those at the end."
)
BACK = 0.05  # m: a robot that was carried away is back if its error is smaller


def results(story: Story, field_: Field) -> dict[str, Any]:
    """Return all errors and times as values for a JSON file, in m, degrees and milliseconds.

    Where the truth is not known, the errors are left out.
    """
    places = np.array([(mark.x, mark.y) for mark in field_.landmarks])
    found: dict[str, Any] = {
        "units": UNITS,
        "pictures": len(story.poses),
        "way": way_of(story.frames),
        "vision_ms": _milliseconds(story.vision),
    }
    if story.has_truth:
        found["odometry"] = errors_of(story.odometry[-1], story.poses[-1])
    if story.carried is not None:
        found["kidnapping"] = _kidnapping(story, story.carried)
    for name, estimates in story.estimates.items():
        last = estimates[-1]
        away = np.linalg.norm(last.landmarks[:, None] - places, axis=2)
        found[name] = {
            "pose": last.pose.as_array().tolist(),
            "sigma": sigma_of(last),
            "landmarks": len(last.landmarks),
            "landmarks_median": float(np.median(away.min(axis=1))) if len(away) else None,
            "slam_ms": _milliseconds(story.slam[name]),
        }
        if story.has_truth:
            found[name] |= errors_of(last.pose, story.poses[-1]) | {"nees": _nees(last, story.poses[-1])}
            found[name]["position_at_each_picture"] = [
                round(errors_of(each.pose, true)["position"], 4)
                for each, true in zip(estimates, story.poses, strict=True)
            ]
    return found


def in_words(story: Story, field_: Field) -> list[str]:
    """Return the errors at the end as text, with a line for odometry and a line for each algorithm."""
    found = results(story, field_)
    drive = f"{found['pictures']} pictures, {found['way']:.1f} m"
    lines = [
        f"{drive}; odometry ends {found['odometry']['position']:.2f} m off" if story.has_truth else drive
    ]
    for name in story.estimates:
        each = found[name]
        spent = found["vision_ms"]["median"] + each["slam_ms"]["median"]
        off = f"standard deviation {each['sigma']:.3f} m"
        if story.has_truth:
            off = f"{each['position']:.3f} m and {each['heading']:.2f} degrees off, NEES {each['nees']:.1f}"
        lines.append(
            f"{style_of(name).label}: {off}, {each['landmarks']} landmarks, {spent:.0f} ms per picture"
        )
    return lines + kidnapping_in_words(story)


def _kidnapping(story: Story, carried: int) -> dict[str, Any]:
    """Return where the robot was carried away before a picture, and after how many stops it noticed and was back.

    Stops are counted from 1; the number is None for what did not happen.
    """
    stops = [0, *(number for number, frame in enumerate(story.frames) if number and frame.motion is not None)]
    there = stops[stops.index(carried) :]
    off = [
        errors_of(story.estimates["ekf"][number].pose, story.poses[number])["position"] for number in there
    ]
    noticed = [story.noticed[number] > story.noticed[carried - 1] for number in there]
    back = [
        known and not story.lost[number] and error < BACK
        for number, known, error in zip(there, noticed, off, strict=True)
    ]
    return {
        "stop": stops.index(carried) + 1,
        "distance": errors_of(story.poses[carried - 1], story.poses[carried])["position"],
        "noticed_after": 1 + noticed.index(True) if any(noticed) else None,
        "back_after": 1 + back.index(True) if any(back) else None,
    }


def kidnapping_in_words(story: Story) -> list[str]:
    """Return where the robot was carried away and when its EKF was right again, as text; nothing if it was not."""
    if story.carried is None:
        return []
    found = _kidnapping(story, story.carried)
    ending = "did not notice"
    if found["noticed_after"]:
        back = "but is still lost" if story.lost[-1] else "but was never within 5 cm again"
        if found["back_after"]:
            back = f"and was within 5 cm again after {found['back_after']}"
        ending = f"noticed after {say_count(found['noticed_after'], 'stop')} {back}"
    return [
        f"The robot was carried {found['distance']:.1f} m away before stop {found['stop']}. Its EKF {ending}."
    ]


def keep_calibration(story: Story, path: Path) -> str:
    """Write what a recorded drive says of its bottom camera, for `RealNao`, and say it in words."""
    pitch, roll = story.calibration.mean.tolist()
    lower, sigma = np.degrees([pitch, np.sqrt(story.calibration.covariance[0, 0])])
    if not story.calibration.is_certain:
        return "The pictures do not show how its bottom camera is mounted: drive on along lines that cross."
    write_offsets(path, {"bottom": (pitch, roll)})
    looks = f"Its bottom camera looks {lower:.1f} ± {sigma:.1f}° lower than its joints report"
    return f'{looks}: use RealNao(..., cameras="{path.as_posix()}").'


def field_in_words(field_: Field) -> list[str]:
    """Return what the robot does differently on a field whose goals are not yellow, as text; nothing otherwise."""
    match field_.dimensions.goal_colour:
        case "white":
            return [
                "The goals are white. Lesson 02's find_goalposts gets the white posts as yellow pixels; it finds fewer "
                "of them than yellow posts, because white walls hide them."
            ]
        case "none":
            return ["The field has no goals: the robot maps corners only."]
    return []


def way_of(frames: Sequence[WalkFrame]) -> float:
    """Return the length of the path to the last picture, m, without the part on which the robot was carried."""
    path = np.array([(frame.pose.x, frame.pose.y) for frame in frames])
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    return float(steps[[not frame.carried for frame in frames[1:]]].sum())


def errors_of(pose: Pose, true: Pose) -> dict[str, float]:
    """Return the error of a pose: of its position in m, and of its heading in degrees."""
    return {
        "position": float(np.hypot(pose.x - true.x, pose.y - true.y)),
        "heading": float(np.degrees(abs(wrap_angle(pose.theta - true.theta)))),
    }


def sigma_of(estimate: Estimate) -> float:
    """Return the standard deviation of an estimated position, m: the root of the sum of both variances."""
    return float(np.sqrt(np.trace(estimate.covariance[:2, :2])))


def _nees(estimate: Estimate, true: Pose) -> float:
    away = pose_errors(estimate.pose.as_array(), true.as_array())
    return float(away @ np.linalg.pinv(estimate.covariance) @ away)


def _milliseconds(seconds: Sequence[float]) -> dict[str, float]:
    each = 1000 * np.array(seconds)
    return {"median": float(np.median(each)), "95 %": float(np.quantile(each, 0.95))}


def make_folder(folder: Path) -> Path:
    """Make a folder and raise a ValueError if no file can be written there, before a long calculation starts."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        raise ValueError(f"--out {folder}: nothing can be written there ({error.strerror})") from None
