"""What a picture shows, with its lines and the centre circle, and what all pictures of a stop show together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Literal

import numpy as np
import numpy.typing as npt

from nao_course.field_slam.compass import AGREES, BodyTilt, wrap_quarter
from nao_course.field_slam.known_shapes.circle import RADIUS, Circle, find_circle
from nao_course.field_slam.lines import to_ground
from nao_course.field_slam.observation import Observation, picture_covariance, values_of
from nao_course.geometry import FloatArray, rotation_2d
from nao_course.sim import CameraView
from nao_course.slam import LandmarkKind, Measurement

PointKind = LandmarkKind | Literal["centre"]
# Two in three lines below 0.3 m are arcs of the centre circle or stand upright (`python -m benchmarks compass`).
LEAST_LENGTH = 0.45  # m
LEAST_PIXELS = 20.0  # px at 320: pixel noise turns a shorter line by more than AGREES
# m, to a line's nearest point: there one degree of tilt is as much as the goal area's depth, 0.6 m.
FARTHEST = 4.0
# px at 320, perpendicular to the line, and m; found on seeds 200 to 229 of `benchmarks field_slam`
LINE_SIGMA, CENTRE_SIGMA = 0.85, 0.0175
EDGE = 0.1  # rad: a landmark that is nearer to the edge of a picture may not be detected
# m: measurements of two pictures of a stop that are nearer than this belong to the same thing.
SAME_POINT, SAME_LINE = 0.3, 0.25
COMPASS_GATE = 4.0  # standard deviations, between the compasses of two pictures


@dataclass(frozen=True, eq=False)
class LineObservation(Observation):
    """An observation with the lines and the centre circle of its picture.

    `shared` (2,) is the covariance of pitch and roll with the lines' direction, rad^2. Each of the lines (N, 5) is its
    visible point (x, y) that is nearest to the robot, m, its direction, rad, in the robot frame, and the ends of its
    visible part, m along the direction from that point. `view` is the smallest and the largest bearing in the picture,
    rad.
    """

    shared: FloatArray = field(default_factory=lambda: np.zeros(2))
    lines: FloatArray = field(default_factory=lambda: np.zeros((0, 5)))
    circle: Circle | None = None
    view: tuple[float, float] = (0.0, 0.0)


def scene(
    seen: Observation, tilt: BodyTilt, lines: FloatArray, level: CameraView, radius: float = RADIUS
) -> LineObservation:
    """Add the lines and the centre circle to the landmarks of a picture.

    The compass of `seen` was computed with this tilt, and `level` is the view corrected by it. The lines (N, 4) come
    from `read_lines`, px; the circle's radius is in m, and 0 if there is none. Without a compass the result has no
    lines, because it is then unknown which of the field's two directions each line has.
    """
    own = {each.name: getattr(seen, each.name) for each in fields(Observation)}
    found = field_lines(lines, tilt, level) if np.isfinite(seen.direction_sigma) else np.zeros((0, 5))
    view = (level.yaw - level.hfov / 2 + EDGE, level.yaw + level.hfov / 2 - EDGE)
    circle = find_circle(lines, level, radius)
    return LineObservation(**own, shared=tilt.covariance[:2, 2], lines=found, circle=circle, view=view)


def field_lines(lines: FloatArray, tilt: BodyTilt, level: CameraView) -> FloatArray:
    """Return the lines that have one of the field's two directions, as `LineObservation.lines`."""
    ends = np.asarray(lines, dtype=float).reshape(-1, 4)
    ground = to_ground(ends.reshape(-1, 2), level).reshape(-1, 2, 2) + level.offset
    along = ground[:, 1] - ground[:, 0]
    length = np.maximum(np.hypot(*along.T), 1e-9)
    share = np.clip(-(ground[:, 0] * along).sum(axis=1) / length**2, 0, 1)
    nearest = ground[:, 0] + share[:, None] * along
    direction = np.arctan2(along[:, 1], along[:, 0])
    pixels = np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1]) * 320 / level.size[0]
    with np.errstate(invalid="ignore"):  # points at the horizon have no position
        kept = (length >= LEAST_LENGTH) & (pixels >= LEAST_PIXELS) & (np.hypot(*nearest.T) < FARTHEST)
        kept &= np.abs(wrap_quarter(direction - tilt.direction)) < AGREES
    return np.column_stack([nearest, direction, -share * length, (1 - share) * length])[kept]


def visible_ends(lines: FloatArray) -> FloatArray:
    """Return the ends (N, 2, 2) of the visible parts of `LineObservation.lines`, m, in the robot frame."""
    direction = np.column_stack([np.cos(lines[:, 2]), np.sin(lines[:, 2])])
    return np.asarray(lines[:, None, :2] + lines[:, 3:, None] * direction[:, None])


