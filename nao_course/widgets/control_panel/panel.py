"""The control panel: the graphical user interface of Aliyev et al. 2014, section 3.1, in a notebook."""

from __future__ import annotations

import html
from collections.abc import Callable
from functools import partial
from typing import Any, Literal
from weakref import WeakSet

import numpy as np

from nao_course.geometry import Pose
from nao_course.plotting import Drawing, style_of
from nao_course.robot import RealNao, Robot
from nao_course.sim import Picture, Truth
from nao_course.slam import Measurement, Motion, SlamAlgorithm
from nao_course.widgets.attempts import TIME_LIMIT
from nao_course.widgets.control_panel.cockpit import Cockpit, Measure
from nao_course.widgets.control_panel.controls import SIZES, Controls
from nao_course.widgets.control_panel.motion_runner import MotionRunner
from nao_course.widgets.control_panel.pipeline import Pipeline, View
from nao_course.widgets.control_panel.screen import Screen
from nao_course.widgets.control_panel.student_view import StudentView
from nao_course.widgets.parts import bundle
from nao_course.widgets.vector_map import VectorMap

HEAD_YAW, HEAD_PITCH = float(np.radians(10)), float(np.radians(5))  # rad for one press

_LIVE: WeakSet[ControlPanel] = WeakSet()  # panels of this kernel: a new panel stops the drives of older ones


