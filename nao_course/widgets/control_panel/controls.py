"""The control panel's widgets: cameras, map, numbers, buttons and menus. The panel defines what each button does."""

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
    "camera": ("c",),
    "more": ("o",),
    "world": ("t",),
}
VIEW_KEYS = {"view": ("v",)}  # only if functions of the student are ready
ITSELF_KEYS = {"itself": ("g",)}  # only if the student's code chooses motions
_KEY_WORDS = (
    "Keyboard: W A S D or arrows walk, I J K L turn the head, space takes a picture, M measures, X stops"
)
_MORE_KEY_WORDS = ", H looks ahead, C changes the camera, T shows three dimensions, O opens the settings"
_VIEW_KEY_WORDS = ", V changes the view"
_ITSELF_KEY_WORDS = ", G lets the robot go by itself"
_MORE = "Settings and details"
_KEY_HINT = "Keys: WASD, IJKL"

_CSS = """
.nao-cockpit { container-type: inline-size; width: 100%; max-width: 1000px; padding: 2px 4px; box-sizing: border-box; }
.nao-cockpit .nao-main { display: grid; grid-template: "numbers" "left" "right" / minmax(0, 480px); gap: 6px 12px;
  align-items: start; overflow: visible; margin: 0; }
.nao-cockpit .nao-left { grid-area: left; gap: 6px; overflow: visible; margin: 0; }
.nao-cockpit .nao-right { grid-area: right; gap: 6px; overflow: visible; margin: 0; }
@container (min-width: 800px) {
  .nao-cockpit .nao-main { grid-template: "left numbers" auto "left right" 1fr / 480px minmax(0, 1fr); }
}
.nao-cockpit .nao-cameras { position: relative; overflow: visible; display: block; }
.nao-cockpit .nao-camera { margin: 0; overflow: visible; }
.nao-cockpit .nao-camera img { width: 100%; height: auto; aspect-ratio: 4 / 3; object-fit: fill; border-radius: 4px;
  box-sizing: border-box; margin: 0; display: block; }
.nao-cockpit .nao-camera:not(.nao-chosen) { position: absolute; z-index: 1; left: 8px; bottom: 8px; width: 30%;
  cursor: pointer; border: 2px solid #fff; border-radius: 5px; background: #1f2430; box-shadow: 0 1px 6px #0008; }
.nao-cockpit .nao-camera:not(.nao-chosen) img { border-radius: 0 0 3px 3px; }
.nao-cockpit .nao-camera:not(.nao-chosen) .nao-caption { font-size: 11px; color: #fff; padding: 0 4px; height: 18px; }
.nao-cockpit .nao-camera:not(.nao-chosen) .nao-caption .widget-html-content { color: #fff; font-size: 11px; }
.nao-cockpit .nao-camera .nao-caption .widget-html-content { white-space: nowrap; overflow: hidden;
  text-overflow: ellipsis; }
.nao-cockpit .nao-controls { gap: 6px 8px; flex-wrap: wrap; justify-content: space-between; overflow: visible; }
.nao-cockpit .nao-group { overflow: visible; }
.nao-cockpit .nao-pad { display: grid; grid-template-columns: repeat(3, 54px); gap: 3px; overflow: visible; }
.nao-cockpit .nao-pad button { height: 28px; line-height: 28px; font-size: 12px; margin: 0; width: auto;
  padding: 0 2px; }
.nao-cockpit .nao-actions { gap: 3px; flex: 1 1 100px; max-width: 160px; overflow: visible;
  justify-content: flex-end; }
.nao-cockpit .nao-actions button { margin: 0; width: 100%; height: 28px; line-height: 28px; padding: 0 4px;
  font-size: 12px; }
.nao-cockpit .nao-do-itself { font-weight: 600; }
.nao-cockpit .nao-face { margin: 0; overflow: visible; }
.nao-cockpit .nao-do-world { flex: 0 0 auto; margin: 0; width: 56px; height: 28px; line-height: 28px; padding: 0 4px;
  font-size: 12px; }
.nao-cockpit .nao-below-map .nao-keys { min-width: 120px; }
.nao-cockpit .nao-below-map { gap: 8px; align-items: center; overflow: visible; }
.nao-cockpit .nao-below-map .widget-html, .nao-cockpit .nao-below-map .widget-checkbox { margin: 0; }
.nao-cockpit .nao-below-map .widget-checkbox label { display: flex; align-items: center; gap: 4px; }
.nao-cockpit .nao-settings { gap: 3px 14px; flex-wrap: wrap; overflow: visible; }
.nao-cockpit .nao-settings .widget-dropdown { width: 172px; margin: 0; }
.nao-cockpit .nao-settings .widget-label { min-width: 54px; width: 54px; }
.nao-cockpit .nao-ready { margin: 0; overflow: visible; }
.nao-cockpit .nao-ready .widget-html-content { min-width: 0; line-height: 18px; font-size: 12px; }
.nao-cockpit .nao-ready p { margin: 0; white-space: normal; }
.nao-cockpit .nao-right .nao-map-legend { gap: 0 10px; padding: 2px 0; font-size: 11px; line-height: 16px; }
.nao-cockpit .nao-right .nao-map-legend canvas { transform: scale(0.85); margin: 0 -3px; }
.nao-cockpit .nao-numbers { grid-area: numbers; margin: 0; }
.nao-cockpit .nao-numbers .widget-html-content { display: flex; gap: 6px; }
.nao-cockpit .nao-tile { flex: 1 1 auto; min-width: 0; padding: 3px 6px; border-top: 3px solid #0b5fa5;
  border-radius: 4px; background: var(--jp-layout-color2, #eee); line-height: 16px; font-size: 12px; }
.nao-cockpit .nao-tile b { display: block; font-size: 18px; line-height: 24px; font-variant-numeric: tabular-nums;
  white-space: nowrap; letter-spacing: -0.3px; }
.nao-cockpit .nao-tile span { white-space: nowrap; }
.nao-cockpit .nao-tile small { display: block; width: 0; min-width: 100%; font-size: 11px; line-height: 13px;
  min-height: 26px; }
.nao-cockpit .nao-good { border-top-color: #1f9d61; }
.nao-cockpit .nao-bad { border-top-color: #d9480f; }
.nao-cockpit .nao-status { min-height: 22px; padding: 2px 8px; }
.nao-cockpit .nao-finish { border-left-color: #1f9d61; font-size: 17px; font-weight: 600; line-height: 26px; }
.nao-cockpit .nao-board { font-size: 12px; }
.nao-cockpit .nao-more { margin: 0; }
.nao-cockpit .nao-more .jupyter-widget-Collapse-header { padding: 1px 8px; }
.nao-cockpit .nao-facts { font-size: 12px; line-height: 18px; }
.nao-cockpit .nao-facts ul { margin: 4px 0; padding-left: 18px; }
"""

