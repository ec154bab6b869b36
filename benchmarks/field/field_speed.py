"""What a whole step of lesson 11's system costs, part by part: milliseconds of one core's time a picture of 320 x 240.

The lessons' solutions do what is the students', as in ``nao-course demo``; rendering is no part of it. Time is that of
the thread, so that other work on the machine counts as little as can be.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import cv2
import numpy as np

from benchmarks import ROOT, Result, Table
from benchmarks.field.field_slam.detections import shots
from nao_course.colours import GREEN, YELLOW, mean_lightness
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.compass import tilt_from_lines
from nao_course.field_slam.demo import drive as demo
from nao_course.field_slam.drives import OdometryNoisePerMove, Shot
from nao_course.field_slam.hypotheses import MultipleHypotheses
from nao_course.field_slam.joint_update import JointUpdate
from nao_course.field_slam.lines import corners_of_lines, read_lines
from nao_course.field_slam.observation import Observation, tilted

SEEDS = (0, 1)
MOST = 20.0  # ms of a whole step; 40 where hypotheses are kept

Parts = dict[str, list[float]]


def vision(functions: demo.Functions, shot: Shot, parts: Parts) -> None:
    """Time the parts of what is done with a picture."""
    pixels, view = shot.picture.pixels, shot.picture.view
    white = functions["white_threshold"](mean_lightness(pixels))
    labels = _timed(parts, "labels", functions["color_labels"], pixels, GREEN, YELLOW, white)
    posts = _timed(parts, "posts", functions["find_goalposts"], labels)
    lines = _timed(parts, "lines", read_lines, pixels, view)
    tilt = _timed(parts, "tilt from lines", tilt_from_lines, lines, view)
    level = tilted(view, tilt.pitch, tilt.roll)
    corners = _timed(parts, "corners of lines", corners_of_lines, lines, level)
    _timed(parts, "measurements", functions["measurements_from_pixels"], posts, corners, level)


def steps(functions: demo.Functions, drive: Sequence[Shot], parts: Parts) -> None:
    """Time a drive: what the pictures show, and each algorithm's answer to it."""
    start = drive[0].pose
    ekf = functions["EkfSlam"](start, OdometryNoisePerMove(), demo.GATE, _timed_association(parts))
    graph = functions["GraphSlam"](start, OdometryNoisePerMove(), demo.GATE, associate_jointly)
    inner = functions["EkfSlam"](start, OdometryNoisePerMove(), demo.GATE, associate_jointly)
    hypotheses = MultipleHypotheses(JointUpdate(inner))
    for shot in drive:
        vision(functions, shot, parts)
        picture = shot.picture
        given = functions, picture.pixels, picture.view, demo.FARTHEST, True
        seen = _timed(parts, "picture to observation", demo.see, *given)
        parts["association"].append(0.0)
        _timed(parts, "EKF", _step, ekf, shot, seen, True)
        _timed(parts, "graph: edges", _step, graph, shot, seen, False)
        _timed(parts, "graph: solution", graph.estimate)
        _timed(parts, "joint update, several hypotheses", _step, hypotheses, shot, seen, True)


def _step(slam: Any, shot: Shot, seen: Observation, asked: bool) -> None:
    """Do what an algorithm does with a picture."""
    if shot.motion is not None:
        slam.move(shot.motion)
    slam.observe(seen)
    if asked:
        slam.estimate()


def _timed(parts: Parts, name: str, call: Callable[..., Any], *given: Any) -> Any:
    began = time.thread_time()
    found = call(*given)
    parts.setdefault(name, []).append(1000 * (time.thread_time() - began))
    return found


def _timed_association(parts: Parts) -> Callable[..., Any]:
    """Return the library's association, wrapped so that its time is added to that of the picture."""
    parts.setdefault("association", [])

    def associate(*given: Any) -> Any:
        began = time.thread_time()
        found = associate_jointly(*given)
        parts["association"][-1] += 1000 * (time.thread_time() - began)
        return found

    return associate


def summary(parts: Parts) -> dict[str, dict[str, float]]:
    """Return the median, 95 % and largest time of each part, and of whole steps."""
    seen, edges, solutions = (
        np.array(parts[name]) for name in ("picture to observation", "graph: edges", "graph: solution")
    )
    all_parts: dict[str, Any] = {
        **parts,
        "whole step, EKF": seen + parts["EKF"],
        "whole step, graph": seen + edges + solutions,
        "whole step, several hypotheses": seen + parts["joint update, several hypotheses"],
    }
    return {
        name: {
            "mean": float(np.mean(each)),
            "median": float(np.median(each)),
            "95 %": float(np.quantile(each, 0.95)),
            "worst": float(np.max(each)),
        }
        for name, each in all_parts.items()
    }


def main() -> Result:
    """Time two drives with the solutions."""
    cv2.setNumThreads(1)
    functions = demo.demo_functions(list(demo.ALGORITHMS), ROOT / "solutions")
    parts: Parts = {}
    for seed in SEEDS:
        steps(functions, shots(seed), parts)
    found = summary(parts)
    table = Table(
        f"a step of {len(SEEDS)} drives of {len(shots(SEEDS[0]))} pictures, ms of one core",
        ("part", "mean", "median", "95 %", "worst"),
        tuple((name, *each.values()) for name, each in found.items()),
    )
    note = f"wanted of a whole step: {MOST:.0f} ms; estimates are asked for at each picture"
    return Result("field_speed", {"ms": found, "wanted": MOST}, (table,), (note,))
