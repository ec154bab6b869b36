"""A panel that is made from a function and a list of controls."""

from __future__ import annotations

import asyncio
import html
import threading
from collections.abc import Callable, Collection, Mapping, Sequence
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
from nao_course.widgets.layout import lay_out, place_beside, switch
from nao_course.widgets.parts import RateLimited, box, bundle, html_line, status_box
from nao_course.widgets.picture_row import CSS, SMALL, PictureRow
from nao_course.widgets.shown import Shown, parts_of

_CSS = """
.nao-function .nao-pad { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; overflow: visible; }
.nao-function .nao-pad .widget-html-content, .nao-function .nao-pad-over { position: absolute; inset: 0; }
.nao-function .nao-pad-over { cursor: crosshair; touch-action: none; }
.nao-function .nao-pad-over:focus { outline: 2px solid var(--nao-mark, #0b5fa5); outline-offset: 1px; }
.nao-function .nao-mark { pointer-events: none; }
.nao-function .nao-cursor { position: absolute; width: 15px; height: 15px; transform: translate(-50%, -50%);
  box-sizing: border-box; border: 2px solid #c84b00; border-radius: 50%;
  box-shadow: 0 0 0 1.5px white, inset 0 0 0 1.5px white; }
.nao-function .nao-choices { gap: 4px 10px; align-items: center; flex-wrap: wrap; overflow: visible; }
.nao-function .nao-choices > * { margin: 0; }
.nao-function .nao-choices .widget-dropdown { width: auto; min-width: 120px; }
.nao-function .nao-choices .widget-text { width: auto; }
.nao-function .nao-choices .widget-text input { width: 84px; flex: 0 0 84px; }
.nao-function .nao-choices button { width: auto; padding: 0 14px; }
.nao-function .nao-choices .widget-label { width: auto; }
.nao-function .nao-choices .widget-checkbox label { display: flex; align-items: center; gap: 4px; }
.nao-function .nao-choices .nao-key-line { flex: 1 1 200px; min-width: 0; }
.nao-function .nao-controls { gap: 6px; }
.nao-function .nao-sliders { display: grid; gap: 0 16px; overflow: visible; margin: 0;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 330px), 1fr)); }
.nao-function .nao-sliders .widget-slider { width: 100%; min-width: 0; height: 26px; margin: 0; }
.nao-function .nao-sliders .widget-label { width: 130px; }
.nao-function .nao-sliders :is(.widget-label, .widget-readout) { height: 26px; line-height: 26px; }
.nao-function .noUi-handle:focus { outline: 2px solid var(--nao-mark, #0b5fa5); outline-offset: 2px; }
.nao-function .nao-scores table { border-collapse: collapse; font-size: 13px; line-height: 22px; margin: 0; }
.nao-function .nao-scores th, .nao-function .nao-scores td { padding: 1px 6px; text-align: right; }
.nao-function .nao-scores b { padding: 0 6px; }
.nao-function .nao-scores tbody th { text-align: left; font-weight: normal; }
.nao-function .nao-scores td { font-variant-numeric: tabular-nums; min-width: 44px; }
@container (max-width: 600px) { .nao-function .nao-scores :is(th, td) { padding: 1px 3px; min-width: 0; } }
.nao-function .nao-key { display: inline-block; width: 11px; height: 11px; border: 1px solid #555; margin-right: 5px;
  vertical-align: -1px; }
.nao-function .nao-status { position: relative; }
.nao-function.nao-busy .nao-status::after { position: absolute; right: 8px; bottom: 3px; font-weight: 600;
  content: "Computing \\2026"; background: inherit; padding-left: 8px; animation: nao-later 0.5s; }
.nao-function .nao-legend .widget-html-content { font-size: 12px; line-height: 20px; }
.nao-function .nao-legend span { white-space: nowrap; margin-right: 12px; }
"""

Show = Callable[[Values, StudentCode], Any]
# s; ipywidgets sends a click at once, but a value that changed before it only when the kernel is idle again
HELD_VALUES = 0.25


