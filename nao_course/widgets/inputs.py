"""What a panel's reader can set: sliders, choices, toggles, a pixel of a picture, and buttons, as declarations."""

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

RESERVED = frozenset({"rng", "keys", "values", "items", "get"})  # what `Values` has names for


@dataclass(frozen=True)
class Control(ABC):
    """Something that a panel's reader can set.

    Parameters
    ----------
    name : str
        In code: ``values.name``, ``panel.set(name=...)``.
    label : str
        On the panel.
    """

    name: str
    label: str

    def __post_init__(self) -> None:
        """Refuse what cannot be a name or a start."""
        if not self.name.isidentifier() or keyword.iskeyword(self.name) or self.name.startswith("_"):
            raise ValueError(f"a control's name must be one as variables have, got {self.name!r}")
        if self.name in RESERVED:
            raise ValueError(
                f"a control cannot have the name {self.name!r}: values.{self.name} is another thing"
            )
        if "start" in vars(self):
            object.__setattr__(self, "start", self.first)

    @property
    def first(self) -> Any:
        """The value at first."""
        return self.checked(vars(self).get("start", 0))

    @abstractmethod
    def checked(self, value: Any) -> Any:
        """Return a value as the panel keeps it; a ValueError, with the limits, for one that cannot be set."""

    @abstractmethod
    def widget(self) -> Any:
        """Return a new widget whose `value` is `to_widget(first)`."""

    def say(self, value: Any) -> str:
        """Return a value in words, such as "Tilt 2.0°"."""
        return f"{self.label} {value}"

    def to_widget(self, value: Any) -> Any:
        """Return what the widget is to hold for a value."""
        return value

    def from_widget(self, held: Any) -> Any:
        """Return the value, not yet checked, that a widget holds."""
        return held

    def css_class(self, kind: str) -> str:
        """Return the class of the widget on the page, such as "nao-slider-tilt"."""
        return f"nao-{kind}-{self.name.replace('_', '-')}"


def _with_unit(text: str, unit: str) -> str:
    return f"{text}{unit}" if unit in ("", "°") else f"{text} {unit}"


