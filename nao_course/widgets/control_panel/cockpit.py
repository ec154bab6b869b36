"""What happens on each command to the robot: the control panel without its buttons."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

import numpy as np

from nao_course.geometry import Pose
from nao_course.plotting.drawing import say_count
from nao_course.sim import CameraView, Picture, PictureTruth, SimulatedNao, Truth
from nao_course.slam import Estimate, Measurement, Motion, SlamAlgorithm, place_estimate
from nao_course.widgets.attempts import KEPT_LETTERS, TIME_LIMIT, Attempt, attempt, complaint

Measure = Callable[[Any, CameraView], Iterable[Measurement]]

Value = TypeVar("Value")

CAMERAS = ("top", "bottom")
LIVE_SIZE = (320, 240)
STEP = 0.05  # m between two pictures of a drive
TURN_STEP = float(np.radians(5.0))  # rad between two pictures of a turn
KEPT_PICTURES = 60
LONGEST_NAME = 14  # letters in the map's legend
NOTHING: tuple[Measurement, ...] = ()


def pieces(motion: Motion) -> Iterator[Motion]:
    """Cut a motion into equal small steps: first the way, then the turn.

    Parameters
    ----------
    motion : Motion
        Metres, radians.

    Yields
    ------
    Motion
        Steps of at most `STEP` metres or `TURN_STEP` radians; together they are the motion.

    Examples
    --------
    >>> len(list(pieces(Motion(0.2, 0.0))))
    4
    """
    drives = int(np.ceil(abs(motion.distance) / STEP - 1e-9))
    turns = int(np.ceil(abs(motion.turn) / TURN_STEP - 1e-9))
    yield from (Motion(motion.distance / drives, 0.0) for _ in range(drives))
    yield from (Motion(0.0, motion.turn / turns) for _ in range(turns))


class Cockpit:
    """A robot, its pictures, its paths, and a slot for a SLAM algorithm.

    Whatever the student's code does, a command ends with a message, never with an exception.

    Parameters
    ----------
    nao : SimulatedNao
        The robot.
    truth : Truth, optional
        Of the same robot, for the map.
    slam : SlamAlgorithm, optional
        Gets every motion, and the measurements when `observe` is called.
    measure : callable, optional
        ``measure(pixels, view)`` gives a picture's measurements; by default ``nao.sense()`` does.
    start : Pose, optional
        The odometry's origin in the world; by default where the truth says, else the field frame's.
    frame : Pose, optional
        In the world, of the frame that `slam` maps in; by default `start`, as in both seeds.
    time_limit : float
        Seconds for each call of the student's code before it is stopped.

    Attributes
    ----------
    odometry, estimated : list of Pose
        Paths in the world: the commands added up; what `slam` estimated after each.
    estimate : Estimate or None
        The latest one, in the world.
    seen : tuple of Measurement
        What was measured from where the robot stands now.
    pictures : dict of str to Picture
        The latest of each camera.
    album : deque of Picture
        What `take_picture` took, the newest last.
    frames : int
        Pictures taken in all, live ones too.
    message : str
        What there is to say.
    printed : str
        The end of what the student's code printed during the latest command.
    alarm : bool
        Whether the message is a complaint.
    error : BaseException or None
        What the student's code raised last.
    """

    def __init__(
        self,
        nao: SimulatedNao,
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
        origin = truth.odometry_start if truth is not None else nao.field.pose
        self.start = origin if start is None else start
        self.frame = self.start if frame is None else frame
        self.odometry = [self.start @ nao.odometry]
        self.estimated: list[Pose] = []
        self.estimate: Estimate | None = None
        self.seen: tuple[Measurement, ...] = ()
        self.pictures: dict[str, Picture] = {}
        self.album: deque[Picture] = deque(maxlen=KEPT_PICTURES)
        self.frames = 0
        self.message = ""
        self.printed = ""
        self.alarm = False
        self.error: BaseException | None = None
        self._truths: dict[str, PictureTruth | None] = {}
        for camera in CAMERAS:
            self.photograph(camera)
        self._ask_estimate()
        if not self.alarm:
            self.say("Ready.")

    # --- commands ---

    def move(self, motion: Motion) -> bool:
        """Do one small step and tell `slam` about it.

        Returns
        -------
        bool
            Whether the student's code went along; the robot has moved in any case.
        """
        done = self.nao.walk(motion.distance) if motion.distance else self.nao.turn(motion.turn)
        self.odometry.append(self.start @ self.nao.odometry)
        self.seen = NOTHING
        if self.slam is None:
            return True
        return self._try("move", lambda: self._slam.move(done)).done and self._ask_estimate()

    def turn_head(self, yaw: float, pitch: float) -> None:
        """Turn the head by so much (rad, positive left and down), as far as its joints go."""
        wanted = np.add(self.nao.head, (yaw, pitch))
        limits = (self.nao.model.yaw_limits, self.nao.model.pitch_limits)
        reached = [float(np.clip(angle, *limit)) for angle, limit in zip(wanted, limits, strict=True)]
        self.nao.look(*reached)
        self.seen = NOTHING
        words = f"yaw {np.degrees(reached[0]):z.0f}°, pitch {np.degrees(reached[1]):z.0f}°"
        stuck = not np.allclose(wanted, reached, atol=1e-6)
        self.say(f"Head at {words}: a joint is at its limit." if stuck else f"Head at {words}.")

    def photograph(self, camera: str, size: tuple[int, int] = LIVE_SIZE) -> Picture:
        """Take a live picture: shown, counted, not kept."""
        picture = self.nao.take_picture(camera, size)
        self.pictures[camera] = picture
        self._truths[camera] = None if self.truth is None else self.truth.picture
        self.frames += 1
        return picture

    def take_picture(self, camera: str = "bottom", size: tuple[int, int] = LIVE_SIZE) -> Picture:
        """Take a picture and keep it."""
        picture = self.photograph(camera, size)
        self.album.append(picture)
        self.say(f"Picture taken: {camera} camera, {size[0]} × {size[1]}. It is panel.picture.")
        return picture

    def observe(self, camera: str = "bottom", size: tuple[int, int] = LIVE_SIZE) -> tuple[Measurement, ...]:
        """Measure what a camera sees and give it to `slam`.

        Returns
        -------
        tuple of Measurement
            What was measured; empty if the student's code failed.
        """
        self.seen, self.printed = NOTHING, ""
        seen = self._measured(camera, size)
        if seen is None:
            return ()
        self.seen = seen
        found = f"Measured {len(self.seen)} landmark" + ("" if len(self.seen) == 1 else "s")
        if self.slam is None:
            self.say(f"{found} with the {camera} camera.")
        elif self._try("observe", lambda: self._slam.observe(seen)).done and self._ask_estimate():
            known = 0 if self.estimate is None else len(self.estimate.landmarks)
            self.say(f"{found}; {type(self.slam).__name__} knows {known}.")
        return self.seen

    def picture_truth(self, camera: str) -> PictureTruth | None:
        """What a camera's latest picture really shows; None without `truth`."""
        return self._truths.get(camera)

    # --- words ---

    def say(self, message: str) -> None:
        """Say something that is no complaint."""
        self.message, self.alarm = message, False

    def complain(self, what: str, error: Exception) -> None:
        """Say what went wrong, and where."""
        self.error, self.alarm = error, True
        self.message = complaint(what, error)

    def names(self, source: str, believed: bool) -> dict[str, str]:
        """What each path on the map is called, by its source; `believed`: your code estimates."""
        names = {"truth": "truth"} if self.truth is not None else {}
        names["odometry"] = "odometry"
        if self.slam is not None:
            name = type(self.slam).__name__
            names[source] = name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"
        elif believed:
            names[source] = "your estimate"
        return names

    def facts(self, show_truth: bool = False) -> list[str]:
        """Return where the robot is and what it has seen, in short; the truth only if asked for."""
        yaw, pitch = np.degrees(self.nao.head)
        facts = [f"odometry {_place(self.odometry[-1])}"]
        if show_truth and self.truth is not None:
            facts.append(f"truth {_place(self.truth.pose)}")
        if self.slam is not None:
            facts.append(f"{type(self.slam).__name__} {_knows(self.estimate)}")
        facts.append(f"head yaw {yaw:z.0f}°, pitch {pitch:z.0f}°")
        facts.append(f"{say_count(len(self.album), 'picture') if self.album else 'no picture'} kept")
        return facts

    def summary(self, show_truth: bool = False) -> str:
        """Return the facts and what was said last, a line each."""
        return "\n".join([self.nao.model.name, *self.facts(show_truth), f"status: {self.message}"])

    # --- the student's code, at arm's length ---

    @property
    def _slam(self) -> SlamAlgorithm:
        assert self.slam is not None
        return self.slam

    def _measured(self, camera: str, size: tuple[int, int]) -> tuple[Measurement, ...] | None:
        """What a camera sees from here; None if the student's code failed."""
        measure = self.measure
        if measure is None:
            return self.nao.sense(camera)
        picture = self.photograph(camera, size)
        return self._try("measure", lambda: _checked(measure(picture.pixels.copy(), picture.view))).value

    def _ask_estimate(self) -> bool:
        if self.slam is None:
            return True
        placed = self._try("estimate", self._placed_estimate).value
        if placed is None:
            return False
        self.estimate = placed
        self.estimated.append(placed.pose)
        return True

    def _placed_estimate(self) -> Estimate:
        believed = self._slam.estimate()
        if not isinstance(believed, Estimate):
            raise TypeError(f"it must return an Estimate, got {type(believed).__name__}")
        return place_estimate(believed, self.frame)

    def _try(self, what: str, call: Callable[[], Value]) -> Attempt[Value]:
        """Run a student's code; what goes wrong becomes the message."""
        tried = attempt(call, f"{what}()", limit=self.time_limit)
        self.printed = (self.printed + tried.printed)[-KEPT_LETTERS:]
        if not tried.done:
            self.error, self.alarm, self.message = tried.error, True, tried.message
        return tried


