"""Building blocks of the panels: encoded pictures, boxes, the status line and the common style."""

from __future__ import annotations

import asyncio
import html
import time
from collections.abc import Callable
from typing import Any, Literal

import anywidget
import cv2
import ipywidgets
import numpy as np
import numpy.typing as npt
import traitlets

from nao_course.exercises.asking import styles_that_keep_keys
from nao_course.plotting import Drawing

StatusKind = Literal["", "alarm", "finish"]

PERIOD = 0.04  # s between two frames: 25 pictures a second
BREATH = 0.01  # s that every frame leaves for buttons and sliders
AHEAD = 1  # pictures on their way to the page while the next one is computed
JPEG_QUALITY = 90
SHOWN_WIDTH = 640  # px; larger pictures are reduced before they are sent to the browser
COMMON_CSS = """
.nao-panel { position: relative; font-size: 13px; overflow: visible; }
.nao-panel .nao-caption { line-height: 18px; height: 20px; margin: 0; }
.nao-panel .nao-caption .widget-html-content { line-height: 18px; }
.nao-panel .nao-heading { font-weight: 600; margin: 0; line-height: 18px; height: 18px; }
.nao-panel .nao-status { padding: 3px 8px; border-left: 4px solid var(--nao-mark, #0b5fa5); line-height: 18px;
  min-height: 54px; background: var(--jp-layout-color2, #eee); overflow-wrap: anywhere; }
.nao-panel .nao-status [role=status] { white-space: pre-line; }
.nao-panel .nao-facts { font-size: 12px; color: var(--jp-ui-font-color2, #555); }
.nao-panel .nao-printed { max-height: 72px; overflow: auto; margin: 2px 0; font-size: 12px; line-height: 16px; }
.nao-panel .nao-alarm { border-left-color: #c84b00; }
.nao-panel .nao-keys { box-sizing: border-box; width: 100%; min-width: 180px; height: 28px; padding: 0 6px;
  font-size: 11px; border-radius: 4px; border: 1px solid var(--jp-border-color1, #bbb);
  background: var(--jp-layout-color1, white); color: var(--jp-ui-font-color1, black); caret-color: transparent; }
.nao-panel .nao-keys:focus { outline: 2px solid var(--nao-mark, #0b5fa5); outline-offset: 1px; }
.nao-panel :focus-visible { outline: 2px solid var(--nao-mark, #0b5fa5); outline-offset: 1px; }
"""


# ipywidgets gives a slider's handles no accessible name, and noUiSlider rounds the value that it reports to one digit.
# A page that forbids such handlers still shows the label beside the slider and the status line below. Space does
# nothing at a slider or on a picture, where it would scroll the page.
_SLIDER_NAMES = """const panel = this.closest('.nao-panel');
if (!panel || panel.naoNames) return;
const put = (each, key, words) => { if (each.getAttribute(key) !== words) each.setAttribute(key, words); };
const name = () => panel.querySelectorAll('.widget-slider').forEach(slider => {
  const words = slider.querySelector('.widget-label')?.textContent || '';
  const handles = slider.querySelectorAll('[role=slider]');
  handles.forEach((handle, i) => {
    put(handle, 'aria-label', handles.length > 1 ? words + (i ? ', to' : ', from') : words);
    const value = handle.getAttribute('aria-valuetext');
    if (value && isFinite(value)) put(handle, 'aria-valuenow', value);
  });
  const typed = slider.querySelector('.widget-readout');
  if (typed) { put(typed, 'role', 'textbox'); put(typed, 'aria-label', words + ', typed'); }
});
panel.addEventListener('keydown', event => {
  if (event.key === ' ' && event.target.matches('[role=slider], [role=application]')) event.preventDefault();
});
panel.naoNames = new MutationObserver(name);
panel.naoNames.observe(panel, {subtree: true, childList: true, attributes: true,
  attributeFilter: ['aria-valuetext', 'aria-valuenow']});
name();"""
# After a click on a button the panel's key field has the keys, so that space plays and does not press the button again.
_KEYS_AFTER_A_BUTTON = """const panel = this.closest('.nao-panel');
if (!panel || panel.naoButtons) return;
panel.naoButtons = true;
panel.addEventListener('click', event => {
  const field = event.detail && event.target.closest('button') && panel.querySelector('.nao-keys');
  if (field) field.focus({preventScroll: true});
});"""

