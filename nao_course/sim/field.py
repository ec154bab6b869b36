"""A football field with its lines, goals and landmarks, by the rules of a year or from a file of dimensions."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal, Self, assert_never, get_args

import numpy as np

from nao_course.codec import register
from nao_course.geometry import FloatArray, Pose, finite
from nao_course.sim.fields import DIMENSIONS, FieldDimensions, read_field
from nao_course.slam import LandmarkKind

Shape = Literal["L", "T", "X", "post"]
MarkKind = Literal["corner", "post", "cross"]


@register
@dataclass(frozen=True)
class Landmark:
    """A point of the field that a robot can recognise.

    Parameters
    ----------
    x, y : float
        Position in the field frame, m.
    kind : "corner", "post" or "cross"
        Corner of two lines (L or T), foot of a goal post, or crossing (a mark, or the circle with the halfway line),
        which the paper by Aliyev et al. does not detect.
    shape : "L", "T", "X" or "post"
        Shape in a picture.

    Raises
    ------
    ValueError
        If a coordinate is not finite, or if the kind or shape is unknown.
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

    @property
    def detected_as(self) -> LandmarkKind | None:
        """Kind that a detector reports for this landmark; None for crossings, which are not detected."""
        match self.kind:
            case "corner" | "post":
                return self.kind
            case "cross":
                return None
        assert_never(self.kind)


@register
@dataclass(frozen=True)
class Field:
    """A field with its lines, arcs, marks, goals and landmarks in the field frame.

    Parameters
    ----------
    rules : int or FieldDimensions
        Year of the rules: 2012 (as in Aliyev et al. 2014), 2013 or 2025; or dimensions of one's own. `from_toml` reads
        them from a file.
    half : bool
        Whether there is only the half with positive x and its goal, as in Aliyev et al. 2014, section 2.2.
    pose : Pose
        Pose of the field frame in the world frame, in which the poses of robots are given. By default, both frames are
        the same.

    Raises
    ------
    ValueError
        If the year is not one of these.

    Examples
    --------
    >>> Field(2012).posts
    array([[ 3. , -0.7],
           [ 3. ,  0.7]])
    """

    rules: int | FieldDimensions = 2012
    half: bool = True
    pose: Pose = field(default_factory=Pose)

    def __post_init__(self) -> None:
        """Check the values."""
        if not isinstance(self.rules, FieldDimensions) and self.rules not in DIMENSIONS:
            raise ValueError(
                f"Field: the year must be one of {sorted(DIMENSIONS)} (rule books), got {self.rules!r}; "
                "Field.from_toml reads another field from a file"
            )
        if not isinstance(self.pose, Pose):
            raise ValueError(f"Field: pose must be a Pose, got {self.pose!r}")
        object.__setattr__(self, "half", bool(self.half))

    @classmethod
    def from_toml(cls, path: str | Path, pose: Pose | None = None) -> Self:
        """Return the field that a TOML file describes; docs/own_field.md lists the file's keys.

        Parameters
        ----------
        path : str or Path
            The file; or the name of a field of the course: "2012", "2013", "2025" or "lab".
        pose : Pose, optional
            Pose of the field frame in the world frame; by default, both frames are the same.

        Raises
        ------
        ValueError
            If there is no such file, or if it does not describe a field. The message names the file and the key.

        Examples
        --------
        >>> Field.from_toml("lab").x_range
        (-2.25, 2.25)
        """
        dimensions, half = read_field(path)
        return cls(dimensions, half, pose or Pose())

    @property
    def dimensions(self) -> FieldDimensions:
        """Dimensions of the whole field."""
        return self.rules if isinstance(self.rules, FieldDimensions) else DIMENSIONS[self.rules]

    @property
    def _ends(self) -> tuple[int, ...]:
        """Signs of the x coordinates of the goal lines."""
        return (1,) if self.half else (-1, 1)

    @property
    def x_range(self) -> tuple[float, float]:
        """Smallest and largest x of the lines' centre lines, m."""
        return (0.0 if self.half else -self.dimensions.length / 2), self.dimensions.length / 2

    @property
    def y_range(self) -> tuple[float, float]:
        """Smallest and largest y of the lines' centre lines, m."""
        return -self.dimensions.width / 2, self.dimensions.width / 2

    @property
    def carpet(self) -> tuple[float, float, float, float]:
        """Rectangle of the carpet, which includes the border: (x_min, y_min, x_max, y_max), m."""
        b = self.dimensions.border
        return self.x_range[0] - b, self.y_range[0] - b, self.x_range[1] + b, self.y_range[1] + b

    @cached_property
    def lines(self) -> FloatArray:
        """Centre lines of the straight lines, (N, 4) as x1, y1, x2, y2, m; each is parallel to an axis."""
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
        """Centres of the marks, (N, 2), m. On the halfway line, only a dash across it remains of the cross."""
        d = self.dimensions
        centre = [(0.0, 0.0)] if d.mark_size else []
        ends = self._ends if d.penalty_mark else ()
        penalty = [(sign * (d.length / 2 - d.penalty_mark), 0.0) for sign in ends]
        return np.array([*centre, *penalty]).reshape(-1, 2)

    @cached_property
    def mark_lines(self) -> FloatArray:
        """Centre lines of the marks' bars, (N, 4) as in `lines`, m."""
        h = self.dimensions.mark_size / 2
        rows = []
        for x, y in self.marks:
            left = max(x - h, self.x_range[0])
            rows += [(left, y, x + h, y), (x, y - h, x, y + h)]
        return np.array(rows).reshape(-1, 4)

    @property
    def arcs(self) -> FloatArray:
        """Circular lines: (N, 5) as x, y and radius, m, and first and last angle, rad counterclockwise."""
        span = (-np.pi / 2, np.pi / 2) if self.half else (-np.pi, np.pi)
        radius = self.dimensions.circle_diameter / 2
        return np.array([(0.0, 0.0, radius, *span)] if radius else []).reshape(-1, 5)

    @cached_property
    def bars(self) -> FloatArray:
        """Ends of the crossbars' axes, (N, 2, 3) as x, y, z, m."""
        d = self.dimensions
        ends = () if d.goal_colour == "none" else self._ends
        sides = (-d.goal_width / 2, d.goal_width / 2)
        return np.array([[(s * d.length / 2, y, d.post_height) for y in sides] for s in ends]).reshape(
            -1, 2, 3
        )

    @property
    def posts(self) -> FloatArray:
        """Positions of the goal posts, (N, 2), m."""
        return self.bars[..., :2].reshape(-1, 2)

    @cached_property
    def landmarks(self) -> tuple[Landmark, ...]:
        """Corners (L, T), feet of posts and crossings (X) of this field."""
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
        found += [Landmark(0.0, s * radius, "cross", "X") for radius in self.arcs[:, 2] for s in (-1, 1)]
        return tuple(found)

    @cached_property
    def detectable(self) -> tuple[Landmark, ...]:
        """Landmarks that detectors report: corners and feet of posts."""
        return tuple(mark for mark in self.landmarks if mark.detected_as is not None)

    @cached_property
    def detectable_positions(self) -> FloatArray:
        """Positions of the detectable landmarks in the field frame, (N, 2), m; read-only."""
        positions = np.array([(mark.x, mark.y) for mark in self.detectable])
        positions.flags.writeable = False
        return positions

    @cached_property
    def detectable_kinds(self) -> tuple[LandmarkKind, ...]:
        """Kind that a detector reports for each of the detectable landmarks."""
        return tuple(mark.detected_as for mark in self.detectable if mark.detected_as is not None)
