"""Declarations of a panel's controls: sliders, choices, toggles, pixels of a picture, and buttons."""

from __future__ import annotations

import html
import keyword
import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import ipywidgets
import numpy as np

from nao_course.widgets.keyboard import key_names

RESERVED = frozenset({"rng", "keys", "values", "items", "get"})  # names that `Values` defines itself


@dataclass(frozen=True)
class Control(ABC):
    """A control of a panel, with its name in code (``values.name``, ``panel.set(name=...)``), label and tooltip."""

    name: str
    label: str
    tooltip: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        """Check the name and the start value."""
        if not self.name.isidentifier() or keyword.iskeyword(self.name) or self.name.startswith("_"):
            raise ValueError(f"a control's name must be a valid variable name, got {self.name!r}")
        if self.name in RESERVED:
            raise ValueError(
                f"a control cannot have the name {self.name!r}, because values.{self.name} has another meaning"
            )
        if "start" in vars(self):
            object.__setattr__(self, "start", self.first)

    @property
    def first(self) -> Any:
        """The start value."""
        return self.checked(vars(self).get("start", 0))

    @abstractmethod
    def checked(self, value: Any) -> Any:
        """Return a value as the panel stores it; raise ValueError, with the limits, if it cannot be set."""

    @abstractmethod
    def widget(self) -> Any:
        """Return a new widget whose `value` is `to_widget(first)`."""

    def say(self, value: Any) -> str:
        """Return a value in words, such as "Tilt 2.0°"."""
        return f"{self.label} {value}"

    def to_widget(self, value: Any) -> Any:
        """Return the widget's representation of a value."""
        return value

    def css_class(self, kind: str) -> str:
        """Return the class of the widget on the page, such as "nao-slider-tilt"."""
        return f"nao-{kind}-{self.name.replace('_', '-')}"


def _with_unit(text: str, unit: str) -> str:
    return f"{text}{unit}" if unit in ("", "°") else f"{text} {unit}"


@dataclass(frozen=True)
class _Scale(Control):
    """A control with limits and steps; its values are integers if limits and step are."""

    low: float
    high: float
    step: float
    start: Any
    unit: str = field(default="", kw_only=True)
    look: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        """Check that the limits and the step leave a range."""
        if not (self.low < self.high and 0 < self.step <= self.high - self.low):
            raise ValueError(
                f"{self.name} must have low < high and a step between them, "
                f"got {self.low} to {self.high} in steps of {self.step}"
            )
        super().__post_init__()

    @property
    def whole(self) -> bool:
        """Whether its values are integers."""
        return all(isinstance(each, int | np.integer) for each in (self.low, self.high, self.step))

    def rounded(self, value: Any) -> float:
        """Return a number rounded as in a browser: to whole steps from the lower limit, halves up."""
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = math.nan
        if isinstance(value, bool) or not self.low <= number <= self.high:
            raise ValueError(f"{self.name} must be from {self.limits}, got {value!r}")
        steps = math.floor(round((number - self.low) / self.step, 9) + 0.5)
        result = min(round(self.low + steps * self.step, 10), self.high)
        return int(result) if self.whole else float(result)

    @property
    def limits(self) -> str:
        """Both limits in words."""
        return _with_unit(f"{self.low:g} to {self.high:g}", self.unit)

    def number(self, value: float) -> str:
        """Return a number with as many digits as a step has."""
        return f"{value:.{self.digits}f}"

    @property
    def digits(self) -> int:
        """Number of decimals that distinguishes two steps."""
        return (
            0 if self.whole else next((n for n in range(6) if abs(round(self.step, n) - self.step) < 1e-9), 6)
        )

    def _made(self, kind: str, value: Any) -> Any:
        make = getattr(ipywidgets, f"{'Int' if self.whole else 'Float'}{kind}")
        widget = make(
            value=value,
            min=self.low,
            max=self.high,
            step=self.step,
            description=f"{self.label} ({self.unit})" if self.unit else self.label,
            readout_format="d" if self.whole else f".{self.digits}f",
            tooltip=self.tooltip or f"{self.label}: {self.limits}",
        )
        widget.add_class(self.css_class("slider"))
        if self.look:
            widget.add_class(self.look)
        return widget


