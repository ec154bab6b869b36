"""A panel from a function and a list of controls."""

from __future__ import annotations

import html
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import ipywidgets
import numpy as np

from nao_course.plotting import Drawing
from nao_course.widgets.attempts import TIME_LIMIT, Attempt, StudentCode, attempt
from nao_course.widgets.inputs import (
    Action,
    Choice,
    Control,
    Pixel,
    RangeSlider,
    Slider,
    Values,
    check_controls,
)
from nao_course.widgets.keyboard import key_field, key_names, key_sign
from nao_course.widgets.parts import LabelledImage, Newest, box, bundle, html_line, status_box, styles
from nao_course.widgets.shown import Shown, encoded, parts_of

SLOW = 0.1  # s for one call of the student's code: from here on the panel says why it lags
TALLEST = 430  # px of a picture on the page: the panel fits on a laptop's screen
_CSS = """
.nao-function .nao-pictures { gap: 8px; flex-wrap: wrap; overflow: visible; }
.nao-function .nao-column { flex: 1 1 0; min-width: 150px; overflow: visible; }
.nao-function .nao-frame { position: relative; overflow: visible; }
.nao-function .nao-frame img { display: block; width: 100%; height: auto; margin: 0; box-sizing: border-box; }
.nao-function .nao-photo img { border: 1px solid #888; }
.nao-function .nao-small img { image-rendering: pixelated; }
.nao-function .nao-pad { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; overflow: visible; }
.nao-function .nao-pad .widget-html-content, .nao-function .nao-pad-over { position: absolute; inset: 0; }
.nao-function .nao-pad-over { cursor: crosshair; touch-action: none; }
.nao-function .nao-pad-over:focus { outline: 2px solid #0b5fa5; outline-offset: 1px; }
.nao-function .nao-mark { pointer-events: none; }
.nao-function .nao-cursor { position: absolute; width: 15px; height: 15px; transform: translate(-50%, -50%);
  box-sizing: border-box; border: 2px solid #c84b00; border-radius: 50%;
  box-shadow: 0 0 0 1.5px white, inset 0 0 0 1.5px white; }
.nao-function .nao-choices { gap: 10px; align-items: center; flex-wrap: wrap; overflow: visible; }
.nao-function .nao-choices > * { margin: 0; }
.nao-function .nao-choices .widget-dropdown { width: auto; min-width: 120px; }
.nao-function .nao-choices .widget-text { width: auto; }
.nao-function .nao-choices .widget-text input { width: 84px; flex: 0 0 84px; }
.nao-function .nao-choices button { width: auto; padding: 0 14px; }
.nao-function .nao-choices .widget-label { width: auto; }
.nao-function .nao-choices .widget-checkbox label { display: flex; align-items: center; gap: 4px; }
.nao-function .nao-choices .nao-key-line { flex: 1 1 200px; max-width: 100%; }
.nao-function .nao-below { gap: 24px; flex-wrap: wrap; align-items: flex-start; overflow: visible; margin-top: 2px; }
.nao-function .nao-sliders { flex: 1 1 480px; overflow: visible; }
.nao-function .nao-sliders .widget-slider { width: 100%; max-width: 560px; height: 26px; margin: 0; }
.nao-function .nao-sliders .widget-label { width: 120px; }
.nao-function .noUi-handle:focus { outline: 2px solid #0b5fa5; outline-offset: 2px; }
.nao-function .nao-scores { flex: 0 0 auto; }
.nao-function .nao-scores table { border-collapse: collapse; font-size: 13px; line-height: 22px; margin: 0; }
.nao-function .nao-scores th, .nao-function .nao-scores td { padding: 1px 10px; text-align: right; }
.nao-function .nao-scores b { padding: 0 10px; }
.nao-function .nao-scores tbody th { text-align: left; font-weight: normal; }
.nao-function .nao-scores td { font-variant-numeric: tabular-nums; min-width: 70px; }
.nao-function .nao-key { display: inline-block; width: 11px; height: 11px; border: 1px solid #555; margin-right: 5px;
  vertical-align: -1px; }
.nao-function .nao-legend { font-size: 12px; line-height: 18px; }
.nao-function .nao-legend span { white-space: nowrap; margin-right: 12px; }
"""

Show = Callable[[Values, StudentCode], Any]


