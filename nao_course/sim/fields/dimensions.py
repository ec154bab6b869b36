"""Dimensions of a field, checked, and read from a TOML file."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, get_args

from nao_course.codec import register

GoalColour = Literal["yellow", "white", "none"]

LONGEST = 30.0  # m, of a side: the texture of the carpet needs memory in proportion to its area
GOAL = ("goal_width", "post_height", "post_diameter", "bar_diameter")
AREAS = ("goal_area", "penalty_area")


@register
@dataclass(frozen=True)
class FieldDimensions:
    """Dimensions of a whole field in metres, measured between the centre lines of the field's lines.

    The names are also the keys of a field's TOML file.

    Parameters
    ----------
    length, width : float
        Distance between the goal lines, and between the touch lines.
    border : float
        Width of the carpet around the lines.
    line_width : float
        Width of the lines.
    goal_colour : "yellow", "white" or "none"
        Colour of both goals, or "none" for a field without goals.
    goal_area, penalty_area : (float, float) or None
        Depth and width of the goal area and of the penalty area; None for a field without them.
    circle_diameter : float
        Diameter of the centre circle; 0 for a field without it.
    mark_size : float
        Length of the bars of the centre mark and the penalty marks; 0 for a field without marks.
    penalty_mark : float
        Distance of a penalty mark's centre from its goal line; 0 for a field without penalty marks.
    goal_width, post_diameter, post_height, bar_diameter : float
        Distance between the axes of the posts, diameter of a post, height of the crossbar's axis, and diameter of the
        crossbar; 0 for a field without goals.

    Raises
    ------
    ValueError
        If a value has the wrong type or does not fit on the field. The message names it and says what is allowed.
    """

    length: float
    width: float
    border: float
    line_width: float
    goal_colour: GoalColour
    goal_area: tuple[float, float] | None = None
    penalty_area: tuple[float, float] | None = None
    circle_diameter: float = 0.0
    mark_size: float = 0.0
    penalty_mark: float = 0.0
    goal_width: float = 0.0
    post_diameter: float = 0.0
    post_height: float = 0.0
    bar_diameter: float = 0.0

    def __post_init__(self) -> None:
        """Check the values."""
        if self.goal_colour not in get_args(GoalColour):
            known = ", ".join(f'"{each}"' for each in get_args(GoalColour))
            raise ValueError(f"goal_colour must be one of {known}, got {self.goal_colour!r}")
        for each in fields(self):
            value = getattr(self, each.name)
            if each.name in AREAS:
                checked: object = None if value is None else _depth_and_width(each.name, value)
            elif each.name == "goal_colour":
                continue
            else:
                checked = _length(each.name, value)
            object.__setattr__(self, each.name, checked)
        self._check_outer_lines()
        self._check_inside()
        self._check_goals()

    def _check_outer_lines(self) -> None:
        for name in ("length", "width"):
            _check_between(name, getattr(self, name), 0.0, LONGEST)
        _check_between("line_width", self.line_width, 0.0, self.width / 4, "a quarter of the width")

    def _check_inside(self) -> None:
        """Check that areas, circle and marks lie inside the outer lines."""
        half = "half of the length"
        for name in AREAS:
            if (area := getattr(self, name)) is not None:
                _check_between(f"{name}: the depth", area[0], self.line_width, self.length / 2, half)
                _check_between(
                    f"{name}: the width", area[1], self.line_width, self.width, "the field's width"
                )
        if self.goal_area and self.penalty_area:
            for name, inner, outer in zip(("depth", "width"), self.goal_area, self.penalty_area, strict=True):
                if inner >= outer:
                    raise ValueError(
                        f"penalty_area: the {name} must be above the {name} of the goal area, {inner:g} m, "
                        f"got {outer:g}"
                    )
        if self.circle_diameter:
            room = min(self.width, self.length - 2 * (self.penalty_area or self.goal_area or (0.0,))[0])
            limit = "the circle would reach the outer lines or an area"
            _check_between("circle_diameter", self.circle_diameter, 2 * self.line_width, room, limit)
        if self.penalty_mark:
            _check_between("penalty_mark", self.penalty_mark, 0.0, self.length / 2, half)
            if not self.mark_size:
                raise ValueError("mark_size must be given for a field with penalty marks; it is missing")
        if self.mark_size:
            _check_between("mark_size", self.mark_size, 0.0, self.width / 2, "half of the width")

    def _check_goals(self) -> None:
        given = [name for name in GOAL if getattr(self, name)]
        if self.goal_colour == "none":
            if given:
                raise ValueError(f'{given[0]} must be left out if goal_colour = "none": there are no goals')
            return
        if missing := [name for name in GOAL if name not in given]:
            raise ValueError(
                f'{missing[0]} must be given for a field with goals; leave goals out by goal_colour = "none"'
            )
        _check_between("goal_width", self.goal_width, 0.0, self.width, "the field's width")
        _check_between("post_height", self.post_height, 0.0, 3.0)
        for name in ("post_diameter", "bar_diameter"):
            largest = min(self.goal_width, self.post_height) / 2
            _check_between(name, getattr(self, name), 0.0, largest, "half of the goal's width or height")


def _length(name: str, value: object) -> float:
    """Return a length in metres, 0 or more."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} must be a number of metres, got {_shown(value)}")
    number = float(value) if abs(value) < 1e9 else math.inf
    if not (math.isfinite(number) and number >= 0):
        raise ValueError(f"{name} must be a number of metres that is not negative, got {_shown(value)}")
    return number


