"""A joint update with everything that a picture shows: landmarks, the compass, lines and the centre circle.

A tilt of the body moves everything that a picture shows on the ground, and it turns the lines. The errors of landmarks,
lines and compass are therefore correlated, and each of them improves the others. A line is a landmark with one
coordinate, because the field has two directions: it is either x = c or y = c. A robot that sees no corner often sees a
line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag

from nao_course.field_slam.adaptive_noise import FACTORS, AdaptiveOdometryNoise, OdometryModel
from nao_course.field_slam.association import landmark_jacobian
from nao_course.field_slam.compass import QUARTER, wrap_quarter
from nao_course.field_slam.known_shapes.circle import Circle
from nao_course.field_slam.likelihood import (
    KnownMap,
    Part,
    PictureLikelihood,
    compass_log_densities,
    landmark_log_densities,
    line_log_densities,
    other_heading_of,
)
from nao_course.field_slam.line_observation import (
    CENTRE_SIGMA,
    LINE_SIGMA,
    LineObservation,
    PointKind,
    visible_ends,
)
from nao_course.field_slam.observation import CAMERA_HEIGHT, FOCAL, Observation, as_observation, tilt_jacobian
from nao_course.geometry import FloatArray, Pose, rotation_2d, wrap_angle
from nao_course.slam import Estimate, LandmarkKind, Measurement, Motion, SlamAlgorithm

# A line of the picture is matched with a line of the map that is at most KNOWN sigma away, if all others are farther
# than OTHER. An ambiguous line is not used. A line that is farther than NEW sigma and APART metres from all lines of
# the map becomes a new one. In between it is ignored, because a second copy of a line would bend the map.
KNOWN, OTHER, NEW = 3.0, 4.0, 6.0
APART = 0.3  # m: half of the smallest distance between two parallel lines of the field
SURE = 0.12  # m: a new line is added only where it can be recognised again
CENTRE_GATE = 4.0  # sigma
CENTRE_SURE = 0.25  # m: there is one centre circle, so it may be added with less certainty than a line
UNKNOWN = 100.0  # m^2: variance that a new landmark has before its first update
# The kind that lines and the circle's centre have on the filter's map; estimates leave them out.
INTERNAL: Final = "internal"


class JointFilter(Protocol):
    """The interface of a filter that `JointUpdate` wraps; lesson 11's EkfSlam has it."""

    state: FloatArray
    covariance: FloatArray
    kinds: list[LandmarkKind | Literal["internal"]]
    indices: npt.NDArray[np.int64]
    odometry: OdometryModel

    def move(self, motion: Motion) -> None:
        """Predict the state after a motion."""
        ...

    def use_compass(self, direction: float, sigma: float) -> None:
        """Update the heading with the direction of the field's lines."""
        ...

    def number(self, seen: Observation) -> None:
        """Associate the measurements with landmarks, and add new landmarks to the map."""
        ...

    def estimate(self) -> Estimate:
        """Return the current estimate."""
        ...


class _Move(NamedTuple):
    """A motion, with the state and the covariance before it."""

    motion: Motion
    state: FloatArray
    covariance: FloatArray


class LinearisedMeasurement(NamedTuple):
    """Measurements linearised at the current estimate.

    The innovation (m,) is measured minus expected, H (m, n) the Jacobian of the expected measurements with respect to
    the state, `own` (m, m) the noise's covariance without the part of the tilt, and `tilt_jacobian` (m, 2) the Jacobian
    of the innovation with respect to the errors of pitch and roll. `known` (m,) marks measurements of something that
    was on the map before.
    """

    innovation: FloatArray
    H: FloatArray
    own: FloatArray
    tilt_jacobian: FloatArray
    part: Part
    known: npt.NDArray[np.bool_]


