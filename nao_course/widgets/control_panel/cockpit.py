"""The commands of the control panel and their effects, without its buttons."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.geometry import Pose
from nao_course.robot import PlacedNao, RealNao, RecordedNao, Robot, RobotError
from nao_course.sim import CameraView, Picture, PictureTruth, SimulatedNao, Truth
from nao_course.slam import DeadReckoning, Estimate, Measurement, Motion, SlamAlgorithm, place_estimate
from nao_course.widgets.attempts import KEPT_LETTERS, TIME_LIMIT, Attempt, attempt, complaint

Measure = Callable[[Any, CameraView], Iterable[Measurement]]

Value = TypeVar("Value")

CAMERAS = ("top", "bottom")
LIVE_SIZE = (320, 240)
STEP = 0.05  # m between two pictures of a drive
TURN_STEP = float(np.radians(5.0))  # rad between two pictures of a turn
EDGE = 0.001  # m: a step may end so far outside of the carpet, because rounding must not stop a walk along its edge
KEPT_PICTURES = 60
LONGEST_NAME = 14  # letters in the map's legend
NOTHING: tuple[Measurement, ...] = ()


def small_steps(motion: Motion) -> Iterator[Motion]:
    """Divide a motion into equal steps of at most `STEP` metres, then of at most `TURN_STEP` radians.

    >>> len(list(small_steps(Motion(0.2, 0.0))))
    4
    """
    drives = int(np.ceil(abs(motion.distance) / STEP - 1e-9))
    turns = int(np.ceil(abs(motion.turn) / TURN_STEP - 1e-9))
    yield from (Motion(motion.distance / drives, 0.0) for _ in range(drives))
    yield from (Motion(0.0, motion.turn / turns) for _ in range(turns))


class Cockpit:
    """A robot with its pictures and paths and, optionally, a SLAM algorithm.

    `slam` is given every motion, and the measurements of each call of `observe`: ``measure(pixels, view)``, by default
    ``nao.sense()``. `start` is the odometry's origin in the world, by default the true start, without `truth` where a
    real robot was put, else the field frame's origin; `frame`, by default `start`, is the pose in the world of the
    frame that `slam` maps in. The paths and the estimate are in world coordinates, and `walked` is their commanded
    length, m. `measured` is the pose that a person has measured where the robot stands, until it moves. `outdated` are
    the cameras whose latest picture is older than the latest motion. An error in the student's code, which is stopped
    after `time_limit` seconds, becomes a message; a command never raises it.
    """

    def __init__(
        self,
        nao: Robot,
        truth: Truth | None = None,
        slam: SlamAlgorithm | None = None,
        measure: Measure | None = None,
        start: Pose | None = None,
        frame: Pose | None = None,
        time_limit: float = TIME_LIMIT,
    ) -> None:
        """Take the first picture with each camera."""
        _check_parts(nao, truth, slam, measure)
        self.nao, self.truth, self.slam, self.measure = nao, truth, slam, measure
        self.time_limit = time_limit
        origin = nao.start if isinstance(nao, PlacedNao) else nao.field.pose
        origin = origin if truth is None else truth.odometry_start
        self.start = origin if start is None else start
        self.frame = self.start if frame is None else frame
        self.odometry = [self.start @ nao.odometry]
        self.estimated: list[Pose] = []
        self.estimate: Estimate | None = None
        self.seen: tuple[Measurement, ...] = ()
        self.pictures: dict[str, Picture] = {}
        self.album: deque[Picture] = deque(maxlen=KEPT_PICTURES)
        self.outdated: set[str] = set()
        self.frames = self.moves = 0
        self.walked = 0.0
        self.message = ""
        self.printed = ""
        self.alarm = False
        self.error: BaseException | None = None
        self.head = nao.head
        self._measured_at: tuple[Pose, Pose] | None = None  # the pose, and the odometry there
        self._truths: dict[str, PictureTruth | None] = {}
        for camera in CAMERAS:
            self.photograph(camera)
        self._update_estimate()
        if not self.alarm:
            warnings = nao.warnings() if isinstance(nao, PlacedNao) else ()
            self.say(" ".join(["Ready.", *map(_sentence, warnings)]))

    # --- commands ---

    def step(self, motion: Motion) -> Motion:
        """Move the robot by one small step and return it; a real robot takes its time, so a thread may run this."""
        return self.nao.walk(motion.distance) if motion.distance else self.nao.turn(motion.turn)

    def note(self, done: Motion) -> bool:
        """Note a step that was run, pass it to `slam`, and return whether the student's code succeeded."""
        self.walked += abs(done.distance)
        self.odometry.append(self.start @ self.nao.odometry)
        self.seen, self.outdated = NOTHING, set(CAMERAS)
        if self.slam is None:
            return True
        return self._try("move", lambda: self._slam.move(done)).done and self._update_estimate()

    @property
    def measured(self) -> Pose | None:
        """Pose that a person has measured; None if the robot has moved since."""
        pose, odometry = self._measured_at or (None, None)
        return pose if odometry == self.nao.odometry else None

    @measured.setter
    def measured(self, pose: Pose) -> None:
        self._measured_at = pose, self.nao.odometry

    def is_blocked(self, motion: Motion) -> bool:
        """Return whether the carpet ends before the end of a step: a simulated robot would walk on the spot."""
        if not isinstance(self.nao, SimulatedNao):
            return False
        field, goal = self.nao.field, Truth(self.nao).pose @ Pose(motion.distance)
        x0, y0, x1, y1 = field.carpet
        x, y = field.pose.to_local([goal.x, goal.y])[0]
        outside = max(x0 - x, x - x1, y0 - y, y - y1)
        return bool(motion.distance) and outside > EDGE

    def turn_head(self, yaw: float, pitch: float) -> None:
        """Turn the head by `yaw` and `pitch` (rad, positive left and down), within its joint limits."""
        target = np.add(self.nao.head, (yaw, pitch))
        limits = (self.nao.model.yaw_limits, self.nao.model.pitch_limits)
        reached = [float(np.clip(angle, *limit)) for angle, limit in zip(target, limits, strict=True)]
        self.nao.look(*reached)
        self.head = reached[0], reached[1]
        self.seen, self.outdated = NOTHING, set(CAMERAS)
        words = f"yaw {np.degrees(reached[0]):z.0f}°, pitch {np.degrees(reached[1]):z.0f}°"
        limited = not np.allclose(target, reached, atol=1e-6)
        self.say(f"Head at {words}: a joint is at its limit." if limited else f"Head at {words}.")

    def photograph(self, camera: str, size: tuple[int, int] = LIVE_SIZE) -> Picture:
        """Take a live picture, which is shown and counted but not kept; it is black before a recording's first."""
        nao = self.nao
        if isinstance(nao, RecordedNao) and not nao.has_picture(camera):
            picture = Picture(np.zeros((*LIVE_SIZE[::-1], 3), np.uint8), nao.view(camera), camera)
        else:
            picture = nao.take_picture(camera, size)
        self.pictures[camera], self.head = picture, nao.head
        self._truths[camera] = None if self.truth is None else self.truth.picture
        self.outdated.discard(camera)
        self.frames += 1
        return picture

    def glance(self, camera: str) -> None:
        """Take a live picture if the robot has moved since the last one, without an effect on its later motions."""
        if camera in self.outdated:
            seed = len(self.nao.odometry_path), CAMERAS.index(camera)
            with self.nao.aside(np.random.default_rng(seed)):
                self.photograph(camera)

    def take_picture(self, camera: str = "bottom", size: tuple[int, int] = LIVE_SIZE) -> Picture:
        """Take a picture and keep it in the album."""
        picture = self.photograph(camera, size)
        self.album.append(picture)
        self.say(f"Picture taken: {camera} camera, {size[0]} × {size[1]}. It is panel.picture.")
        return picture

    def record(self) -> None:
        """Begin a recording of a real robot's drive in a new folder, or end it."""
        assert isinstance(self.nao, RealNao)
        if self.nao.recorder is None:
            folder = Path("recordings", time.strftime("%Y-%m-%d_%H-%M-%S"))
            self.nao.record(folder)
            for camera in CAMERAS:
                self.photograph(camera)
            self.say(f"Recording into {folder}.")
        else:
            folder = self.nao.recorder.folder
            self.nao.record(None)
            self.say(f'Recorded: RecordedNao("{folder.as_posix()}") plays it.')

    def observe(self, camera: str = "bottom", size: tuple[int, int] = LIVE_SIZE) -> tuple[Measurement, ...]:
        """Measure what a camera sees, pass it to `slam` and return it; nothing if the student's code failed."""
        self.seen, self.printed = NOTHING, ""
        seen = self._measured(camera, size)
        if seen is None:
            return ()
        self.seen = seen
        found = f"Measured {say_count(len(self.seen), 'landmark')} with the {camera} camera"
        if self.slam is None:
            self.say(f"{found}.")
        elif self._try("observe", lambda: self._slam.observe(seen)).done and self._update_estimate():
            mapped = 0 if self.estimate is None else len(self.estimate.landmarks)
            self.say(f"{found}; the map of {self._slam_name} contains {mapped}.")
        return self.seen

    def picture_truth(self, camera: str) -> PictureTruth | None:
        """Return the true contents of a camera's latest picture; None without `truth`."""
        return self._truths.get(camera)

    # --- words ---

    def say(self, message: str) -> None:
        """Show a message that does not report an error."""
        self.message, self.alarm = message, False

    def complain(self, what: str, error: Exception) -> None:
        """Show an error: the code that raised it and its message."""
        self.error, self.alarm = error, True
        self.message = _sentence(str(error)) if isinstance(error, RobotError) else complaint(what, error)

    def names(self, source: str, pipeline_estimates: bool) -> dict[str, str]:
        """Return the legend's name of each path on the map, by its source."""
        names = {"truth": "truth"} if self.truth is not None else {}
        if type(self.slam) is not DeadReckoning:  # whose path is the odometry's
            names["odometry"] = "odometry"
        if self.slam is not None:
            name = self._slam_name
            names[source] = name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"
        elif pipeline_estimates:
            names[source] = "your estimate"
        return names

    def facts(self, show_truth: bool = False) -> list[str]:
        """Return short facts about the poses, the map and the pictures; the true pose only with `show_truth`."""
        yaw, pitch = np.degrees(self.head)
        facts = [f"odometry {_place(self.odometry[-1])}"]
        if show_truth and self.truth is not None:
            facts.append(f"truth {_place(self.truth.pose)}")
        if self.slam is not None:
            facts.append(f"{self._slam_name} {_described(self.estimate)}")
        facts.append(f"head yaw {yaw:z.0f}°, pitch {pitch:z.0f}°")
        facts.append(f"{say_count(len(self.album), 'picture') if self.album else 'no picture'} kept")
        return facts

    def summary(self, show_truth: bool = False) -> str:
        """Return the facts and the latest message, one per line."""
        return "\n".join([self.nao.model.name, *self.facts(show_truth), f"status: {self.message}"])

    # --- calls of the student's code, whose errors become messages ---

    @property
    def _slam(self) -> SlamAlgorithm:
        assert self.slam is not None
        return self.slam

    @property
    def _slam_name(self) -> str:
        """Name of the algorithm for the reader of the page."""
        return "odometry alone" if type(self.slam) is DeadReckoning else type(self.slam).__name__

    def _measured(self, camera: str, size: tuple[int, int]) -> tuple[Measurement, ...] | None:
        """Return a camera's measurements from the present pose; None if the student's code failed."""
        measure, nao = self.measure, self.nao
        if measure is None and isinstance(nao, SimulatedNao):
            # Equal random numbers: the body tilts as in the picture, which the page then shows.
            seed = self.frames
            with nao.aside(np.random.default_rng(seed)):
                self.photograph(camera, size)
            with nao.aside(np.random.default_rng(seed)):
                return nao.sense(camera)
        if measure is None:
            self.say("Only a simulated robot measures by itself: make the panel with a function measure.")
            return None
        picture = self.photograph(camera, size)
        return self._try("measure", lambda: _checked(measure(picture.pixels.copy(), picture.view))).value

    def _update_estimate(self) -> bool:
        if self.slam is None:
            return True
        placed = self._try("estimate", self._placed_estimate).value
        if placed is None:
            return False
        self.estimate = placed
        self.estimated.append(placed.pose)
        return True

    def _placed_estimate(self) -> Estimate:
        estimate = self._slam.estimate()
        if not isinstance(estimate, Estimate):
            raise TypeError(f"it must return an Estimate, got {type(estimate).__name__}")
        return place_estimate(estimate, self.frame)

    def _try(self, what: str, call: Callable[[], Value]) -> Attempt[Value]:
        """Call the student's code; an error becomes the message."""
        tried = attempt(call, f"{what}()", limit=self.time_limit)
        self.printed = (self.printed + tried.printed)[-KEPT_LETTERS:]
        if not tried.done:
            self.error, self.alarm, self.message = tried.error, True, tried.message
        return tried


