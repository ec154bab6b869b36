"""The control panel's widgets: cameras, map, numbers, buttons and menus. The panel defines what each button does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import ipywidgets

from nao_course.widgets.control_panel.cockpit import CAMERAS
from nao_course.widgets.keyboard import Keys, key_field, key_names
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
    "stop": ("x", "escape"),
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
RECORD_KEYS = {"record": ("r",)}  # only for a real robot
_KEY_WORDS = "Keyboard: W A S D or arrows walk, I J K L turn the head, X or Escape stops"
_MORE_KEY_WORDS = (
    ", space takes a picture, M measures, H looks ahead, C changes the camera, T shows three dimensions, "
    "O opens the settings"
)
_VIEW_KEY_WORDS = ", V changes the view"
_ITSELF_KEY_WORDS = ", G lets the robot go by itself"
_RECORD_KEY_WORDS = ", R begins or ends a recording"
_CAPS = {" ": "Space", "x": "X \N{MIDDLE DOT} Esc"}  # keys whose caps do not have their letter alone

# All heights are fixed or follow from the panel's width, so that nothing moves when a state or a view changes. `--h` is
# the height of picture and map. Beside a picture of 4/3 h there is a map of half a field, 0.82 h, and its lens.
_CSS = """
.nao-cockpit { container-type: inline-size; position: relative; width: 100%; max-width: 1000px; padding: 6px;
  box-sizing: border-box; gap: 6px; border-radius: 8px; }
