"""Concept questions and predictions: buttons where widgets live, text where they do not.

ipywidgets is imported where it is used: workers and the command line start without it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from html import escape
from math import inf
from typing import Any

from nao_course.exercises.exercise import PublicQuestion
from nao_course.exercises.trying import Message

_NUMBER = re.compile(
    r"(?P<number>[-+\N{MINUS SIGN}]?(\d+([.,]\d*)?|[.,]\d+)(e[-+]?\d+)?)\s*(?P<unit>\D*)", re.IGNORECASE
)
_JUDGED = re.compile(r"(?:right|not quite)[.:!] +", re.IGNORECASE)
_SPELLINGS = {  # of units, as they are typed
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


def styles_that_keep_keys(css: str = "", *scripts: str) -> str:
    """HTML of rules of CSS that also keeps JupyterLab's commands from the keys of the box of widgets it is put into.

    Further scripts run there, too, each with the style's element as `this`.
    """
    all_of_them = "\n".join(f"(() => {{ {script} }})();" for script in (_KEYS_SCRIPT, *scripts))
    return f'<style onload="{escape(all_of_them)}">{css or "/* */"}</style>'


def reply(question: PublicQuestion, answer: str) -> Message:
    """Return the reply to a choice, given as its text or as its number from 1."""
    choices = list(question.choices)
    if answer.isdecimal() and 1 <= int(answer) <= len(choices):
        answer = choices[int(answer) - 1]
    if answer not in question.choices:
        return Message(f"Choose one of: {_numbered(choices)}")
    sign = "✔ Right." if answer == question.right else "✘ Not quite."
    said = question.choices[answer]
    if judged := _JUDGED.match(said):  # as the sign says already
        said = said[judged.end() :]
        said = said[:1].upper() + said[1:]
    return Message(f"{sign} {said}")


def ask(question: PublicQuestion) -> Any:
    """Return radio buttons that reply to each choice; nothing is chosen at first."""
    import ipywidgets

    buttons = ipywidgets.RadioButtons(
        options=list(question.choices),
        value=None,
        layout=ipywidgets.Layout(width="auto"),
        description="",
        tooltip=question.text,
    )
    answer = ipywidgets.HTML()
    title = ipywidgets.HTML(value=Message(question.text)._repr_html_() + styles_that_keep_keys())

    def chosen(change: Any) -> None:
        answer.value = reply(question, change["new"])._repr_html_() if change["new"] else ""

    buttons.observe(chosen, names="value")
    choices = "\n".join(f"  {number}. {text}" for number, text in enumerate(question.choices, start=1))
    return _box([title, buttons, answer], f"{question.text}\n{choices}")


class Prediction:
    """What a student expects, written down before it is run and laid beside what came out.

    Parameters
    ----------
    text : str
        What to predict.
    unit : str
        Of the number: a sign such as "m" or "%", or a word in the plural; one is said without its s.
    low, high : float
        What it can be at least and at most.
    choices : tuple of str
        What there is to choose; then it is no number.
    """

    def __init__(
        self, text: str, unit: str = "", low: float = -inf, high: float = inf, choices: tuple[str, ...] = ()
    ) -> None:
        self.text, self.unit, self.low, self.high, self.choices = text, unit, low, high, choices
        self.value: float | str | None = None  # what is written down
        self.final = False  # what was laid beside what came out stays as it was
        self._measured: float | str | None = None
        self._view: Any = None

    def write(self, typed: object) -> Message:
        """Write a prediction down; what cannot be one is refused with a sentence.

        Parameters
        ----------
        typed : str or float
            A number, with the unit or without one; or one of the choices, or its number from 1.
        """
        if self.final:
            return Message(f"The result is there already. {self.said()}")
        try:
            self.value = self._understood(str(typed).strip())
        except ValueError as error:
            return Message(str(error))
        self.final = self._measured is not None
        return Message(self.said())

    def beside(self, measured: float | str) -> Message:
        """Return one line that has the prediction and what came out.

        Parameters
        ----------
        measured : float or str
            What came out, in the prediction's unit; of choices, the right one.
        """
        self._measured = measured
        self.final = self.value is not None
        if self._view is not None:
            self._view.refresh()
        return Message(self.said())

    def _understood(self, typed: str) -> float | str:
        """Return what was typed as a value; a ValueError says what is wanted instead."""
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
            raise ValueError(f"{typed!r}: write {wanted}; {unit!r} is another unit.")
        value = float(match["number"].replace(",", ".").replace("\N{MINUS SIGN}", "-"))
        if not self.low <= value <= self.high:
            raise ValueError(f"It cannot be {self._say(value)}: it is {self._limits()}.")
        return value

    def _limits(self) -> str:
        if self.low == -inf:
            return f"at most {self._say(self.high)}"
        if self.high == inf:
            return f"at least {self._say(self.low)}"
        return f"from {self.low:g} to {self._say(self.high)}"

    def _say(self, value: float | str) -> str:
        """Return a value with its unit, a number with three digits at most."""
        if isinstance(value, str):
            return value
        number = f"{float(value):{'z.0f' if abs(value) >= 1000 else 'z.3g'}}"
        unit = _one(self.unit) if number == "1" else self.unit
        return f"{number} {unit}" if unit not in ("", "°") else f"{number}{unit}"

    def said(self) -> str:
        """Return what there is: the prediction, what came out, or both."""
        came = "" if self._measured is None else f"it is {self._say(self._measured)}."
        if (
            self._measured is not None
            and self.value is not None
            and self._say(self.value) == self._say(self._measured)
        ):
            return f"You predicted {self._say(self.value)}, and so it is."
        if self.value is None:
            return (
                f"You wrote no prediction: {came} Next time, guess first; a guess is enough." if came else ""
            )
        predicted = f"You predicted {self._say(self.value)}"
        return f"{predicted}; {came}" if came else f"{predicted}. Now run the next cell."

    def __repr__(self) -> str:
        """Say what to predict, and how, where there is no field to write into."""
        how = f" {_numbered(self.choices)}" if self.choices else f" (in {self.unit})" if self.unit else ""
        return f"Predict: {self.text}{how}\n{self.said()}".strip()

    def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, Any]:
        """Show a field to write into; the text where no widget lives."""
        if self._view is None:
            self._view = _PredictionView(self)
        return {**self._view.box._repr_mimebundle_(**kwargs), "text/plain": repr(self)}


class _PredictionView:
    """The widgets of a prediction: Enter, leaving the field, or the button writes it down."""

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
        self.said = ipywidgets.HTML()
        title = ipywidgets.HTML(value=Message(prediction.text)._repr_html_() + styles_that_keep_keys())
        row = ipywidgets.HBox([self.field, ipywidgets.Label(prediction.unit), self.button])
        self.box = ipywidgets.VBox([title, row, self.said])
        self.field.observe(self.write, names="value")
        self.button.on_click(self.write)
        self.refresh()

    def write(self, _: Any) -> None:
        """Take what stands in the field."""
        self.said.value = self.prediction.write(self.field.value)._repr_html_()
        self._lock()

    def refresh(self) -> None:
        """Show what is written down, and what came out, if anything."""
        said = self.prediction.said()
        self.said.value = Message(said)._repr_html_() if said else ""
        self._lock()

    def _lock(self) -> None:
        self.field.disabled = self.button.disabled = self.prediction.final


@cache  # a cell that is run again shows the prediction that was written there
def _asked(text: str, unit: str, low: float, high: float, choices: tuple[str, ...]) -> Prediction:
    return Prediction(text, unit, low, high, choices)


def prediction(
    text: str, *, unit: str = "", low: float = -inf, high: float = inf, choices: Sequence[str] = ()
) -> Prediction:
    """Return a field to write a prediction into before something is run.

    Parameters
    ----------
    text : str
        What to predict.
    unit : str
        Shown behind the field; it may be typed, too. As of `Prediction`.
    low, high : float
        What the number can be at least and at most.
    choices : sequence of str
        What there is to choose, instead of a number.

    Returns
    -------
    Prediction
        The same one for the same question. Its `beside(measured)` lays what came out beside it; its
        `write(typed)` writes one down where no widget lives.

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
    """Return a unit in one spelling."""
    return _SPELLINGS.get(typed.casefold(), typed)


def _one(unit: str) -> str:
    """Return a unit as it is said of one: a word loses its s, a sign such as "m" or "ms" stays."""
    return unit.removesuffix("s") if len(unit) > 2 else unit


def _numbered(choices: Sequence[str]) -> str:
    return ", ".join(f"{number}. {text}" for number, text in enumerate(choices, start=1))


def _box(children: list[Any], text: str) -> Any:
    """A box of widgets that is a text where no widget can live."""
    import ipywidgets

    class Box(ipywidgets.VBox):  # type: ignore[misc]
        def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, Any]:
            return {**super()._repr_mimebundle_(**kwargs), "text/plain": text}

    return Box(children)
