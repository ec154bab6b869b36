"""The student's functions, run stage by stage on each camera picture while the robot drives.

A lesson adds one `Stage`. The control panel runs every stage that is ready on the picture of the chosen camera. It
draws the stages' results over the picture and their points on the map. An error in a stage never stops the drive.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

import cv2
import numpy as np
import numpy.typing as npt

from nao_course._internal.time_limits import TooSlow
from nao_course.exercises.lesson_names import number_of
from nao_course.geometry import FloatArray, as_points
from nao_course.robot import Robot
from nao_course.sim import Picture
from nao_course.slam import Estimate, Motion
from nao_course.widgets.attempts import KEPT_LETTERS, StudentCode, attempt

Pixels = npt.NDArray[np.uint8]
View = Literal["picture", "over", "beside"]

VIEWS: Mapping[View, str] = MappingProxyType(
    {"picture": "View: off", "over": "View: overlay", "beside": "View: inset"}
)
PICTURE_LIMIT = (
    3.0  # s for one stage and one picture: about a hundred times as long as the labels of lesson 01
)
SLOW = 0.25  # s of processor time for one picture; the panel warns if the student's code takes longer
JUDGED = 5  # latest pictures whose median is judged: the first picture calibrates, and others may be slow
_NONE = np.empty((0, 2))
_STRENGTH = 0.6  # opacity of an image that is laid over the picture
_MARK = (255, 59, 129)


@dataclass(frozen=True)
class Overlay:
    """The result of a stage for one picture, and how the panel shows it.

    Parameters
    ----------
    result : object
        Value for later stages, which read it as ``frame.results["labels"]``.
    painted : ndarray of uint8, shape (H, W, 3), optional
        RGB image of the picture's size. The panel shows it over the picture or beside it.
    where : ndarray of bool, shape (H, W), optional
        Pixels where `painted` covers the picture; by default all.
    pixels : array_like, shape (N, 2)
        Points (u, v) to mark in the picture.
    points : array_like, shape (N, 2)
        Points in the robot frame, m (x ahead, y left), to mark on the map.
    text : str
        A summary of the result in a few words: "green 62 %, yellow 3 %".
    estimate : Estimate, optional
        Estimate of the robot's pose in world coordinates, for the map.
    motion : Motion, optional
        The next motion of the robot while it drives by itself.
    cells : array_like, shape (N, 2)
        Centres of grid cells in world coordinates, m, to mark on the map: frontiers.
    finish : str
        What is complete, if no motion is left: "The whole field is seen".

    Raises
    ------
    ValueError
        If a shape is wrong, or a point is not finite.
    """

    result: Any = None
    painted: Pixels | None = None
    where: npt.NDArray[np.bool_] | None = None
    pixels: npt.ArrayLike = field(default_factory=lambda: _NONE)
    points: npt.ArrayLike = field(default_factory=lambda: _NONE)
    text: str = ""
    estimate: Estimate | None = None
    motion: Motion | None = None
    cells: npt.ArrayLike = field(default_factory=lambda: _NONE)
    finish: str = ""

    def __post_init__(self) -> None:
        """Check that all points are finite."""
        for name in ("pixels", "points", "cells"):
            points = as_points(getattr(self, name), name=name)
            if not np.isfinite(points).all():
                raise ValueError(f"{name} must be finite numbers, got {points[~np.isfinite(points)][0]}")
            object.__setattr__(self, name, points)


@dataclass(frozen=True)
class Frame:
    """The input of a stage.

    Parameters
    ----------
    picture : Picture
        Picture of the chosen camera: its `pixels`, its estimated `view` and the name of its `camera`.
    results : mapping of str to object
        Results of the earlier stages for the same picture, by the stages' names.
    """

    picture: Picture
    results: Mapping[str, Any]


StageFunction = Callable[[Frame], Overlay]


@dataclass(frozen=True)
class Stage:
    """One step of the student's perception, which a lesson adds to the robot.

    Parameters
    ----------
    name : str
        Name of its result: "labels".
    lesson : str
        Name of the lesson, such as "01_hsl_filtering".
    uses : tuple of str
        The student's functions that it calls: exercises of this lesson, or "01:rgb_to_hsl" for an earlier lesson.
    wire : callable
        ``wire(student, nao)`` is called once. It may calibrate, and it returns the function from a `Frame` to an
        `Overlay` that is called for each picture. The student's functions are attributes of `student`:
        ``student.color_labels(...)``.
    after : tuple of str
        Names of the stages whose results it needs.
    estimates : bool
        Whether its overlays contain an estimate, which the map then shows.
    helped_by : tuple of str
        The student's functions that it calls only if they are ready: ``"measure" in student``.
    drives : bool
        Whether its overlays contain a motion, so that the robot can drive by itself.
    simulated : bool
        Whether it needs measurements of the simulator, so that it runs on no other robot.
    """

    name: str
    lesson: str
    uses: tuple[str, ...]
    wire: Callable[[StudentCode, Any], StageFunction]
    after: tuple[str, ...] = ()
    estimates: bool = False
    helped_by: tuple[str, ...] = ()
    drives: bool = False
    simulated: bool = False


@dataclass(frozen=True)
class Seen:
    """The results of all stages for one picture.

    `overlays` has the stages that succeeded by name, `complaints` a sentence on why each of the others failed. `error`
    and `printed` are the last exception of the student's code and the end of its printed text, and `seconds` is its
    processor time, the median of the latest pictures.
    """

    overlays: Mapping[str, Overlay] = field(default_factory=dict)
    complaints: tuple[str, ...] = ()
    error: BaseException | None = None
    printed: str = ""
    seconds: float = 0.0

    @property
    def points(self) -> FloatArray:
        """All points in the robot frame, (N, 2), m."""
        return np.vstack([_NONE, *(as_points(each.points) for each in self.overlays.values())])

    @property
    def cells(self) -> FloatArray:
        """All marked cells in world coordinates, (N, 2), m."""
        return np.vstack([_NONE, *(as_points(each.cells) for each in self.overlays.values())])

    @property
    def finish(self) -> str:
        """What is complete; empty if nothing is."""
        return next((each.finish for each in self.overlays.values() if each.finish), "")

    @property
    def estimate(self) -> Estimate | None:
        """The estimate of the last stage that has one; None without an estimate."""
        found = [each.estimate for each in self.overlays.values() if each.estimate is not None]
        return found[-1] if found else None

    @property
    def motion(self) -> Motion | None:
        """The next motion, given by the last stage that drives; None without a motion."""
        found = [each.motion for each in self.overlays.values() if each.motion is not None]
        return found[-1] if found else None

    @property
    def names(self) -> str:
        """Names of the stages that draw in the picture, joined by commas."""
        shown = [
            name for name, each in self.overlays.items() if each.painted is not None or np.size(each.pixels)
        ]
        return ", ".join(shown)

    def lines(self) -> list[str]:
        """Return a line of text for each stage that has a text."""
        return [f"{name}: {each.text}" for name, each in self.overlays.items() if each.text]

    @property
    def board(self) -> str:
        """The line of the stage that drives, else of the stage whose estimate the map shows; empty without both."""
        drives = [name for name, each in self.overlays.items() if each.motion is not None or each.finish]
        names = [name for name, each in self.overlays.items() if each.estimate is not None]
        name = next(iter(drives[-1:] or names[-1:]), "")
        return f"{name}: {self.overlays[name].text}" if name else ""

    def pace(self) -> list[str]:
        """Return a warning if the student's code was slow, else nothing; the run time depends on the machine."""
        slow = f"Your code takes {1000 * self.seconds:.0f} ms for a picture, which slows the drive down"
        return [slow] if self.seconds > SLOW else []

    def over(self, pixels: Pixels) -> Pixels:
        """Return a picture (H, W, 3) with all overlays drawn over it."""
        shown = pixels.copy()
        for each in self.overlays.values():
            if each.painted is not None:
                blended = cv2.addWeighted(each.painted, _STRENGTH, shown, 1 - _STRENGTH, 0.0)
                where = np.ones(shown.shape[:2], bool) if each.where is None else each.where
                shown = np.where(where[..., None], blended, shown).astype(np.uint8)
        return self.marked(shown)

    def alone(self, pixels: Pixels) -> Pixels:
        """Return the last painted overlay with all marks; without one, draw the marks on the picture in grey."""
        painted = [each.painted for each in self.overlays.values() if each.painted is not None]
        if not painted:
            painted = [np.repeat(pixels.mean(axis=2, keepdims=True), 3, axis=2).astype(np.uint8)]
        return self.marked(painted[-1])

    def marked(self, pixels: Pixels) -> Pixels:
        """Return a picture (H, W, 3) with rings around the marked pixels."""
        shown = pixels.copy()
        radius = max(4, shown.shape[1] // 60)
        for each in self.overlays.values():
            for u, v in np.round(np.clip(as_points(each.pixels), -1e4, 1e4)).astype(int).tolist():
                cv2.circle(shown, (u, v), radius + 1, (255, 255, 255), 3, cv2.LINE_AA)
                cv2.circle(shown, (u, v), radius, _MARK, 2, cv2.LINE_AA)
        return shown


class Pipeline:
    """A sequence of stages that is run on each picture; the stages' errors become messages.

    A stage that raises an exception or returns an unusable value is skipped for this picture. A stage that takes too
    long, or whose `wire` fails, is skipped until `retry` is called.

    Parameters
    ----------
    stages : sequence of Stage
        Stages in the order in which they run.
    functions : mapping of str to callable
        The student's functions by name: at least the functions that the stages use.
    nao : Robot
        The robot, for stages that calibrate.
    missing : mapping of str to str
        Why each stage that is not ready is missing, by the stage's name.
    time_limit : float
        Longest run time of one stage for one picture, seconds.
    remarks : sequence of str
        Further sentences about the functions, such as a warning.
    """

    def __init__(
        self,
        stages: Sequence[Stage],
        functions: Mapping[str, Callable[..., Any]],
        nao: Robot,
        missing: Mapping[str, str] | None = None,
        time_limit: float = PICTURE_LIMIT,
        remarks: Sequence[str] = (),
    ) -> None:
        """Store the stages; each is wired at its first picture."""
        self.stages, self.nao = tuple(stages), nao
        self.missing, self.time_limit = dict(missing or {}), time_limit
        self.remarks = tuple(remarks)
        self._student = StudentCode(functions)
        self._wired: dict[str, StageFunction] = {}
        self._skipped: dict[str, str] = {}
        self._seconds: deque[float] = deque(maxlen=JUDGED)

    @property
    def estimates(self) -> bool:
        """Whether a stage estimates the robot's pose."""
        return any(stage.estimates for stage in self.stages)

    @property
    def drives(self) -> bool:
        """Whether a stage chooses the robot's next motion."""
        return any(stage.drives for stage in self.stages)

    def retry(self) -> None:
        """Run the skipped stages again from the next picture on."""
        self._skipped.clear()

    def process(self, picture: Picture) -> Seen:
        """Run all stages on a picture.

        Returns
        -------
        Seen
            The results of all stages. KeyboardInterrupt is the only exception that is raised.
        """
        overlays: dict[str, Overlay] = {}
        complaints, printed, seconds = [], "", 0.0
        error: BaseException | None = None
        for stage in self.stages:
            if why := self._skipped.get(stage.name) or _lacks_results(stage, overlays):
                complaints.append(why)
                continue
            results = {name: each.result for name, each in overlays.items()}
            self._student.begin()
            began = time.process_time()
            tried = attempt(
                lambda stage=stage, results=results: self._run(stage, Frame(picture, results)),  # type: ignore[misc]
                lambda stage=stage: self._source_of_error(stage),  # type: ignore[misc]
                limit=self.time_limit,
                quiet=True,
            )
            printed, seconds = (
                (printed + tried.printed)[-KEPT_LETTERS:],
                seconds + time.process_time() - began,
            )
            if tried.value is not None:
                overlays[stage.name] = tried.value
                continue
            error = tried.error
            complaints.append(self._complaint(stage, tried.message, isinstance(error, TooSlow)))
        self._seconds.append(seconds)
        usual = float(np.median(self._seconds)) if len(self._seconds) == JUDGED else 0.0
        return Seen(overlays, tuple(complaints), error, printed, usual)

    def summary(self) -> list[str]:
        """Return a line that lists the stages that run, and a line for each stage that does not."""
        running = ", ".join(f"✔ {stage.name} ({number_of(stage.lesson)})" for stage in self.stages)
        return [
            f"your NAO so far: {running or 'nothing yet'}",
            *(f"not yet: {name}, because {why}" for name, why in self.missing.items()),
            *self.remarks,
        ]

    def heading(self) -> list[str]:
        """Return short lines: the stages that run, those still to come, and further remarks."""
        running = ", ".join(f"✔ {stage.name}" for stage in self.stages)
        coming = [f"Still to come: {', '.join(self.missing)}"] if self.missing else []
        return [f"Your NAO so far: {running or 'nothing yet'}", *coming, *self.remarks]

    def _run(self, stage: Stage, frame: Frame) -> Overlay:
        if stage.name not in self._wired:
            self._wired[stage.name] = stage.wire(self._student, self.nao)
        overlay = self._wired[stage.name](frame)
        shape = frame.picture.pixels.shape
        if overlay.painted is not None and overlay.painted.shape != shape:
            raise ValueError(f"shape {overlay.painted.shape[:2]} does not fit the picture's, {shape[:2]}")
        return overlay

    def _source_of_error(self, stage: Stage) -> str:
        student = self._student
        if student.running:
            return f"{student.running}()"
        return (
            f"the panel, in the code that uses the result of {student.last}()"
            if student.last
            else f"the {stage.name}"
        )

    def _complaint(self, stage: Stage, message: str, took_too_long: bool) -> str:
        if took_too_long or stage.name not in self._wired:
            message = (
                f"{message} The robot drives on without {stage.name}. Correct your code, then take a picture."
            )
            self._skipped[stage.name] = f"Without {stage.name}: {message}"
        return f"Without {stage.name}: {message}"


def _lacks_results(stage: Stage, available: Iterable[str]) -> str:
    """Return why a stage cannot run if the result of an earlier stage is missing, else an empty string."""
    missing = [name for name in stage.after if name not in available]
    return f"Without {stage.name}: it needs {' and '.join(missing)}." if missing else ""