.nao-cockpit > * { margin: 0; overflow: visible; flex: none; }
.nao-cockpit:has(.nao-keys:focus)::before { content: ""; position: absolute; inset: 2px; border-radius: 6px;
  outline: 2px solid var(--nao-mark, #0b5fa5); pointer-events: none; }
.nao-cockpit .nao-key-place { position: absolute; left: 0; top: 0; width: 1px; height: 1px; opacity: 0;
  overflow: hidden; }
.nao-cockpit .nao-ready .widget-html-content { display: flex; gap: 14px; flex: 1 1 0; min-width: 0;
  line-height: 18px; font-size: 12px; }
.nao-cockpit .nao-ready p { margin: 0; min-width: 90px; white-space: nowrap; overflow: hidden;
  text-overflow: ellipsis; }
.nao-cockpit .nao-ready p:first-child:not(:only-child) { flex: none; max-width: 72%; }
.nao-cockpit .nao-numbers .widget-html-content { display: grid; grid-template-columns: 3fr 3fr 4fr; gap: 6px; }
.nao-cockpit .nao-tile { min-width: 0; padding: 1px 8px 2px; border-left: 4px solid #0b5fa5; border-radius: 4px;
  background: var(--jp-layout-color2, #eee); font-size: 12px; line-height: 20px; }
.nao-cockpit .nao-tile :is(span, b, small) { white-space: nowrap; }
.nao-cockpit .nao-tile b { font-size: 15px; margin-left: 4px; font-variant-numeric: tabular-nums; }
.nao-cockpit .nao-tile small { display: block; font-size: 11px; line-height: 14px; overflow: hidden;
  text-overflow: ellipsis; }
.nao-cockpit .nao-good { border-left-color: #1f9d61; }
.nao-cockpit .nao-bad { border-left-color: #b3001b; }
.nao-cockpit .nao-stage { --h: clamp(150px, (100cqw - 109px) / 2.15, 400px); display: grid; gap: 12px;
  height: var(--h); grid-template-columns: calc(var(--h) * 4 / 3) minmax(0, 1fr); }
.nao-cockpit .nao-stage > * { margin: 0; height: var(--h); overflow: visible; }
.nao-cockpit .nao-cameras { position: relative; display: block; border-radius: 6px; overflow: hidden; }
.nao-cockpit .nao-camera { margin: 0; overflow: hidden; cursor: pointer; }
.nao-cockpit .nao-camera img { width: 100%; height: auto; aspect-ratio: 4 / 3; object-fit: fill; display: block; }
.nao-cockpit .nao-camera .nao-caption { height: 18px; padding: 0 6px; box-sizing: border-box; color: #fff;
  background: #10151cb3; overflow: hidden; }
.nao-cockpit .nao-camera .nao-caption .widget-html-content { color: #fff; font-size: 11px; white-space: nowrap;
  overflow: hidden; text-overflow: ellipsis; }
.nao-cockpit .nao-chosen { cursor: default; }
.nao-cockpit .nao-chosen .nao-caption { position: absolute; z-index: 1; left: 6px; top: 6px; max-width: 62%;
  border-radius: 9px; }
.nao-cockpit .nao-camera:not(.nao-chosen) .nao-caption span { display: none; }
.nao-cockpit .nao-camera:not(.nao-chosen) { position: absolute; z-index: 1; right: 6px; top: 6px; width: 30%;
  border: 2px solid #fff; border-radius: 5px; box-sizing: border-box; box-shadow: 0 1px 6px #0008; }
.nao-cockpit .nao-over { position: absolute; z-index: 2; left: 0; right: 0; bottom: 0; max-height: 48%; margin: 0;
  overflow: auto; }
.nao-cockpit .nao-over .widget-html-content { color: #fff; }
.nao-cockpit .nao-over .nao-status { min-height: 36px; padding: 3px 8px 4px; background: #10151cc7; color: #fff; }
.nao-cockpit .nao-over .nao-board { font-size: 12px; }
.nao-cockpit .nao-over .nao-printed { color: inherit; background: none; }
.nao-cockpit .nao-over .nao-finish { border-left-color: #2fbf71; }
.nao-cockpit .nao-finish [role=status] { font-size: 15px; font-weight: 600; line-height: 20px; }
@media (prefers-reduced-motion: no-preference) {
  .nao-cockpit .nao-over:has(.nao-finish) { animation: nao-finish 3.4s ease-in; }
}
@keyframes nao-finish { 0%, 88% { transform: translateY(calc(50% - var(--h) / 2)); } }
.nao-cockpit .nao-face .nao-map { position: relative; display: block; height: var(--h); }
.nao-cockpit .nao-map-legend { height: 20px; padding: 0 18px 0 0; gap: 0 10px; font-size: 11px; line-height: 20px;
  overflow: hidden; position: relative; box-sizing: border-box; align-content: flex-start; border-radius: 4px; }
.nao-cockpit .nao-map-legend::after { content: "\\22EF"; position: absolute; right: 3px; top: 0; }
.nao-cockpit .nao-map-legend:hover { position: absolute; z-index: 3; left: 0; right: 0; bottom: 0; height: auto;
  padding: 2px 4px; overflow: visible; background: var(--jp-layout-color1, #fff); box-shadow: 0 0 6px #0006; }
.nao-cockpit .nao-map-legend:hover::after { content: none; }
.nao-cockpit .nao-map-legend span { gap: 2px; white-space: nowrap; height: 20px; }
.nao-cockpit .nao-map-legend .path { order: -1; }
.nao-cockpit .nao-map-legend canvas { transform: scale(0.8); margin: 0 -3px; }
.nao-cockpit .nao-map-lens { position: absolute; right: 0; bottom: 22px; width: min(116px, 30%); flex-direction: column;
  gap: 2px; margin: 0; font-size: 10px; line-height: 12px; text-align: center; }
.nao-cockpit .nao-map-lens[hidden] { display: none; }
.nao-cockpit .nao-map-lens canvas { width: 100% !important; height: auto !important; }
.nao-cockpit .nao-face .nao-world { max-width: none !important; }
.nao-cockpit .nao-face .nao-world .stage { height: calc(var(--h) - 20px); aspect-ratio: auto !important; }
.nao-cockpit .nao-face .nao-world .keys { margin: 0; height: 20px; line-height: 20px; font-size: 11px;
  white-space: nowrap; overflow: hidden; text-overflow: ellipsis; }
.nao-cockpit .nao-caps { display: flex; flex-wrap: wrap; gap: 6px 18px; }
.nao-cockpit .nao-caps > * { margin: 0; overflow: visible; display: grid; gap: 4px; }
.nao-cockpit .nao-pad { grid-template-columns: repeat(3, 66px); flex: none; }
.nao-cockpit .nao-actions { grid-template-columns: repeat(4, minmax(0, 1fr)); flex: 1 1 300px; }
.nao-cockpit .nao-actions:not(:has(.nao-do-view)) { grid-template-columns: repeat(3, minmax(0, 1fr)); }
.nao-cockpit .nao-caps button { display: flex; flex-direction: column; justify-content: center; align-items: center;
  width: auto; height: 38px; margin: 0; padding: 0 1px; font-size: 11px; line-height: 14px; border-radius: 6px;
  color: var(--jp-ui-font-color1, #222); background: var(--jp-layout-color1, #fff); box-shadow: none;
  border: 1px solid var(--jp-border-color1, #bbb); border-bottom-width: 3px; }
.nao-cockpit .nao-caps button:hover { background: var(--jp-layout-color2, #eee); }
.nao-cockpit .nao-caps button:active { border-bottom-width: 1px; padding-top: 2px; }
.nao-cockpit .nao-caps button::before { font-size: 13px; line-height: 17px; font-weight: 700; }
.nao-cockpit:has(.nao-keys:focus) .nao-caps button::before { color: var(--nao-mark, #0b5fa5); }
.nao-cockpit .nao-caps .widget-checkbox { display: flex; align-items: center; width: auto; height: 38px; margin: 0; }
.nao-cockpit .nao-caps .widget-checkbox label { display: flex; align-items: center; gap: 4px; font-size: 12px;
  line-height: 15px; white-space: normal; }
.nao-cockpit .nao-settings { gap: 3px 14px; flex-wrap: wrap; overflow: visible; }
.nao-cockpit .nao-settings .widget-dropdown { width: 172px; margin: 0; }
.nao-cockpit .nao-settings .widget-label { min-width: 54px; width: 54px; }
.nao-cockpit .nao-facts { font-size: 12px; line-height: 18px; }
.nao-cockpit .nao-facts ul { margin: 4px 0; padding-left: 18px; }
@container (max-width: 680px) {
  .nao-cockpit .nao-stage { --h: clamp(150px, (100cqw - 30px) / 2.15, 400px); }
  .nao-cockpit .nao-tile b { display: block; margin: 0; }
  .nao-cockpit .nao-tile:not(.nao-bad) small, .nao-cockpit .nao-bad span { display: none; }
  .nao-cockpit .nao-over .nao-board { white-space: nowrap; overflow: hidden; text-overflow: ellipsis; }
  .nao-cockpit .nao-map-lens figcaption { display: none; }
  .nao-cockpit .nao-camera:not(.nao-chosen) .nao-caption { padding: 0 3px; }
  .nao-cockpit .nao-camera:not(.nao-chosen) .nao-caption .widget-html-content { font-size: 10px; }
}
@container (min-width: 520px) and (max-width: 680px) {
  .nao-cockpit .nao-map-legend { height: 40px; }
  .nao-cockpit .nao-map-lens { bottom: 42px; }
}
@container (max-width: 440px) {
  .nao-cockpit .nao-stage { --h: 75cqw; grid-template-columns: minmax(0, 1fr); }
  .nao-cockpit .nao-face, .nao-cockpit.nao-swapped .nao-cameras { display: none; }
  .nao-cockpit.nao-swapped .nao-face { display: block; }
  .nao-cockpit .nao-tile :is(span, small) { display: none; }
  .nao-cockpit .nao-pad { grid-template-columns: repeat(3, 1fr); flex: 1 1 120px; }
}
"""

# A press in the panel gives the keys to its key field, before any key can reach JupyterLab, unless it opens a menu or
# selects text. A menu that was changed with the mouse gives them back. A click on the small picture chooses its camera.
# On a page with room for the picture alone, T or a click changes between picture, map and three dimensions.
_KEYS_AFTER_A_CLICK = """const panel = this.closest('.nao-panel');
if (!panel || panel.naoClicks) return;
panel.naoClicks = true;
const take = () => panel.querySelector('.nao-keys')?.focus({preventScroll: true});
const takeLater = () => { if (getSelection().isCollapsed) take(); };
const isOwn = event => event.target.closest('select, input, label, a, pre, .nao-facts, .nao-status');
const isNarrow = () => ['.nao-cameras', '.nao-face'].some(each => !panel.querySelector(each)?.offsetWidth);
const swap = () => panel.classList.toggle('nao-swapped');
let mouse = false;
panel.addEventListener('pointerdown', event => { mouse = true; if (!isOwn(event)) take(); });
panel.addEventListener('mousedown', event => { if (!isOwn(event)) { event.preventDefault(); take(); } });
panel.addEventListener('keydown', () => { mouse = false; });
panel.addEventListener('click', event => {
  if (event.target.closest('.nao-do-world') && isNarrow()) {
    const shown = panel.classList.contains('nao-swapped'), in3d = Boolean(panel.querySelector('.nao-face .nao-world'));
    if (!shown || in3d) swap();
    if (!shown) event.stopPropagation();
  }
}, true);
panel.addEventListener('click', event => {
  if (!event.detail) return;
  if (event.target.closest('.nao-camera:not(.nao-chosen)')) panel.querySelector('.nao-do-camera')?.click();
  else if (event.target.closest('.nao-camera, .nao-map-canvas') && isNarrow()) swap();
  if (!event.target.closest('select, a, pre')) setTimeout(takeLater);
});
panel.addEventListener('change', () => { if (mouse) setTimeout(takeLater); });"""


class Controls:
    """The control panel's widgets in one box.

    `heading` is HTML above the other widgets, `has_views` means that functions of the student can draw over the
    picture, `drives` that one of them chooses the robot's motions, and `records` that a recording of the robot can be
    made: its button has the place of the truth's. The settings `camera`, `size` (width, height) in
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
        records: bool = False,
    ) -> None:
        """Build the widgets."""
        self._actions = {**actions, "more": self._show_more, "camera": self._other_camera}
        self._keys = {
            **KEYS,
            **(VIEW_KEYS if has_views else {}),
            **(ITSELF_KEYS if drives else {}),
            **(RECORD_KEYS if records else {}),
        }
        self._controls: list[Any] = []
        self.numbers, self.status, self.facts = (
            html_line("", "nao-numbers"),
            html_line("", "nao-over"),
            ipywidgets.HTML(),
        )
        self.images = {camera: _image(camera) for camera in CAMERAS}
        self.captions = {camera: html_line("", "nao-caption") for camera in CAMERAS}
        self._camera_boxes = {
            camera: box("V", "nao-camera", self.captions[camera], self.images[camera]) for camera in CAMERAS
        }
        self._more = box("V", "nao-folded", self._settings(), self.facts)
        self._more.layout.display = "none"
        cameras = box("", "nao-cameras", *self._camera_boxes.values(), self.status)
        self._map = map_widget
        self._face = box("V", "nao-face", map_widget)
        stage = box("", "nao-stage", cameras, self._face)
        actions_box = self._action_buttons(has_slam, has_truth, show_truth)
        caps = box("", "nao-caps", self._drive_pad(), self._head_pad(), actions_box)
        above = [html_line(heading, "nao-ready")] if heading else []
        css = styles(_CSS + _cap_css(self._keys), _KEYS_AFTER_A_CLICK)
        self.widget = box(
            "V", "nao-panel", css, self._key_field(), *above, self.numbers, stage, caps, self._more
        )
        self.widget.add_class("nao-cockpit")
        self.camera.observe(lambda change: self._mark_camera(), "value")
        self._mark_camera()

    def disable(self) -> None:
        """Disable all buttons and menus."""
        for control in self._controls:
            control.disabled = True

    def _button(self, name: str, label: str, tooltip: str) -> Any:
        tooltip = f"{tooltip} (key: {key_names(self._keys[name])})"
        button = ipywidgets.Button(description=label, tooltip=tooltip)
        button.add_class(f"nao-do-{name}")
        button.on_click(lambda _: self._actions[name]())
        self._controls.append(button)
        return button

    def _drive_pad(self) -> Any:
        gap = ipywidgets.Box()
        return box(
            "",
            "nao-pad",
            gap,
            self._button("forward", "Ahead", "Walk ahead by one step"),
            gap,
            self._button("left", "Left", "Turn left on the spot"),
            self._button("back", "Back", "Walk backwards by one step"),
            self._button("right", "Right", "Turn right on the spot"),
        )

    def _head_pad(self) -> Any:
        return box(
            "",
            "nao-pad",
            self._button("camera", "Camera", "Change to the robot's other camera"),
            self._button("look-up", "Look up", "Look up by 5 degrees"),
            self._button("look-ahead", "Centre", "Turn the head back to where it began"),
            self._button("look-left", "Look left", "Turn the head 10 degrees to the left"),
            self._button("look-down", "Look down", "Look down by 5 degrees"),
            self._button("look-right", "Look right", "Turn the head 10 degrees to the right"),
        )

    def _settings(self) -> Any:
        cameras = [(camera.capitalize(), camera) for camera in CAMERAS]
        self.camera = self._choice("Camera", cameras, "bottom", "Which camera takes pictures and measures")
        self.size = self._choice(
            "Size", list(SIZES.items()), SIZES["320 × 240"], "Size of pictures that are kept"
        )
        self.step = self._choice("Step", list(STEPS.items()), 0.2, "How far one press walks")
        self.turn = self._choice("Turn", list(TURNS.items()), 15.0, "How far one press turns")
        return box("H", "nao-settings", self.camera, self.size, self.step, self.turn)

    def _choice(self, label: str, options: list[tuple[str, Any]], value: Any, tooltip: str) -> Any:
        choice = ipywidgets.Dropdown(description=label, options=options, value=value)
        choice.tooltip = tooltip
        self._controls.append(choice)
        return choice

    def _action_buttons(self, has_slam: bool, has_truth: bool, show_truth: bool) -> Any:
        measure = "Measure landmarks from here" + (" and give them to your SLAM" if has_slam else "")
        tooltip = "Show what your code sees over the picture, in an inset, or not at all"
        go = "Let your code choose where the robot goes, until you press Stop"
        self.view = self._button("view", "View", tooltip) if "view" in self._keys else None
        self._world = self._button("world", "3-D", "Show the field in three dimensions, or the map")
        self.show_truth = ipywidgets.Checkbox(
            value=show_truth and has_truth, description="Show the truth", indent=False, disabled=not has_truth
        )
        self.show_truth.tooltip = (
            "Draw the robot's true pose" if has_truth else "This panel was made without the truth"
        )
        self._controls.append(self.show_truth)
        return box(
            "",
            "nao-actions",
            *([self._button("itself", "By itself", go)] if "itself" in self._keys else []),
            *([self.view] if self.view is not None else []),
            self._button("picture", "Take picture", "Take a picture and keep it"),
            self._button("record", "Record", "Begin or end a recording of the drive")
            if "record" in self._keys
            else self.show_truth,
            self._button("stop", "Stop", "Stop the drive"),
            self._world,
            self._button("slam", "Run SLAM" if has_slam else "Measure", measure),
            self._button("more", "Settings", "Show or hide the settings and all details"),
        )

    def _key_field(self) -> Any:
        """Return the field that has the keys while the panel is framed."""
        more = (
            _MORE_KEY_WORDS
            + (_VIEW_KEY_WORDS if "view" in self._keys else "")
            + (_ITSELF_KEY_WORDS if "itself" in self._keys else "")
            + (_RECORD_KEY_WORDS if "record" in self._keys else "")
        )
        once = ("picture", "slam", "view", "itself", "camera", "more", "world", "record")
        return html_line(key_field(self._keys, _KEY_WORDS, more, "", once=once), "nao-key-place")

    def show_face(self, face: Any | None) -> None:
        """Show another widget in the map's place; None shows the map again."""
        self._face.children = (self._map if face is None else face,)
        self._world.description = "3-D" if face is None else "Map"

    def _show_more(self) -> None:
        """Show the settings and the details, or hide them."""
        hidden = self._more.layout.display == "none"
        self._more.layout.display = "" if hidden else "none"

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


def _cap_css(keys: Keys) -> str:
    """Return the CSS that writes each button's key on the button."""
    caps = {name: _CAPS.get(first, first.upper()) for name, (first, *_) in keys.items()}
    return "\n".join(
        f'.nao-cockpit .nao-do-{name}::before {{ content: "{cap}"; }}' for name, cap in caps.items()
    )