class JointUpdate(SlamAlgorithm):
    """A filter that also uses lines and the centre circle, and the tilt that all measurements of a picture share.

    Lines and the circle's centre are landmarks of another kind on the filter's own map. A line's c is the first of its
    two coordinates; the second one has no meaning. The update is exact to first order. The gates before it ignore that
    the compass has already reduced the uncertainty of the tilt, so they are slightly too wide. `inner` predicts,
    updates with the compass and associates landmarks; nobody else may use it. `factors` are candidates for the scale of
    the odometry's standard deviations, estimated from the compass (`AdaptiveOdometryNoise`); (1.0,) keeps the stated
    noise. `likelihood` is the likelihood of the last picture's measurements.
    """

    likelihood: PictureLikelihood

    def __init__(self, inner: JointFilter, factors: Sequence[float] = FACTORS) -> None:
        """Start with the state of the filter, and with no lines on the map."""
        self.inner = inner
        self.odometry = inner.odometry = AdaptiveOdometryNoise(inner.odometry, factors)
        self._last: _Move | None = None
        # By the number of a line's landmark: 0 if the line is x = c, 1 if it is y = c.
        self._axes: dict[int, int] = {}
        self._spans: dict[int, tuple[float, float]] = {}  # where the part of each line that was seen ends, m
        self._circle: int | None = None

    def move(self, motion: Motion) -> None:
        """Predict the state after a motion."""
        self._last = _Move(motion, self.inner.state.copy(), self.inner.covariance.copy())
        self.inner.move(motion)

    def observe(self, measurements: Sequence[Measurement], quarter: int = 0) -> None:
        """Update with a picture; a `LineObservation` also has lines and the centre circle.

        The heading differs by `quarter` quarter turns from the nearest heading of the compass.
        """
        seen = as_observation(measurements)
        self._estimate_noise(seen, quarter)
        innovation, P = self._heading_innovation(seen, quarter), self.inner.covariance
        variance = P[2, 2] + seen.direction_sigma**2
        compass = compass_log_densities(innovation, variance)
        if quarter:  # the filter only knows the nearest heading
            self.inner.state = self.inner.state + quarter * QUARTER * P[:, 2] / P[2, 2]
            self.inner.state[2] = wrap_angle(self.inner.state[2])
        self.inner.use_compass(seen.direction, seen.direction_sigma)
        on_map = len(self.inner.kinds)
        self.inner.number(seen)
        numbers = np.asarray(self.inner.indices, dtype=int)
        landmarks = landmark_log_densities(seen, (numbers >= 0) & (numbers < on_map))
        found, lines = [self._landmarks(seen, on_map)], (0.0, 0.0)
        if isinstance(seen, LineObservation):
            used: set[int] = set()
            on_map = len(self.inner.kinds)
            of_lines = [self._line(line, seen.tilt, on_map, used) for line in seen.lines]
            of_circle = self._centre(seen.circle, seen) if seen.circle else None
            lines = line_log_densities(
                len(seen.lines),
                int(seen.circle is not None),
                sum(each is not None and bool(each.known.all()) for each in of_lines),
                int(of_circle is not None and bool(of_circle.known.all())),
            )
            found += [*of_lines, of_circle]
        others: dict[Part, tuple[float, float]] = {"compass": compass, "landmarks": landmarks, "lines": lines}
        other_heading = other_heading_of(innovation, variance)
        innovations = self._correct([each for each in found if each], seen)
        self.likelihood = PictureLikelihood(*innovations, others, other_heading)

    def estimate(self) -> Estimate:
        """Return the estimate of the robot's pose and of the corners and posts."""
        found = self.inner.estimate()
        kept = np.array([kind != INTERNAL for kind in self.inner.kinds], dtype=bool)
        return replace(
            found,
            landmarks=np.asarray(found.landmarks).reshape(-1, 2)[kept],
            landmark_covariances=np.asarray(found.landmark_covariances).reshape(-1, 2, 2)[kept],
            kinds=tuple(kind for kind in self.inner.kinds if kind != INTERNAL),
        )

    @property
    def lines(self) -> dict[int, int]:
        """Axis of each line by the number of its landmark: 0 if the line is x = c, 1 if it is y = c."""
        return dict(self._axes)

    @property
    def circle(self) -> int | None:
        """Number of the landmark that is the circle's centre; None if the circle is not on the map."""
        return self._circle

    @property
    def known_map(self) -> KnownMap:
        """The map of the filter as points and lines."""
        state, P = self.inner.state, self.inner.covariance
        n = len(self.inner.kinds)
        at = 3 + 2 * np.arange(n)
        places = state[3:].reshape(n, 2)
        own = P[at[:, None, None] + np.array([[0], [1]]), at[:, None, None] + np.array([[0, 1]])]
        points = [i for i, kind in enumerate(self.inner.kinds) if kind != INTERNAL or i == self._circle]
        kinds: list[PointKind] = []
        for i in points:
            kind = self.inner.kinds[i]
            kinds.append("centre" if kind == INTERNAL else kind)
        lines = np.array(list(self._axes), dtype=int)
        return KnownMap(
            places[points], own[points], tuple(kinds),
            np.array(list(self._axes.values()), dtype=int), places[lines, 0], own[lines, 0, 0],
            np.array([self._spans[number] for number in self._axes]).reshape(-1, 2),
        )  # fmt: skip

    def place(self, pose: Pose, covariance: FloatArray) -> None:
        """Put the robot elsewhere on the map, with a covariance (3, 3) that is independent of the map's."""
        self._last = None
        self.inner.state[:3] = pose.as_array()
        self.inner.covariance[:3], self.inner.covariance[:, :3] = 0.0, 0.0
        self.inner.covariance[:3, :3] = covariance

    def _heading_innovation(self, seen: Observation, quarter: int) -> float:
        return float(wrap_quarter(-seen.direction - self.inner.state[2])) + quarter * QUARTER

    def _estimate_noise(self, seen: Observation, quarter: int) -> None:
        """Estimate the odometry's noise if the first picture after a motion has a compass, and predict again."""
        last, self._last = self._last, None
        if last is None or not np.isfinite(seen.direction_sigma):
            return
        innovation = self._heading_innovation(seen, quarter)
        self.odometry.learn(innovation, last.covariance[2, 2] + seen.direction_sigma**2, last.motion)
        self.inner.state, self.inner.covariance = last.state, last.covariance
        self.inner.move(last.motion)

    def _landmarks(self, seen: Observation, on_map: int) -> LinearisedMeasurement | None:
        """Linearise the bearings and ranges of the associated landmarks; the first `on_map` were on the map before."""
        used = np.flatnonzero(np.asarray(self.inner.indices) >= 0)
        if not len(used):
            return None
        numbers, part, state = np.asarray(self.inner.indices)[used], seen.part(used), self.inner.state
        offset = state[3:].reshape(-1, 2)[numbers] - state[:2]
        distance = np.maximum(np.hypot(*offset.T), 1e-6)
        values, R = part.linearised_at(distance)
        bearing = wrap_angle(values[::2] - np.arctan2(offset[:, 1], offset[:, 0]) + state[2])
        scale = np.column_stack([np.ones(len(used)), (distance / part.values[:, 1]) ** 2]).ravel()
        J = scale[:, None] * tilt_jacobian(part.values)
        H = landmark_jacobian(offset, distance, numbers, len(state))
        innovation = np.column_stack([bearing, values[1::2] - distance]).ravel()
        known = np.repeat(numbers < on_map, 2)
        return LinearisedMeasurement(innovation, H, R - J @ part.tilt @ J.T, J, "landmarks", known)

    def _line(
        self, line: FloatArray, tilt: FloatArray, on_map: int, used: set[int]
    ) -> LinearisedMeasurement | None:
        """Linearise the measurement of one line.

        It is matched with a line among the first `on_map` landmarks that is not in `used`, or added to the map. None is
        returned if the match is ambiguous.
        """
        axis = int(abs(np.cos(line[2] + self.inner.state[2])) > np.sqrt(0.5))
        positions, H, range_jacobian = self._on_the_field(line[:2])
        position, h, J = positions[axis], H[axis], range_jacobian[axis] @ tilt_jacobian(_polar(line[:2]))[1:]
        pixels = _pixel_noise(line[:2], self.inner.state[2])[axis] ** 2
        own = pixels + J @ tilt @ J
        P = self.inner.covariance
        numbers = [number for number, which in self._axes.items() if which == axis]
        residuals = {number: self.inner.state[3 + 2 * number] - position for number in numbers}
        rows = {
            number: _minus_landmark(h[None], number, np.eye(1, 2)) for number in numbers if number < on_map
        }
        sigmas = {n: abs(residuals[n]) / np.sqrt((row @ P @ row.T).item() + own) for n, row in rows.items()}
        nearest = sorted(sigmas, key=sigmas.__getitem__)
        if nearest and sigmas[nearest[0]] < KNOWN and all(sigmas[other] > OTHER for other in nearest[1:]):
            number = nearest[0]
            self._extend(number, axis, line)
            if number in used:  # a longer segment of the same line has been used
                return None
        else:
            far = all(each > NEW for each in sigmas.values()) and all(
                abs(each) > APART for each in residuals.values()
            )
            if not far or h @ P @ h + own >= SURE**2:
                return None
            number = self._put_on_map([position, 0.0], [UNKNOWN, 1e-6])
            self._axes[number], residuals[number] = axis, 0.0
            rows[number] = _minus_landmark(np.pad(h, (0, 2))[None], number, np.eye(1, 2))
            self._extend(number, axis, line)
        used.add(number)
        known = np.array([number < on_map])
        return LinearisedMeasurement(
            np.array([residuals[number]]), rows[number], np.array([[pixels]]), -J[None], "lines", known
        )

    def _extend(self, number: int, axis: int, line: FloatArray) -> None:
        """Add the visible part of a line to the part of a line of the map that was seen."""
        ends = visible_ends(line[None])[0] @ rotation_2d(self.inner.state[2]).T + self.inner.state[:2]
        seen = *ends[:, 1 - axis].tolist(), *self._spans.get(number, ())
        self._spans[number] = min(seen), max(seen)

    def _centre(self, circle: Circle, seen: Observation) -> LinearisedMeasurement | None:
        """Linearise the measurement of the circle's centre; None if it fails the gate."""
        centre, H, _ = self._on_the_field(circle.centre)
        J = rotation_2d(self.inner.state[2]) @ circle.tilt_jacobian
        own = CENTRE_SIGMA**2 * np.eye(2)
        noise = own + J @ seen.tilt @ J.T
        known = np.full(2, self._circle is not None)
        if self._circle is None:
            no_compass = np.isinf(seen.direction_sigma)  # without a compass the arcs may belong to anything
            if no_compass or np.trace(H @ self.inner.covariance @ H.T + noise) >= CENTRE_SURE**2:
                return None
            self._circle = self._put_on_map(centre, [UNKNOWN, UNKNOWN])
            H = np.pad(H, ((0, 0), (0, 2)))
        H = _minus_landmark(H, self._circle, np.eye(2))
        residual = self.inner.state[3 + 2 * self._circle : 5 + 2 * self._circle] - centre
        S = H @ self.inner.covariance @ H.T + noise
        if residual @ np.linalg.solve(S, residual) >= CENTRE_GATE**2:
            return None
        return LinearisedMeasurement(residual, H, own, -J, "lines", known)

    def _on_the_field(self, point: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return a point of the robot frame on the map (2,), with its Jacobians: state (2, n) and range (2, 1)."""
        R, (x, y) = rotation_2d(self.inner.state[2]), point
        H = np.zeros((2, len(self.inner.state)))
        H[:, :2], H[:, 2] = np.eye(2), R @ [-y, x]
        return self.inner.state[:2] + R @ point, H, (R @ point / max(np.hypot(x, y), 1e-9))[:, None]

    def _put_on_map(self, position: Sequence[float] | FloatArray, variances: Sequence[float]) -> int:
        """Append a landmark to the state, and return its number."""
        self.inner.state = np.concatenate([self.inner.state, position])
        self.inner.covariance = block_diag(self.inner.covariance, np.diag(variances))
        self.inner.kinds.append(INTERNAL)
        return len(self.inner.kinds) - 1

    def _correct(
        self, found: list[LinearisedMeasurement], seen: Observation
    ) -> tuple[FloatArray, FloatArray, npt.NDArray[np.str_]]:
        """Update with all measurements at once; return the innovations of known landmarks, their S, and their parts.

        The filter has been updated with the compass before. Its error is correlated with the errors here through the
        tilt, so the measurements are first decorrelated from it.
        """
        if not found:
            return np.zeros(0), np.zeros((0, 0)), np.zeros(0, dtype=str)
        size = len(self.inner.state)
        nu, J = (
            np.concatenate([each.innovation for each in found]),
            np.vstack([each.tilt_jacobian for each in found]),
        )
        H = np.vstack([np.pad(each.H, ((0, 0), (0, size - each.H.shape[1]))) for each in found])
        R = block_diag(*(each.own for each in found)) + J @ seen.tilt @ J.T
        if np.isfinite(seen.direction_sigma) and isinstance(seen, LineObservation):
            # The sign: a tilt that was estimated too small makes the innovation too large.
            shared = -J @ seen.shared
            share = shared / seen.direction_sigma**2
            nu = nu - share * wrap_quarter(seen.direction + self.inner.state[2])
            H[:, 2] += share  # the measured direction decreases as the heading increases
            R = R - np.outer(share, shared)
        P = self.inner.covariance
        with_rows = P @ H.T
        S = R + H @ with_rows
        K = np.linalg.solve(S, with_rows.T).T
        self.inner.state = self.inner.state + K @ nu
        self.inner.state[2] = wrap_angle(self.inner.state[2])
        P = P - K @ S @ K.T
        self.inner.covariance = (P + P.T) / 2
        known = np.concatenate([each.known for each in found])
        parts = np.concatenate([np.full(len(each.known), each.part) for each in found])
        return nu[known], S[np.ix_(known, known)], parts[known]


def _minus_landmark(H: FloatArray, number: int, J: FloatArray) -> FloatArray:
    """Return the Jacobian of a point minus a landmark, from the point's (m, n) and the landmark's (m, 2)."""
    H = H.copy()
    H[:, 3 + 2 * number : 5 + 2 * number] = -J
    return H


def _polar(point: FloatArray) -> FloatArray:
    """Return the bearing and range (1, 2) of a point (2,) in the robot frame."""
    x, y = point
    return np.array([[np.arctan2(y, x), np.hypot(x, y)]])


def _pixel_noise(point: FloatArray, heading: float) -> FloatArray:
    """Return the standard deviations (2,) in metres that pixel noise gives a point, along the field's two axes."""
    bearing, distance = _polar(point)[0]
    bearing = bearing + heading
    toward = CAMERA_HEIGHT + distance**2 / CAMERA_HEIGHT
    across = np.hypot(distance, CAMERA_HEIGHT)
    along = np.hypot(np.cos(bearing) * toward, np.sin(bearing) * across)
    aside = np.hypot(np.sin(bearing) * toward, np.cos(bearing) * across)
    return LINE_SIGMA / FOCAL * np.array([along, aside])
