"""The RoboCup Standard Platform League field by rule year: one table of dimensions, and the geometry that follows."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, get_args

import numpy as np

from nao_course.exercises.codec import register
from nao_course.geometry import FloatArray, Pose, finite

Shape = Literal["L", "T", "X", "post"]
MarkKind = Literal["corner", "post", "cross"]


@dataclass(frozen=True)
class FieldDimensions:
    """Dimensions of a whole field in metres; lines are measured to their middle.

    Parameters
    ----------
    length, width : float
        Goal line to goal line, touch line to touch line.
    goal_area : (float, float)
        Depth and width of the box at the goal.
    penalty_area : (float, float) or None
        Depth and width of the larger box, where the rules have one.
    penalty_mark : float
        From the goal line to the middle of the mark.
    circle_diameter : float
        Of the centre circle.
    bar_diameter : float
        Of the goal's crossbar.
    goal_colour : "yellow" or "white"
        Of the goal nearest to positive x; the other goal has the same.
    goal_width, post_diameter, post_height : float
        Between the posts' centres; of a post; ground to the bar's middle.
    line_width, border, mark_size : float
        Of all lines; carpet beyond them; of the penalty mark's cross.
    """

    length: float
    width: float
    goal_area: tuple[float, float]
    penalty_area: tuple[float, float] | None
    penalty_mark: float
    circle_diameter: float
    bar_diameter: float
    goal_colour: Literal["yellow", "white"]
    goal_width: float = 1.4
    post_diameter: float = 0.10
    post_height: float = 0.80
    line_width: float = 0.05
    border: float = 0.70
    mark_size: float = 0.10


# RoboCup SPL rule books of the years named; 2025 stands for 2020 to 2025.
DIMENSIONS: dict[int, FieldDimensions] = {
    2012: FieldDimensions(6.0, 4.0, (0.6, 2.2), None, 1.8, 1.2, 0.05, "yellow"),
    2013: FieldDimensions(9.0, 6.0, (0.6, 2.2), None, 1.8, 1.5, 0.10, "yellow"),
    2025: FieldDimensions(9.0, 6.0, (0.6, 2.2), (1.65, 4.0), 1.3, 1.5, 0.10, "white"),
}


@register
@dataclass(frozen=True)
class Landmark:
    """A point of the field that a robot can recognise.

    Parameters
    ----------
    x, y : float
        Field frame, metres.
    kind : "corner", "post" or "cross"
        A corner of two lines (L or T), a goal post's foot, or a crossing that the seed paper does not
        look for (marks, and where the circle meets the halfway line).
    shape : "L", "T", "X" or "post"
        What it looks like.

    Raises
    ------
    ValueError
        If a position is not finite, or kind or shape is another.
    """

    x: float
    y: float
    kind: MarkKind
    shape: Shape

    def __post_init__(self) -> None:
        """Check the values."""
        for name in ("x", "y"):
            object.__setattr__(self, name, finite(f"Landmark: {name} (m)", getattr(self, name)))
        for name, known in (("kind", get_args(MarkKind)), ("shape", get_args(Shape))):
            if getattr(self, name) not in known:
                raise ValueError(f"Landmark: {name} must be one of {known}, got {getattr(self, name)!r}")


@register
@dataclass(frozen=True)
class Field:
    """A field: its lines, arcs, marks, goals and landmarks in the field frame.

    Parameters
    ----------
    year : int
        Rule year: 2012 (the seed paper's), 2013 or 2025.
    half : bool
        Only the half with positive x, with its one goal, as in Aliyev et al. 2014, section 2.2.
    pose : Pose
        The field frame's pose in the world. Robot poses are given in the world; with the default the
        two are the same.

    Raises
    ------
    ValueError
        If the year is not in the table.

    Examples
    --------
    >>> Field(2012).posts
    array([[ 3. , -0.7],
           [ 3. ,  0.7]])
    """

    year: int = 2012
    half: bool = True
    pose: Pose = field(default_factory=Pose)

    def __post_init__(self) -> None:
        """Check year and pose."""
        if self.year not in DIMENSIONS:
            raise ValueError(f"year must be one of {sorted(DIMENSIONS)} (rule books), got {self.year!r}")
        if not isinstance(self.pose, Pose):
            raise ValueError(f"Field: pose must be a Pose, got {self.pose!r}")
        object.__setattr__(self, "half", bool(self.half))

    @property
    def dimensions(self) -> FieldDimensions:
        """The table's row for this year."""
        return DIMENSIONS[self.year]

    @property
    def _ends(self) -> tuple[int, ...]:
        """Signs of the goal lines that are there."""
        return (1,) if self.half else (-1, 1)

    @property
    def x_range(self) -> tuple[float, float]:
        """Smallest and largest x of a line's middle, in metres."""
        return (0.0 if self.half else -self.dimensions.length / 2), self.dimensions.length / 2

    @property
    def y_range(self) -> tuple[float, float]:
        """Smallest and largest y of a line's middle, in metres."""
        return -self.dimensions.width / 2, self.dimensions.width / 2

    @property
    def carpet(self) -> tuple[float, float, float, float]:
        """The green rectangle (x_min, y_min, x_max, y_max) in metres: the lines and the border."""
        b = self.dimensions.border
        return self.x_range[0] - b, self.y_range[0] - b, self.x_range[1] + b, self.y_range[1] + b

    @cached_property
    def lines(self) -> FloatArray:
        """Middles of the straight lines: (N, 4) as x1, y1, x2, y2, each parallel to an axis, in metres."""
        d = self.dimensions
        (x0, x1), (y0, y1) = self.x_range, self.y_range
        rows = [(x0, y0, x1, y0), (x0, y1, x1, y1), (0.0, y0, 0.0, y1)]
        for sign in self._ends:
            goal_line = sign * d.length / 2
            rows.append((goal_line, y0, goal_line, y1))
            for depth, width in filter(None, (d.goal_area, d.penalty_area)):
                front = goal_line - sign * depth
                rows.append((front, -width / 2, front, width / 2))
                rows += [(front, y, goal_line, y) for y in (-width / 2, width / 2)]
        return np.array(rows)

    @cached_property
    def marks(self) -> FloatArray:
        """Middles of the cross-shaped marks: (N, 2), in metres. The centre mark is a dash across the halfway line."""
        d = self.dimensions
        penalty = [(sign * (d.length / 2 - d.penalty_mark), 0.0) for sign in self._ends]
        return np.array([(0.0, 0.0), *penalty])

    @cached_property
    def mark_lines(self) -> FloatArray:
        """The marks' bars as lines: (N, 4) like `lines`, in metres."""
        h = self.dimensions.mark_size / 2
        rows = []
        for x, y in self.marks:
            left = max(x - h, self.x_range[0])
            rows += [(left, y, x + h, y), (x, y - h, x, y + h)]
        return np.array(rows)

    @property
    def arcs(self) -> FloatArray:
        """Circles of line: (N, 5) as x, y, radius, first and last angle (rad, counterclockwise)."""
        span = (-np.pi / 2, np.pi / 2) if self.half else (-np.pi, np.pi)
        return np.array([(0.0, 0.0, self.dimensions.circle_diameter / 2, *span)])

    @cached_property
    def posts(self) -> FloatArray:
        """Feet of the goal posts: (N, 2), in metres."""
        d = self.dimensions
        return np.array(
            [(s * d.length / 2, y) for s in self._ends for y in (-d.goal_width / 2, d.goal_width / 2)]
        )

    @cached_property
    def bars(self) -> FloatArray:
        """Middles of the crossbars' ends: (N, 2, 3) as x, y, z, in metres."""
        d = self.dimensions
        return np.array(
            [
                [(s * d.length / 2, y, d.post_height) for y in (-d.goal_width / 2, d.goal_width / 2)]
                for s in self._ends
            ]
        )

    @cached_property
    def landmarks(self) -> tuple[Landmark, ...]:
        """Corners (L, T), post feet and crossings (X) of this field."""
        d = self.dimensions
        (x0, x1), (y0, y1) = self.x_range, self.y_range
        found: list[Landmark] = [Landmark(x, y, "corner", "L") for x in (x0, x1) for y in (y0, y1)]
        if not self.half:
            found += [Landmark(0.0, y, "corner", "T") for y in (y0, y1)]
        for sign in self._ends:
            goal_line = sign * d.length / 2
            for depth, width in filter(None, (d.goal_area, d.penalty_area)):
                for y in (-width / 2, width / 2):
                    found.append(Landmark(goal_line, y, "corner", "T"))
                    found.append(Landmark(goal_line - sign * depth, y, "corner", "L"))
        found += [Landmark(float(x), float(y), "post", "post") for x, y in self.posts]
        found += [Landmark(float(x), float(y), "cross", "X") for x, y in self.marks]
        found += [Landmark(0.0, s * d.circle_diameter / 2, "cross", "X") for s in (-1, 1)]
        return tuple(found)
