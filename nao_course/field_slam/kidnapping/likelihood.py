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
from nao_course.field_slam.likelihood import CLUTTER
from nao_course.field_slam.observation import Observation, picture_covariance, values_of
from nao_course.geometry import FloatArray, rotation_2d, wrap_angle
from nao_course.slam import LandmarkKind, Measurement

PointKind = LandmarkKind | Literal["centre"]
# m: ranges at which a landmark of the map is nearly always detected. The centre is detected by its circle, so never.
VISIBLE: dict[PointKind, tuple[float, float]] = {
    "corner": (1.2, 2.5),
    "post": (1.2, 3.0),
    "centre": (0.0, 0.0),
}
DETECTED, ELSEWHERE = 0.9, 0.4  # probability of detection at these ranges, and at others
LINE_DETECTED = 0.5
MAP_SIGMA = 0.05  # m: is added to a match, because an error of the map is the same at all stops
WELL_KNOWN = 0.06  # m: a landmark with a larger standard deviation may not exist, so it is not missed
# m: measurements of two pictures of a stop that are nearer than this belong to the same thing.
SAME_POINT, SAME_LINE = 0.3, 0.25
LEAST_INFORMATION = 1e-2 * np.eye(2)  # 1/m^2: where nothing is matched
STEPS = 6  # of expectation maximisation
COMPASS_GATE = 4.0  # standard deviations, between the compasses of two pictures


@dataclass(frozen=True, eq=False)
class StopView:
    """What all pictures of a stop show together.

    The heading from the compass is known modulo 90 degrees, rad, and its standard deviation is infinite without a
    compass. Points (k, 2) with covariances (k, 2, 2) are corners, posts and the circle's centre; each line has a point
    (m, 2) with covariance (m, 2, 2) and a direction (m,). All are in the robot frame, in m, m^2 and rad. Each of the
    views (p, 2) is the smallest and the largest bearing in a picture, rad.
    """

    heading: float
    heading_sigma: float
    points: FloatArray
    covariances: FloatArray
    kinds: tuple[PointKind, ...]
    lines: FloatArray
    line_covariances: FloatArray
    directions: FloatArray
    views: FloatArray

    @classmethod
    def of(cls, pictures: Sequence[Observation]) -> StopView:
        """Combine the pictures of a stop; a thing that two pictures show is used once, where it is more certain."""
        heading, sigma = _heading(pictures)
        points, covariances, kinds = [np.zeros((0, 2))], [np.zeros((0, 2, 2))], list[PointKind]()
        lines, line_covariances, directions = [np.zeros((0, 2))], [np.zeros((0, 2, 2))], [np.zeros(0)]
        views = np.array([each.view for each in pictures if isinstance(each, LineObservation)]).reshape(-1, 2)
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
            np.vstack(lines), np.vstack(line_covariances), np.concatenate(directions), views,
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
            self.lines[lines], self.line_covariances[lines], self.directions[lines], self.views,
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