class ControlPanel:
    """Drive the robot, take pictures, run SLAM.

    Write the panel in the last line of a cell to show its buttons, which drive the robot live. The methods do the
    same from code and return when the motion is complete: ``panel.forward()``. Both take the same pictures in the same
    order, so the same seed gives the same drive.

    Parameters
    ----------
    nao : Robot
        The robot: a `SimulatedNao`, a `RealNao` or a `RecordedNao`. A newer panel for the same robot closes this panel.
    truth : Truth, optional
        The robot's true pose, for the map.
    slam : SlamAlgorithm, optional
        Algorithm whose ``move`` is called for every small step. The button "Run SLAM" measures and calls its
        ``observe``.
    measure : callable, optional
        ``measure(pixels, view)`` returns a list of Measurement; by default a simulated robot's ideal ``nao.sense()``.
    show_truth : bool, optional
        Whether the map shows the truth at first; by default it does if `truth` is given.
    start : Pose, optional
        The odometry's origin in the world; by default the true start, without `truth` where a real robot was put, else
        the field frame's origin.
    frame : Pose, optional
        Pose in the world of the frame that `slam` maps in; by default `start`, so that the map begins at zeros.
    source : "ekf" or "graph"
        Source whose colours the estimate has.
    time_limit : float
        Seconds after which a call of your code is stopped; the panel then shows a message.
    pipeline : Pipeline, optional
        Your own functions, which are run on the chosen camera's picture after each step; see
        `nao_course.student.my_nao`.

    Raises
    ------
    ValueError
        If an argument has the wrong type.

    Examples
    --------
    >>> from nao_course.sim import SimulatedNao
    >>> panel = ControlPanel(SimulatedNao(rng=1))
    >>> panel.forward(0.2)
    >>> panel.left(np.radians(15))
    >>> print(panel.summary())
    NAO V4
    odometry (0.20, 0.00) m, heading 15°
    head yaw 0°, pitch -31°
    no picture kept
    status: Turn 15° left: done.
    """

    def __init__(
        self,
        nao: Robot,
        truth: Truth | None = None,
        slam: SlamAlgorithm | None = None,
        measure: Measure | None = None,
        *,
        show_truth: bool | None = None,
        start: Pose | None = None,
        frame: Pose | None = None,
        source: Literal["ekf", "graph"] = "ekf",
        time_limit: float = TIME_LIMIT,
        pipeline: Pipeline | None = None,
    ) -> None:
        """Take the first pictures and build the widgets."""
        style_of(source)
        self.source: Literal["ekf", "graph"] = source
        self.cockpit = Cockpit(nao, truth, slam, measure, start, frame, time_limit)
        self._own = StudentView(pipeline)
        self._first_head = nao.head
        names = self.cockpit.names(source, self._own.estimates)
        field_map = VectorMap(nao.field, names, tallest=0)
        self._controls = Controls(
            {name: partial(self._guarded, action) for name, action in self._actions().items()},
            map_widget=field_map.widget,
            has_slam=slam is not None,
            has_truth=truth is not None,
            show_truth=show_truth is None or bool(show_truth),
            heading="".join(_line(each) for each in self._own.heading()),
            has_views=self._own.available,
            drives=self._own.drives,
            records=isinstance(nao, RealNao) and truth is None,
        )
        self._screen = Screen(
            self.cockpit,
            self._controls,
            self._own,
            field_map,
            names,
            source,
            lambda: self._drive.waiting_text(),
        )
        self._drive = MotionRunner(
            self.cockpit,
            lambda: self._own.latest.motion,
            self._screen.refresh,
            self._screen.show_status,
            self._screen.is_behind,
            self._screen.give_up,
        )
        self._controls.show_truth.observe(lambda change: self._screen.show(), "value")
        self._controls.camera.observe(lambda change: self._guarded(self._screen.show_chosen), "value")
        for older in list(_LIVE):
            older.stop()
            if older.cockpit.nao is nao:
                older.close("A newer panel drives this robot, so this panel is closed.")
        _LIVE.add(self)
        self._screen.show_chosen()

    # --- commands: called from code, each returns when it is complete ---

    def forward(self, distance: float | None = None) -> None:
        """Walk ahead by `distance` metres; by default the panel's step."""
        self._drive.run(Motion(self.step if distance is None else distance))

    def back(self, distance: float | None = None) -> None:
        """Walk backwards by `distance` metres; by default the panel's step."""
        self._drive.run(Motion(-(self.step if distance is None else distance)))

    def left(self, angle: float | None = None) -> None:
        """Turn to the left by `angle` radians; by default the panel's turn."""
        self._drive.run(Motion(0.0, self.turn if angle is None else angle))

    def right(self, angle: float | None = None) -> None:
        """Turn to the right by `angle` radians; by default the panel's turn."""
        self._drive.run(Motion(0.0, -(self.turn if angle is None else angle)))

    def explore(self, moves: int = 20) -> None:
        """Run at most `moves` motions that your code chooses; stop when it chooses none."""
        for _ in range(moves):
            if (motion := self._own.latest.motion) is not None:
                self._drive.run(motion)

    def turn_head(self, yaw: float = 0.0, pitch: float = 0.0) -> None:
        """Turn the head by `yaw` and `pitch` radians, positive left and down, within its joint limits."""
        self.cockpit.turn_head(yaw, pitch)
        self._screen.refresh()

    def look_ahead(self) -> None:
        """Turn the head back to its first direction."""
        self.turn_head(*np.subtract(self._first_head, self.cockpit.nao.head))

    def take_picture(self) -> Picture:
        """Take a picture with the chosen camera and size, and keep it; functions that took too long run again."""
        self._own.retry()
        picture = self.cockpit.take_picture(self.camera, self.size)
        self._screen.show_chosen()
        return picture

    def run_slam(self) -> tuple[Measurement, ...]:
        """Measure with the chosen camera, and pass the measurements to `slam` if the panel has it."""
        seen = self.cockpit.observe(self.camera, self.size)
        self._screen.show_chosen()
        return seen

    def stop(self) -> None:
        """Stop a drive after its present step, and discard the waiting commands."""
        self._drive.stop()

    def close(self, reason: str = "This panel is closed.") -> None:
        """Stop the drive and disable all controls; the pictures and the map stay visible."""
        self._drive.close()
        self._controls.disable()
        self.cockpit.say(f"{reason} Run the cell again to make a new panel.")
        self._screen.show_status()

    # --- state ---

    @property
    def widget(self) -> Any:
        """The panel as a widget, for a layout with other widgets."""
        return self._controls.widget

    @property
    def closed(self) -> bool:
        """Whether the panel is closed and no longer drives."""
        return self._drive.closed

    @property
    def driving(self) -> bool:
        """Whether a drive that a button started is still running."""
        return self._drive.going

    @property
    def picture(self) -> Picture:
        """The last picture that was taken; before the first, the chosen camera's live picture."""
        album = self.cockpit.album
        return album[-1] if album else self.cockpit.pictures[self.camera]

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """All pictures that were taken and kept, oldest first."""
        return tuple(self.cockpit.album)

    @property
    def error(self) -> BaseException | None:
        """The last exception of your code; ``raise panel.error`` shows where it was raised."""
        return self.cockpit.error

    @property
    def camera(self) -> str:
        """The chosen camera: "top" or "bottom"."""
        return str(self._controls.camera.value)

    @camera.setter
    def camera(self, camera: str) -> None:
        self._controls.camera.value = self.cockpit.nao.model.check_camera(camera)

    @property
    def size(self) -> tuple[int, int]:
        """The chosen width and height (pixels) of pictures that are kept or measured."""
        width, height = self._controls.size.value
        return width, height

    @size.setter
    def size(self, size: tuple[int, int]) -> None:
        if tuple(size) not in SIZES.values():
            raise ValueError(f"size must be one of {list(SIZES.values())} pixels, got {size}")
        self._controls.size.value = tuple(size)

    @property
    def step(self) -> float:
        """Distance that one press walks, metres."""
        return float(self._controls.step.value)

    @property
    def turn(self) -> float:
        """Angle that one press turns, radians."""
        return float(np.radians(self._controls.turn.value))

    @property
    def show_truth(self) -> bool:
        """Whether the map and the summary show the truth."""
        return bool(self._controls.show_truth.value)

    @show_truth.setter
    def show_truth(self, shown: bool) -> None:
        if shown and self.cockpit.truth is None:
            raise ValueError(
                "this panel was made without the truth: make it with ControlPanel(nao, truth=Truth(nao))"
            )
        self._controls.show_truth.value = bool(shown)

    @property
    def measured_pose(self) -> Pose | None:
        """Pose in the world where a person has measured the robot, with a tape; None if it has moved since.

        Set it to compare the estimate with it: ``panel.measured_pose = Pose(1.2, 0.4, 0.5)``.
        """
        return self.cockpit.measured

    @measured_pose.setter
    def measured_pose(self, pose: Pose) -> None:
        if not isinstance(pose, Pose):
            raise ValueError(f"measured_pose must be a Pose(x, y, theta) in metres and radians, got {pose!r}")
        self.cockpit.measured = pose
        self._screen.show()

    @property
    def view(self) -> View:
        """Where your code's results are shown: "over" the picture, "beside" it, or not at all ("picture")."""
        return self._own.view

    @view.setter
    def view(self, view: View) -> None:
        self._own.view = view
        self._screen.show_chosen()

    def summary(self) -> str:
        """Return the panel's contents as text."""
        return self._screen.summary()

    def drawing(self) -> Drawing:
        """Return the panel's contents as a figure, for places without widgets."""
        return self._screen.drawing()

    def __repr__(self) -> str:
        """Return the panel's contents as text."""
        return f"ControlPanel: {self.summary()}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the widgets, and a picture and the summary for places without widgets."""
        drawing = self.drawing()
        return bundle(self.widget, drawing, repr(self), drawing.alt)

    # --- actions of the buttons ---

    def _guarded(self, action: Callable[[], object]) -> None:
        """Run a button's action; an error becomes a message, so that the panel keeps working."""
        if self.closed:
            return
        try:
            action()
        except Exception as error:  # noqa: BLE001 - no caller of a callback could catch this
            self._drive.report_panel_error(error)

    def _actions(self) -> dict[str, Callable[[], object]]:
        """Return the action of each button."""

        def drive(steps: int, turns: int) -> Callable[[], None]:
            return lambda: self._drive.press(Motion(steps * self.step, turns * self.turn))

        return {
            "forward": drive(1, 0),
            "back": drive(-1, 0),
            "left": drive(0, 1),
            "right": drive(0, -1),
            "stop": self.stop,
            "look-up": partial(self.turn_head, 0.0, -HEAD_PITCH),
            "look-down": partial(self.turn_head, 0.0, HEAD_PITCH),
            "look-left": partial(self.turn_head, HEAD_YAW, 0.0),
            "look-right": partial(self.turn_head, -HEAD_YAW, 0.0),
            "look-ahead": self.look_ahead,
            "picture": self.take_picture,
            "slam": self.run_slam,
            "record": self._record,
            "view": self._next_view,
            "world": self._next_face,
            "itself": lambda: self._drive.go_by_itself(),
        }

    def _record(self) -> None:
        self.cockpit.record()
        self._screen.show_status()

    def _next_face(self) -> None:
        self._screen.switch_face()

    def _next_view(self) -> None:
        self.view = self._own.next_view


def _line(text: str) -> str:
    """Return a line of HTML that is cut where the panel ends; its tooltip is the whole text."""
    return f'<p title="{html.escape(text)}">{html.escape(text)}</p>'