class FunctionPanel:
    """A panel that shows the results of a function of its controls' values.

    Parameters
    ----------
    title : str
        Title for texts and screen readers.
    show : callable
        ``show(values, student)`` returns or yields the results: a picture, a Drawing, a table, a text, a Legend, or
        {title: picture, Drawing or table}. Results that were yielded before an error are still shown.
    controls : sequence of Control
        The controls.
    student : mapping of str to callable, optional
        The student's functions, by the names under which `show` finds them.
    unfinished : str or mapping of str to str, optional
        Message for a function that raises NotImplementedError; a mapping has a message for each function.
    small : collection of str
        Titles of pictures that are shown among the controls, and smaller than the others.
    drawn : collection of str
        Titles of arrays that are drawings, such as matrices: a dark page inverts their lightness, and the legend's.
    seed : int
        Seed of ``values.rng``, which starts in the same state at each call.
    time_limit : float
        Seconds after which a call of `show` is stopped; the panel then shows a message.

    Raises
    ------
    ValueError
        If controls share a name or a key, or a start value is outside its limits.

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

    css = ""  # further styles of a subclass
    wide_controls = False  # whether the controls below wide pictures have a line of their own

    def __init__(
        self,
        title: str,
        show: Show,
        controls: Sequence[Control],
        *,
        student: Mapping[str, Callable[..., Any]] | None = None,
        unfinished: str | Mapping[str, str] | None = None,
        small: Collection[str] = (),
        drawn: Collection[str] = (),
        seed: int = 0,
        time_limit: float = TIME_LIMIT,
    ) -> None:
        """Build the widgets, and show the results for the first values."""
        check_controls(controls)
        self.title, self.time_limit, self.seed = title, time_limit, seed
        self._show, self._student, self._unfinished = show, StudentCode(student or {}), unfinished
        self._small, self._drawn_titles = small, drawn
        self._controls = {each.name: each for each in controls}
        self._values = self._start()
        self._shown, self._latest = Shown({}, {}), Attempt[None]()
        self._error: BaseException | None = None
        self._refused = ""
        self._moving = False
        self._one_at_a_time = threading.RLock()
        self._newest = RateLimited(self._update)
        self._build()
        self._update()

    # --- from code ---

    def set(self, **values: Any) -> None:
        """Set some controls and show the results.

        Raises
        ------
        ValueError
            If a value is outside its limits; then no control is changed.
        TypeError
            If a control does not exist.
        """
        self._put(self._checked(values))

    def reset(self) -> None:
        """Set all controls to their start values, except the choices that stay."""
        self._put(self._start() | {name: self._values[name] for name in self._staying()})

    @property
    def values(self) -> Values:
        """The controls' values."""
        presses = [
            self._values[name]
            for name, each in self._controls.items()
            if name in self._values and isinstance(each, Action)
        ]
        return Values(self._values, np.random.default_rng([self.seed, *presses]))

    @property
    def error(self) -> BaseException | None:
        """The last exception of the student's code; ``raise panel.error`` shows where it was raised."""
        return self._error

    @property
    def shown(self) -> Shown:
        """The results for the present values; after an error, the results that `show` had yielded before it."""
        return self._shown

    def say_values(self) -> str:
        """Return the controls' values as text."""
        words = (self._controls[name].say(value) for name, value in self._values.items())
        return ", ".join(filter(None, words))

    def summary(self) -> str:
        """Return the controls' values and the results as text, or the error."""
        shown = self._shown
        failed = [] if self._latest.done else [self._latest.message]
        lines = [self.say_values(), *shown.texts, *map(repr, shown.tables.values()), *failed]
        return "\n".join(filter(None, lines))

    def drawing(self) -> Drawing:
        """Return the panel's contents as a figure, for places without widgets."""
        marks = {}
        for each in self._pixels():
            title, value = self._picture_of(each), self._values[each.name]
            if title in self._shown.pictures and each.is_marked(value):
                height, width = self._shown.pictures[title].shape[:2]
                scale = np.divide((width, height), each.size)  # a picture may be shown enlarged
                marks[title] = tuple(scale * (np.array(value) + 0.5) - 0.5)
        return self._shown.drawing(f"{self.title}: {'; '.join(self.summary().splitlines())}", marks)

    def __repr__(self) -> str:
        """Return the panel's contents as text."""
        return f"{self.title}: {self.summary()}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the widgets, and a picture and the summary for places without widgets."""
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
        """Set the values, move the controls, and show the results once."""
        self._take(values)
        self._update()

    def _take(self, values: dict[str, Any]) -> None:
        self._values, self._moving, self._refused = values, True, ""
        for name, control in self._controls.items():
            if name in values and not isinstance(control, Action):
                self._widgets[name].value = control.to_widget(values[name])
        self._moving = False

    def _moved(self, control: Control, change: Any) -> None:
        """Update the value of a control that was moved on the page."""
        if self._moving:
            return
        try:
            self._values = self._checked({control.name: change["new"]})
            self._refused = ""
        except ValueError as error:  # an impossible value was typed: no caller of a callback could catch this
            self._take(self._values)
            self._refused = str(error)
        self._newest.ask()

    def _press_later(self, action: Action) -> None:
        """Run a button's action; in a panel with pixels, after the pixel that was clicked before it has arrived."""
        try:
            loop = asyncio.get_running_loop() if self._pixels() else None
        except RuntimeError:  # no kernel: a plain Python program
            loop = None
        if loop:
            loop.call_later(HELD_VALUES, self._pressed, action)
        else:
            self._pressed(action)

    def _pressed(self, action: Action) -> None:
        counted = {} if action.sets else {action.name: self._values[action.name] + 1}
        self._take(self._checked({**action.sets, **counted}))
        self._newest.ask()

    # --- the student's code ---

    def _update(self) -> None:
        """Call the function and show its results."""
        with self._one_at_a_time:  # a slider and a cell may use different threads
            before, parts = self._shown, list[Any]()
            self._student.begin()
            self._latest = Attempt(message="Interrupted.")  # unless the attempt below ends
            switch(self.widget, "nao-busy", True)  # JupyterLab calls the kernel idle meanwhile
            try:
                self._latest = attempt(
                    lambda: self._call_show(parts),
                    self._source_of_error,
                    limit=self.time_limit,
                    unfinished=self._say_unfinished,
                    quiet=True,
                )
            finally:
                switch(self.widget, "nao-busy", False)
            self._error = self._latest.error or self._error
            if not self._latest.done:
                self._shown = Shown.of(_showable(parts))
            self._display(before)

    def _call_show(self, parts: list[Any]) -> None:
        for part in parts_of(self._show(self.values, self._student)):
            parts.append(part)
        self._shown = Shown.of(parts)

    def _source_of_error(self) -> str:
        student = self._student
        if student.running:
            return _called(student.running)
        return (
            f"the panel, in the code that uses the result of {_called(student.last)}"
            if student.last
            else "the panel"
        )

    def _say_unfinished(self) -> str:
        name = self._student.called
        if isinstance(self._unfinished, Mapping) and name in self._unfinished:
            return self._unfinished[name]
        if isinstance(self._unfinished, str):
            return self._unfinished
        return f"Finish {_called(name) if name else 'the exercise'} to see this."

    # --- showing ---

    def _display(self, before: Shown) -> None:
        """Send the results to the page; the place of a picture that failed becomes grey."""
        missing = {
            title: np.full_like(pixels, 225)
            for title, pixels in before.pictures.items()
            if not self._latest.done and title not in self._shown.pictures
        }
        shown = {**self._shown.pictures, **missing}
        for row, is_small in ((self._row, False), (self._small_row, True)):
            row.show(
                {title: pixels for title, pixels in shown.items() if (title in self._small) == is_small},
                self._shown.drawings,
                missing,
                self._drawn_titles,
            )
        place_beside(self.widget, self._row.ratio)
        self._lay_pads(list(self._row.titles))
        self._legend.value = "".join(each._repr_html_() for each in self._shown.legends)
        self._table.value = self._shown.tables_html()
        for part, is_empty in (
            (self._small_row.widget, not self._small_row.titles),
            (self._table, not self._table.value),
            (self._legend, not self._legend.value),
        ):
            switch(part, "nao-empty", is_empty)
        self._status.value = self._say_status()

    def _lay_pads(self, titles: list[str]) -> None:
        """Lay each pixel's mark and pad over its picture."""
        over: dict[str, list[Any]] = {title: [] for title in titles}
        for control in self._pixels():
            pad, mark = self._pads[control.name]
            mark.value = control.mark(self._values[control.name])
            over.get(self._picture_of(control), []).extend((mark, pad))
        self._row.lay_over(list(over.values()))

    def _say_status(self) -> str:
        latest, values = self._latest, self.say_values()
        if self._refused:
            return status_box(self._refused, values, kind="alarm")
        if not latest.done:
            where = latest.error is not None and not latest.unfinished
            return status_box(latest.message, values, kind="alarm", shows_where=where, printed=latest.printed)
        texts = "\n".join(self._shown.texts)
        return status_box(texts or values, self.say_pace(self._student.seconds), printed=latest.printed)

    def say_pace(self, seconds: float) -> str:
        """Return the run time of the student's code as text."""
        if not self._student.called:
            return ""
        return f"Your code took {1000 * seconds:.0f} ms."

    # --- widgets ---

    def _pixels(self) -> list[Pixel]:
        return [each for each in self._controls.values() if isinstance(each, Pixel)]

    def _keyed(self) -> list[Action]:
        return [each for each in self._controls.values() if isinstance(each, Action) and each.key]

    def _picture_of(self, control: Pixel) -> str:
        return control.picture or next(iter(self._shown.pictures), "")

    def _build(self) -> None:
        self._widgets = {name: each.widget() for name, each in self._controls.items()}
        self._row, self._small_row = PictureRow(self.title), PictureRow(self.title, SMALL)
        self._pads = {
            each.name: (html_line(each.pad(), "nao-pad"), html_line("", "nao-pad")) for each in self._pixels()
        }
        for _, mark in self._pads.values():
            mark.add_class("nao-mark")
        for name, control in self._controls.items():
            if isinstance(control, Action):
                self._widgets[name].on_click(lambda pressed, action=control: self._press_later(action))
            else:
                self._widgets[name].observe(partial(self._moved, control), "value")
        self._legend = html_line("", "nao-legend")
        switch(self._legend, "nao-drawn-keys", bool(self._drawn_titles))
        self._table, self._status = html_line("", "nao-scores"), ipywidgets.HTML()
        sliders = [self._widgets[name] for name, each in self._controls.items() if _slides(each)]
        choices = box("H", "nao-choices", *self._small_controls(), *self._key_line())
        controls = box("V", "nao-controls", choices, box("", "nao-sliders", *sliders))
        switch(controls, "nao-wide", self.wide_controls)
        group = box("V", "nao-group", self._small_row.widget, self._table)
        self.widget = lay_out(
            CSS + _CSS + self.css, self._row.widget, [controls, group], self._legend, self._status
        )
        self.widget.add_class("nao-function")

    def _small_controls(self) -> list[Any]:
        kept = "".join(f"; {self._controls[name].label} stays" for name in self._staying())
        again = ipywidgets.Button(
            description="Reset", tooltip=f"Set all controls to their start values{kept}"
        )
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
        # Wide enough for the whole hint, on its own line if necessary
        line.layout.min_width = f"min(100%, {len(hint)}ch)"
        return [line]


def _slides(control: Control) -> bool:
    return isinstance(control, Slider | RangeSlider)


def _only_sets(control: Control) -> bool:
    return isinstance(control, Action) and bool(control.sets)


def _called(name: str) -> str:
    """Return a function's name with brackets; return other text unchanged."""
    return f"{name}()" if name.isidentifier() else name


def _showable(parts: Sequence[Any]) -> list[Any]:
    """Return the parts that can be shown."""
    good = []
    for part in parts:
        try:
            Shown.of([part])
        except (TypeError, ValueError):
            continue
        good.append(part)
    return good
