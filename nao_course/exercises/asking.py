"""Concept questions and predictions, shown as widgets or, without widgets, as text.

ipywidgets is imported where it is used, so that workers and the command line start without it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from html import escape
from math import inf
from types import MappingProxyType
from typing import Any

from nao_course.exercises.exercise import PublicQuestion
from nao_course.exercises.trying import Message, strict

_NUMBER = re.compile(
    r"(?P<number>[-+\N{MINUS SIGN}]?(\d+([.,]\d*)?|[.,]\d+)(e[-+]?\d+)?)\s*(?P<unit>\D*)", re.IGNORECASE
)
_JUDGED = re.compile(r"(?:right|not quite)[.:!] +", re.IGNORECASE)
_SAME = 0.08  # the share by which a prediction may differ from a typical one
_NO_REMARKS: Mapping[float, str] = MappingProxyType({})
_SPELLINGS = {  # of units that students may type
    **dict.fromkeys(("meter", "meters", "metre", "metres"), "m"),
    **dict.fromkeys(("percent", "per cent"), "%"),
    **dict.fromkeys(("deg", "degree", "degrees"), "°"),
}


# JupyterLab takes keys outside of text fields for commands: arrows leave for another cell, "b" adds one, "x" cuts this
# one. Here a key that is pressed in a menu, on a button or at a slider goes no farther; Shift+Enter and Ctrl+S do.
_KEYS_SCRIPT = """const box = this.closest('.nao-panel, .widget-vbox');
if (!box || box.dataset.naoKeys) return;
box.dataset.naoKeys = 'here';
box.addEventListener('keydown', event => {
  if (event.ctrlKey || event.metaKey || event.altKey || (event.shiftKey && event.key === 'Enter')) return;
  event.stopPropagation();
});"""

# What a panel, a question, a prediction or a sheet says when no kernel answers; ipywidgets shows only broken links.
_NO_KERNEL_CSS = """
.nao-asks { position: relative; }
:is(.nao-panel, .nao-asks).jupyter-widgets-disconnected::before, :is(.nao-panel, .nao-asks)
  .jupyter-widgets-disconnected.jupyter-widgets-disconnected::before { content: none !important; }
:is(.nao-panel, .nao-asks).jupyter-widgets-disconnected > * {
  opacity: 0.3; filter: grayscale(1); pointer-events: none; }
