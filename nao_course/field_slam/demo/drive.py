"""The complete program of the autonomous robot: it drives or walks, takes pictures, and maps the field."""

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
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.calibration import CameraCalibration
from nao_course.field_slam.compass import tilt_from_lines
from nao_course.field_slam.drives import MOVES, YAWS, OdometryNoisePerMove, drive_over_field
from nao_course.field_slam.joint_update import scene
from nao_course.field_slam.lines import corners_of_lines, read_lines
from nao_course.field_slam.observation import POST_SIGMA, TILT_SIGMAS, Observation, observation, tilted
from nao_course.field_slam.surest_first import SurestFirst
from nao_course.field_slam.walk import Frame, real_walk
from nao_course.geometry import Pose
from nao_course.sim import CameraView, Field
from nao_course.slam import Estimate, SlamAlgorithm
from nao_course.student.notebooks import own_function

USES = ("01:color_labels", "01:white_threshold", "02:find_goalposts", "11:measurements_from_pixels")
ALGORITHMS = {"ekf": "11:EkfSlam", "graph": "11:GraphSlam"}
CORNER_SIGMA = 0.5  # px at 320: standard deviation of a corner where two lines found by the library meet
FARTHEST = 6.0  # m: largest range of a measurement that is used
GATE = 4.0  # standard deviations

Functions = Mapping[str, Callable[..., Any]]


@dataclass
class Story:
    """The record of a drive, with one entry for each picture.

    Parameters
    ----------
    frames : list of Frame
        Pictures, with the true poses.
    seen : list of Observation
        Measurements of each picture.
    odometry : list of Pose
        Poses in the field frame that follow from the commanded motions alone.
    estimates : mapping of str to list of Estimate
        Estimates of each algorithm. The pictures of a stop are used together, in order of their compass.
    vision : list of float
        Seconds from the pixels of each picture to its observation.
    slam : mapping of str to list of float
        Seconds of each algorithm from the observations of a stop to its estimate, divided by its number of pictures.
    """

    frames: list[Frame] = field(default_factory=list)
    seen: list[Observation] = field(default_factory=list)
    odometry: list[Pose] = field(default_factory=list)
    estimates: dict[str, list[Estimate]] = field(default_factory=dict)
    vision: list[float] = field(default_factory=list)
    slam: dict[str, list[float]] = field(default_factory=dict)

    @property
    def poses(self) -> list[Pose]:
        """True pose of the robot at each picture, in the field frame."""
        return [frame.pose for frame in self.frames]


def simulated(seed: int, moves: int) -> Iterator[Frame]:
    """Render a drive over the half field; see `drive_over_field`."""
    for shot in drive_over_field(seed, moves=moves):
        yield Frame(shot.motion, shot.picture.pixels, shot.picture.view, shot.pose)


def route(seed: int, walk: Path | None = None) -> tuple[Iterator[Frame], int, Field]:
    """Return the pictures of a drive or walk, their number, and the field.

    Parameters
    ----------
    seed : int
        Seed of the drive, or of the walk's odometry.
    walk : Path, optional
        Folder that contains ``amsterdam_2013``, or the folder of the walk itself. If it is given, the real pictures are
        used instead of a simulated drive.
    """
    if walk is None:
        return simulated(seed, MOVES), (MOVES + 1) * len(YAWS), Field(2012)
    own = (walk / "annotations.json").is_file()
    pictures = read_pictures("straightwalk", walk.resolve().parents[1] if own else walk)
    return real_walk(pictures, seed), len(pictures), Field(2012, half=False)