# A click in the panel gives the keys to its key field, unless it opens a menu or selects text. A menu that was changed
# with the mouse gives them back. A click on the small picture chooses its camera.
_KEYS_AFTER_A_CLICK = """const panel = this.closest('.nao-panel');
if (!panel || panel.naoClicks) return;
panel.naoClicks = true;
const take = () => { if (getSelection().isCollapsed) panel.querySelector('.nao-keys')?.focus({preventScroll: true}); };
let mouse = false;
panel.addEventListener('pointerdown', () => { mouse = true; });
panel.addEventListener('keydown', () => { mouse = false; });
panel.addEventListener('click', event => {
  if (!event.detail) return;
  if (event.target.closest('.nao-camera:not(.nao-chosen)')) panel.querySelector('.nao-do-camera')?.click();
  if (!event.target.closest('select, a, pre')) setTimeout(take);
});
panel.addEventListener('change', () => { if (mouse) setTimeout(take); });"""


class Controls:
    """The control panel's widgets in one box.

    `heading` is HTML above the other widgets, `has_views` means that functions of the student can draw over the
    picture, and `drives` that one of them chooses the robot's motions. The settings `camera`, `size` (width, height) in
    pixels, `step` in metres, `turn` in degrees and `show_truth` are widgets with a value; so are `numbers`, `status`
    and `facts`, which hold HTML.
    """

    def __init__(
        self,
        actions: Mapping[str, Callable[[], object]],
        *,
        map_widget: Any,
        has_slam: bool,
        has_truth: bool,
        show_truth: bool,
        heading: str = "",
        has_views: bool = False,
        drives: bool = False,
    ) -> None:
        """Build the widgets."""
        self._actions = {**actions, "more": self._show_more, "camera": self._other_camera}
        self._keys = {**KEYS, **(VIEW_KEYS if has_views else {}), **(ITSELF_KEYS if drives else {})}
        self._controls: list[Any] = []
        self.numbers, self.status, self.facts = (
            html_line("", "nao-numbers"),
            ipywidgets.HTML(),
            ipywidgets.HTML(),
        )
        self.images = {camera: _image(camera) for camera in CAMERAS}
        self.captions = {camera: html_line("", "nao-caption") for camera in CAMERAS}
        self._camera_boxes = {
            camera: box("V", "nao-camera", self.captions[camera], self.images[camera]) for camera in CAMERAS
        }
        settings = self._settings()
        self._world = self._button("world", "3-D", "Show the field in three dimensions, or the map", "cube")
        self._more = box("V", "nao-folded", settings, self.facts)
        self._more.layout.display = "none"
        actions_box = self._action_buttons(has_slam)
        left = box(
            "V",
            "nao-left",
            box("", "nao-cameras", *self._camera_boxes.values()),
            box("H", "nao-controls", self._drive_pad(), self._head_pad(), actions_box),
        )
        self._map = map_widget
        self._face = box("V", "nao-face", map_widget)
        right = box("V", "nao-right", self._face, self._below_map(has_truth, show_truth))
        main = box("", "nao-main", self.numbers, left, right)
        above = [html_line(heading, "nao-ready")] if heading else []
        css = styles(_CSS, _KEYS_AFTER_A_CLICK)
        self.widget = box("V", "nao-panel", css, *above, main, self.status, self._more_button, self._more)
        self.widget.add_class("nao-cockpit")
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
            self._button("look-ahead", "Ahead", "Turn the head back to where it began"),
            self._button("look-right", "Right ▶", "Turn the head 10 degrees to the right"),
            gap,
            self._button("look-down", "▼ Down", "Look down by 5 degrees"),
            self._button("camera", "Camera", "Change to the robot's other camera"),
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
        self._more_button = self._button(
            "more", _MORE, "Show or hide the settings and all details", "caret-right"
        )
        self._more_button.layout.width = "auto"
        self._more_button.add_class("nao-more")
        return box("H", "nao-settings", self.camera, self.size, self.step, self.turn)

    def _choice(self, label: str, options: list[tuple[str, Any]], value: Any, tooltip: str) -> Any:
        choice = ipywidgets.Dropdown(description=label, options=options, value=value)
        choice.tooltip = tooltip
        self._controls.append(choice)
        return choice

    def _action_buttons(self, has_slam: bool) -> Any:
        has_views, drives = "view" in self._keys, "itself" in self._keys
        measure = "Measure landmarks from here" + (" and give them to your SLAM" if has_slam else "")
        tooltip = "Show what your code sees over the picture, in an inset, or not at all"
        go = "Let your code choose where the robot goes, until you press Stop"
        self.view = self._button("view", "View", tooltip, "eye") if has_views else None
        return box(
            "V",
            "nao-actions",
            *([self._button("itself", "By itself", go, "play")] if drives else []),
            *([self.view] if has_views else []),
            self._button("slam", "Run SLAM" if has_slam else "Measure", measure, "crosshairs"),
            self._button("picture", "Take picture", "Take a picture and keep it", "camera"),
        )

    def _below_map(self, has_truth: bool, show_truth: bool) -> Any:
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
        once = ("picture", "slam", "view", "itself", "camera", "more", "world")
        keys = ipywidgets.HTML(key_field(self._keys, _KEY_WORDS, more, hint, once=once))
        keys.layout.flex = "1 1 120px"
        return box("H", "nao-below-map", keys, self._world, self.show_truth)

    def show_face(self, face: Any | None) -> None:
        """Show another widget in the map's place; None shows the map again."""
        self._face.children = (self._map if face is None else face,)
        self._world.description = "3-D" if face is None else "Map"
        self._world.icon = "cube" if face is None else "map"

    def _show_more(self) -> None:
        """Show the settings and the details, or hide them."""
        hidden = self._more.layout.display == "none"
        self._more.layout.display = "" if hidden else "none"
        self._more_button.icon = "caret-down" if hidden else "caret-right"

    def _other_camera(self) -> None:
        """Choose the camera that is not chosen."""
        self.camera.value = next(each for each in CAMERAS if each != self.camera.value)

    def _mark_camera(self) -> None:
        for camera, shown in self._camera_boxes.items():
            (shown.add_class if camera == self.camera.value else shown.remove_class)("nao-chosen")


def _image(camera: str) -> Any:
    image = LabelledImage(format="jpeg", alt=f"Live picture of the {camera} camera")
    image.add_class(f"nao-image-{camera}")
    return image