@dataclass(frozen=True)
class Slider(_Scale):
    """A slider for one number.

    Parameters
    ----------
    name, label : str
        Name in code, and label on the panel.
    low, high, step : float
        Limits and step; if all three are integers, the values are integers.
    start : float
        Start value.
    unit : str
        Unit, shown after the label and after the value.
    look : str
        CSS class of the widget.

    Examples
    --------
    >>> Slider("tilt", "Tilt", -5, 5, 0.5, 0, unit="°").checked(1.3)
    1.5
    """

    def checked(self, value: Any) -> float:
        """Return a number within the limits, in whole steps."""
        return self.rounded(value)

    def widget(self) -> Any:
        """Return a slider."""
        return self._made("Slider", self.start)

    def say(self, value: Any) -> str:
        """Return the value with its label and unit."""
        return f"{self.label} {_with_unit(self.number(value), self.unit)}"


@dataclass(frozen=True)
class RangeSlider(_Scale):
    """A slider for two numbers in ascending order, with the parameters of `Slider` and a pair as `start`."""

    def checked(self, value: Any) -> tuple[float, float]:
        """Return both numbers, in whole steps."""
        if np.shape(value) != (2,):
            raise ValueError(f"{self.name} must be two numbers from {self.limits}, got {value!r}")
        first, last = map(self.rounded, value)
        if first > last:
            raise ValueError(f"{self.name} must have its smaller number first, got {value!r}")
        return first, last

    def widget(self) -> Any:
        """Return a slider with two handles."""
        return self._made("RangeSlider", self.start)

    def say(self, value: Any) -> str:
        """Return both numbers with the label and the unit."""
        return f"{self.label} {_with_unit(' to '.join(map(self.number, value)), self.unit)}"


@dataclass(frozen=True)
class Choice(Control):
    """A menu of texts or numbers.

    Parameters
    ----------
    name, label : str
        Name in code, and label on the panel.
    options : sequence of str, int or float
        The options, which are shown as `str` formats them.
    start : str, int or float, optional
        Start value; by default the first option.
    stays : bool
        Whether Reset keeps the choice, as it should for the choice of a picture.
    """

    options: Sequence[Any]
    start: Any = None
    stays: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        """Set the start value to the first option unless it is given."""
        if not self.options:
            raise ValueError(f"{self.name} must have at least one option, got none")
        if self.start is None:
            object.__setattr__(self, "start", self.options[0])
        super().__post_init__()

    def checked(self, value: Any) -> Any:
        """Return the option that equals a value."""
        for option in self.options:
            if type(value) in (type(option), int, float) and value == option:
                return option
        raise ValueError(f"{self.name} must be one of {', '.join(map(repr, self.options))}; got {value!r}")

    def widget(self) -> Any:
        """Return a menu."""
        options = [(str(option), option) for option in self.options]
        menu = ipywidgets.Dropdown(description=self.label, options=options, value=self.start)
        menu.tooltip = self.tooltip or self.label
        menu.add_class(self.css_class("choice"))
        return menu


@dataclass(frozen=True)
class Toggle(Control):
    """A checkbox.

    Parameters
    ----------
    name, label : str
        Name in code, and label on the panel.
    start : bool
        Start value.
    """

    start: bool = False

    def checked(self, value: Any) -> bool:
        """Return True or False."""
        if not isinstance(value, bool | np.bool_):
            raise ValueError(f"{self.name} must be True or False, got {value!r}")
        return bool(value)

    def widget(self) -> Any:
        """Return a checkbox."""
        box = ipywidgets.Checkbox(value=self.start, description=self.label, indent=False)
        box.tooltip = self.tooltip or self.label
        box.layout.width = "auto"
        box.add_class(self.css_class("toggle"))
        return box

    def say(self, value: Any) -> str:
        """Return the label with "on" or "off"."""
        return f"{self.label} {'on' if value else 'off'}"


