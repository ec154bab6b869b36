"""The control panel: the graphical user interface of Aliyev et al. 2014, section 3.1, in a notebook."""

from __future__ import annotations

import asyncio
import html
import json
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Literal
from weakref import WeakSet

import ipywidgets
import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import Pose
from nao_course.plotting import (
    Drawing,
    course_style,
    plot_estimate,
    plot_field,
    plot_measurements,
    plot_path,
    plot_picture,
    style_of,
)
from nao_course.sim import Picture, SimulatedNao, Truth
from nao_course.slam import Measurement, Motion, SlamAlgorithm
from nao_course.widgets.cockpit import CAMERAS, LIVE_SIZE, Cockpit, Measure, pieces
from nao_course.widgets.live_map import LiveMap, MapContents, legend_key
from nao_course.widgets.parts import (
    BREATH,
    PERIOD,
    LabelledImage,
    box,
    bundle,
    html_line,
    jpeg,
    png,
    status_box,
    styles,
)

SIZES = {"320 × 240": (320, 240), "640 × 480": (640, 480), "1280 × 960": (1280, 960)}
STEPS = {"5 cm": 0.05, "10 cm": 0.1, "20 cm": 0.2, "50 cm": 0.5, "1 m": 1.0}
TURNS = {"5°": 5.0, "15°": 15.0, "30°": 30.0, "45°": 45.0, "90°": 90.0}
HEAD_YAW, HEAD_PITCH = float(np.radians(10)), float(np.radians(5))  # rad for one press

# Each key presses the button that has the class nao-do-<name>: letters for hands on the keyboard, arrows for the rest.
KEYS = {
    "forward": ("w", "arrowup"),
    "back": ("s", "arrowdown"),
    "left": ("a", "arrowleft"),
    "right": ("d", "arrowright"),
    "stop": ("x",),
    "look-up": ("i",),
    "look-down": ("k",),
    "look-left": ("j",),
    "look-right": ("l",),
    "look-ahead": ("h",),
    "picture": (" ",),
    "slam": ("m",),
}
_HANDLER = """const name = %s[event.key.toLowerCase()];
if (!name || event.ctrlKey || event.metaKey || event.altKey) return;
event.preventDefault(); event.stopPropagation();
const button = this.closest('.nao-panel').querySelector('.nao-do-' + name);
if (button && !button.disabled && !(event.repeat && (name === 'picture' || name === 'slam'))) button.click();"""

