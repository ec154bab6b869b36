"""How likely measurements are: a picture's at the filter's estimate, and a stop's at any position on a known map.

At any position, the landmarks of a stop are a random set: each landmark of the map in the field of view is detected
with some probability, and the other measurements are clutter, which has a constant density. These likelihoods are
relative to a stop whose measurements are all clutter, so they can be compared between poses.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from nao_course.field_slam.compass import OUTLIERS, QUARTER, reading_density
from nao_course.field_slam.line_observation import PointKind, StopView
from nao_course.field_slam.observation import Observation
from nao_course.geometry import FloatArray, rotation_2d

Part = Literal["compass", "landmarks", "lines"]  # the centre circle belongs to the lines
Clutter = Literal["corner", "post", "centre", "line"]
# Density of measurements that belong to nothing on the map, because they are false or show something new: points per
# m^2, lines per m (`python -m benchmarks kidnapping`).
CLUTTER: Mapping[Clutter, float] = {"corner": 0.02, "post": 0.006, "centre": 0.002, "line": 0.025}
IGNORED = 0.3  # factor for measurements that are ignored although the map may explain them
# Probability of detection by the range of a landmark in view, m, and by the length of a line that is in view, m. They
# are a little lower than on drives 200 to 249, because a thing on the map may be false.
DETECTED: Mapping[Clutter, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "corner": ((0.7, 1.1, 2.5, 3.0, 4.0), (0.0, 0.95, 0.95, 0.8, 0.1)),
    "post": ((0.7, 1.1, 3.0, 4.0), (0.0, 0.95, 0.95, 0.5)),
    "centre": ((0.8, 1.6, 2.5, 3.5), (0.0, 0.85, 0.85, 0.1)),
    "line": ((0.2, 0.6, 1.0, 1.5), (0.0, 0.5, 0.8, 0.95)),
}
LEAST_DETECTED = 0.3  # of a match: near an edge of the view, and at other ranges, detection remains possible
SEGMENTS = 12  # of a line, for the length that is in view
LINE_RANGE = (0.45, 2.5)  # m: of a segment in view
BEYOND_SIGMA, BEYOND = 0.25, 0.03  # m, and least factor: for a line's visible part beyond the line on the map
MAP_SIGMA = 0.05  # m: is added to a match, because an error of the map is the same at all stops
WELL_KNOWN = 0.06  # m: a landmark with a larger standard deviation may not exist, so it is not missed
LEAST_INFORMATION = 1e-2 * np.eye(2)  # 1/m^2: where nothing is matched
STEPS = 6  # of expectation maximisation


@dataclass(frozen=True, eq=False)
class PictureLikelihood:
    """The likelihood of one picture's measurements, given the estimate before it.

    Innovations (m,) with covariance S (m, m) are of landmarks, lines and the circle that were on the map before, and
    `parts` (m,) says which part each belongs to. `others` has, for each part, the log density of its other
    measurements, and of all its measurements if it is ignored. `other_heading` is the compass's second nearest heading,
    in quarter turns from the nearest, and its log density minus the log density of the nearest.
    """

    innovation: FloatArray
    S: FloatArray
    parts: npt.NDArray[np.str_]
    others: Mapping[Part, tuple[float, float]]
    other_heading: tuple[int, float]

    def log_density(self, ignored: Collection[Part] = ()) -> float:
        """Return the log density of all measurements, if the measurements of some parts are ignored."""
        kept = np.isin(self.parts, list(ignored), invert=True)
        others = sum(densities[part in ignored] for part, densities in self.others.items())
        return gaussian_log_density(self.innovation[kept], self.S[np.ix_(kept, kept)]) + others

    def present(self, parts: Collection[Part]) -> tuple[Part, ...]:
        """Return the parts that have measurements, in the given order."""
        return tuple(part for part in parts if self.others[part][1])

    def ignored(self, parts: Collection[Part]) -> float:
        """Return the log density of all measurements of some parts, if they are ignored."""
        return sum(self.others[part][1] for part in parts)


def gaussian_log_density(innovation: FloatArray, S: FloatArray) -> float:
    """Return the log density of an innovation (m,) with covariance S (m, m); 0 if m is 0."""
    if not len(innovation):
        return 0.0
    distance = innovation @ np.linalg.solve(S, innovation)
    return float(-0.5 * (distance + np.linalg.slogdet(2 * np.pi * S)[1]))


def compass_log_densities(innovation: float, variance: float) -> tuple[float, float]:
    """Return the log densities of a compass reading, and of a reading that is independent of the heading.

    The innovation is measured minus predicted heading, rad, and its variance is in rad^2; it is infinite without a
    reading, and both results are then 0.
    """
    if not np.isfinite(variance):
        return 0.0, 0.0
    return float(np.log(reading_density(innovation, variance))), float(np.log(OUTLIERS / QUARTER))


def other_heading_of(innovation: float, variance: float) -> tuple[int, float]:
    """Return `PictureLikelihood.other_heading` of a compass reading; see `compass_log_densities`."""
    if not np.isfinite(variance):
        return 0, -np.inf
    quarter = -1 if innovation > 0 else 1
    return quarter, float((innovation**2 - (innovation + quarter * QUARTER) ** 2) / (2 * variance))


def landmark_log_densities(seen: Observation, explained: npt.ArrayLike) -> tuple[float, float]:
    """Return the log densities of the landmarks that the map does not explain, and of all if they are ignored.

    `explained` (k,) says which of the observation's k landmarks were on the map.
    """
    # A square metre at range r covers 1/r of an area in bearing (rad) and range (m).
    each = np.log([CLUTTER[of.kind] * of.range for of in seen])
    return float(each[~np.array(explained, dtype=bool)].sum()), float((each + np.log(IGNORED)).sum())


def line_log_densities(lines: int, circles: int, lines_known: int, circles_known: int) -> tuple[float, float]:
    """Return the log densities of the lines and circles that the map does not explain, and of all if ignored."""
    line, circle = np.log((CLUTTER["line"], CLUTTER["centre"]))
    new = (lines - lines_known) * line + (circles - circles_known) * circle
    return float(new), float(lines * line + circles * circle + (lines + circles) * np.log(IGNORED))


@dataclass(frozen=True, eq=False)
class KnownMap:
    """The map of a filter, as points and lines.

    Points (n, 2) with covariances (n, 2, 2) are corners, posts and the circle's centre, in the map frame, m and m^2.
    The axis of each line (m,) is 0 for x = c and 1 for y = c, with c in `places` (m,), m, and its variance (m,), m^2.
    The spans (m, 2) are where the part that was seen begins and ends, m along the line.
    """

    points: FloatArray
    covariances: FloatArray
    kinds: tuple[PointKind, ...]
    axes: npt.NDArray[np.int64]
    places: FloatArray
    variances: FloatArray
    spans: FloatArray

    def segments(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres (m, SEGMENTS, 2) of equal segments of each line, map frame, and their lengths (m,), m."""
        each, lengths = np.arange(len(self.axes)), (self.spans[:, 1] - self.spans[:, 0]) / SEGMENTS
        centres = np.empty((len(each), SEGMENTS, 2))
        centres[each, :, self.axes] = self.places[:, None]
        centres[each, :, 1 - self.axes] = self.spans[:, :1] + np.outer(lengths, np.arange(SEGMENTS) + 0.5)
        return centres, lengths


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
        self._scale = np.append(
            1 / (2 * np.pi * np.sqrt(np.linalg.det(S)) * clutter),
            1 / np.sqrt(2 * np.pi * variance) / CLUTTER["line"],
        )
        self._of = np.append(self._landmark, len(known.kinds) + known_line)
        self._along, self._seen = 1 - axes[line], stop.spans_from(heading)[line]
        self._span = known.spans[known_line]
        self._segments, self._lengths = known.segments()
        self._exists = (
            np.append(np.trace(known.covariances, axis1=1, axis2=2) / 2, known.variances) < WELL_KNOWN**2
        )
        self._owner = np.eye(of_points + len(axes))[np.append(point, of_points + line)]

    def log_likelihood(self, positions: FloatArray) -> FloatArray:
        """Return the log-likelihoods (N,) at positions (N, 2), m, map frame."""
        detected = self._detected(positions)
        matched = np.log1p(self._matches(positions, detected) @ self._owner).sum(axis=1)
        return np.asarray(matched + np.log1p(-detected) @ self._exists)

    def missed(self, positions: FloatArray) -> FloatArray:
        """Return the log-likelihoods (N,) at positions (N, 2) of a stop at which nothing is detected."""
        return np.asarray(np.log1p(-self._detected(positions)) @ self._exists)

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
        mean, detected = positions if mean is None else mean, self._detected(positions)
        for _ in range(STEPS):
            matches = self._matches(positions, detected)
            weights = matches / (1 + matches @ self._owner @ self._owner.T)
            found = prior + LEAST_INFORMATION + np.tensordot(weights, self._information, 1)
            pull = weights @ np.einsum("pij,pj->pi", self._information, self._at)
            pull += np.einsum("...ij,...j->...i", prior, mean) + positions @ LEAST_INFORMATION
            positions = np.linalg.solve(found, pull[..., None])[..., 0]
        evidence = self.log_likelihood(positions) - gaussian_log_densities(np.zeros(2), found)
        if information is not None:
            evidence = evidence + gaussian_log_densities(positions - mean, prior)
        return positions, found, evidence

    def _matches(self, positions: FloatArray, detected: FloatArray) -> FloatArray:
        """Return the likelihood of each match relative to clutter, shape (N, matches); see `_detected`."""
        residual = positions[:, None] - self._at
        square = np.einsum("npi,pij,npj->np", residual, self._information, residual)
        matches = self._scale * np.exp(-0.5 * square)
        seen = positions[:, self._along, None] + self._seen
        beyond = np.maximum((self._span - seen) * (1, -1), 0).sum(axis=2)
        inside = np.exp(-0.5 * (beyond / BEYOND_SIGMA) ** 2)
        matches[:, len(self._landmark) :] *= np.maximum(inside, BEYOND)
        detected = np.maximum(detected, LEAST_DETECTED)
        return matches * (detected / (1 - detected))[:, self._of]

    def _detected(self, positions: FloatArray) -> FloatArray:
        """Return the probabilities (N, n + m) that the landmarks and lines of the map are detected."""
        distance, seen = self._in_view(self._known.points, self._stop.views, positions)
        landmarks = [np.interp(distance[:, i], *DETECTED[kind]) for i, kind in enumerate(self._known.kinds)]
        of_points = np.reshape(landmarks, distance.T.shape).T * seen
        distance, seen = self._in_view(self._segments.reshape(-1, 2), self._stop.line_views, positions)
        seen &= (distance > LINE_RANGE[0]) & (distance < LINE_RANGE[1])
        length = seen.reshape(len(positions), len(self._lengths), SEGMENTS).sum(axis=2) * self._lengths
        return np.hstack([of_points, np.interp(length, *DETECTED["line"])])

    def _in_view(
        self, points: FloatArray, views: FloatArray, positions: FloatArray
    ) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Return the distances (N, P) of points from positions, and whether a view (of less than pi) shows them."""
        distance = np.hypot(*(points.T[:, None] - positions.T[:, :, None]))
        normals = np.stack([-np.sin(self._heading + views), np.cos(self._heading + views)])
        aside = np.tensordot(points, normals, 1) - np.tensordot(positions, normals, 1)[:, None]
        return distance, np.any((aside[..., 0] > 0) & (aside[..., 1] < 0), axis=-1)


def gaussian_log_densities(residuals: FloatArray, information: FloatArray) -> FloatArray:
    """Return the log densities (...) of residuals (..., 2) with information matrices (..., 2, 2)."""
    square = np.einsum("...i,...ij,...j->...", residuals, information, residuals)
    return np.asarray(0.5 * (np.linalg.slogdet(information)[1] - square) - np.log(2 * np.pi))