@dataclass(frozen=True)
class _Scale(Control):
    """What has limits and steps; whole numbers where all of these are whole."""

    low: float
    high: float
    step: float
    start: Any
    unit: str = field(default="", kw_only=True)
    tooltip: str = field(default="", kw_only=True)
    look: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        """Refuse limits that leave nothing to slide."""
        if not (self.low < self.high and 0 < self.step <= self.high - self.low):
            raise ValueError(
                f"{self.name} must have low < high and a step between them, "
                f"got {self.low} to {self.high} in steps of {self.step}"
            )
        super().__post_init__()

    @property
    def whole(self) -> bool:
        """Whether its values are whole numbers."""
        return all(isinstance(each, int | np.integer) for each in (self.low, self.high, self.step))

    def rounded(self, value: Any) -> float:
        """Return a number as a browser rounds it, to whole steps from the low end."""
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = math.nan
        if isinstance(value, bool) or not self.low <= number <= self.high:
            raise ValueError(f"{self.name} must be from {self.limits}, got {value!r}")
        steps = round((number - self.low) / self.step)
        result = min(round(self.low + steps * self.step, 10), self.high)
        return int(result) if self.whole else float(result)

    @property
    def limits(self) -> str:
        """Both ends in words."""
        return _with_unit(f"{self.low:g} to {self.high:g}", self.unit)

    def number(self, value: float) -> str:
        """Return a number with as many digits as a step has."""
        return f"{value:.{self.digits}f}"

    @property
    def digits(self) -> int:
        """Digits after the point that tell two steps apart."""
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
    """One number.

    Parameters
    ----------
    name, label : str
        In code, and on the panel.
    low, high, step : float
        Limits and steps; where all three are whole, so are the values.
    start : float
        At first.
    unit : str
        Shown behind the label, and behind the value in words.
    tooltip : str
        What it does.
    look : str
        A class of CSS for the widget.

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
        """Return it with its unit."""
        return f"{self.label} {_with_unit(self.number(value), self.unit)}"


@dataclass(frozen=True)
class RangeSlider(_Scale):
    """Two numbers, the first not above the second; arguments as of `Slider`, `start` a pair."""

    def checked(self, value: Any) -> tuple[float, float]:
        """Return both limits, in whole steps."""
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
        """Return both with their unit."""
        return f"{self.label} {_with_unit(' to '.join(map(self.number, value)), self.unit)}"


@dataclass(frozen=True)
class Choice(Control):
    """One of a few texts or numbers.

    Parameters
    ----------
    name, label : str
        In code, and on the panel.
    options : sequence of str, int or float
        What there is to choose; shown as `str` gives it.
    start : str, int or float, optional
        At first; by default the first.
    tooltip : str
        What it does.
    stays : bool
        Whether Reset leaves it as it is: what is looked at, such as the picture, and not how.
    """

    options: Sequence[Any]
    start: Any = None
    tooltip: str = field(default="", kw_only=True)
    stays: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        """Begin with the first if nothing else is said."""
        if not self.options:
            raise ValueError(f"{self.name} must have at least one option, got none")
        if self.start is None:
            object.__setattr__(self, "start", self.options[0])
        super().__post_init__()

    def checked(self, value: Any) -> Any:
        """Return the option that is equal."""
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
    """Yes or no.

    Parameters
    ----------
    name, label : str
        In code, and on the panel.
    start : bool
        At first.
    tooltip : str
        What it does.
    """

    start: bool = False
    tooltip: str = field(default="", kw_only=True)

    def checked(self, value: Any) -> bool:
        """Return True or False."""
        if not isinstance(value, bool | np.bool_):
            raise ValueError(f"{self.name} must be True or False, got {value!r}")
        return bool(value)

    def widget(self) -> Any:
        """Return a box to tick."""
        box = ipywidgets.Checkbox(value=self.start, description=self.label, indent=False)
        box.tooltip = self.tooltip or self.label
        box.layout.width = "auto"
        box.add_class(self.css_class("toggle"))
        return box

    def say(self, value: Any) -> str:
        """Return whether it is on."""
        return f"{self.label} {'on' if value else 'off'}"


@dataclass(frozen=True)
class Pixel(Control):
    """A pixel of a picture: clicked, dragged to, reached with the arrow keys, or typed.

    Parameters
    ----------
    name, label : str
        In code, and on the panel.
    size : (int, int)
        Width and height of the picture.
    start : (int, int), optional
        (u, v) at first; by default the middle.
    picture : str, optional
        Title of the picture; by default the first one.
    tooltip : str
        What it does.
    """

    size: tuple[int, int]
    start: Any = None
    picture: str = field(default="", kw_only=True)
    tooltip: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        """Begin in the middle if nothing else is said."""
        if self.start is None:
            object.__setattr__(self, "start", tuple(length // 2 for length in self.size))
        super().__post_init__()

    def checked(self, value: Any) -> tuple[int, int]:
        """Return (u, v), two whole numbers inside the picture."""
        try:
            u, v = (float(each) for each in value)
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

    def from_widget(self, held: Any) -> Any:
        """Return what is typed, as numbers where it is some."""
        return held.strip("() ").split(",")

    def widget(self) -> Any:
        """Return a line to type in; the picture writes into it, too."""
        line = ipywidgets.Text(
            value=self.to_widget(self.start), description=f"{self.label} (u, v)", continuous_update=False
        )
        line.tooltip = self.tooltip or f"{self.label}: click into the picture, or use the arrow keys there"
        line.add_class(self.css_class("pixel"))
        return line

    def say(self, value: Any) -> str:
        """Return (u, v)."""
        return f"{self.label} ({value[0]}, {value[1]})"

    def pad(self) -> str:
        """Return HTML of what lies over the picture and takes clicks and keys."""
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
        """Return HTML of the mark at a pixel; it lies over the picture, whose pixels stay as they are."""
        across, down = (100 * (each + 0.5) / length for each, length in zip(value, self.size, strict=True))
        return f'<i class="nao-cursor" style="left: {across:.3f}%; top: {down:.3f}%"></i>'


# Writes "u, v" into the control's line, as if it were typed: ipywidgets' pictures have no events of their own.
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
    """A button: it draws again with new random numbers, or sets other controls.

    Its value is how often it was pressed; it is part of the seed, so the same presses give the same.

    Parameters
    ----------
    name, label : str
        In code, and on the panel.
    key : str, optional
        A key that presses it, as a browser names it: "n", "arrowup", " ".
    sets : mapping of str to object, optional
        Values that it sets; it counts no presses then.
    tooltip : str
        What it does.
    """

    key: str = field(default="", kw_only=True)
    sets: Mapping[str, Any] = field(default_factory=dict, kw_only=True)
    tooltip: str = field(default="", kw_only=True)

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
        """Return how often it was pressed, if it was."""
        return f"{self.label} × {value}" if value else ""


class Values(Mapping[str, Any]):
    """Where a panel's controls stand: ``values.tilt`` or ``values["tilt"]``.

    Attributes
    ----------
    rng : numpy.random.Generator
        Begins the same for the same seed and the same presses of buttons.
    """

    def __init__(self, values: Mapping[str, Any], rng: np.random.Generator) -> None:
        """Keep a copy."""
        self._values, self.rng = dict(values), rng

    def __getitem__(self, name: str) -> Any:
        """Return a control's value."""
        return self._values[name]

    def __getattr__(self, name: str) -> Any:
        """Return a control's value."""
        try:
            return self.__dict__["_values"][name]
        except KeyError:
            raise AttributeError(f"this panel has no control {name!r}, but {list(self)}") from None

    def __iter__(self) -> Iterator[str]:
        """The controls' names."""
        return iter(self._values)

    def __len__(self) -> int:
        """How many there are."""
        return len(self._values)

    def __repr__(self) -> str:
        """As a call with these values."""
        return f"Values({', '.join(f'{name}={value!r}' for name, value in self.items())})"


def check_controls(controls: Sequence[Control]) -> None:
    """Refuse controls of one panel that share a name or a key, or set what is not there."""
    names = [each.name for each in controls]
    keys = [each.key.lower() for each in controls if isinstance(each, Action) and each.key]
    for what, several in (("name", names), ("key", keys)):
        if twice := {each for each in several if several.count(each) > 1}:
            raise ValueError(f"each control needs a {what} of its own; two have {sorted(twice)[0]!r}")
    by_name = {each.name: each for each in controls}
    for action in controls:
        for name, value in action.sets.items() if isinstance(action, Action) else ():
            if name not in by_name:
                raise ValueError(f"{action.name} sets {name}, which is no control of this panel")
            by_name[name].checked(value)