class PositionLikelihood:
    """The likelihood of a stop at positions of the robot, for one heading (rad, map frame).

    Each measurement and each thing on the map that it may belong to put the robot at one position, in closed form, with
    a Gaussian error; a line leaves the position along it free. The likelihood is relative to a stop with nothing but
    clutter.
    """

    def __init__(self, stop: StopView, known: KnownMap, heading: float) -> None:
        """Match all measurements of a stop with everything on the map that is of the same kind."""
        self._stop, self._known, self._heading = stop, known, heading
        R, of_points = rotation_2d(heading), len(stop.points)
        offset = stop.points @ R.T
        aside = stop.heading_sigma * offset[:, ::-1] * (-1, 1) if of_points else offset
        own = R @ stop.covariances @ R.T + aside[:, :, None] * aside[:, None]
        point, self._landmark = np.nonzero(
            np.equal.outer(np.array(stop.kinds, str), np.array(known.kinds, str))
        )
        S = own[point] + known.covariances[self._landmark] + MAP_SIGMA**2 * np.eye(2)
        self.positions = known.points[self._landmark] - offset[point]
        clutter = np.array([CLUTTER[stop.kinds[i]] for i in point])
        axes, places, variances = stop.lines_from(heading)
        line, known_line = np.nonzero(np.equal.outer(axes, known.axes))
        variance = variances[line] + known.variances[known_line] + MAP_SIGMA**2
        across = np.eye(2)[axes[line]]
        self._at = np.vstack([self.positions, across * (known.places[known_line] - places[line])[:, None]])
        self._information = np.concatenate(
            [np.linalg.inv(S), across[:, :, None] * across[:, None] / variance[:, None, None]]
        )
        of_line = LINE_DETECTED / (1 - LINE_DETECTED) / CLUTTER["line"]
        self._scale = np.append(
            1 / (2 * np.pi * np.sqrt(np.linalg.det(S)) * clutter), of_line / np.sqrt(2 * np.pi * variance)
        )
        self._owner = np.eye(of_points + len(axes))[np.append(point, of_points + line)]

    def log_likelihood(self, positions: FloatArray) -> FloatArray:
        """Return the log-likelihoods (N,) at positions (N, 2), m, map frame."""
        return np.log1p(self._matches(positions) @ self._owner).sum(axis=1) + self.missed(positions)

    def missed(self, positions: FloatArray) -> FloatArray:
        """Return the log-likelihoods (N,) at positions (N, 2) of the landmarks that should be in view."""
        offset = self._known.points - positions[:, None]
        bearing = wrap_angle(np.arctan2(offset[..., 1], offset[..., 0]) - self._heading)[..., None]
        seen = ((bearing > self._stop.views[:, 0]) & (bearing < self._stop.views[:, 1])).any(axis=-1)
        exists = np.trace(self._known.covariances, axis1=1, axis2=2) < 2 * WELL_KNOWN**2
        return np.log1p(-DETECTED) * (self._certain(positions) & exists & seen).sum(axis=1)

    def fit(
        self, positions: FloatArray, mean: FloatArray | None = None, information: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the local maxima (N, 2) near positions (N, 2), their information (N, 2, 2), and evidence (N,).

        The maxima are found by expectation maximisation. The evidence is the logarithm of the likelihood's integral
        near the maximum, by Laplace's approximation. Positions may have Gaussian priors with means (N, 2) or (2,) and
        information matrices (N, 2, 2) or (2, 2), 1/m^2. Otherwise the prior is 1 everywhere, and the integral is in
        m^2.
        """
        prior = np.zeros((2, 2)) if information is None else information
        mean = positions if mean is None else mean
        for _ in range(STEPS):
            matches = self._matches(positions)
            weights = matches / (1 + matches @ self._owner @ self._owner.T)
            found = prior + LEAST_INFORMATION + np.tensordot(weights, self._information, 1)
            pull = weights @ np.einsum("pij,pj->pi", self._information, self._at)
            pull += np.einsum("...ij,...j->...i", prior, mean) + positions @ LEAST_INFORMATION
            positions = np.linalg.solve(found, pull[..., None])[..., 0]
        evidence = self.log_likelihood(positions) - gaussian_log_densities(np.zeros(2), found)
        if information is not None:
            evidence = evidence + gaussian_log_densities(positions - mean, prior)
        return positions, found, evidence

    def _matches(self, positions: FloatArray) -> FloatArray:
        """Return the likelihood of each match relative to clutter, shape (N, matches)."""
        residual = positions[:, None] - self._at
        square = np.einsum("npi,pij,npj->np", residual, self._information, residual)
        matches = self._scale * np.exp(-0.5 * square)
        odds = np.where(self._certain(positions), DETECTED / (1 - DETECTED), ELSEWHERE / (1 - ELSEWHERE))
        matches[:, : len(self._landmark)] *= odds[:, self._landmark]
        return matches

    def _certain(self, positions: FloatArray) -> npt.NDArray[np.bool_]:
        """Return which landmarks (N, n) are at a range at which they are nearly always detected."""
        distance = np.linalg.norm(self._known.points - positions[:, None], axis=-1)
        nearest, farthest = np.array([VISIBLE[kind] for kind in self._known.kinds]).reshape(-1, 2).T
        return (distance > nearest) & (distance < farthest)


def gaussian_log_densities(residuals: FloatArray, information: FloatArray) -> FloatArray:
    """Return the log densities (...) of residuals (..., 2) with information matrices (..., 2, 2)."""
    square = np.einsum("...i,...ij,...j->...", residuals, information, residuals)
    return np.asarray(0.5 * (np.linalg.slogdet(information)[1] - square) - np.log(2 * np.pi))


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