def see(
    functions: Functions,
    pixels: npt.NDArray[np.uint8],
    view: CameraView,
    farthest: float = FARTHEST,
    calibration: CameraCalibration | None = None,
    joint: bool = False,
) -> Observation:
    """Make an observation from a picture with the student's functions and the library's detection of lines.

    Parameters
    ----------
    functions : mapping of str to callable
        Functions of `USES` by name, without the numbers of their lessons.
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB picture.
    view : CameraView
        Assumed view of the camera.
    farthest : float
        Largest range of a measurement that is used, m.
    calibration : CameraCalibration, optional
        Estimate of the camera's offset from the view. It is updated with the picture before the picture is measured.
    joint : bool
        Whether to return a `Scene`, which also has the lines and the centre circle for a `JointUpdate`.
    """
    white = functions["white_threshold"](mean_lightness(pixels))
    labels = functions["color_labels"](pixels, GREEN, YELLOW, white)
    posts = functions["find_goalposts"](labels)
    prior: npt.ArrayLike = TILT_SIGMAS
    lines = read_lines(pixels, calibration.reading_view(view) if calibration else view)
    if calibration:
        calibration.update(lines, posts, view)
        view, prior = calibration.corrected(view), calibration.tilt_covariance(view)
    tilt = tilt_from_lines(lines, view, prior)
    level = tilted(view, tilt.pitch, tilt.roll)
    found = functions["measurements_from_pixels"](posts, corners_of_lines(lines, level), level)
    near = [each for each in found if each.range < farthest]
    compass = tilt.direction, tilt.direction_sigma
    seen = observation(near, tilt.covariance[:2, :2], CORNER_SIGMA, *compass, POST_SIGMA)
    return scene(seen, tilt, lines, level) if joint else seen


def demo_functions(slam: Sequence[str], notebooks: Path) -> Functions:
    """Load the functions that the demo uses from the notebooks of a folder.

    Parameters
    ----------
    slam : sequence of "ekf" or "graph"
        Algorithms that will run.
    notebooks : Path
        Folder with the student's notebooks, or with the solutions.

    Raises
    ------
    ValueError
        If functions are missing or do not pass their public checks. The message names them and says what to do.
    """
    found: dict[str, Callable[..., Any]] = {}
    missing: list[str] = []
    for use in (*USES, *(ALGORITHMS[name] for name in slam)):
        function, lacking = own_function(use, {}, notebooks)
        missing += [lacking] if lacking else []
        found[use.partition(":")[2]] = function
    if missing:
        raise ValueError(
            f"The robot drives with your own functions, and {'; '.join(dict.fromkeys(missing))}. "
            "Finish that, save the notebook, and start the demo again."
        )
    return found


def run_demo(functions: Functions, frames: Iterable[Frame], slam: Sequence[str]) -> Story:
    """Run the algorithms, independently of each other, over the pictures of a drive.

    Parameters
    ----------
    functions : mapping of str to callable
        Functions of `USES`, and the classes of the chosen algorithms.
    frames : iterable of Frame
        Pictures of a drive or a walk.
    slam : sequence of "ekf" or "graph"
        Algorithms that run.

    Returns
    -------
    Story
        Record of the drive.
    """
    story = Story(estimates={name: [] for name in slam}, slam={name: [] for name in slam})
    calibration: CameraCalibration | None = None
    algorithms: dict[str, SlamAlgorithm] = {}
    for stop in _stops(frames):
        first, motion = stop[0], stop[0].motion
        if not algorithms:
            calibration = None if first.calibrated else CameraCalibration()
            kinds = {name: functions[ALGORITHMS[name].partition(":")[2]] for name in slam}
            algorithms = {
                name: SurestFirst(kind(first.pose, OdometryNoisePerMove(), GATE, associate_jointly))
                for name, kind in kinds.items()
            }
        last = story.odometry[-1] if story.odometry else first.pose
        story.odometry += [last @ motion.as_pose() if motion else last] * len(stop)
        observed = []
        for frame in stop:
            began = time.perf_counter()
            observed.append(see(functions, frame.pixels, frame.view, frame.farthest, calibration))
            story.vision.append(time.perf_counter() - began)
        story.frames += stop
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


def _stops(frames: Iterable[Frame]) -> Iterator[list[Frame]]:
    """Yield the pictures between two motions as one list."""
    stop: list[Frame] = []
    for frame in frames:
        if stop and frame.motion is not None:
            yield stop
            stop = []
        stop.append(frame)
    if stop:
        yield stop