def _checked(found: object) -> tuple[Measurement, ...]:
    """What a student's `measure` returned, if it is what it must be."""
    if isinstance(found, Measurement) or not isinstance(found, Iterable):
        raise TypeError(f"it must return a list of Measurement, got {type(found).__name__}")
    seen = tuple(found)
    for each in seen:
        if not isinstance(each, Measurement):
            raise TypeError(f"its list must hold Measurement only, got {type(each).__name__}")
    return seen


def _place(pose: Pose) -> str:
    return f"({pose.x:z.2f}, {pose.y:z.2f}) m, heading {np.degrees(pose.theta):z.0f}°"


def _knows(estimate: Estimate | None) -> str:
    return (
        "no estimate" if estimate is None else f"{_place(estimate.pose)}, {len(estimate.landmarks)} landmarks"
    )


def _check_parts(nao: object, truth: object, slam: object, measure: object) -> None:
    """Refuse what cannot work, in words."""
    if not hasattr(nao, "take_picture"):
        raise ValueError(f"nao must be a SimulatedNao, got {type(nao).__name__}")
    if truth is not None and not isinstance(truth, Truth):
        raise ValueError(f"truth must be Truth(nao) or None, got {truth!r}")
    if isinstance(slam, type):
        raise ValueError(f"slam must be an algorithm, not its class: write {slam.__name__}(...)")
    if slam is not None and not all(
        callable(getattr(slam, name, None)) for name in ("move", "observe", "estimate")
    ):
        raise ValueError(
            f"slam must have move, observe and estimate, such as a SlamAlgorithm; got {type(slam).__name__}"
        )
    if measure is not None and not callable(measure):
        raise ValueError(f"measure must be a function measure(pixels, view), got {type(measure).__name__}")
