"""How likely the pictures of a stop are from a pose, if the map is known.

The landmarks of a stop are a random set: each landmark of the map in the field of view is detected with some
probability, and the other measurements are clutter, which has a constant density. Likelihoods are relative to a stop
whose measurements are all clutter, so they can be compared between poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from nao_course.field_slam.compass import wrap_quarter
from nao_course.field_slam.joint_update import (
    CENTRE_SIGMA,
    INTERNAL,
    LINE_SIGMA,
    JointUpdate,
    LineObservation,
)
from nao_course.field_slam.observation import Observation, picture_covariance, values_of
from nao_course.geometry import FloatArray, rotation_2d, wrap_angle
from nao_course.slam import LandmarkKind, Measurement

PointKind = LandmarkKind | Literal["centre"]
# Measurements that belong to nothing on the map: points per m^2, lines per m.
CLUTTER: dict[PointKind, float] = {"corner": 0.05, "post": 0.03, "centre": 0.03}
LINE_CLUTTER = 0.15
# m: ranges at which a landmark of the map is nearly always detected. The centre is detected by its circle, so never.
VISIBLE: dict[PointKind, tuple[float, float]] = {
    "corner": (1.2, 2.5),
    "post": (1.2, 3.0),
    "centre": (0.0, 0.0),
}
DETECTED, ELSEWHERE = 0.9, 0.4  # probability of detection at these ranges, and at others
LINE_DETECTED = 0.5
WELL_KNOWN = 0.06  # m: a landmark with a larger standard deviation may not exist, so it is not missed
# m: measurements of two pictures of a stop that are nearer than this belong to the same thing.
SAME_POINT, SAME_LINE = 0.3, 0.25
COMPASS_GATE = 4.0  # standard deviations, between the compasses of two pictures


@dataclass(frozen=True, eq=False)
class StopView:
    """What all pictures of a stop show together.

    The heading from the compass is known modulo 90 degrees, rad, and its standard deviation is infinite without a
    compass. Points (k, 2) with covariances (k, 2, 2) are corners, posts and the circle's centre; each line has a point
    (m, 2) with covariance (m, 2, 2) and a direction (m,). All are in the robot frame, in m, m^2 and rad.
    """

    heading: float
    heading_sigma: float
    points: FloatArray
    covariances: FloatArray
    kinds: tuple[PointKind, ...]
    lines: FloatArray
    line_covariances: FloatArray
    directions: FloatArray

    @classmethod
    def of(cls, pictures: Sequence[Observation]) -> StopView:
        """Combine the pictures of a stop; a thing that two pictures show is used once, where it is more certain."""
        heading, sigma = _heading(pictures)
        points, covariances, kinds = [np.zeros((0, 2))], [np.zeros((0, 2, 2))], list[PointKind]()
        lines, line_covariances, directions = [np.zeros((0, 2))], [np.zeros((0, 2, 2))], [np.zeros(0)]
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
            polar = [Measurement(float(np.arctan2(y, x)), float(np.hypot(x, y))) for x, y, _ in seen.lines]
            R = picture_covariance(polar, seen.tilt, LINE_SIGMA).reshape(len(polar), 2, len(polar), 2)
            each = np.arange(len(polar))
            at, spread = _cartesian(values_of(polar), R[each, :, each])
            lines.append(at)
            line_covariances.append(spread)
            directions.append(seen.lines[:, 2])
        found = cls(
            heading, sigma, np.vstack(points), np.vstack(covariances), tuple(kinds),
            np.vstack(lines), np.vstack(line_covariances), np.concatenate(directions),
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
            self.lines[lines], self.line_covariances[lines], self.directions[lines],
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


@dataclass(frozen=True, eq=False)
class KnownMap:
    """The map of a filter, as points and lines.

    Points (n, 2) with covariances (n, 2, 2) are corners, posts and the circle's centre, in the map frame, m and m^2.
    The axis of each line (m,) is 0 for x = c and 1 for y = c, with c in `places` (m,), m, and its variance (m,), m^2.
    """

    points: FloatArray
    covariances: FloatArray
    kinds: tuple[PointKind, ...]
    axes: npt.NDArray[np.int64]
    places: FloatArray
    variances: FloatArray

    @classmethod
    def of(cls, slam: JointUpdate) -> KnownMap:
        """Return the map of a joint update."""
        state, P = slam.inner.state, slam.inner.covariance
        n = len(slam.inner.kinds)
        at = 3 + 2 * np.arange(n)
        places = state[3:].reshape(n, 2)
        own = P[at[:, None, None] + np.array([[0], [1]]), at[:, None, None] + np.array([[0, 1]])]
        points = [i for i, kind in enumerate(slam.inner.kinds) if kind != INTERNAL or i == slam.circle]
        kinds: list[PointKind] = []
        for i in points:
            kind = slam.inner.kinds[i]
            kinds.append("centre" if kind == INTERNAL else kind)
        lines = np.array(list(slam.lines), dtype=int)
        return cls(
            places[points], own[points], tuple(kinds),
            np.array(list(slam.lines.values()), dtype=int), places[lines, 0], own[lines, 0, 0],
        )  # fmt: skip


def log_likelihood(
    stop: StopView, known: KnownMap, heading: float, positions: FloatArray, smoothing: float, half_view: float
) -> FloatArray:
    """Return the log-likelihoods (N,) of a stop at positions (N, 2), relative to a stop with nothing but clutter.

    Positions (m) and heading (rad) are in the map frame. The likelihood is averaged over the position with the standard
    deviation `smoothing`, m; `half_view` is the largest bearing at which pictures of a stop show a landmark, rad.
    """
    return _of_points(stop, known, heading, positions, smoothing, half_view) + _of_lines(
        stop, known, heading, positions, smoothing
    )


def _of_points(
    stop: StopView, known: KnownMap, heading: float, positions: FloatArray, smoothing: float, half_view: float
) -> FloatArray:
    """Return the part of the log-likelihood (N,) that corners, posts and the circle's centre contribute."""
    R = rotation_2d(heading)
    offset = known.points - positions[:, None]  # (N, n, 2)
    distance = np.hypot(offset[..., 0], offset[..., 1])
    nearest, farthest = np.array([VISIBLE[kind] for kind in known.kinds]).reshape(-1, 2).T
    certain = (distance > nearest) & (distance < farthest)
    bearing = wrap_angle(np.arctan2(offset[..., 1], offset[..., 0]) - heading)
    exists = np.trace(known.covariances, axis1=1, axis2=2) < 2 * WELL_KNOWN**2
    missed = certain & exists & (np.abs(bearing) < half_view)
    total = np.log1p(-DETECTED) * missed.sum(axis=1)
    odds = np.where(certain, DETECTED / (1 - DETECTED), ELSEWHERE / (1 - ELSEWHERE))
    for point, covariance, kind in zip(stop.points, stop.covariances, stop.kinds, strict=True):
        same = np.flatnonzero([each == kind for each in known.kinds])
        if not len(same):
            continue
        x, y = R @ point
        aside = stop.heading_sigma * np.array([-y, x])
        S = known.covariances[same] + R @ covariance @ R.T + np.outer(aside, aside) + smoothing**2 * np.eye(2)
        a, b, d = S[:, 0, 0], S[:, 0, 1], S[:, 1, 1]
        determinant = a * d - b**2
        u, v = offset[:, same, 0] - x, offset[:, same, 1] - y
        square = (d * u**2 - 2 * b * u * v + a * v**2) / determinant
        density = np.exp(-0.5 * square) / (2 * np.pi * np.sqrt(determinant))
        total = total + np.log1p((odds[:, same] * density).sum(axis=1) / CLUTTER[kind])
    return np.asarray(total)


def _of_lines(
    stop: StopView, known: KnownMap, heading: float, positions: FloatArray, smoothing: float
) -> FloatArray:
    """Return the part of the log-likelihood (N,) that lines contribute."""
    total = np.zeros(len(positions))
    for axis, place, variance in zip(*stop.lines_from(heading), strict=True):
        same = known.axes == axis
        S = variance + known.variances[same] + smoothing**2
        residual = known.places[same] - place - positions[:, axis, None]
        density = np.exp(-0.5 * residual**2 / S) / np.sqrt(2 * np.pi * S)
        total += np.log1p(LINE_DETECTED / (1 - LINE_DETECTED) * density.sum(axis=1) / LINE_CLUTTER)
    return total


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
