"""The student's vision, stage by stage: what their own functions make of each camera picture while the robot drives.

A lesson adds one `Stage`. The control panel runs all stages that are ready on the chosen camera's picture, lays what
they paint over it, and puts what they measure on the map. Whatever a stage does, the drive goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.colors import to_rgb

from nao_course.exercises.lesson_names import number_of
from nao_course.geometry import FloatArray, as_points
from nao_course.sim import Picture, SimulatedNao
from nao_course.slam import Estimate, Motion
from nao_course.time_limits import TooSlow
from nao_course.widgets.attempts import KEPT_LETTERS, StudentCode, attempt

Pixels = npt.NDArray[np.uint8]
View = Literal["picture", "over", "beside"]

VIEWS: Mapping[View, str] = MappingProxyType(
    {"picture": "View: picture", "over": "View: yours over it", "beside": "View: yours beside"}
)
PICTURE_LIMIT = 3.0  # s for one stage and one picture: some hundred times what lesson 01's labels take
SLOW = 0.1  # s a picture, from which on the panel says how long it takes
_NONE = np.empty((0, 2))
_STRENGTH = 0.6  # of what is painted over a picture
_MARK = tuple(round(255 * each) for each in to_rgb("#ff3b81"))


@dataclass(frozen=True)
class Overlay:
    """What a stage makes of a picture, and how it is shown.

    Parameters
    ----------
    result : object
        For the stages after it: ``sight.results["labels"]``.
    painted : ndarray of uint8, shape (H, W, 3), optional
        RGB, of the picture's size, to be laid over it or beside it.
    where : ndarray of bool, shape (H, W), optional
        Where it is laid over; by default everywhere.
    pixels : array_like, shape (N, 2)
        Points (u, v) to mark in the picture.
    points : array_like, shape (N, 2)
        Points in the robot frame, m (x ahead, y left), to mark on the map.
    text : str
        What came of it, in a few words: "green 62 %, yellow 3 %".
    estimate : Estimate, optional
        Where the robot is believed to be, in the world, for the map.
    motion : Motion, optional
        What the robot would do next, if it were to drive by itself.

    Raises
    ------
    ValueError
        For another shape, or a point that is not finite.
    """

    result: Any = None
    painted: Pixels | None = None
    where: npt.NDArray[np.bool_] | None = None
    pixels: npt.ArrayLike = field(default_factory=lambda: _NONE)
    points: npt.ArrayLike = field(default_factory=lambda: _NONE)
    text: str = ""
    estimate: Estimate | None = None
    motion: Motion | None = None

    def __post_init__(self) -> None:
        """Refuse points that are none."""
        for name in ("pixels", "points"):
            points = as_points(getattr(self, name), name=name)
            if not np.isfinite(points).all():
                raise ValueError(f"{name} must be finite numbers, got {points[~np.isfinite(points)][0]}")
            object.__setattr__(self, name, points)


@dataclass(frozen=True)
class Sight:
    """What a stage is given.

    Parameters
    ----------
    picture : Picture
        Of the chosen camera: its `pixels`, the `view` that the robot believes, and which `camera` it is.
    results : mapping of str to object
        What the stages before made of the same picture, by their names.
    """

    picture: Picture
    results: Mapping[str, Any]


Look = Callable[[Sight], Overlay]


@dataclass(frozen=True)
class Stage:
    """What a lesson adds to the student's robot.

    Parameters
    ----------
    name : str
        Of what it finds: "labels".
    lesson : str
        Such as "01_hsl_filtering".
    uses : tuple of str
        The student's functions that it calls: exercises of this lesson, or "01:rgb_to_hsl" of an earlier one.
    wire : callable
        ``wire(student, nao)`` is called once; it may calibrate, and returns ``look(sight) -> Overlay``, which is called
        for each picture. The student's functions are `student`'s: ``student.color_labels(...)``.
    after : tuple of str
        Names of the stages whose results it needs.
    estimates : bool
        Whether its overlays have an estimate: then the map has a place for it.
    helped_by : tuple of str
        The student's functions that it calls where they are ready, and does without where they are not:
        ``"measure" in student``.
    drives : bool
        Whether its overlays have a motion: then the panel can let the robot drive by itself.
    """

    name: str
    lesson: str
    uses: tuple[str, ...]
    wire: Callable[[StudentCode, SimulatedNao], Look]
    after: tuple[str, ...] = ()
    estimates: bool = False
    helped_by: tuple[str, ...] = ()
    drives: bool = False


@dataclass(frozen=True)
class Seen:
    """What all stages made of a picture.

    Parameters
    ----------
    overlays : mapping of str to Overlay
        By the stage's name, of those that came to their end.
    complaints : tuple of str
        Why the others did not, a sentence each.
    error : BaseException or None
        What the student's code raised last.
    printed : str
        The end of what it printed.
    seconds : float
        How long the student's code took.
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
    def estimate(self) -> Estimate | None:
        """The last stage's estimate, of those that have one."""
        found = [each.estimate for each in self.overlays.values() if each.estimate is not None]
        return found[-1] if found else None

    @property
    def motion(self) -> Motion | None:
        """What the last stage that drives would do next."""
        found = [each.motion for each in self.overlays.values() if each.motion is not None]
        return found[-1] if found else None

    @property
    def names(self) -> str:
        """Names of the stages that show something in the picture."""
        shown = [
            name for name, each in self.overlays.items() if each.painted is not None or np.size(each.pixels)
        ]
        return ", ".join(shown)

    def lines(self) -> list[str]:
        """What came of each stage, in words."""
        return [f"{name}: {each.text}" for name, each in self.overlays.items() if each.text]

    @property
    def board(self) -> str:
        """The line of the stage whose estimate the map shows; empty without one."""
        names = [name for name, each in self.overlays.items() if each.estimate is not None]
        return f"{names[-1]}: {self.overlays[names[-1]].text}" if names else ""

    def pace(self) -> list[str]:
        """How long it took, where that is long; it differs from machine to machine, and from time to time."""
        slow = f"your code took {1000 * self.seconds:.0f} ms for this picture: the drive follows slowly"
        return [slow] if self.seconds > SLOW else []

    def over(self, pixels: Pixels) -> Pixels:
        """Lay everything over a picture (H, W, 3)."""
        shown = pixels.copy()
        for each in self.overlays.values():
            if each.painted is not None:
                blended = cv2.addWeighted(each.painted, _STRENGTH, shown, 1 - _STRENGTH, 0.0)
                where = np.ones(shown.shape[:2], bool) if each.where is None else each.where
                shown = np.where(where[..., None], blended, shown).astype(np.uint8)
        return self._marked(shown)

    def alone(self, pixels: Pixels) -> Pixels:
        """What is painted, without the picture (H, W, 3) under it; marks on the picture in grey where nothing is."""
        painted = [each.painted for each in self.overlays.values() if each.painted is not None]
        grey = np.repeat(pixels.mean(axis=2, keepdims=True), 3, axis=2).astype(np.uint8)
        return self._marked((painted[-1] if painted else grey).copy())

    def _marked(self, shown: Pixels) -> Pixels:
        radius = max(4, shown.shape[1] // 60)
        for each in self.overlays.values():
            for u, v in np.round(np.clip(as_points(each.pixels), -1e4, 1e4)).astype(int).tolist():
                cv2.circle(shown, (u, v), radius + 1, (255, 255, 255), 3, cv2.LINE_AA)
                cv2.circle(shown, (u, v), radius, _MARK, 2, cv2.LINE_AA)
        return shown


class Pipeline:
    """Runs stages on pictures, each at arm's length.

    A stage that raises or returns nonsense is left out for this picture. One that takes too long, or cannot be wired,
    is left out until `wake` is called.

    Parameters
    ----------
    stages : sequence of Stage
        In the order in which they run.
    functions : mapping of str to callable
        The student's, by name: at least those that the stages use.
    nao : SimulatedNao
        The robot, for stages that calibrate.
    missing : mapping of str to str
        Stages that are not ready, and why, in a sentence.
    time_limit : float
        Seconds for one stage and one picture.
    remarks : sequence of str
        What else is to be known of the functions, a sentence each.
    """

    def __init__(
        self,
        stages: Sequence[Stage],
        functions: Mapping[str, Callable[..., Any]],
        nao: SimulatedNao,
        missing: Mapping[str, str] | None = None,
        time_limit: float = PICTURE_LIMIT,
        remarks: Sequence[str] = (),
    ) -> None:
        """Begin with nothing wired."""
        self.stages, self.nao = tuple(stages), nao
        self.missing, self.time_limit = dict(missing or {}), time_limit
        self.remarks = tuple(remarks)
        self._student = StudentCode(functions)
        self._looks: dict[str, Look] = {}
        self._left_out: dict[str, str] = {}

    @property
    def estimates(self) -> bool:
        """Whether a stage says where the robot is."""
        return any(stage.estimates for stage in self.stages)

    @property
    def drives(self) -> bool:
        """Whether a stage says what the robot would do next."""
        return any(stage.drives for stage in self.stages)

    def wake(self) -> None:
        """Try stages again that were left out."""
        self._left_out.clear()

    def look(self, picture: Picture) -> Seen:
        """Run all stages on a picture.

        Returns
        -------
        Seen
            What came of it; nothing is raised but KeyboardInterrupt.
        """
        overlays: dict[str, Overlay] = {}
        complaints, printed, seconds = [], "", 0.0
        error: BaseException | None = None
        for stage in self.stages:
            if why := self._left_out.get(stage.name) or _not_before(stage, overlays):
                complaints.append(why)
                continue
            results = {name: each.result for name, each in overlays.items()}
            self._student.begin()
            tried = attempt(
                lambda stage=stage, results=results: self._run(stage, Sight(picture, results)),  # type: ignore[misc]
                lambda stage=stage: self._whose(stage),  # type: ignore[misc]
                limit=self.time_limit,
                quiet=True,
            )
            printed, seconds = (printed + tried.printed)[-KEPT_LETTERS:], seconds + self._student.seconds
            if tried.value is not None:
                overlays[stage.name] = tried.value
                continue
            error = tried.error
            complaints.append(self._complaint(stage, tried.message, isinstance(error, TooSlow)))
        return Seen(overlays, tuple(complaints), error, printed, seconds)

    def summary(self) -> list[str]:
        """Say which stages run and which do not, a line each."""
        running = ", ".join(f"✔ {stage.name} ({number_of(stage.lesson)})" for stage in self.stages)
        return [
            f"your NAO so far: {running or 'nothing yet'}",
            *(f"not yet: {name}, for {why}" for name, why in self.missing.items()),
            *self.remarks,
        ]

    def _run(self, stage: Stage, sight: Sight) -> Overlay:
        if stage.name not in self._looks:
            self._looks[stage.name] = stage.wire(self._student, self.nao)
        overlay = self._looks[stage.name](sight)
        shape = sight.picture.pixels.shape
        if overlay.painted is not None and overlay.painted.shape != shape:
            raise ValueError(f"shape {overlay.painted.shape[:2]} does not fit the picture's, {shape[:2]}")
        return overlay

    def _whose(self, stage: Stage) -> str:
        student = self._student
        if student.running:
            return f"{student.running}()"
        return (
            f"the panel, which uses what {student.last}() returned" if student.last else f"the {stage.name}"
        )

    def _complaint(self, stage: Stage, message: str, took_too_long: bool) -> str:
        if took_too_long or stage.name not in self._looks:
            message = f"{message} Mend it and press V: until then the drive goes on without {stage.name}."
            self._left_out[stage.name] = f"Without {stage.name}: {message}"
        return f"Without {stage.name}: {message}"


def _not_before(stage: Stage, there: Iterable[str]) -> str:
    """Why a stage cannot run, where one that it needs did not."""
    lacking = [name for name in stage.after if name not in there]
    return f"Without {stage.name}: {' and '.join(lacking)} would come first." if lacking else ""
