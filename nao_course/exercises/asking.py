"""Concept questions and predictions: buttons where widgets live, text where they do not.

ipywidgets is imported where it is used: workers and the command line start without it.
"""

from __future__ import annotations

from typing import Any

from nao_course.exercises.exercise import PublicQuestion
from nao_course.exercises.trying import Message


def reply(question: PublicQuestion, answer: str) -> Message:
    """Return the reply to a choice, given as its text or as its number from 1."""
    choices = list(question.choices)
    if answer.isdecimal() and 1 <= int(answer) <= len(choices):
        answer = choices[int(answer) - 1]
    if answer not in question.choices:
        return Message(
            f"Choose one of: {', '.join(f'{i}. {text}' for i, text in enumerate(choices, start=1))}"
        )
    sign = "✔ Right." if answer == question.right else "✘ Not quite."
    return Message(f"{sign} {question.choices[answer]}")


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
    title = ipywidgets.HTML(value=Message(question.text)._repr_html_())

    def chosen(change: Any) -> None:
        answer.value = reply(question, change["new"])._repr_html_() if change["new"] else ""

    buttons.observe(chosen, names="value")
    choices = "\n".join(f"  {number}. {text}" for number, text in enumerate(question.choices, start=1))
    return _box([title, buttons, answer], f"{question.text}\n{choices}")


def prediction(text: str, *, unit: str = "") -> Any:
    """Return a field to write a prediction into before something is run.

    Parameters
    ----------
    text : str
        What to predict.
    unit : str
        Shown behind the field.

    Returns
    -------
    ipywidgets.VBox
        Its `prediction` attribute is what was written; it can be changed until it is locked in.
    """
    import ipywidgets

    field = ipywidgets.Text(placeholder="your prediction", continuous_update=False, tooltip=text)
    button = ipywidgets.Button(
        description="Write it down", tooltip="Keep this prediction and compare it below"
    )
    said = ipywidgets.HTML()
    title = ipywidgets.HTML(value=Message(text)._repr_html_())
    box = _box([title, ipywidgets.HBox([field, ipywidgets.Label(unit), button]), said], f"Predict: {text}")
    box.prediction = None

    def write(_: Any) -> None:
        if not field.value.strip():
            said.value = Message("Write something first: a guess is enough.")._repr_html_()
            return
        box.prediction = field.value.strip()
        field.disabled = button.disabled = True
        said.value = Message(
            f"You predicted: {box.prediction} {unit}".rstrip() + ". Now run the next cell."
        )._repr_html_()

    button.on_click(write)
    return box


def _box(children: list[Any], text: str) -> Any:
    """A box of widgets that is a text where no widget can live."""
    import ipywidgets

    class Box(ipywidgets.VBox):  # type: ignore[misc]
        def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, Any]:
            return {**super()._repr_mimebundle_(**kwargs), "text/plain": text}

    return Box(children)
