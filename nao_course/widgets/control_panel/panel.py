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
from nao_course.sim import Picture, SimulatedNao, Truth
from nao_course.slam import Measurement, Motion, SlamAlgorithm
from nao_course.widgets.attempts import TIME_LIMIT
from nao_course.widgets.control_panel.cockpit import CAMERAS, LIVE_SIZE, Cockpit, Measure
from nao_course.widgets.control_panel.controls import SIZES, Controls
from nao_course.widgets.control_panel.drive import Drive
from nao_course.widgets.control_panel.live_map import LiveMap, MapContents
from nao_course.widgets.control_panel.pipeline import VIEWS, Pipeline, Seen, View
from nao_course.widgets.control_panel.still import draw_still
from nao_course.widgets.parts import bundle, jpeg, png, status_box

HEAD_YAW, HEAD_PITCH = float(np.radians(10)), float(np.radians(5))  # rad for one press

_LIVE: WeakSet[ControlPanel] = WeakSet()  # panels of this kernel: a new one stops what older ones still drive


class ControlPanel:
    """Drive the robot, take pictures, run SLAM.

    Display it (the last line of a cell) for the panel with its buttons, which drive live. Its methods do the same
    from code, at once and to the end: ``panel.forward()``. Both take the same pictures in the same order, so the
    same seed gives the same drive.

    Parameters
    ----------
    nao : SimulatedNao
        The robot. A newer panel of the same robot closes this one.
    truth : Truth, optional
        Where the robot really is, for the map; without it the panel cannot show it.
    slam : SlamAlgorithm, optional
        Every small step goes to ``slam.move``; the button "Run SLAM" measures and calls ``slam.observe``.
    measure : callable, optional
        ``measure(pixels, view)`` returns a list of Measurement; by default the ideal ``nao.sense()``.
    show_truth : bool, optional
        Whether the map shows the truth at first; by default if there is one.
    start : Pose, optional
        The odometry's origin in the world; by default what the truth says, else the field frame's origin.
    frame : Pose, optional
        In the world, of the frame `slam` maps in; by default `start`: both seeds begin their map at zeros.
    source : "ekf" or "graph"
        Whose colours the estimate gets.
    time_limit : float
        Seconds for each call of your code; one that takes longer is stopped, and the panel says so.
    pipeline : Pipeline, optional
        Your own functions, which look at the chosen camera's picture with each step; see `nao_course.student.my_nao`.

    Raises
    ------
    ValueError
        If a part is not what it must be.

    Examples
    --------
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
        nao: SimulatedNao,
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
        self._pipeline = pipeline
        self._view: View = "over" if pipeline is not None and pipeline.stages else "picture"
        self._seen = Seen()
        self._believed: list[Pose] = []  # where the pipeline's estimates were
        self._stale: set[str] = set()  # cameras whose latest picture is from before the latest step
        self.cockpit = Cockpit(nao, truth, slam, measure, start, frame, time_limit)
        self.source = source
        self._drive = Drive(self.cockpit, lambda: self._seen.motion, self._look, self._show_status)
        self._names = self.cockpit.names(source, pipeline is not None and pipeline.estimates)
        self._map = LiveMap(nao.field, self._names)
        self._first_head = nao.head
        self._controls = Controls(
            {name: partial(self._guarded, action) for name, action in self._actions().items()},
            has_slam=slam is not None,
            has_truth=truth is not None,
            show_truth=show_truth is None or bool(show_truth),
            heading="<br>".join(html.escape(f"{each[:1].upper()}{each[1:]}") for each in self._ready()),
            has_views=pipeline is not None and bool(pipeline.stages),
            drives=pipeline is not None and pipeline.drives,
        )
        self._controls.show_truth.observe(lambda change: self._show(), "value")
        self._controls.camera.observe(lambda change: self._guarded(self._show_chosen), "value")
        for older in list(_LIVE):
            older.stop()
            if older.cockpit.nao is nao:
                older.close("A newer panel drives this robot.")
        _LIVE.add(self)
        self._show_chosen()

    # --- commands: from code they run to the end, buttons start them ---

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
        """Let your code drive: so many moves, each where it says, or fewer if it has nothing more to say."""
        for _ in range(moves):
            if (motion := self._seen.motion) is not None:
                self._drive.run(motion)

    def turn_head(self, yaw: float = 0.0, pitch: float = 0.0) -> None:
        """Turn the head by so many radians, positive left and down, as far as its joints go."""
        self.cockpit.turn_head(yaw, pitch)
        self._look()

    def look_ahead(self) -> None:
        """Turn the head back to where it was when the panel began."""
        self.turn_head(*np.subtract(self._first_head, self.cockpit.nao.head))

    def take_picture(self) -> Picture:
        """Take a picture with the chosen camera and size, and keep it."""
        picture = self.cockpit.take_picture(self.camera, self.size)
        self._show_chosen()
        return picture

    def run_slam(self) -> tuple[Measurement, ...]:
        """Measure with the chosen camera and give the measurements to `slam`; without one, only measure."""
        seen = self.cockpit.observe(self.camera, self.size)
        self._show_chosen()
        return seen

    def stop(self) -> None:
        """Stop a drive after its present step, and forget what was to come next."""
        self._drive.stop()

    def close(self, reason: str = "This panel is closed.") -> None:
        """Stop and switch all controls off; pictures and map stay as they are."""
        self._drive.close()
        self._controls.disable()
        self.cockpit.say(f"{reason} Run the cell again for a new one.")
        self._show_status()

    # --- what it knows ---

    @property
    def widget(self) -> Any:
        """The panel as a widget, to be laid out beside others."""
        return self._controls.widget

    @property
    def closed(self) -> bool:
        """Whether it drives no more."""
        return self._drive.closed

    @property
    def driving(self) -> bool:
        """Whether a drive that a button began is going on."""
        return self._drive.going

    @property
    def picture(self) -> Picture:
        """The picture taken last; before the first, the chosen camera's live one."""
        album = self.cockpit.album
        return album[-1] if album else self.cockpit.pictures[self.camera]

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """All pictures taken and kept, oldest first."""
        return tuple(self.cockpit.album)

    @property
    def error(self) -> BaseException | None:
        """What your code raised last; ``raise panel.error`` shows where it came from."""
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
        """The chosen size of pictures that are kept or measured, pixels."""
        width, height = self._controls.size.value
        return width, height

    @size.setter
    def size(self, size: tuple[int, int]) -> None:
        if tuple(size) not in SIZES.values():
            raise ValueError(f"size must be one of {list(SIZES.values())} pixels, got {size}")
        self._controls.size.value = tuple(size)

    @property
    def step(self) -> float:
        """Metres of one press."""
        return float(self._controls.step.value)

    @property
    def turn(self) -> float:
        """Radians of one press."""
        return float(np.radians(self._controls.turn.value))

    @property
    def show_truth(self) -> bool:
        """Whether map and summary show the truth."""
        return bool(self._controls.show_truth.value)

    @show_truth.setter
    def show_truth(self, shown: bool) -> None:
        if shown and self.cockpit.truth is None:
            raise ValueError("this panel knows no truth: make it with ControlPanel(nao, truth=Truth(nao))")
        self._controls.show_truth.value = bool(shown)

    @property
    def view(self) -> View:
        """How the chosen camera's picture is shown: "picture", or your code's view "over" or "beside" it."""
        return self._view

    @view.setter
    def view(self, view: View) -> None:
        if view not in VIEWS:
            raise ValueError(f"view must be one of {list(VIEWS)}, got {view!r}")
        if self._pipeline is None or not self._pipeline.stages:
            raise ValueError("this panel has none of your functions to look with: make it with my_nao()")
        self._view = view
        self._pipeline.wake()
        self._show_chosen()

    def summary(self) -> str:
        """Return what the panel shows, in words."""
        *facts, status = self.cockpit.summary(self.show_truth).splitlines()
        return "\n".join([*facts, *self._ready(), *self._seen.lines(), *self._seen.complaints, status])

    def drawing(self) -> Drawing:
        """Return what the panel shows as a figure, for where no widget can live."""
        views = [(camera, *self._shown(camera)) for camera in CAMERAS]
        pictures = {whose or f"{camera} camera": pixels for camera, pixels, whose in views}
        alt = f"Control panel: {'; '.join(self.summary().splitlines())}"
        return draw_still(pictures, self.cockpit.nao.field, self._contents(), self._names, alt)

    def __repr__(self) -> str:
        """Say what the panel shows."""
        return f"ControlPanel: {self.summary()}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Show the widgets; beside them lie a picture and the summary for where they cannot live."""
        drawing = self.drawing()
        return bundle(self.widget, drawing, repr(self), drawing.alt)

    # --- what buttons do ---

    def _guarded(self, action: Callable[[], object]) -> None:
        """Do what a button asks; a mistake, even one of ours, is a message and leaves the panel alive."""
        if self.closed:
            return
        try:
            action()
        except Exception as error:  # noqa: BLE001 - a callback has nobody above it who could catch this
            self._drive.admit(error)

    def _actions(self) -> dict[str, Callable[[], object]]:
        """What each button does."""

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
            "view": self._next_view,
            "itself": self._go_by_itself,
        }

    def _go_by_itself(self) -> None:
        """Drive where the student's code says until somebody presses Stop."""
        self.view = "over" if self.view == "picture" else self.view
        self._drive.go_by_itself()

    # --- the student's code looks along ---

    def _next_view(self) -> None:
        views = list(VIEWS)
        self.view = views[(views.index(self.view) + 1) % len(views)]

    def _perceive(self) -> None:
        """Let the student's code look at the chosen camera's picture, unless only that is wanted."""
        if self._pipeline is None or self.view == "picture":
            self._seen = Seen()
            return
        self._seen = self._pipeline.look(self.cockpit.pictures[self.camera])
        self.cockpit.error = self._seen.error or self.cockpit.error
        if self._seen.estimate is not None:
            self._believed.append(self._seen.estimate.pose)

    def _shown(self, camera: str) -> tuple[Any, str]:
        """The pixels to show in a camera's place, and what they are where they are not its picture alone."""
        own, chosen = self.cockpit.pictures[camera].pixels, self.cockpit.pictures[self.camera].pixels
        names = self._seen.names
        if names and self.view == "over" and camera == self.camera:
            return self._seen.over(own), f"{camera} camera, your {names}"
        if names and self.view == "beside" and camera != self.camera:
            return self._seen.alone(chosen), f"your {names}"
        return own, ""

    def _is_hidden(self, camera: str) -> bool:
        """Whether the student's view stands in the place of a camera's picture."""
        return self.view == "beside" and camera != self.camera and bool(self._seen.names)

    def _ready(self) -> list[str]:
        return [] if self._pipeline is None else self._pipeline.summary()

    # --- showing ---

    def _look(self) -> None:
        """Take the live pictures that are seen, the chosen camera's first, and show everything."""
        for camera in sorted(CAMERAS, key=lambda each: each != self.camera):
            if self._is_hidden(camera):
                self._stale.add(camera)
            else:
                self.cockpit.photograph(camera)
                self._stale.discard(camera)
            if camera == self.camera:
                self._perceive()
            self._show_picture(camera)
        self._show_map()
        self._show_status()

    def _show_chosen(self) -> None:
        for camera in sorted(self._stale):
            self.cockpit.photograph(camera)
        self._stale.clear()
        self._perceive()
        self._show()

    def _show(self) -> None:
        if self._controls.view is not None:
            self._controls.view.description = VIEWS[self.view]
        for camera in CAMERAS:
            self._show_picture(camera)
        self._show_map()
        self._show_status()

    def _show_picture(self, camera: str) -> None:
        picture = self.cockpit.pictures[camera]
        image, caption = self._controls.images[camera], self._controls.captions[camera]
        pixels, whose = self._shown(camera)
        image.value = jpeg(pixels)
        width, height = picture.view.size
        live = "live" if (width, height) == LIVE_SIZE else f"{width} × {height}"
        said = f"<b>{html.escape((whose or f'{camera} camera').capitalize())}</b>, {live}"
        if caption.value != said:
            caption.value = said

    def _show_map(self) -> None:
        self._controls.map.value = png(self._map.draw(self._contents()))

    def _show_status(self) -> None:
        cockpit, seen = self.cockpit, self._seen
        lines = [line for line in seen.lines() if line != seen.board]
        facts = " · ".join([*cockpit.facts(self.show_truth), *lines, *seen.pace()])
        alarm = cockpit.alarm or bool(seen.complaints)
        message = "\n".join(filter(None, [cockpit.message, self._drive.said(), *seen.complaints]))
        printed = cockpit.printed + seen.printed
        board = seen.board[:1].upper() + seen.board[1:]
        status = status_box(message, facts, alarm=alarm, shows_where=alarm, printed=printed, board=board)
        if self._controls.status.value != status:
            self._controls.status.value = status

    def _contents(self) -> MapContents:
        cockpit = self.cockpit
        known = self.show_truth and cockpit.truth is not None
        paths: dict[str, Any] = {"truth": cockpit.truth.path} if known else {}  # type: ignore[union-attr]
        paths["odometry"] = cockpit.odometry
        if cockpit.slam is not None:
            paths[self.source] = cockpit.estimated
        estimate = cockpit.estimate
        if cockpit.slam is None and self._seen.estimate is not None:
            estimate = self._seen.estimate
            paths[self.source] = self._believed
        observer = self.source if paths.get(self.source) else "odometry"
        return MapContents(paths, estimate, cockpit.seen, observer, self._seen.points)
