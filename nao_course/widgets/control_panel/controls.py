"""The control panel's widgets: cameras, map, buttons and menus. The panel defines what each button does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import ipywidgets

from nao_course.widgets.control_panel.cockpit import CAMERAS
from nao_course.widgets.keyboard import key_field, key_names
from nao_course.widgets.parts import LabelledImage, box, html_line, styles

SIZES = {"320 × 240": (320, 240), "640 × 480": (640, 480), "1280 × 960": (1280, 960)}
STEPS = {"5 cm": 0.05, "10 cm": 0.1, "20 cm": 0.2, "50 cm": 0.5, "1 m": 1.0}
TURNS = {"5°": 5.0, "15°": 15.0, "30°": 30.0, "45°": 45.0, "90°": 90.0}

# Letters for touch typists, arrow keys for everybody else.
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
VIEW_KEYS = {"view": ("v",)}  # only if functions of the student are ready
ITSELF_KEYS = {"itself": ("g",)}  # only if the student's code chooses motions
_KEY_WORDS = "Keyboard: click here, then W A S D or arrows walk, I J K L turn the head, space takes a picture"
_MORE_KEY_WORDS = ", M measures, X stops, H looks ahead"
_VIEW_KEY_WORDS = ", V changes the view"
_ITSELF_KEY_WORDS = ", G lets the robot go by itself"
_KEY_HINT = "Click here, type WASD, IJKL"

_CSS = """
.nao-panel .nao-main { gap: 10px; align-items: flex-start; overflow: visible; }
.nao-panel .nao-left { flex: 1 1 520px; min-width: 0; max-width: 640px; gap: 6px; overflow: visible; }
.nao-panel .nao-cameras { gap: 8px; }
.nao-panel .nao-camera { flex: 1 1 0; min-width: 0; }
.nao-panel .nao-camera img { width: 100%; height: auto; aspect-ratio: 4 / 3; object-fit: fill; border-radius: 4px;
  box-sizing: border-box; border: 3px solid transparent; margin: 0; }