_CSS = """
.nao-panel .nao-main { gap: 10px; align-items: flex-start; overflow: visible; }
.nao-panel .nao-left { flex: 1 1 520px; max-width: 640px; gap: 6px; overflow: visible; }
.nao-panel .nao-cameras { gap: 8px; }
.nao-panel .nao-camera { flex: 1 1 0; min-width: 0; }
.nao-panel .nao-camera img { width: 100%; height: auto; aspect-ratio: 4 / 3; object-fit: fill; border-radius: 4px;
  box-sizing: border-box; border: 3px solid transparent; margin: 0; }
.nao-panel .nao-chosen img { border-color: #0b5fa5; }
.nao-panel .nao-controls { gap: 12px; flex-wrap: wrap; overflow: visible; }
.nao-panel .nao-pad { display: grid; grid-template-columns: repeat(3, 62px); gap: 3px; overflow: visible; }
.nao-panel .nao-pad button, .nao-panel .nao-actions button { margin: 0; width: auto; padding: 0 4px; }
.nao-panel .nao-pad button { height: 28px; line-height: 28px; font-size: 12px; }
.nao-panel .nao-settings { gap: 3px; overflow: visible; }
.nao-panel .nao-settings .widget-dropdown { width: 158px; margin: 0; }
.nao-panel .nao-settings .widget-label { min-width: 54px; width: 54px; }
.nao-panel .nao-actions { gap: 6px; align-items: center; flex-wrap: wrap; overflow: visible; }
.nao-panel .nao-actions .widget-html, .nao-panel .nao-actions .widget-checkbox { margin: 0; }
.nao-panel .nao-actions .widget-checkbox label { display: flex; align-items: center; gap: 4px; }
.nao-panel .nao-keys { box-sizing: border-box; width: 100%; min-width: 180px; height: 28px; padding: 0 8px;
  border-radius: 4px; border: 1px solid var(--jp-border-color1, #bbb); background: var(--jp-layout-color1, white);
  color: var(--jp-ui-font-color1, black); caret-color: transparent; }
.nao-panel .nao-keys:focus { outline: 2px solid #0b5fa5; outline-offset: 1px; }
.nao-panel .nao-map { flex: 0 0 auto; margin: 0; }
"""

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
    16 pictures, 0 kept
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
    ) -> None:
        """Take the first pictures and build the widgets."""
        style_of(source)
        self.cockpit = Cockpit(nao, truth, slam, measure, start, frame)
        self.source = source
        self.closed = False
        self._task: asyncio.Task[None] | None = None
        self._next: Motion | None = None
        self._stopping = False
        self._names = {"truth": "truth"} if truth is not None else {}
        self._names |= {"odometry": "odometry"} | (
            {source: _short(type(slam).__name__)} if slam is not None else {}
        )
        self._map = LiveMap(nao.field, self._names)
        self._build(truth is not None if show_truth is None else bool(show_truth))
        for older in list(_LIVE):
            older.stop()
            if older.cockpit.nao is nao:
                older.close("A newer panel drives this robot.")
        _LIVE.add(self)
        self._show()

    # --- commands: from code they run to the end, buttons start them ---

    def forward(self, distance: float | None = None) -> None:
        """Walk ahead by `distance` metres; by default the panel's step."""
        self._run(Motion(self.step if distance is None else distance))

    def back(self, distance: float | None = None) -> None:
        """Walk backwards by `distance` metres; by default the panel's step."""
        self._run(Motion(-(self.step if distance is None else distance)))

    def left(self, angle: float | None = None) -> None:
        """Turn to the left by `angle` radians; by default the panel's turn."""
        self._run(Motion(0.0, self.turn if angle is None else angle))

    def right(self, angle: float | None = None) -> None:
        """Turn to the right by `angle` radians; by default the panel's turn."""
        self._run(Motion(0.0, -(self.turn if angle is None else angle)))

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
        self._show()
        return picture

    def run_slam(self) -> tuple[Measurement, ...]:
        """Measure with the chosen camera and give the measurements to `slam`; without one, only measure."""
        seen = self.cockpit.observe(self.camera, self.size)
        self._show()
        return seen

    def stop(self) -> None:
        """Stop a drive after its present step, and forget what was to come next."""
        self._next = None
        self._stopping = self.driving

    def close(self, reason: str = "This panel is closed.") -> None:
        """Stop and switch all controls off; pictures and map stay as they are."""
        self.stop()
        self.closed = True
        for control in self._controls:
            control.disabled = True
        self.cockpit.say(f"{reason} Run the cell again for a new one.")
        self._show_status()

    # --- what it knows ---

    @property
    def driving(self) -> bool:
        """Whether a drive that a button began is going on."""
        return self._task is not None and not self._task.done()

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
    def error(self) -> Exception | None:
        """What your code raised last; ``raise panel.error`` shows where it came from."""
        return self.cockpit.error

    @property
    def camera(self) -> str:
        """The chosen camera: "top" or "bottom"."""
        return str(self._camera.value)

    @camera.setter
    def camera(self, camera: str) -> None:
        self._camera.value = self.cockpit.nao.model.check_camera(camera)

    @property
    def size(self) -> tuple[int, int]:
        """The chosen size of pictures that are kept or measured, pixels."""
        width, height = self._size.value
        return width, height

    @size.setter
    def size(self, size: tuple[int, int]) -> None:
        if tuple(size) not in SIZES.values():
            raise ValueError(f"size must be one of {list(SIZES.values())} pixels, got {size}")
        self._size.value = tuple(size)

    @property
    def step(self) -> float:
        """Metres of one press."""
        return float(self._step.value)

    @property
    def turn(self) -> float:
        """Radians of one press."""
        return float(np.radians(self._turn.value))

    @property
    def show_truth(self) -> bool:
        """Whether map and summary show the truth."""
        return bool(self._show_truth.value)

    @show_truth.setter
    def show_truth(self, shown: bool) -> None:
        if shown and self.cockpit.truth is None:
            raise ValueError("this panel knows no truth: make it with ControlPanel(nao, truth=Truth(nao))")
        self._show_truth.value = bool(shown)

    def summary(self) -> str:
        """Return what the panel shows, in words."""
        return self.cockpit.summary(self.show_truth)

    def drawing(self) -> Drawing:
        """Return what the panel shows as a figure, for where no widget can live."""
        with course_style():
            figure = Figure(figsize=(9.6, 5.4))
            grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.25))
            for row, camera in enumerate(CAMERAS):
                ax = figure.add_subplot(grid[row, 0])
                plot_picture(self.cockpit.pictures[camera], ax, ticks=False)
                ax.set_title(f"{camera} camera", fontsize=11)
            ax = figure.add_subplot(grid[:, 1])
            self._plot_map(ax)
            handles = [legend_key(source, self._names[source]) for source in self._contents().paths]
            figure.legend(handles=handles, loc="outside lower center", ncols=3)
        return Drawing(figure, f"Control panel: {'; '.join(self.summary().splitlines())}", photo=True)

    def _plot_map(self, ax: Any) -> None:
        contents = self._contents()
        plot_field(self.cockpit.nao.field, ax)
        if contents.estimate is not None:
            plot_estimate(contents.estimate, ax, self.source)
        for source, path in contents.paths.items():
            plot_path(list(path), ax, source)
        if contents.seen:
            plot_measurements(contents.seen, contents.paths[contents.observer][-1], ax, contents.observer)

    def __repr__(self) -> str:
        """Say what the panel shows."""
        return f"ControlPanel: {self.summary()}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Show the widgets; beside them lie a picture and the summary for where they cannot live."""
        drawing = self.drawing()
        return bundle(self.widget, drawing, repr(self), drawing.alt)

    # --- driving ---

    def _run(self, motion: Motion) -> None:
        """Drive now and to the end."""
        self._refuse_if_closed()
        for _ in self._steps(motion):
            pass

    def _press(self, motion: Motion) -> None:
        """Drive as a task of the kernel's loop, so that the buttons stay live; the newest command waits its turn."""
        if self.driving:
            self._next = motion
            return
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:  # no kernel: a plain Python program
            self._run(motion)
            return
        self._stopping = False
        self._task = loop.create_task(self._drive(motion))

    async def _drive(self, motion: Motion) -> None:
        """Drive with nobody above who could catch a mistake."""
        try:
            await self._drive_on(motion)
        except Exception as error:  # noqa: BLE001 - see _guarded
            self._admit(error)

    async def _drive_on(self, motion: Motion) -> None:
        """Drive, and then what was asked for meanwhile; at most one step each `PERIOD`."""
        upcoming: Motion | None = motion
        while upcoming is not None:
            began = time.perf_counter()
            for _ in self._steps(upcoming):
                await asyncio.sleep(max(BREATH, PERIOD - (time.perf_counter() - began)))
                began = time.perf_counter()
                if self._stopping:
                    if not self.closed:
                        self.cockpit.say("Stopped.")
                    self._show_status()
                    return
            upcoming, self._next = self._next, None

    def _guarded(self, action: Callable[[], object]) -> None:
        """Do what a button asks; a mistake, even one of ours, is a message and leaves the panel alive."""
        if self.closed:
            return
        try:
            action()
        except Exception as error:  # noqa: BLE001 - a callback has nobody above it who could catch this
            self._admit(error)

    def _admit(self, error: Exception) -> None:
        self.cockpit.complain("the panel", error)
        self._show_status()

    def _steps(self, motion: Motion) -> Iterator[None]:
        """Do a motion step by step, with new pictures and a new map after each; end where `slam` fails."""
        self.cockpit.say(f"{_in_words(motion)} …")
        self.cockpit.printed = ""
        for part in pieces(motion):
            went_well = self.cockpit.move(part)
            self._look()
            if not went_well:
                return
            yield
        if not self.cockpit.alarm:
            self.cockpit.say(f"{_in_words(motion)}: done.")
            self._show_status()

    def _look(self) -> None:
        """Take both live pictures, the chosen camera's first, and show everything."""
        for camera in sorted(CAMERAS, key=lambda each: each != self.camera):
            self.cockpit.photograph(camera)
            self._show_picture(camera)
        self._show_map()
        self._show_status()

    # --- showing ---

    def _show(self) -> None:
        for camera in CAMERAS:
            self._show_picture(camera)
        self._show_map()
        self._show_status()

    def _show_picture(self, camera: str) -> None:
        picture = self.cockpit.pictures[camera]
        image, caption = self._images[camera], self._captions[camera]
        image.value = jpeg(picture.pixels)
        width, height = picture.view.size
        live = "live" if (width, height) == LIVE_SIZE else f"{width} × {height}"
        caption.value = f"<b>{camera.capitalize()} camera</b>, {live}"

    def _show_map(self) -> None:
        self._map_image.value = png(self._map.draw(self._contents()))

    def _show_status(self) -> None:
        cockpit = self.cockpit
        words = html.escape(cockpit.message)
        if cockpit.alarm:
            words += " <i>(raise panel.error shows where)</i>"
        facts = " · ".join(cockpit.facts(self.show_truth))
        status = status_box(words, facts, alarm=cockpit.alarm, printed=cockpit.printed)
        if self._status.value != status:
            self._status.value = status

    def _contents(self) -> MapContents:
        cockpit = self.cockpit
        paths: dict[str, Any] = {}
        if self.show_truth and cockpit.truth is not None:
            paths["truth"] = cockpit.truth.path
        paths["odometry"] = cockpit.odometry
        if cockpit.slam is not None:
            paths[self.source] = cockpit.estimated
        observer = self.source if cockpit.estimated else "odometry"
        return MapContents(paths, cockpit.estimate, cockpit.seen, observer)

    def _refuse_if_closed(self) -> None:
        if self.closed:
            raise ValueError("this panel is closed: a newer one drives this robot")

    # --- widgets ---

    def _build(self, show_truth: bool) -> None:
        self._first_head = self.cockpit.nao.head
        self._controls: list[Any] = []
        self._status = ipywidgets.HTML()
        self._images = {camera: self._image(camera, "jpeg") for camera in CAMERAS}
        self._captions = {camera: html_line("", "nao-caption") for camera in CAMERAS}
        boxes = [box("V", "nao-camera", self._captions[camera], self._images[camera]) for camera in CAMERAS]
        self._camera_boxes = dict(zip(CAMERAS, boxes, strict=True))
        self._map_image = self._image("map", "png")
        self._map_image.add_class("nao-map")
        controls = box("H", "nao-controls", self._drive_pad(), self._head_pad(), self._settings())
        left = box(
            "V",
            "nao-left",
            box("H", "nao-cameras", *boxes),
            controls,
            self._actions(show_truth),
            self._status,
        )
        main = box("H", "nao-main", left, self._map_image)
        main.layout.flex_flow = "row wrap"
        self.widget = box("V", "nao-panel", styles(_CSS), main)
        self._camera.observe(lambda change: self._mark_camera(), "value")
        self._show_truth.observe(lambda change: self._show(), "value")
        self._mark_camera()

    def _image(self, name: str, kind: str) -> Any:
        labels = {"map": "Map of the field from above; what it shows stands in words beside it"}
        image = LabelledImage(format=kind, tooltip=labels.get(name, f"Live picture of the {name} camera"))
        image.add_class(f"nao-image-{name}")
        return image

    def _button(
        self, name: str, label: str, tooltip: str, action: Callable[[], object], icon: str = ""
    ) -> Any:
        keys = " or ".join(
            key.replace("arrow", "arrow ").replace(" ", "space", key == " ") for key in KEYS[name]
        )
        button = ipywidgets.Button(description=label, tooltip=f"{tooltip} (key: {keys})", icon=icon)
        button.add_class(f"nao-do-{name}")
        button.on_click(lambda _: self._guarded(action))
        self._controls.append(button)
        return button

    def _drive_pad(self) -> Any:
        def drive(distance: float, turn: float) -> Callable[[], None]:
            return lambda: self._press(Motion(distance * self.step, turn * self.turn))

        gap = ipywidgets.Box()
        pad = [
            gap,
            self._button("forward", "▲ Fwd", "Walk ahead by one step", drive(1, 0)),
            gap,
            self._button("left", "◀ Left", "Turn left on the spot", drive(0, 1)),
            self._button("stop", "■ Stop", "Stop the drive", self.stop),
            self._button("right", "Right ▶", "Turn right on the spot", drive(0, -1)),
            gap,
            self._button("back", "▼ Back", "Walk backwards by one step", drive(-1, 0)),
            gap,
        ]
        return box("V", "nao-group", html_line("Walk", "nao-heading"), box("", "nao-pad", *pad))

    def _head_pad(self) -> Any:
        gap = ipywidgets.Box()
        turn = partial(partial, self.turn_head)
        pad = [
            gap,
            self._button("look-up", "▲ Up", "Look up by 5 degrees", turn(0, -HEAD_PITCH)),
            gap,
            self._button("look-left", "◀ Left", "Turn the head 10 degrees to the left", turn(HEAD_YAW, 0)),
            self._button("look-ahead", "● Ahead", "Turn the head back to where it began", self.look_ahead),
            self._button(
                "look-right", "Right ▶", "Turn the head 10 degrees to the right", turn(-HEAD_YAW, 0)
            ),
            gap,
            self._button("look-down", "▼ Down", "Look down by 5 degrees", turn(0, HEAD_PITCH)),
            gap,
        ]
        return box("V", "nao-group", html_line("Head", "nao-heading"), box("", "nao-pad", *pad))

    def _settings(self) -> Any:
        cameras = [(camera.capitalize(), camera) for camera in CAMERAS]
        self._camera = self._choice("Camera", cameras, "bottom", "Which camera takes pictures and measures")
        self._size = self._choice(
            "Size", list(SIZES.items()), SIZES["320 × 240"], "Of pictures that are kept"
        )
        self._step = self._choice("Step", list(STEPS.items()), 0.2, "How far one press walks")
        self._turn = self._choice("Turn", list(TURNS.items()), 15.0, "How far one press turns")
        return box("V", "nao-settings", self._camera, self._size, self._step, self._turn)

    def _choice(self, label: str, options: list[tuple[str, Any]], value: Any, tooltip: str) -> Any:
        choice = ipywidgets.Dropdown(description=label, options=options, value=value)
        choice.tooltip = tooltip
        self._controls.append(choice)
        return choice

    def _actions(self, show_truth: bool) -> Any:
        has_slam, has_truth = self.cockpit.slam is not None, self.cockpit.truth is not None
        measure = "Measure landmarks from here" + (" and give them to your SLAM" if has_slam else "")
        self._show_truth = ipywidgets.Checkbox(
            value=show_truth and has_truth, description="Show the truth", indent=False, disabled=not has_truth
        )
        self._show_truth.layout.width = "auto"
        self._show_truth.tooltip = (
            "Draw where the robot really is" if has_truth else "This panel knows no truth"
        )
        self._controls.append(self._show_truth)
        keys = ipywidgets.HTML(_keyboard())
        keys.layout.flex = "1 1 200px"
        return box(
            "H",
            "nao-actions",
            self._button(
                "picture", "Take picture", "Take a picture and keep it", self.take_picture, "camera"
            ),
            self._button("slam", "Run SLAM" if has_slam else "Measure", measure, self.run_slam, "crosshairs"),
            self._show_truth,
            keys,
        )

    def _mark_camera(self) -> None:
        for camera, shown in self._camera_boxes.items():
            (shown.add_class if camera == self.camera else shown.remove_class)("nao-chosen")


