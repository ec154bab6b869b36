"""Every field of the course: what the detectors find in its pictures, and where the demo's drives end.

The fields differ in size, lines and goals. The landmarks are split by distance, because a larger field has more of them
far away. On a field with white goals, posts are also searched for by their yellow
colour alone, as the lessons do. The lessons' solutions do what is the students', as in ``nao-course demo --field``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks import ROOT, Result, Table, in_processes
from nao_course.field_slam.compass import estimate_body_tilt
from nao_course.field_slam.demo import drive as demo
from nao_course.field_slam.demo import report
from nao_course.field_slam.drives import Shot, drive_over_field
from nao_course.field_slam.lines import corners_of_lines
from nao_course.field_slam.observation import tilted
from nao_course.field_slam.walk import WalkFrame
from nao_course.geometry import FloatArray
from nao_course.metrics import PointMatch, match_points, total
from nao_course.sim import Field
from nao_course.sim.fields import SHIPPED

SEEDS = range(10)
LOST = 0.5  # m: an error at the end from which a drive counts as lost
NEAR = 3.0  # m


@dataclass(frozen=True, eq=False)
class Match(PointMatch):
    """A match of one picture's landmarks, or of several pictures', with their distances (K,), m."""

    distances: FloatArray


def detections(functions: demo.Functions, field: Field, shots: Iterable[Shot]) -> dict[str, list[Match]]:
    """Return the matches of corners and posts up to the demo's largest range in the pictures of a drive."""
    rules, matches = field.dimensions, defaultdict[str, list[Match]](list)
    by_colour = replace(rules, goal_colour="yellow") if rules.goal_colour == "white" else None
    for shot in shots:
        pixels, view = shot.picture.pixels, shot.picture.view
        found = demo.detect(functions, pixels, view, rules)
        tilt = estimate_body_tilt(found.lines, view)
        corners = corners_of_lines(found.lines, tilted(view, tilt.pitch, tilt.roll))
        matches["corners"].append(_match(shot, field, corners, "corner"))
        if len(field.posts):
            matches["posts"].append(_match(shot, field, found.posts, "post"))
        if by_colour:
            posts = demo.detect(functions, pixels, view, by_colour).posts
            matches["posts by yellow alone"].append(_match(shot, field, posts, "post"))
    return matches


def _match(shot: Shot, field: Field, points: FloatArray, kind: str) -> Match:
    """Match points with the visible landmarks of a kind; those far away, hidden or at the rim may be found too."""
    marks = shot.truth.landmarks
    clear = [m for m in marks if m.landmark.kind == kind and not m.occluded and m.distance < demo.FARTHEST]
    others = [m.pixel for m in marks if m not in clear and m.landmark.kind in (kind, "cross")]
    if kind == "post":
        others += list(map(tuple, shot.truth.view.project(field.posts, shot.pose)))
    pixels, distances = [m.pixel for m in clear], np.array([m.distance for m in clear])
    match = match_points(points, np.reshape(pixels, (-1, 2)), np.reshape(others, (-1, 2)))
    return Match(match.found, match.false, distances)


def _rates(matches: list[Match]) -> dict[str, float]:
    every = total(matches)
    near = every.distances < NEAR
    return {
        "near": int(near.sum()),
        "recall, near": float(every.found[near].mean()),
        "far": int((~near).sum()),
        "recall, far": float(every.found[~near].mean()),
        "false per picture": every.false / len(matches),
    }


def ends(stories: list[demo.Story], field: Field) -> dict[str, dict[str, float]]:
    """Return the errors at the end of drives by odometry and by the EKF, and the errors of the EKF's maps."""
    each = [report.results(story, field) for story in stories]
    found = {}
    for name in ("odometry", "ekf"):
        position = np.array([result[name]["position"] for result in each])
        found[name] = {
            "position median": float(np.median(position)),
            "position worst": float(position.max()),
            "lost": int((position > LOST).sum()),
        }
    for name in ("landmarks", "landmarks_median"):
        found["ekf"][name] = float(np.median([result["ekf"][name] for result in each]))
    return found


def field_results(name: str, seeds: Sequence[int] = SEEDS) -> dict[str, Any]:
    """Return what the detectors find on a field of the course, and where the drives of some seeds end."""
    functions, field = demo.demo_functions(["ekf"], ROOT / "solutions"), Field.from_toml(name)
    pictures, stories = [], []
    for seed in seeds:
        shots = list(drive_over_field(seed, field=field))
        frames = [WalkFrame(each.motion, each.picture.pixels, each.picture.view, each.pose) for each in shots]
        stories.append(demo.run_demo(functions, frames, ["ekf"], rules=field.dimensions))
        pictures.append(detections(functions, field, shots))
    found = {kind: _rates([match for each in pictures for match in each[kind]]) for kind in pictures[0]}
    return {"pictures": len(seeds) * len(shots), "detectors": found, "drives": ends(stories, field)}


def main() -> Result:
    """Drive over each field of the course."""
    found = dict(zip(SHIPPED, in_processes(field_results, SHIPPED, "fields"), strict=True))
    detectors, drives = (
        {f"{field}, {name}": of for field, each in found.items() for name, of in each[part].items()}
        for part in ("detectors", "drives")
    )
    title = (
        f"detectors, {len(SEEDS)} drives on each field, landmarks up to {demo.FARTHEST:g} m, near: {NEAR:g} m"
    )
    columns = ("position median", "position worst", "lost", "landmarks", "landmarks_median")
    ends_of = f"ends of {len(SEEDS)} drives, m; lost: over {LOST:g} m"
    tables = Table.of(title, detectors), Table.of(ends_of, drives, *columns)
    return Result("own_fields", {"fields": found, "seeds": len(SEEDS), "lost": LOST}, tables)