def _depth_and_width(name: str, value: object) -> tuple[float, float]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError(
            f"{name} must be its depth and width in metres, such as [0.6, 2.2], got {_shown(value)}"
        )
    return _length(f"{name}: the depth", value[0]), _length(f"{name}: the width", value[1])


def _check_between(name: str, value: float, least: float, largest: float, why: str = "") -> None:
    if not least < value < largest:
        reason = f" ({why})" if why else ""
        raise ValueError(f"{name} must be above {least:g} and below {largest:g} m{reason}, got {value:g}")


def _shown(value: object) -> str:
    """Return a value as text, shortened, as TOML has it for texts, numbers and truth values."""
    text = str(value).lower() if isinstance(value, bool) else repr(value)
    return text if len(text) <= 60 else f"{text[:60]}..."


# --- files ---


def read_field(path: str | Path) -> tuple[FieldDimensions, bool]:
    """Read the TOML file of a field.

    Parameters
    ----------
    path : str or Path
        The file, or the name of a field in `SHIPPED`, such as "lab".

    Returns
    -------
    dimensions : FieldDimensions
        Dimensions of the whole field.
    half : bool
        Whether there is only the half with positive x.

    Raises
    ------
    ValueError
        If there is no such file, or if it is not a valid description of a field. The message names the file and the
        key, and says what is allowed.
    """
    file = SHIPPED.get(str(path), Path(path))
    try:
        table = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(
            f"{file}: the field cannot be read ({error.strerror}); "
            f"give a TOML file, or the name of a field of the course: {', '.join(SHIPPED)}"
        ) from None
    except ValueError as error:  # of TOML or of UTF-8
        raise ValueError(f"{file}: not a TOML file: {error}") from None
    try:
        return _from_table(table)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None


def _from_table(table: Mapping[str, Any]) -> tuple[FieldDimensions, bool]:
    required = [each.name for each in fields(FieldDimensions) if each.default is MISSING]
    known = ["half", *(each.name for each in fields(FieldDimensions))]
    for key in table:
        if key not in known:
            near = get_close_matches(key, known, 1)
            meant = f"did you mean {near[0]}?" if near else f"the keys are {', '.join(known)}"
            raise ValueError(f"{key} is not a key of a field; {meant}")
    for key in ("half", *required):
        if key not in table:
            raise ValueError(f"{key} is missing; the keys {', '.join(['half', *required])} must be given")
    half = table["half"]
    if not isinstance(half, bool):
        raise ValueError(f"half must be true or false, got {_shown(half)}")
    return FieldDimensions(**{key: value for key, value in table.items() if key != "half"}), half


SHIPPED = {path.stem: path for path in sorted(Path(__file__).parent.glob("*.toml"))}
# By rule year, because most of the course writes Field(2012).
DIMENSIONS = {int(name): read_field(path)[0] for name, path in SHIPPED.items() if name.isdecimal()}