def _keyboard() -> str:
    """A text field that turns keys into presses of the panel's buttons.

    In a text field JupyterLab leaves keys alone (elsewhere "a" or "d d" would add or delete cells). ipywidgets has
    no key events, and arrow keys change no text: hence a handler of its own. Where a page forbids such handlers,
    the buttons are still there for Tab and Enter.
    """
    table = json.dumps({key: name for name, keys in KEYS.items() for key in keys})
    handler = html.escape(_HANDLER % table, quote=True)
    words = "Keyboard: click here, then W A S D or arrows walk, I J K L turn the head, space takes a picture"
    return (
        f'<input class="nao-keys" type="text" autocomplete="off" spellcheck="false" aria-label="{words}, M measures, '
        f'X stops, H looks ahead" title="{words}" placeholder="Keys: click, then WASD, IJKL, space" '
        f'oninput="this.value=\'\'" onkeydown="{handler}">'
    )


def _short(name: str, letters: int = 14) -> str:
    return name if len(name) <= letters else f"{name[: letters - 1]}…"


def _in_words(motion: Motion) -> str:
    """A command in a few words."""
    parts = []
    if motion.distance:
        parts.append(f"Walk {abs(motion.distance):.2f} m {'ahead' if motion.distance > 0 else 'back'}")
    if motion.turn:
        parts.append(f"Turn {abs(np.degrees(motion.turn)):.0f}° {'left' if motion.turn > 0 else 'right'}")
    return ", ".join(parts) or "Stand still"