:is(.nao-panel, .nao-asks)::after { position: absolute; z-index: 9; left: 5%; right: 5%; top: 50%; translate: 0 -50%;
  padding: 10px 14px; border-radius: 6px; border-left: 4px solid #c84b00; line-height: 20px; font-size: 14px;
  white-space: normal; color: var(--jp-ui-font-color1, black); background: var(--jp-layout-color1, white);
  box-shadow: 0 1px 8px #0006; }
:is(.nao-panel, .nao-asks).jupyter-widgets-disconnected::after { content: "The kernel was restarted, so this no longer \
works. In the menu Run, choose Run All Above Selected Cell; then run this cell again."; }
.jp-NotebookPanel:has(.jp-Notebook-ExecutionIndicator:is([data-status=connecting], [data-status=disconnected]))
  :is(.nao-panel, .nao-asks):not(.jupyter-widgets-disconnected)::after { animation: nao-later 3s; content: "The \
connection to the kernel is lost. Wait a moment: this goes on by itself. If it does not, reload this page and run the \
cell again."; }
@keyframes nao-later { 0%, 99% { opacity: 0; } }
"""


def styles_that_keep_keys(css: str = "", *scripts: str) -> str:
    """Return CSS rules as HTML that also disables JupyterLab's shortcuts inside the widgets of the box.

    A box with the class ``nao-panel`` or ``nao-asks`` also says when there is no kernel. Further scripts are run as
    well, each with the style's element as `this`.
    """
    all_of_them = "\n".join(f"(() => {{ {script} }})();" for script in (_KEYS_SCRIPT, *scripts))
    return f'<style onload="{escape(all_of_them)}">{_NO_KERNEL_CSS}{css}</style>'


def reply(question: PublicQuestion, answer: str) -> Message:
    """Return the reply to a choice, given as its text or as its number from 1."""
    choices = list(question.choices)
    if answer.isdecimal() and 1 <= int(answer) <= len(choices):
        answer = choices[int(answer) - 1]
    if answer not in question.choices:
        return Message(f"Choose one of: {_numbered(choices)}")
    sign = "✔ Right." if answer == question.right else "✘ Not quite."
    said = question.choices[answer]
    if judged := _JUDGED.match(said):  # the sign has the same meaning
        said = said[judged.end() :]
        said = said[:1].upper() + said[1:]
    return Message(f"{sign} {said}")


# ipywidgets gives every choice a fixed height, so that choices of two lines would lie over each other.
_CHOICES_CSS = """
.nao-question .widget-radio, .nao-question .widget-radio-box { width: auto; height: auto; max-width: 100%; }
.nao-question .widget-radio-box label { display: flex; align-items: flex-start; gap: 8px; height: auto;
  line-height: 1.4; margin: 0 0 6px; white-space: normal; cursor: pointer; }
.nao-question .widget-radio-box input { order: -1; flex: none; height: 13px; margin: 3px 0 0; }
"""


def ask(question: PublicQuestion) -> Any:
    """Return radio buttons that reply to each choice, with no choice at first."""
    import ipywidgets

    buttons = ipywidgets.RadioButtons(
        options=list(question.choices),
        value=None,
        layout=ipywidgets.Layout(width="auto"),
        description="",
        tooltip=question.text,
    )
    answer = ipywidgets.HTML()
    words = Message(question.text)._repr_html_()
    title = ipywidgets.HTML(value=words + styles_that_keep_keys(_CHOICES_CSS))

    def chosen(change: Any) -> None:
        answer.value = reply(question, change["new"])._repr_html_() if change["new"] else ""

    buttons.observe(chosen, names="value")
    choices = "\n".join(f"  {number}. {text}" for number, text in enumerate(question.choices, start=1))
    box = _box([title, buttons, answer], f"{question.text}\n{choices}")
    box.add_class("nao-question").add_class("nao-asks")
    return box


class Prediction:
    """A student's prediction, which is written before an experiment and compared with its result.

    The answer is a number from `low` to `high` or one of the `choices`. The unit is a sign such as "m" or "%", or a
    noun in the plural, which loses its s after 1.
    """

    def __init__(
        self, text: str, unit: str = "", low: float = -inf, high: float = inf, choices: tuple[str, ...] = ()
    ) -> None:
        self.text, self.unit, self.low, self.high, self.choices = text, unit, low, high, choices
        self.value: float | str | None = None  # the written prediction
        self.final = False  # a prediction cannot change after its comparison with the result
        self.given_up = False  # the result was shown without a prediction
        self._measured: float | str | None = None
        self._typical: Mapping[float, str] = _NO_REMARKS
        self._view: Any = None

    @property
    def waits(self) -> bool:
        """Whether there is a result, but no prediction yet."""
        return self._measured is not None and not self.final

    def write(self, typed: object) -> Message:
        """Store a prediction, or return a message that explains why the input is not valid.

        It is a number with or without the unit, or one of the choices or its number from 1.
        """
        if self.final:
            return Message(f"You have already seen the result. {self.said()}")
        try:
            self.value = self._understood(str(typed).strip())
        except ValueError as error:
            return Message(str(error))
        self.final = self._measured is not None
        return Message(self.said())

    def beside(self, measured: float | str, typical: Mapping[float, str] = _NO_REMARKS) -> Message:
        """Return a line that compares the prediction with the result.

        Without a prediction, the result waits for one: the field above then shows both. A typical prediction gets a
        remark on what leads to it: `typical` has the remarks, by the predicted number.
        """
        self._measured, self._typical = measured, typical
        self.final = self.value is not None
        if self._view is not None:
            self._view.refresh()
        return Message(self.said())

    def unlocks(self, answer: object) -> object:
        """Return what shows the result, such as a figure; without a prediction, a sentence in its place.

        The executed lesson and graders always get the answer.
        """
        if self.value is not None or self.given_up or strict():
            return answer
        return Message("The result waits for your prediction: write it down, then run this cell again.")

    def give_up(self) -> Message:
        """Return the result without a prediction."""
        self.given_up = self.final = self._measured is not None
        return Message(self.said() or "Run the cell with the result first.")

    def _understood(self, typed: str) -> float | str:
        """Return the typed text as a value, or raise ValueError with an explanation of what to type."""
        if not typed:
            raise ValueError("Write something first: a guess is enough.")
        return self._chosen(typed) if self.choices else self._number(typed)

    def _chosen(self, typed: str) -> str:
        named = {choice.casefold(): choice for choice in self.choices}
        named |= {str(number): choice for number, choice in enumerate(self.choices, start=1)}
        if typed.casefold() not in named:
            raise ValueError(f"Choose one of: {_numbered(self.choices)}")
        return named[typed.casefold()]

    def _number(self, typed: str) -> float:
        wanted = f"a number in {self.unit}" if self.unit else "a number"
        match = _NUMBER.fullmatch(typed)
        if not match:
            raise ValueError(f"{typed!r} is not {wanted}. Write one; a guess is enough.")
        unit = match["unit"].strip()
        if unit and _unit(unit) not in (_unit(self.unit), _one(self.unit)):
            raise ValueError(f"{typed!r} has another unit: write {wanted}.")
        value = float(match["number"].replace(",", ".").replace("\N{MINUS SIGN}", "-"))
        if not self.low <= value <= self.high:
            raise ValueError(f"It cannot be {self._say(value)}, because it is {self._limits()}.")
        return value

    def _limits(self) -> str:
        if self.low == -inf:
            return f"at most {self._say(self.high)}"
        if self.high == inf:
            return f"at least {self._say(self.low)}"
        return f"from {self.low:g} to {self._say(self.high)}"

    def _say(self, value: float | str) -> str:
        """Return a value with its unit; a number has at most three significant digits."""
        if isinstance(value, str):
            return value
        number = f"{float(value):{'z.0f' if abs(value) >= 1000 else 'z.3g'}}"
        unit = _one(self.unit) if number == "1" else self.unit
        return f"{number} {unit}" if unit not in ("", "°") else f"{number}{unit}"

    def said(self) -> str:
        """Return the prediction, the result, or both as text."""
        came = "" if self._measured is None else f"it is {self._say(self._measured)}."
        if (
            self._measured is not None
            and self.value is not None
            and self._say(self.value) == self._say(self._measured)
        ):
            return f"You predicted {self._say(self.value)}, and so it is."
        if self.value is None:
            if not came:
                return ""
            if not self.given_up:
                return (
                    "The result waits for your prediction: write it into the field above. A guess is enough."
                )
            return f"You wrote no prediction: {came} Next time, guess first; a guess is enough."
        predicted = f"You predicted {self._say(self.value)}"
        return f"{predicted}; {came}{self._remark()}" if came else f"{predicted}. Now run the next cell."

    def _remark(self) -> str:
        """Return the remark on the typical prediction that this one is, if it is one and not nearer to the result."""
        if not isinstance(self.value, float) or not isinstance(self._measured, (float, int)):
            return ""
        value, off = self.value, abs(self.value - self._measured)
        near = [each for each in self._typical if abs(value - each) <= min(_SAME * abs(each), off)]
        return f" {self._typical[min(near, key=lambda each: abs(value - each))]}" if near else ""

    def __repr__(self) -> str:
        """Return the question as text, for places without widgets."""
        how = f" {_numbered(self.choices)}" if self.choices else f" (in {self.unit})" if self.unit else ""
        return f"Predict: {self.text}{how}\n{self.said()}".strip()

    def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, Any]:
        """Return a field to write into, and the question as text for places without widgets."""
        if self._view is None:
            self._view = _PredictionView(self)
        return {**self._view.box._repr_mimebundle_(**kwargs), "text/plain": repr(self)}


class _PredictionView:
    """The widgets of a prediction, which is stored by Enter, by leaving the field, or by the button.

    A second button shows a result that waits for a prediction.
    """

    def __init__(self, prediction: Prediction) -> None:
        import ipywidgets

        self.prediction = prediction
        words = {"continuous_update": False, "tooltip": prediction.text}
        if prediction.choices:
            self.field = ipywidgets.Dropdown(
                options=[("choose", ""), *((each, each) for each in prediction.choices)],
                tooltip=prediction.text,
            )
        else:
            self.field = ipywidgets.Text(placeholder="your prediction", **words)
        self.button = ipywidgets.Button(
            description="Write it down", tooltip="Keep this prediction and compare it below"
        )
        self.quit = ipywidgets.Button(description="Give up", tooltip="Show the result without a prediction")
        self.said = ipywidgets.HTML()
        title = ipywidgets.HTML(value=Message(prediction.text)._repr_html_() + styles_that_keep_keys())
        unit = ipywidgets.Label(prediction.unit, layout={"flex": "none"})
        row = ipywidgets.HBox([self.field, unit, self.button, self.quit], layout={"flex_flow": "row wrap"})
        self.box = ipywidgets.VBox([title, row, self.said]).add_class("nao-asks")
        self.field.observe(self.write, names="value")
        self.button.on_click(self.write)
        self.quit.on_click(self.give_up)
        self.refresh()

    def write(self, _: Any) -> None:
        """Store the contents of the field."""
        self.said.value = self.prediction.write(self.field.value)._repr_html_()
        self._lock()

    def give_up(self, _: Any) -> None:
        """Show the result without a prediction."""
        self.prediction.give_up()
        self.refresh()

    def refresh(self) -> None:
        """Show the prediction and, if it is known, the result."""
        said = self.prediction.said()
        self.said.value = Message(said)._repr_html_() if said else ""
        self._lock()

    def _lock(self) -> None:
        prediction = self.prediction
        self.field.disabled = self.button.disabled = prediction.final
        self.quit.layout.display = "" if prediction.waits else "none"


@cache  # a cell that is run again shows the same prediction
def _asked(text: str, unit: str, low: float, high: float, choices: tuple[str, ...]) -> Prediction:
    return Prediction(text, unit, low, high, choices)


def prediction(
    text: str, *, unit: str = "", low: float = -inf, high: float = inf, choices: Sequence[str] = ()
) -> Prediction:
    """Return a field for a prediction, to be shown before an experiment.

    Parameters
    ----------
    text : str
        The question.
    unit : str
        Unit as in `Prediction`, shown after the field; students may also type it.
    low, high : float
        Smallest and largest possible value.
    choices : sequence of str
        Possible answers, if the prediction is not a number.

    Returns
    -------
    Prediction
        The prediction; equal arguments give the same object. Its `beside(measured)` compares it with the result, and
        its `write(typed)` stores a prediction without widgets.

    Examples
    --------
    >>> drift = prediction("How far from its start?", unit="m", low=0)
    >>> drift.write("half a metre")
    'half a metre' is not a number in m. Write one; a guess is enough.
    >>> drift.write("0.5 m")
    You predicted 0.5 m. Now run the next cell.
    >>> drift.beside(1.93)
    You predicted 0.5 m; it is 1.93 m.
    """
    return _asked(text, unit, low, high, tuple(choices))


def _unit(typed: str) -> str:
    """Return the standard spelling of a unit."""
    return _SPELLINGS.get(typed.casefold(), typed)


def _one(unit: str) -> str:
    """Return the singular of a unit: a word loses its s, and a sign such as "m" or "ms" does not change."""
    return unit.removesuffix("s") if len(unit) > 2 else unit


def _numbered(choices: Sequence[str]) -> str:
    return ", ".join(f"{number}. {text}" for number, text in enumerate(choices, start=1))


def _box(children: list[Any], text: str) -> Any:
    """Make a box of widgets that is replaced by a text where widgets cannot be shown."""
    import ipywidgets

    class Box(ipywidgets.VBox):  # type: ignore[misc]
        def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, Any]:
            return {**super()._repr_mimebundle_(**kwargs), "text/plain": text}

    return Box(children)
