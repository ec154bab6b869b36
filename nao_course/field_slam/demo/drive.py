"""The complete program of the autonomous robot: it drives or walks, takes pictures, and maps the field."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nao_course.colours import GREEN, YELLOW, mean_lightness
from nao_course.datasets import read_pictures
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.compass import estimate_body_tilt
from nao_course.field_slam.drives import MOVES, YAWS, OdometryNoisePerMove, drive_over_field, inside
from nao_course.field_slam.hypotheses import MultipleHypotheses
from nao_course.field_slam.joint_update import JointUpdate
from nao_course.field_slam.kidnapping.candidates import Area
from nao_course.field_slam.kidnapping.recovery import KidnapRecovery
from nao_course.field_slam.known_shapes.calibration import CameraCalibration
from nao_course.field_slam.known_shapes.white_posts import as_goal_colour
from nao_course.field_slam.line_observation import scene
from nao_course.field_slam.lines import corners_of_lines, read_lines
from nao_course.field_slam.observation import POST_SIGMA, TILT_SIGMAS, Observation, observation, tilted
from nao_course.field_slam.surest_first import SurestFirst
from nao_course.field_slam.walk import WalkFrame, real_walk
from nao_course.geometry import FloatArray, Pose
from nao_course.robot import RecordedNao, RobotError
from nao_course.sim import DIMENSIONS, CameraView, Field, FieldDimensions
from nao_course.slam import Estimate, SlamAlgorithm
from nao_course.student.notebooks import own_function

USES = ("01:color_labels", "01:white_threshold", "02:find_goalposts", "11:measurements_from_pixels")
ALGORITHMS = {"ekf": "11:EkfSlam", "graph": "11:GraphSlam"}
# px at 320: standard deviations of a corner where two lines found by the library meet. Both are chosen for a consistent
# NEES; a filter without the lines makes other errors, which the larger one covers.
CORNER_SIGMA, JOINT_CORNER_SIGMA = 0.5, 0.35
FARTHEST = 6.0  # m: largest range of a measurement that is used
GATE = 4.0  # standard deviations
RULES = DIMENSIONS[2012]

Functions = Mapping[str, Callable[..., Any]]


@dataclass
class Story:
    """The record of a drive, with one entry for each picture.

    Poses are in the field frame; `odometry` follows from the commanded motions alone. The pictures of a stop are used
    together, in order of their compass. `calibration` is the camera's, where it was not calibrated. `vision` has the
    seconds from each picture's pixels to its observation, `slam` the seconds of each algorithm from a stop's
    observations to its estimate, divided by the number of pictures. `noticed` is how often the EKF has noticed that it
    was carried away, and `lost` whether it does not know where it is.
    """

    frames: list[WalkFrame] = field(default_factory=list)
    seen: list[Observation] = field(default_factory=list)
    odometry: list[Pose] = field(default_factory=list)
    estimates: dict[str, list[Estimate]] = field(default_factory=dict)
    vision: list[float] = field(default_factory=list)
    slam: dict[str, list[float]] = field(default_factory=dict)
    calibration: CameraCalibration = field(default_factory=CameraCalibration)
    noticed: list[int] = field(default_factory=list)
    lost: list[bool] = field(default_factory=list)

    @property
    def poses(self) -> list[Pose]:
        """True pose of the robot at each picture, in the field frame; odometry's where the truth is not known."""
        return [frame.pose for frame in self.frames]

    @property
    def has_truth(self) -> bool:
        """Whether the true poses are known."""
        return all(frame.known for frame in self.frames)

    @property
    def carried(self) -> int | None:
        """Number of the first picture after the robot was carried away; None if it was not."""
        return next((number for number, frame in enumerate(self.frames) if frame.carried), None)