class FunctionPanel:
    """A panel that shows what a function makes of its controls' values.

    Parameters
    ----------
    title : str
        What the panel is, for texts and readers who cannot see it.
    show : callable
        ``show(values, student)`` returns what to show, or yields several of them: a picture, a Drawing, a table, a
        text, a Legend, or {title: picture, Drawing or table}. What was yielded before an error stays.
    controls : sequence of Control
        What can be set.
    student : mapping of str to callable, optional
        The student's functions, by the names under which `show` finds them.
    unfinished : str or mapping of str to str, optional
        What to say where one raises NotImplementedError; a mapping has a sentence for each.
    seed : int
        Of ``values.rng``, which begins the same at each call.
    time_limit : float
        Seconds for one call of `show`; one that takes longer is stopped, and the panel says so.

    Raises
    ------
    ValueError
        If controls share a name or a key, or a start is out of its limits.

    Examples
    --------
    >>> def show(values, student):
    ...     yield np.full((4, 4), values.grey, dtype=np.uint8)
    ...     yield f"The square is {student.square(values.grey)}."
    >>> panel = FunctionPanel("Grey", show, [Slider("grey", "Grey", 0, 255, 1, 7)], student={"square": lambda x: x * x})
    >>> panel.set(grey=9)
    >>> print(panel.summary())
    Grey 9
    The square is 81.
    """

    css = ""  # the look of a kind of panel, beside that of all

    def __init__(
        self,
        title: str,
        show: Show,
        controls: Sequence[Control],
        *,
        student: Mapping[str, Callable[..., Any]] | None = None,
        unfinished: str | Mapping[str, str] | None = None,
        seed: int = 0,
        time_limit: float = TIME_LIMIT,
    ) -> None:
        """Show what the first values give, and build the widgets."""
        check_controls(controls)
        self.title, self.time_limit, self.seed = title, time_limit, seed
        self._show, self._student, self._unfinished = show, StudentCode(student or {}), unfinished
        self._controls = {each.name: each for each in controls}
        self._values = self._start()
        self._shown, self._latest = Shown({}, {}), Attempt[None]()
        self._error: BaseException | None = None
        self._refused = ""
        self._moving = False
        self._one_at_a_time = threading.RLock()
        self._newest = Newest(self._update)
        self._build()
        self._update()

    # --- from code ---

    def set(self, **values: Any) -> None:
        """Set some controls, at once.

        Raises
        ------
        ValueError
            If a value is out of its limits; nothing is set then.
        TypeError
            For a control that there is not.
        """
        self._put(self._checked(values))

    def reset(self) -> None:
        """Set all controls back to where they began, but for those that stay."""
        self._put(self._start() | {name: self._values[name] for name in self._staying()})

    @property
    def values(self) -> Values:
        """Where the controls stand."""
        presses = [
            self._values[name]
            for name, each in self._controls.items()
            if name in self._values and isinstance(each, Action)
        ]
        return Values(self._values, np.random.default_rng([self.seed, *presses]))

    @property
    def error(self) -> BaseException | None:
        """What the student's code raised last; ``raise panel.error`` shows where it came from."""
        return self._error

    @property
    def shown(self) -> Shown:
        """What `show` gave for the present values: all it had yielded where it failed."""
        return self._shown

    def say_values(self) -> str:
        """Say where the controls stand."""
        words = (self._controls[name].say(value) for name, value in self._values.items())
        return ", ".join(filter(None, words))

    def summary(self) -> str:
        """Say where the controls stand and what is shown, or why there is nothing."""
        shown = self._shown
        failed = [] if self._latest.done else [self._latest.message]
        lines = [self.say_values(), *shown.texts, *map(repr, shown.tables.values()), *failed]
        return "\n".join(filter(None, lines))

    def drawing(self) -> Drawing:
        """Return what the panel shows as a figure, for where no widget can live."""
        marks = {self._picture_of(each): self._values[each.name] for each in self._pixels()}
        return self._shown.drawing(f"{self.title}: {'; '.join(self.summary().splitlines())}", marks)

    def __repr__(self) -> str:
        """Say what the panel shows."""
        return f"{self.title}: {self.summary()}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Show the widgets; beside them lie a picture and the summary for where they cannot live."""
        drawing = self.drawing()
        return bundle(self.widget, drawing, repr(self), drawing.alt)

    # --- values ---

    def _start(self) -> dict[str, Any]:
        return {name: each.first for name, each in self._controls.items() if not _only_sets(each)}

    def _staying(self) -> list[str]:
        return [name for name, each in self._controls.items() if isinstance(each, Choice) and each.stays]

    def _checked(self, values: Mapping[str, Any]) -> dict[str, Any]:
        if unknown := sorted(values.keys() - self._values.keys()):
            raise TypeError(f"this panel has no {', '.join(unknown)}; it has {', '.join(self._values)}")
        return self._values | {name: self._controls[name].checked(value) for name, value in values.items()}

    def _put(self, values: dict[str, Any]) -> None:
        """Take on values, and move the controls without a picture for each."""
        self._take(values)
        self._update()

    def _take(self, values: dict[str, Any]) -> None:
        self._values, self._moving, self._refused = values, True, ""
        for name, control in self._controls.items():
            if name in values and not isinstance(control, Action):
                self._widgets[name].value = control.to_widget(values[name])
        self._moving = False

    def _moved(self, control: Control, change: Any) -> None:
        """Follow a control on the page."""
        if self._moving:
            return
        try:
            self._values = self._checked({control.name: control.from_widget(change["new"])})
            self._refused = ""
        except (
            ValueError
        ) as error:  # typed, and not possible: a callback has nobody above it who could catch it
            self._take(self._values)
            self._refused = str(error)
        self._newest.ask()

    def _pressed(self, action: Action) -> None:
        counted = {} if action.sets else {action.name: self._values[action.name] + 1}
        self._take(self._checked({**action.sets, **counted}))
        self._newest.ask()

    # --- the student's code ---

    def _update(self) -> None:
        """Ask the function, and show what comes of it."""
        with self._one_at_a_time:  # a slider's thread and a cell's
            before, parts = self._shown, list[Any]()
            self._student.begin()
            self._latest = Attempt(message="Interrupted.")  # unless what follows comes to its end
            self._latest = attempt(
                lambda: self._ask(parts),
                self._whose,
                limit=self.time_limit,
                unfinished=self._say_unfinished,
                quiet=True,
            )
            self._error = self._latest.error or self._error
            if not self._latest.done:
                self._shown = Shown.of(_showable(parts))
            self._display(before)

    def _ask(self, parts: list[Any]) -> None:
        for part in parts_of(self._show(self.values, self._student)):
            parts.append(part)
        self._shown = Shown.of(parts)

    def _whose(self) -> str:
        student = self._student
        if student.running:
            return _called(student.running)
        return f"the panel, which uses what {_called(student.last)} returned" if student.last else "the panel"

    def _say_unfinished(self) -> str:
        name = self._student.called
        if isinstance(self._unfinished, Mapping) and name in self._unfinished:
            return self._unfinished[name]
        if isinstance(self._unfinished, str):
            return self._unfinished
        return f"Finish {_called(name) if name else 'the exercise'} to see this."

    # --- showing ---

    def _display(self, before: Shown) -> None:
        """Bring what is shown to the page; a picture that failed leaves its place empty."""
        empty = {
            title: np.full_like(pixels, 225)
            for title, pixels in before.pictures.items()
            if not self._latest.done and title not in self._shown.pictures
        }
        places = {**self._shown.pictures, **empty}
        while len(self._images) < len(places):
            self._add_place()
        for number, (title, pixels) in enumerate(places.items()):
            if not _same(pixels, self._sent[number], title):
                self._sent[number] = (title, pixels)
                self._fill(number, title, pixels, title in empty)
        columns = tuple(self._columns[: len(places)])
        if self._pictures.children != columns:
            self._pictures.children = columns
        self._lay_pads(list(places))
        self._legend.value = "".join(each._repr_html_() for each in self._shown.legends)
        self._table.value = self._shown.tables_html()
        self._table.layout.display = "" if self._shown.tables else "none"
        self._status.value = self._say_status()

    def _fill(self, number: int, title: str, pixels: Any, is_empty: bool) -> None:
        image, caption, column = self._images[number], self._captions[number], self._columns[number]
        is_figure = title in self._shown.drawings
        image.format, image.value = encoded(pixels, is_figure)
        note = " (nothing yet)" if is_empty else ""
        image.alt = image.description = image.tooltip = f"{title.strip() or self.title}{note}"
        caption.layout.display = "" if title.strip() else "none"
        caption.value = f"<b>{html.escape(title.strip())}</b>{note}"
        height, width = pixels.shape[:2]
        most = width if is_figure else max(width, 322)
        column.layout.max_width = f"{min(most, TALLEST * width // height)}px"
        column.layout.flex = f"{width / height:.3f} 1 {'340px' if is_figure else '0'}"
        for name, holds in (("nao-photo", not is_figure), ("nao-small", width <= 64)):
            (column.add_class if holds else column.remove_class)(name)

    def _lay_pads(self, titles: list[str]) -> None:
        """Lay each pixel's mark and pad over its picture."""
        over: dict[str, list[Any]] = {title: [] for title in titles}
        for control in self._pixels():
            pad, mark = self._pads[control.name]
            mark.value = control.mark(self._values[control.name])
            over.get(self._picture_of(control), []).extend((mark, pad))
        for image, frame, title in zip(self._images, self._frames, titles, strict=False):
            if frame.children != (children := (image, *over[title])):
                frame.children = children

    def _say_status(self) -> str:
        latest, values = self._latest, self.say_values()
        if self._refused:
            return status_box(self._refused, values, alarm=True)
        if not latest.done:
            where = latest.error is not None and not latest.unfinished
            return status_box(latest.message, values, alarm=True, shows_where=where, printed=latest.printed)
        texts = "\n".join(self._shown.texts)
        return status_box(texts or values, self.say_pace(self._student.seconds), printed=latest.printed)

    def say_pace(self, seconds: float) -> str:
        """Say how long the student's code took."""
        if not self._student.called:
            return ""
        slowly = " The panel follows slowly." if seconds > SLOW else ""
        return f"Your code took {1000 * seconds:.0f} ms.{slowly}"

    # --- widgets ---

    def _pixels(self) -> list[Pixel]:
        return [each for each in self._controls.values() if isinstance(each, Pixel)]

    def _keyed(self) -> list[Action]:
        return [each for each in self._controls.values() if isinstance(each, Action) and each.key]

    def _picture_of(self, control: Pixel) -> str:
        return control.picture or next(iter(self._shown.pictures), "")

    def _build(self) -> None:
        self._widgets = {name: each.widget() for name, each in self._controls.items()}
        self._images: list[Any] = []
        self._sent: list[tuple[str, Any]] = []  # what the page has of each, so that only news are sent
        self._captions: list[Any] = []
        self._frames: list[Any] = []
        self._columns: list[Any] = []
        self._pads = {
            each.name: (html_line(each.pad(), "nao-pad"), html_line("", "nao-pad")) for each in self._pixels()
        }
        for _, mark in self._pads.values():
            mark.add_class("nao-mark")
        for name, control in self._controls.items():
            if isinstance(control, Action):
                self._widgets[name].on_click(lambda pressed, action=control: self._pressed(action))
            else:
                self._widgets[name].observe(partial(self._moved, control), "value")
        self._pictures, self._legend = box("H", "nao-pictures"), html_line("", "nao-legend")
        self._table, self._status = html_line("", "nao-scores"), ipywidgets.HTML()
        sliders = [self._widgets[name] for name, each in self._controls.items() if _slides(each)]
        self.widget = box(
            "V",
            "nao-panel",
            styles(_CSS + self.css),
            self._pictures,
            box("H", "nao-choices", *self._small_controls(), *self._key_line(), self._legend),
            box("H", "nao-below", box("V", "nao-sliders", *sliders), self._table),
            self._status,
        )
        self.widget.add_class("nao-function")

    def _small_controls(self) -> list[Any]:
        but = "".join(f"; {self._controls[name].label} stays" for name in self._staying())
        again = ipywidgets.Button(description="Reset", tooltip=f"Set everything back to where it began{but}")
        again.on_click(lambda pressed: self.reset())
        again.add_class("nao-do-reset")
        return [*(self._widgets[name] for name, each in self._controls.items() if not _slides(each)), again]

    def _key_line(self) -> list[Any]:
        keys = {each.css_class("do").removeprefix("nao-do-"): (each.key.lower(),) for each in self._keyed()}
        if not keys:
            return []
        said = ", ".join(f"{key_names((each.key.lower(),))}: {each.label}" for each in self._keyed())
        hint = "Keys: " + ", ".join(f"{key_sign(each.key.lower())} {each.label}" for each in self._keyed())
        field = key_field(keys, html.escape(f"Keyboard: click here, then {said}"), "", html.escape(hint))
        line = html_line(field, "nao-key-line")
        line.layout.min_width = (
            f"min(100%, {len(hint)}ch)"  # all of it can be read, on a line of its own if need be
        )
        return [line]

    def _add_place(self) -> None:
        self._images.append(LabelledImage())
        self._sent.append(("", None))
        self._captions.append(html_line("", "nao-caption"))
        self._frames.append(box("", "nao-frame", self._images[-1]))
        self._columns.append(box("V", "nao-column", self._captions[-1], self._frames[-1]))


def _same(pixels: Any, sent: tuple[str, Any], title: str) -> bool:
    return sent[1] is not None and title == sent[0] and np.array_equal(pixels, sent[1])


def _slides(control: Control) -> bool:
    return isinstance(control, Slider | RangeSlider)


def _only_sets(control: Control) -> bool:
    return isinstance(control, Action) and bool(control.sets)


def _called(name: str) -> str:
    """A function's name as one would call it; words as they are."""
    return f"{name}()" if name.isidentifier() else name


def _showable(parts: Sequence[Any]) -> list[Any]:
    """Those of the parts that can be shown."""
    good = []
    for part in parts:
        try:
            Shown.of([part])
        except (TypeError, ValueError):
            continue
        good.append(part)
    return good