.nao-panel .nao-chosen img { border-color: #0b5fa5; }
.nao-panel .nao-controls { gap: 8px; flex-wrap: wrap; overflow: visible; }
.nao-panel .nao-pad { display: grid; grid-template-columns: repeat(3, 62px); gap: 3px; overflow: visible; }
.nao-panel .nao-pad button, .nao-panel .nao-actions button { margin: 0; width: auto; padding: 0 4px; }
.nao-panel .nao-pad button { height: 28px; line-height: 28px; font-size: 12px; }
.nao-panel .nao-settings { gap: 3px; overflow: visible; }
.nao-panel .nao-settings .widget-dropdown { width: 172px; margin: 0; }
.nao-panel .nao-settings .widget-label { min-width: 54px; width: 54px; }
.nao-panel .nao-actions { gap: 6px; align-items: center; flex-wrap: wrap; overflow: visible; }
.nao-panel .nao-actions .widget-html, .nao-panel .nao-actions .widget-checkbox { margin: 0; }
.nao-panel .nao-actions .widget-checkbox label { display: flex; align-items: center; gap: 4px; }
.nao-panel .nao-camera .nao-caption .widget-html-content { white-space: nowrap; overflow: hidden;
  text-overflow: ellipsis; }
.nao-panel .nao-ready { margin: 0 0 4px 0; line-height: 18px; }
.nao-panel .nao-map { flex: 0 0 auto; margin: 0; }
"""


class Controls:
    """The control panel's widgets in one box.

    Parameters
    ----------
    actions : mapping of str to callable
        Action of each button, by the names in `KEYS`.
    has_slam, has_truth : bool
        Whether the panel has a SLAM algorithm, and a truth to show.
    show_truth : bool
        Whether the truth is shown at first, if the panel has it.
    heading : str
        HTML of a line above the other widgets.
    has_views : bool
        Whether functions of the student can draw over the picture.
    drives : bool
        Whether a function of the student chooses the robot's motions.

    Attributes
    ----------
    widget : ipywidgets.Box
        The box with all widgets.
    camera, size, step, turn, show_truth : widgets with a value
        The settings: a camera, pixels (width, height), metres, degrees, and whether the map shows the truth.
    images, captions : dict of str to widget
        Widgets of each camera.
    map, status : widgets with a value
        The map as a PNG file, and the status as HTML.
    view : ipywidgets.Button or None
        Button whose label is the present view.
    """

    def __init__(
        self,
        actions: Mapping[str, Callable[[], object]],
        *,
        has_slam: bool,
        has_truth: bool,
        show_truth: bool,
        heading: str = "",
        has_views: bool = False,
        drives: bool = False,
    ) -> None:
        """Build the widgets."""
        self._actions = actions
        self._keys = {**KEYS, **(VIEW_KEYS if has_views else {}), **(ITSELF_KEYS if drives else {})}
        self._controls: list[Any] = []
        self.status = ipywidgets.HTML()
        self.images = {
            camera: _image(camera, "jpeg", f"Live picture of the {camera} camera") for camera in CAMERAS
        }
        self.captions = {camera: html_line("", "nao-caption") for camera in CAMERAS}
        self.map = _image("map", "png", "Map of the field from above; the text beside it describes it")
        self.map.add_class("nao-map")
        self._camera_boxes = {
            camera: box("V", "nao-camera", self.captions[camera], self.images[camera]) for camera in CAMERAS
        }
        left = box(
            "V",
            "nao-left",
            box("H", "nao-cameras", *self._camera_boxes.values()),
            box("H", "nao-controls", self._drive_pad(), self._head_pad(), self._settings()),
            self._last_row(has_slam, has_truth, show_truth),
            self.status,
        )
        main = box("H", "nao-main", left, self.map)
        main.layout.flex_flow = "row wrap"
        above = [html_line(heading, "nao-ready")] if heading else []
        self.widget = box("V", "nao-panel", styles(_CSS), *above, main)
        self.camera.observe(lambda change: self._mark_camera(), "value")
        self._mark_camera()

    def disable(self) -> None:
        """Disable all buttons and menus."""
        for control in self._controls:
            control.disabled = True

    def _button(self, name: str, label: str, tooltip: str, icon: str = "") -> Any:
        tooltip = f"{tooltip} (key: {key_names(self._keys[name])})"
        button = ipywidgets.Button(description=label, tooltip=tooltip, icon=icon)
        button.add_class(f"nao-do-{name}")
        button.on_click(lambda _: self._actions[name]())
        self._controls.append(button)
        return button

    def _drive_pad(self) -> Any:
        gap = ipywidgets.Box()
        pad = [
            gap,
            self._button("forward", "▲ Fwd", "Walk ahead by one step"),
            gap,
            self._button("left", "◀ Left", "Turn left on the spot"),
            self._button("stop", "■ Stop", "Stop the drive"),
            self._button("right", "Right ▶", "Turn right on the spot"),
            gap,
            self._button("back", "▼ Back", "Walk backwards by one step"),
            gap,
        ]
        return box("V", "nao-group", html_line("Walk", "nao-heading"), box("", "nao-pad", *pad))

    def _head_pad(self) -> Any:
        gap = ipywidgets.Box()
        pad = [
            gap,
            self._button("look-up", "▲ Up", "Look up by 5 degrees"),
            gap,
            self._button("look-left", "◀ Left", "Turn the head 10 degrees to the left"),
            self._button("look-ahead", "● Ahead", "Turn the head back to where it began"),
            self._button("look-right", "Right ▶", "Turn the head 10 degrees to the right"),
            gap,
            self._button("look-down", "▼ Down", "Look down by 5 degrees"),
            gap,
        ]
        return box("V", "nao-group", html_line("Head", "nao-heading"), box("", "nao-pad", *pad))

    def _settings(self) -> Any:
        cameras = [(camera.capitalize(), camera) for camera in CAMERAS]
        self.camera = self._choice("Camera", cameras, "bottom", "Which camera takes pictures and measures")
        self.size = self._choice(
            "Size", list(SIZES.items()), SIZES["320 × 240"], "Size of pictures that are kept"
        )
        self.step = self._choice("Step", list(STEPS.items()), 0.2, "How far one press walks")
        self.turn = self._choice("Turn", list(TURNS.items()), 15.0, "How far one press turns")
        return box("V", "nao-settings", self.camera, self.size, self.step, self.turn)

    def _choice(self, label: str, options: list[tuple[str, Any]], value: Any, tooltip: str) -> Any:
        choice = ipywidgets.Dropdown(description=label, options=options, value=value)
        choice.tooltip = tooltip
        self._controls.append(choice)
        return choice

    def _last_row(self, has_slam: bool, has_truth: bool, show_truth: bool) -> Any:
        measure = "Measure landmarks from here" + (" and give them to your SLAM" if has_slam else "")
        self.show_truth = ipywidgets.Checkbox(
            value=show_truth and has_truth, description="Show the truth", indent=False, disabled=not has_truth
        )
        self.show_truth.layout.width = "auto"
        self.show_truth.tooltip = (
            "Draw the robot's true pose" if has_truth else "This panel was made without the truth"
        )
        self._controls.append(self.show_truth)
        has_views, drives = "view" in self._keys, "itself" in self._keys
        hint = _KEY_HINT + (", V" if has_views else "") + (", G" if drives else "")
        more = (
            _MORE_KEY_WORDS + (_VIEW_KEY_WORDS if has_views else "") + (_ITSELF_KEY_WORDS if drives else "")
        )
        keys = ipywidgets.HTML(
            key_field(self._keys, _KEY_WORDS, more, hint, once=("picture", "slam", "view", "itself"))
        )
        keys.layout.flex = "1 1 200px"
        tooltip = "Show your code's view of the picture over it, beside it, or not at all"
        self.view = self._button("view", "View", tooltip, "eye") if has_views else None
        go = "Let your code choose where the robot goes, until you press Stop"
        return box(
            "H",
            "nao-actions",
            *([self._button("itself", "By itself", go, "play")] if drives else []),
            self._button("picture", "Take picture", "Take a picture and keep it", "camera"),
            self._button("slam", "Run SLAM" if has_slam else "Measure", measure, "crosshairs"),
            *([self.view] if has_views else []),
            self.show_truth,
            keys,
        )

    def _mark_camera(self) -> None:
        for camera, shown in self._camera_boxes.items():
            (shown.add_class if camera == self.camera.value else shown.remove_class)("nao-chosen")


def _image(name: str, kind: str, tooltip: str) -> Any:
    image = LabelledImage(format=kind, tooltip=tooltip)
    image.add_class(f"nao-image-{name}")
    return image