# Shift+Enter chooses the next cell, and JupyterLab holds that cell where it is: a new panel would grow out of sight.
_INTO_SIGHT = """const panel = this.closest('.nao-panel');
if (!panel || panel.naoSeen) return;
panel.naoSeen = true;
if (panel.closest('.jp-Cell:has(+ .jp-Cell.jp-mod-active)')) {
  setTimeout(() => panel.scrollIntoView({block: 'nearest'}), 300);
}"""


class LabelledImage(anywidget.AnyWidget):
    """A picture with a text alternative, which the pictures of ipywidgets do not have.

    `value` is the file and `format` its kind, such as "jpeg". A tooltip would need a description, without which
    ipywidgets shows no picture. A page shows the newest picture when it has loaded the one before, and answers with the
    number of each picture that `show` waits for: `asked` is the latest number and `shown` the latest answer.
    """

    _esm = """
    export default { render({ model, el }) {
      const image = document.createElement("img");
      let url = "", loading = false, newer = false, asked = 0, answered = 0;
      const name = () => { image.alt = model.get("alt"); };
      const show = () => {
        newer = loading;
        if (loading || !model.get("value").byteLength) return;
        const before = url;
        loading = true;
        asked = model.get("asked");
        url = URL.createObjectURL(new Blob([model.get("value")], { type: `image/${model.get("format")}` }));
        image.src = url;
        URL.revokeObjectURL(before);
      };
      image.onload = image.onerror = () => {
        loading = false;
        if (asked > answered) model.send({ shown: answered = asked });
        if (newer) show();
      };
      model.on("change:alt", name);
      model.on("change:value", show);
      name();
      show();
      el.append(image);
      return () => URL.revokeObjectURL(url);
    } };
    """
    value = traitlets.Bytes(b"").tag(sync=True)
    format = traitlets.Unicode("jpeg").tag(sync=True)
    alt = traitlets.Unicode("").tag(sync=True)
    asked = traitlets.Int(0).tag(sync=True)

    def __init__(self, **values: Any) -> None:
        """Begin without an answer of a page."""
        super().__init__(**values)
        self.shown = 0
        self.on_msg(self._note)

    def show(self, value: bytes, alt: str, *, waits: bool) -> None:
        """Show a picture; if `waits`, the pages answer, unless they show the same picture already."""
        with self.hold_sync():
            self.asked += waits and value != self.value
            self.value, self.alt = value, alt

    @property
    def is_behind(self) -> bool:
        """Whether a page that has answered before is more than `AHEAD` pictures behind."""
        return 0 < self.shown < self.asked - AHEAD

    def _note(self, widget: Any, message: Any, buffers: Any) -> None:
        if isinstance(message, dict) and isinstance(number := message.get("shown"), int):
            self.shown = number


class RateLimited:
    """An action that runs at most once per `PERIOD`, however often it is requested.

    The action reads the present state itself and raises nothing.
    """

    def __init__(self, action: Callable[[], None]) -> None:
        """Begin without a request."""
        self._action = action
        self._task: asyncio.Task[None] | None = None
        self._requested = False

    @property
    def busy(self) -> bool:
        """Whether the action is running, or ran less than a `PERIOD` ago."""
        return self._task is not None and not self._task.done() and self._task.get_loop().is_running()

    def ask(self) -> None:
        """Request the action, which runs soon in a kernel's loop, and at once without a loop."""
        self._requested = True
        if self.busy:
            return
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:  # no kernel: a plain Python program
            self._requested = False
            self._action()
            return
        self._task = loop.create_task(self._run())

    async def _run(self) -> None:
        while self._requested:
            self._requested = False
            began = time.perf_counter()
            self._action()
            took = time.perf_counter() - began
            await asyncio.sleep(max(BREATH, PERIOD - took))