@dataclass(frozen=True, eq=False)
class StopView:
    """What all pictures of a stop show together.

    The heading from the compass is known modulo 90 degrees, rad, and its standard deviation is infinite without a
    compass. Points (k, 2) with covariances (k, 2, 2) are corners, posts and the circle's centre; each line has a point
    (m, 2) with covariance (m, 2, 2), a direction (m,), and the ends (m, 2, 2) of its visible part. All are in the robot
    frame, in m, m^2 and rad. Each of the views (p, 2) is the smallest and the largest bearing in a picture, rad, and
    each of the `line_views` (q, 2) in a picture that has a compass, because only these have lines.
    """

    heading: float
    heading_sigma: float
    points: FloatArray
    covariances: FloatArray
    kinds: tuple[PointKind, ...]
    lines: FloatArray
    line_covariances: FloatArray
    directions: FloatArray
    ends: FloatArray
    views: FloatArray
    line_views: FloatArray

    @classmethod
    def of(cls, pictures: Sequence[Observation]) -> StopView:
        """Combine the pictures of a stop; a thing that two pictures show is used once, where it is more certain."""
        heading, sigma = _heading(pictures)
        points, covariances, kinds = [np.zeros((0, 2))], [np.zeros((0, 2, 2))], list[PointKind]()
        lines, line_covariances, directions = [np.zeros((0, 2))], [np.zeros((0, 2, 2))], [np.zeros(0)]
        ends = [np.zeros((0, 2, 2))]
        whole = [each for each in pictures if isinstance(each, LineObservation)]
        views = np.array([each.view for each in whole]).reshape(-1, 2)
        has_lines = np.isfinite([each.direction_sigma for each in whole])
        for seen in pictures:
            k = len(seen)
            own = seen.covariance.reshape(k, 2, k, 2)[np.arange(k), :, np.arange(k)]
            at, spread = _cartesian(seen.values, own)
            points.append(at)
            covariances.append(spread)
            kinds += [each.kind for each in seen]
            if not isinstance(seen, LineObservation):
                continue
            if seen.circle is not None:
                J = seen.circle.tilt_jacobian
                points.append(seen.circle.centre[None])
                covariances.append((CENTRE_SIGMA**2 * np.eye(2) + J @ seen.tilt @ J.T)[None])
                kinds.append("centre")
            polar = [Measurement(float(np.arctan2(y, x)), float(np.hypot(x, y))) for x, y, *_ in seen.lines]
            R = picture_covariance(polar, seen.tilt, LINE_SIGMA).reshape(len(polar), 2, len(polar), 2)
            each = np.arange(len(polar))
            at, spread = _cartesian(values_of(polar), R[each, :, each])
            lines.append(at)
            line_covariances.append(spread)
            directions.append(seen.lines[:, 2])
            ends.append(visible_ends(seen.lines))
        found = cls(
            heading, sigma, np.vstack(points), np.vstack(covariances), tuple(kinds),
            np.vstack(lines), np.vstack(line_covariances), np.concatenate(directions), np.concatenate(ends),
            views, views[has_lines],
        )  # fmt: skip
        return found._without_duplicates()

    def _without_duplicates(self) -> StopView:
        kept: list[int] = []
        for i in np.argsort(np.trace(self.covariances, axis1=1, axis2=2), kind="stable").tolist():
            same = [j for j in kept if self.kinds[j] == self.kinds[i]]
            if all(np.hypot(*(self.points[i] - self.points[j])) > SAME_POINT for j in same):
                kept.append(i)
        axes, places, variances = self.lines_from(self.heading)
        lines: list[int] = []
        for i in np.argsort(variances, kind="stable").tolist():
            if all(abs(places[i] - places[j]) > SAME_LINE for j in lines if axes[j] == axes[i]):
                lines.append(i)
        return StopView(
            self.heading, self.heading_sigma, self.points[kept], self.covariances[kept],
            tuple(self.kinds[i] for i in kept),
            self.lines[lines], self.line_covariances[lines], self.directions[lines], self.ends[lines],
            self.views, self.line_views,
        )  # fmt: skip

    def lines_from(self, heading: float) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:
        """Return each line's axis, its coordinate minus the robot's, m, and the variance, if the robot has a heading.

        The axis is 0 for a line x = c, and 1 for y = c.
        """
        R, each = rotation_2d(heading), np.arange(len(self.lines))
        axes = (np.abs(np.cos(self.directions + heading)) > np.sqrt(0.5)).astype(np.int64)
        offset, variances = self.lines @ R.T, (R @ self.line_covariances @ R.T)[each, axes, axes]
        if len(axes):  # without lines, the heading may be unknown
            variances = variances + (self.heading_sigma * offset[each, 1 - axes]) ** 2
        return axes, offset[each, axes], variances

    def spans_from(self, heading: float) -> FloatArray:
        """Return the ends (m, 2) of each line's visible part, along the line, from the robot on, m; in order."""
        axes, _, _ = self.lines_from(heading)
        ends = self.ends @ rotation_2d(heading).T
        return np.sort(ends[np.arange(len(axes)), :, 1 - axes], axis=1)


def _heading(pictures: Sequence[Observation]) -> tuple[float, float]:
    """Return the heading modulo 90 degrees and its standard deviation from the compasses that agree with the best."""
    usable = sorted(
        (each for each in pictures if np.isfinite(each.direction_sigma)),
        key=lambda each: each.direction_sigma,
    )
    if not usable:
        return 0.0, float("inf")
    best = usable[0]
    deviation = np.array([float(wrap_quarter(best.direction - each.direction)) for each in usable])
    variance = np.array([each.direction_sigma**2 for each in usable])
    agree = deviation**2 <= COMPASS_GATE**2 * (variance + variance[0])
    weight = agree / variance
    mean = float(weight @ deviation / weight.sum())
    return float(wrap_quarter(mean - best.direction)), float(weight.sum() ** -0.5)


def _cartesian(polar: FloatArray, covariances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (k, 2) and covariances (k, 2, 2) from bearings and ranges (k, 2) and theirs (k, 2, 2)."""
    c, s, r = np.cos(polar[:, 0]), np.sin(polar[:, 0]), polar[:, 1]
    J = np.stack([np.stack([-r * s, c], axis=1), np.stack([r * c, s], axis=1)], axis=1)
    return np.column_stack([r * c, r * s]), J @ covariances @ J.mT