def _checked(found: object) -> tuple[Measurement, ...]:
    """Return the result of a student's `measure` as a tuple; raise TypeError if it is not a list of Measurement."""
    if isinstance(found, Measurement) or not isinstance(found, Iterable):
        raise TypeError(f"it must return a list of Measurement, got {type(found).__name__}")
    seen = tuple(found)
    for each in seen:
        if not isinstance(each, Measurement):
            raise TypeError(f"its list must contain only Measurement, got {type(each).__name__}")
    return seen


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}{'' if words[-1:] in '.?!' else '.'}"


def _place(pose: Pose) -> str:
    return f"({pose.x:z.2f}, {pose.y:z.2f}) m, heading {np.degrees(pose.theta):z.0f}°"


def _described(estimate: Estimate | None) -> str:
    return (
        "no estimate" if estimate is None else f"{_place(estimate.pose)}, {len(estimate.landmarks)} landmarks"
    )


def _check_parts(nao: object, truth: object, slam: object, measure: object) -> None:
    """Raise ValueError if an argument has the wrong type."""
    if not isinstance(nao, Robot):
        raise ValueError(f"nao must be a robot, such as SimulatedNao(), got {type(nao).__name__}")
    if truth is not None and not isinstance(truth, Truth):
        raise ValueError(f"truth must be Truth(nao) or None, got {truth!r}")
    if isinstance(slam, type):
        raise ValueError(
            f"slam must be an instance of {slam.__name__}, got the class: write {slam.__name__}(...)"
        )
    if slam is not None and not all(
        callable(getattr(slam, name, None)) for name in ("move", "observe", "estimate")
    ):
        raise ValueError(
            f"slam must have move, observe and estimate, such as a SlamAlgorithm; got {type(slam).__name__}"
        )
    if measure is not None and not callable(measure):
        raise ValueError(f"measure must be a function measure(pixels, view), got {type(measure).__name__}")