def bundle(widget: Any, drawing: Drawing, text: str, alt: str) -> dict[str, Any]:
    """Return a panel's MIME bundle: its widgets, and a picture and a text for places without widgets."""
    shown = widget._repr_mimebundle_()
    if isinstance(shown, tuple):  # anywidget returns metadata, too
        shown = shown[0]
    return {**shown, "text/plain": text, "text/html": drawing.html(alt)}


def styles(own: str, *scripts: str) -> Any:
    """Return the common and own styles of a panel, and scripts for keys, sliders and a new panel's place."""
    return ipywidgets.HTML(
        styles_that_keep_keys(COMMON_CSS + own, _SLIDER_NAMES, _KEYS_AFTER_A_BUTTON, _INTO_SIGHT, *scripts)
    )


def html_line(text: str, name: str) -> Any:
    """Return a line of HTML with a class."""
    widget = ipywidgets.HTML(text)
    widget.add_class(name)
    return widget


def box(kind: str, name: str, *children: Any) -> Any:
    """Return a box with a class; its kind is "H", "V" or "" for a box without a direction."""
    made = {"H": ipywidgets.HBox, "V": ipywidgets.VBox, "": ipywidgets.Box}[kind](children)
    made.add_class(name)
    return made


def status_box(
    message: str,
    facts: str,
    *,
    kind: StatusKind = "",
    shows_where: bool = False,
    printed: str = "",
    board: str = "",
) -> str:
    """Return HTML with the latest message, which a screen reader also reads aloud.

    `facts` is the present state, `kind` says whether the message reports an error or that everything is complete,
    `shows_where` adds that ``raise panel.error`` shows the line of the error, `printed` is the text that the student's
    code printed, and `board` is the most important fact, on its own line.
    """
    words = html.escape(message)
    if shows_where:
        words += " <i>(raise panel.error shows where)</i>"
    if printed.strip():
        words += f'<pre class="nao-printed">{html.escape(printed.rstrip())}</pre>'
    shown = f'<div class="nao-board">{html.escape(board)}</div>' if board else ""
    shown += f'<div class="nao-facts">{html.escape(facts)}</div>' if facts else ""
    return (
        f'<div class="nao-status{f" nao-{kind}" if kind else ""}">'
        f'<div role="status" aria-live="polite">{words}</div>'
        f"{shown}</div>"
    )


def jpeg(pixels: npt.NDArray[np.uint8], quality: int = JPEG_QUALITY) -> bytes:
    """Encode a picture (H, W, 3) as a JPEG file of at most 640 pixels width and a quality of up to 100."""
    if pixels.shape[1] > SHOWN_WIDTH:
        height = round(pixels.shape[0] * SHOWN_WIDTH / pixels.shape[1])
        pixels = np.asarray(
            cv2.resize(pixels, (SHOWN_WIDTH, height), interpolation=cv2.INTER_AREA), dtype=np.uint8
        )
    return _encoded(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])


def png(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Encode a picture (H, W, 3), or (H, W, 4) with opacity, as a PNG file, which keeps the colour of each pixel.

    Drawn pictures have long runs of one colour, and run-length encoding takes half the time of other compression.
    """
    return _encoded(".png", pixels, [cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE])


def _encoded(suffix: str, pixels: npt.NDArray[np.uint8], options: list[int]) -> bytes:
    swap = cv2.COLOR_RGB2BGR if pixels.shape[2] == 3 else cv2.COLOR_RGBA2BGRA
    done, data = cv2.imencode(suffix, cv2.cvtColor(pixels, swap), options)
    if not done:
        raise ValueError(f"OpenCV could not write a {suffix} of shape {pixels.shape}")
    return bytes(data)
