"""The whole robot without a hand in it: it drives or walks, looks, and maps the field."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.colours import GREEN, YELLOW, mean_lightness
from nao_course.datasets import read_pictures
from nao_course.geometry import Pose
from nao_course.lessons.slam_on_the_field.system.association import associate_jointly
from nao_course.lessons.slam_on_the_field.system.careful import SurestFirst
from nao_course.lessons.slam_on_the_field.system.compass import lean_from_lines
from nao_course.lessons.slam_on_the_field.system.drives import MOVES, YAWS, FieldOdometry, drive_over_field
from nao_course.lessons.slam_on_the_field.system.lines import corners_of_lines, read_lines
from nao_course.lessons.slam_on_the_field.system.observation import (
    POST_SIGMA,
    Observation,
    leaning,
    observation,
)
from nao_course.lessons.slam_on_the_field.system.walk import Sight, real_walk
from nao_course.sim import CameraView, Field
from nao_course.slam import Estimate, SlamAlgorithm
from nao_course.student.notebooks import own_function

USES = ("01:color_labels", "01:white_threshold", "02:find_goalposts", "11:measurements_from_pixels")
ALGORITHMS = {"ekf": "11:EkfSlam", "graph": "11:GraphSlam"}
CORNER_SIGMA = 0.5  # px at 320: of a corner where two of the library's lines meet
FARTHEST = 6.0  # m
GATE = 4.0  # standard deviations

Functions = Mapping[str, Callable[..., Any]]


@dataclass
class Story:
    """What happened on a drive: one entry for each picture.

    Parameters
    ----------
    sights : list of Sight
        The pictures, with the true poses.
    seen : list of Observation
        What was made of them.
    odometry : list of Pose
        By the commands alone; in the field's frame.
    estimates : mapping of str to list of Estimate
        By algorithm; the pictures of a stop are taken in together, the surest compass first.
    vision, slam : lists of float
        Seconds each picture took, from pixels to an observation, and by algorithm from there to the estimate (a stop's,
        shared by its pictures).
    """

    sights: list[Sight] = field(default_factory=list)
    seen: list[Observation] = field(default_factory=list)
    odometry: list[Pose] = field(default_factory=list)
    estimates: dict[str, list[Estimate]] = field(default_factory=dict)
    vision: list[float] = field(default_factory=list)
    slam: dict[str, list[float]] = field(default_factory=dict)

    @property
    def poses(self) -> list[Pose]:
        """The true ones."""
        return [sight.pose for sight in self.sights]


def simulated(seed: int, moves: int) -> Iterator[Sight]:
    """Render a drive over the half field; see `drive_over_field`."""
    for shot in drive_over_field(seed, moves=moves):
        yield Sight(shot.motion, shot.picture.pixels, shot.picture.view, shot.pose)


def route(seed: int, walk: Path | None = None) -> tuple[Iterator[Sight], int, Field]:
    """Where the robot goes: what it will see, how many pictures that are, and the field.

    Parameters
    ----------
    seed : int
        Of the drive, or of the walk's odometry.
    walk : Path, optional
        The folder with ``amsterdam_2013`` in it, or the walk's own in there: its pictures instead of a drive.
    """
    if walk is None:
        return simulated(seed, MOVES), (MOVES + 1) * len(YAWS), Field(2012)
    own = (walk / "annotations.json").is_file()
    pictures = read_pictures("straightwalk", walk.resolve().parents[1] if own else walk)
    return real_walk(pictures, seed), len(pictures), Field(2012, half=False)


def see(
    functions: Functions, pixels: npt.NDArray[np.uint8], view: CameraView, farthest: float = FARTHEST
) -> Observation:
    """From a picture to an observation: labels and posts by the student, lines and the lean they tell by the library.

    Parameters
    ----------
    functions : mapping of str to callable
        By the names in `USES`, without their lessons' numbers.
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    view : CameraView
        What the robot believes.
    farthest : float
        What seems farther away is left out, m.
    """
    white = functions["white_threshold"](mean_lightness(pixels))
    labels = functions["color_labels"](pixels, GREEN, YELLOW, white)
    posts = functions["find_goalposts"](labels)
    lines = read_lines(pixels, view)
    lean = lean_from_lines(lines, view)
    level = leaning(view, lean.pitch, lean.roll)
    found = functions["measurements_from_pixels"](posts, corners_of_lines(lines, level), level)
    near = [each for each in found if each.range < farthest]
    tilt, compass = lean.covariance[:2, :2], (lean.direction, lean.direction_sigma)
    return observation(near, tilt, CORNER_SIGMA, *compass, POST_SIGMA)


def demo_functions(slam: Sequence[str], notebooks: Path) -> Functions:
    """Gather what the robot needs from a folder's notebooks: the student's own, or the solutions.

    Parameters
    ----------
    slam : sequence of "ekf" or "graph"
        Algorithms that will run.
    notebooks : Path
        The folder.

    Raises
    ------
    ValueError
        If functions are missing or do not pass their public checks; it says which, and what to do.
    """
    found: dict[str, Callable[..., Any]] = {}
    missing: list[str] = []
    for use in (*USES, *(ALGORITHMS[name] for name in slam)):
        function, lacking = own_function(use, {}, notebooks)
        missing += [lacking] if lacking else []
        found[use.partition(":")[2]] = function
    if missing:
        raise ValueError(
            f"The robot drives with your own functions, and {'; '.join(missing)}. "
            "Finish that, save the notebook, and start the demo again."
        )
    return found


def run_demo(functions: Functions, sights: Iterable[Sight], slam: Sequence[str]) -> Story:
    """Let the robot go where it goes; see `see`.

    Parameters
    ----------
    functions : mapping of str to callable
        Those of `USES`, and the classes of the chosen algorithms.
    sights : iterable of Sight
        A drive, or a walk.
    slam : sequence of "ekf" or "graph"
        The algorithms, each on its own.

    Returns
    -------
    Story
        All of it.
    """
    story = Story(estimates={name: [] for name in slam}, slam={name: [] for name in slam})
    algorithms: dict[str, SlamAlgorithm] = {}
    for stop in _stops(sights):
        first, motion = stop[0], stop[0].motion
        if not algorithms:
            kinds = {name: functions[ALGORITHMS[name].partition(":")[2]] for name in slam}
            algorithms = {
                name: SurestFirst(kind(first.pose, FieldOdometry(), GATE, associate_jointly))
                for name, kind in kinds.items()
            }
        last = story.odometry[-1] if story.odometry else first.pose
        story.odometry += [last @ motion.as_pose() if motion else last] * len(stop)
        observed = []
        for sight in stop:
            began = time.perf_counter()
            observed.append(see(functions, sight.pixels, sight.view, sight.farthest))
            story.vision.append(time.perf_counter() - began)
        story.sights += stop
        story.seen += observed
        for name, algorithm in algorithms.items():
            began = time.perf_counter()
            if motion is not None:
                algorithm.move(motion)
            for each in observed:
                algorithm.observe(each)
            story.estimates[name] += [algorithm.estimate()] * len(stop)
            story.slam[name] += [(time.perf_counter() - began) / len(stop)] * len(stop)
    return story


def _stops(sights: Iterable[Sight]) -> Iterator[list[Sight]]:
    """Yield the pictures between two commands together."""
    stop: list[Sight] = []
    for sight in sights:
        if stop and sight.motion is not None:
            yield stop
            stop = []
        stop.append(sight)
    if stop:
        yield stop