def simulated(seed: int, moves: int, field: Field | None = None, kidnap: bool = False) -> Iterator[WalkFrame]:
    """Render a drive over a field, half way of which a robot may be carried away; see `drive_over_field`."""
    for shot in drive_over_field(seed, moves=moves, field=field, carried=moves // 2 if kidnap else None):
        picture = shot.picture
        yield WalkFrame(shot.motion, picture.pixels, picture.view, shot.pose, carried=shot.carried)


def recorded(nao: RecordedNao) -> Iterator[WalkFrame]:
    """Yield the pictures of the bottom camera in a recording of a real robot, whose camera is not calibrated.

    The drive begins at the first picture. Raise a ValueError if there is none, or a picture cannot be read.
    """
    at_home, first = nao.field.pose.inverse() @ nao.start, True
    try:
        for motions, picture in nao.play():
            *earlier, motion = motions if motions and not first else (None,)
            pose, first = at_home @ nao.odometry, False
            yield WalkFrame(
                motion,
                picture.pixels,
                picture.view,
                pose,
                calibrated=False,
                known=False,
                earlier=tuple(earlier),
            )
    except RobotError as error:
        raise ValueError(str(error)) from error
    if first:
        raise ValueError(f"the recording {nao.folder} has no picture of the bottom camera")


def route(
    seed: int,
    walk: Path | None = None,
    field: Path | None = None,
    recording: Path | None = None,
    kidnap: bool = False,
) -> tuple[Iterator[WalkFrame], int | None, Field]:
    """Return the pictures of a drive or walk, their number if it is known, and the field.

    `walk`, a folder with ``amsterdam_2013`` or of the walk itself, or the folder of a `recording`, replaces the
    simulated drive by real pictures. `field` is a file for `Field.from_toml`, by default the half field of 2012. With
    `kidnap`, the simulated robot is carried away half way. Raise a ValueError if these exclude each other, or if the
    recording or the field is not valid.
    """
    if kidnap and (walk or recording):
        raise ValueError("--kidnap carries the simulated robot away: leave out --walk and --recording")
    if recording is not None:
        if walk is not None:
            raise ValueError("--recording and --walk are two different drives: give one of them")
        on = Field(2012) if field is None else Field.from_toml(field)
        try:
            nao = RecordedNao(recording, on)
        except RobotError as error:
            raise ValueError(str(error)) from error
        return recorded(nao), None, nao.field
    if walk is None:
        own = Field(2012) if field is None else Field.from_toml(field)
        inside(own)
        return simulated(seed, MOVES, own, kidnap), (MOVES + 1) * len(YAWS), own
    if field is not None:
        raise ValueError("--field is for simulated drives; the real walk was recorded on a field of 2012")
    itself = (walk / "annotations.json").is_file()
    pictures = read_pictures("straightwalk", walk.resolve().parents[1] if itself else walk)
    return real_walk(pictures, seed), len(pictures), Field(2012, half=False)


class Detections(NamedTuple):
    """The feet of posts (P, 2), px, and the lines (N, 4) of a picture, px without lens distortion."""

    posts: FloatArray
    lines: FloatArray


class Seen(NamedTuple):
    """A picture with its observation, and the time in seconds from its pixels to the observation."""

    frame: WalkFrame
    observation: Observation
    seconds: float


def see(
    functions: Functions,
    pixels: npt.NDArray[np.uint8],
    view: CameraView,
    farthest: float = FARTHEST,
    joint: bool = False,
    rules: FieldDimensions = RULES,
) -> Observation:
    """Make an observation from a picture with the student's functions and the library's detection of lines.

    The picture is RGB (H, W, 3); measurements beyond the range `farthest`, m, are not used. With `joint`, the
    observation is a `Scene`, which also has the lines and the centre circle for a `JointUpdate`.
    """
    found = detect(functions, pixels, view, rules)
    return _measure(functions, found, view, rules, farthest, joint=joint)


def see_all(
    functions: Functions,
    frames: Iterable[WalkFrame],
    calibration: CameraCalibration | None = None,
    joint: bool = False,
    rules: FieldDimensions = RULES,
) -> Iterator[Seen]:
    """Yield the observations of pictures in their order, and calibrate the camera on the way where that is needed.

    The first pictures of a camera that is not calibrated are held back. They are measured when the calibration is
    certain enough, or when there is no further picture. `calibration` is updated; `joint` is as in `see`.
    """
    calibration = calibration or CameraCalibration()
    waiting: list[tuple[WalkFrame, Detections, float]] = []
    for frame in frames:
        began = time.perf_counter()
        view = frame.view if frame.calibrated else calibration.reading_view(frame.view)
        found = detect(functions, frame.pixels, view, rules)
        if not frame.calibrated:
            calibration.update(found.lines, found.posts, frame.view)
        waiting.append((frame, found, time.perf_counter() - began))
        if frame.calibrated or calibration.is_certain:
            yield from (_measured(functions, *each, calibration, joint, rules) for each in waiting)
            waiting = []
    yield from (_measured(functions, *each, calibration, joint, rules) for each in waiting)


def detect(
    functions: Functions, pixels: npt.NDArray[np.uint8], view: CameraView, rules: FieldDimensions = RULES
) -> Detections:
    """Find the posts of a picture with the student's functions, if the field has any, and the lines; see `see`."""
    lines = read_lines(pixels, view, rules.line_width)
    if rules.goal_colour == "none":
        return Detections(np.empty((0, 2)), lines)
    white = functions["white_threshold"](mean_lightness(pixels))
    labels = functions["color_labels"](pixels, GREEN, YELLOW, white)
    if rules.goal_colour == "white":
        labels = as_goal_colour(labels, view, rules)
    return Detections(functions["find_goalposts"](labels), lines)


def _measured(
    functions: Functions,
    frame: WalkFrame,
    found: Detections,
    seconds: float,
    calibration: CameraCalibration,
    joint: bool,
    rules: FieldDimensions,
) -> Seen:
    """Measure what was detected in a picture after `seconds`, with the present calibration."""
    began, view = time.perf_counter(), frame.view
    prior: npt.ArrayLike = TILT_SIGMAS
    if not frame.calibrated:
        view, prior = calibration.corrected(view), calibration.tilt_covariance(view)
    seen = _measure(functions, found, view, rules, frame.farthest, prior, joint)
    return Seen(frame, seen, seconds + time.perf_counter() - began)


def _measure(
    functions: Functions,
    found: Detections,
    view: CameraView,
    rules: FieldDimensions,
    farthest: float,
    prior: npt.ArrayLike = TILT_SIGMAS,
    joint: bool = False,
) -> Observation:
    tilt = estimate_body_tilt(found.lines, view, prior)
    level = tilted(view, tilt.pitch, tilt.roll)
    corners = corners_of_lines(found.lines, level)
    measured = functions["measurements_from_pixels"](found.posts, corners, level)
    near = [each for each in measured if each.range < farthest]
    compass = tilt.direction, tilt.direction_sigma
    corner_sigma = JOINT_CORNER_SIGMA if joint else CORNER_SIGMA
    seen = observation(near, tilt.covariance[:2, :2], corner_sigma, *compass, POST_SIGMA)
    if not joint:
        return seen
    return scene(seen, tilt, found.lines, level, rules.circle_diameter / 2)


def demo_functions(slam: Sequence[str], notebooks: Path) -> Functions:
    """Load the functions that the demo uses from the notebooks of a folder, the student's or the solutions.

    Raise a ValueError that names the functions that are missing or fail their public checks, and says what to do.
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


def run_demo(
    functions: Functions,
    frames: Iterable[WalkFrame],
    slam: Sequence[str],
    joint: bool = False,
    rules: FieldDimensions = RULES,
    area: Area | None = None,
) -> Story:
    """Run the algorithms, independently of each other, over the pictures of a drive.

    With `joint`, the EKF also uses the lines and the centre circle, and keeps several hypotheses: the student's filter
    in a `JointUpdate` and `MultipleHypotheses`. With the `area` in which the robot can be, m, `KidnapRecovery` replaces
    the hypotheses.
    """
    story = Story(estimates={name: [] for name in slam}, slam={name: [] for name in slam})
    algorithms: dict[str, SlamAlgorithm] = {}
    joint = joint or area is not None
    for stop in _stops(see_all(functions, frames, story.calibration, joint, rules)):
        first = stop[0].frame
        motions = (*first.earlier, *([first.motion] if first.motion else []))
        if not algorithms:
            algorithms = {name: _algorithm(functions, name, first.pose, joint, area) for name in slam}
        last = story.odometry[-1] if story.odometry else first.pose
        for motion in motions:
            last = last @ motion.as_pose()
        story.odometry += [last] * len(stop)
        story.frames += [each.frame for each in stop]
        story.seen += [each.observation for each in stop]
        story.vision += [each.seconds for each in stop]
        for name, algorithm in algorithms.items():
            began = time.perf_counter()
            for motion in motions:
                algorithm.move(motion)
            for each in stop:
                algorithm.observe(each.observation)
            story.estimates[name] += [algorithm.estimate()] * len(stop)
            story.slam[name] += [(time.perf_counter() - began) / len(stop)] * len(stop)
        ekf = algorithms.get("ekf")
        noticed, lost = (ekf.kidnappings, ekf.lost) if isinstance(ekf, KidnapRecovery) else (0, False)
        story.noticed += [noticed] * len(stop)
        story.lost += [lost] * len(stop)
    return story


def _algorithm(functions: Functions, name: str, start: Pose, joint: bool, area: Area | None) -> SlamAlgorithm:
    kind = functions[ALGORITHMS[name].partition(":")[2]]
    inner = kind(start, OdometryNoisePerMove(), GATE, associate_jointly)
    if area is not None and name == "ekf":
        return KidnapRecovery(JointUpdate(inner), area)
    return SurestFirst(MultipleHypotheses(JointUpdate(inner)) if joint and name == "ekf" else inner)


def _stops(pictures: Iterable[Seen]) -> Iterator[list[Seen]]:
    """Yield the pictures between two motions as one list."""
    stop: list[Seen] = []
    for picture in pictures:
        if stop and picture.frame.motion is not None:
            yield stop
            stop = []
        stop.append(picture)
    if stop:
        yield stop