@dataclass(frozen=True)
class Pixel(Control):
    """A pixel of a picture, chosen with a click, by dragging, with the arrow keys, or by typing.

    Parameters
    ----------
    name, label : str
        Name in code, and label on the panel.
    size : (int, int)
        Width and height of the picture.
    start : (int, int), optional
        Start value (u, v); by default the picture's centre.
    picture : str, optional
        Title of the picture; by default the first picture.
    marks_start : bool
        Whether the start value is marked in the picture and named; False if it means that nothing is selected.
    """

    size: tuple[int, int]
    start: Any = None
    picture: str = field(default="", kw_only=True)
    marks_start: bool = field(default=True, kw_only=True)

    def __post_init__(self) -> None:
        """Set the start value to the picture's centre unless it is given."""
        if self.start is None:
            object.__setattr__(self, "start", tuple(length // 2 for length in self.size))
        super().__post_init__()

    def checked(self, value: Any) -> tuple[int, int]:
        """Return (u, v), two integers inside the picture, also from a text such as "12, 7"."""
        try:
            u, v = map(float, value.strip("() ").split(",") if isinstance(value, str) else value)
        except (TypeError, ValueError):
            u = v = math.nan
        width, height = self.size
        if not (u in range(width) and v in range(height)):
            raise ValueError(
                f"{self.name} must be a pixel (u, v), u a whole number from 0 to {width - 1} "
                f"and v from 0 to {height - 1}; got {value!r}"
            )
        return int(u), int(v)

    def to_widget(self, value: Any) -> str:
        """Return "u, v"."""
        return f"{value[0]}, {value[1]}"

    def widget(self) -> Any:
        """Return a text field, which clicks in the picture also fill in."""
        line = ipywidgets.Text(
            value=self.to_widget(self.start), description=f"{self.label} (u, v)", continuous_update=False
        )
        line.tooltip = self.tooltip or f"{self.label}: click into the picture, or use the arrow keys there"
        line.add_class(self.css_class("pixel"))
        return line

    def say(self, value: Any) -> str:
        """Return the label with (u, v), or nothing where no mark is shown."""
        if not self.is_marked(value):
            return ""
        return f"{self.label} ({value[0]}, {value[1]})"

    def is_marked(self, value: Any) -> bool:
        """Return whether a value is marked in the picture."""
        return self.marks_start or tuple(value) != tuple(self.start)

    def pad(self) -> str:
        """Return the HTML of the layer over the picture that receives clicks and keys."""
        width, height = self.size
        script = _PIXEL_SCRIPT % (width, height, self.css_class("pixel"))
        words = f"{self.label}: click, or arrow keys move the pixel, with shift by ten"
        return (
            f'<div class="nao-pad-over" tabindex="0" role="application" data-lm-suppress-shortcuts="true" '
            f'aria-label="{html.escape(words)}" title="{html.escape(words)}" '
            f'onpointerdown="{html.escape(script)}" onpointermove="{html.escape(script)}" '
            f'onkeydown="{html.escape(script)}"></div>'
        )

    def mark(self, value: tuple[int, int]) -> str:
        """Return the HTML of the mark at a pixel; it covers the picture without changing its pixels."""
        if not self.is_marked(value):
            return ""
        across, down = (100 * (each + 0.5) / length for each, length in zip(value, self.size, strict=True))
        return f'<i class="nao-cursor" style="left: {across:.3f}%; top: {down:.3f}%"></i>'


# Writes "u, v" into the control's text field as if it were typed, because the pictures of ipywidgets have no events.
_PIXEL_SCRIPT = """const size = [%d, %d];
const line = this.closest('.nao-panel').querySelector('.%s input');
let pixel = line.value.split(',').map(Number);
if (event.type === 'keydown') {
  const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
  if (!step || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault(); event.stopPropagation();
  pixel = pixel.map((each, i) => each + step[i] * (event.shiftKey ? 10 : 1));
} else {
  if (!(event.buttons & 1)) return;
  if (event.type === 'pointerdown') this.setPointerCapture(event.pointerId);
  const box = this.getBoundingClientRect();
  pixel = [(event.clientX - box.left) / box.width * size[0], (event.clientY - box.top) / box.height * size[1]];
}
pixel = pixel.map((each, i) => Math.max(0, Math.min(size[i] - 1, Math.floor(each))));
if (line.value === pixel.join(', ')) return;
line.value = pixel.join(', ');
line.dispatchEvent(new Event('change', {bubbles: true}));"""


@dataclass(frozen=True)
class Action(Control):
    """A button that draws again with new random numbers, or sets other controls.

    Its value is the number of presses, which is part of the seed: equal presses give equal results.

    Parameters
    ----------
    name, label : str
        Name in code, and label on the panel.
    key : str, optional
        Key that presses it, by its name in a browser: "n", "arrowup", " ".
    sets : mapping of str to object, optional
        Values that it sets; such a button counts no presses.
    """

    key: str = field(default="", kw_only=True)
    sets: Mapping[str, Any] = field(default_factory=dict, kw_only=True)

    def checked(self, value: Any) -> int:
        """Return a number of presses."""
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 0:
            raise ValueError(f"{self.name} must be a number of presses, 0 or more; got {value!r}")
        return int(value)

    def widget(self) -> Any:
        """Return a button."""
        keys = f" (key: {key_names((self.key.lower(),))})" if self.key else ""
        button = ipywidgets.Button(description=self.label, tooltip=f"{self.tooltip or self.label}{keys}")
        button.add_class(self.css_class("do"))
        return button

    def say(self, value: Any) -> str:
        """Return the label with the number of presses; empty for 0."""
        return f"{self.label} × {value}" if value else ""


class Values(Mapping[str, Any]):
    """The values of a panel's controls: ``values.tilt`` or ``values["tilt"]``.

    The random numbers of `rng` depend only on the seed and the presses of buttons.
    """

    def __init__(self, values: Mapping[str, Any], rng: np.random.Generator) -> None:
        """Copy the values."""
        self._values, self.rng = dict(values), rng

    def __getitem__(self, name: str) -> Any:
        """Return a control's value."""
        return self._values[name]

    def __getattr__(self, name: str) -> Any:
        """Return a control's value."""
        try:
            return self.__dict__["_values"][name]
        except KeyError:
            raise AttributeError(f"this panel has no control {name!r}; it has {list(self)}") from None

    def __iter__(self) -> Iterator[str]:
        """Return an iterator over the controls' names."""
        return iter(self._values)

    def __len__(self) -> int:
        """Return the number of controls."""
        return len(self._values)

    def __repr__(self) -> str:
        """Return the call that creates these values."""
        return f"Values({', '.join(f'{name}={value!r}' for name, value in self.items())})"


def check_controls(controls: Sequence[Control]) -> None:
    """Raise ValueError if controls share a name or a key, or set a control that does not exist."""
    names = [each.name for each in controls]
    keys = [each.key.lower() for each in controls if isinstance(each, Action) and each.key]
    for what, several in (("name", names), ("key", keys)):
        if twice := {each for each in several if several.count(each) > 1}:
            raise ValueError(f"each control must have its own {what}; two have {sorted(twice)[0]!r}")
    by_name = {each.name: each for each in controls}
    for action in controls:
        for name, value in action.sets.items() if isinstance(action, Action) else ():
            if name not in by_name:
                raise ValueError(f"{action.name} sets {name}, which is not a control of this panel")
            by_name[name].checked(value)
