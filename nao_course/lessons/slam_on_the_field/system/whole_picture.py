"""All that a picture tells, taken in together: landmarks, the compass, lines, the centre circle, under one lean.

A lean of the body moves everything that a picture shows on the ground, and turns the lines. What landmarks at known
places tell of it makes the compass surer, and the other way round. Lines are landmarks of one coordinate: the field has
two directions, so a line is either x = c or y = c, and a robot that sees no corner sees a line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag

from nao_course.geometry import FloatArray, rotation_2d, wrap_angle
from nao_course.lessons.slam_on_the_field.system.association import landmark_slopes
from nao_course.lessons.slam_on_the_field.system.circle import circle_centre
from nao_course.lessons.slam_on_the_field.system.compass import AGREES, Lean, wrap_quarter
from nao_course.lessons.slam_on_the_field.system.lines import to_ground
from nao_course.lessons.slam_on_the_field.system.observation import (
    CAMERA_HEIGHT,
    FOCAL,
    Observation,
    as_observation,
    tilt_slopes,
)
from nao_course.sim import CameraView
from nao_course.slam import Estimate, LandmarkKind, Measurement, Motion, SlamAlgorithm

LEAST_LENGTH, LEAST_PIXELS, FARTHEST = (
    0.45,
    20.0,
    4.0,
)  # m, px at 320, and m: of a line that is one of the field's
LINE_SIGMA, CENTRE_SIGMA = 1.2, 0.025  # px at 320, and m
KNOWN, OTHER, NEW = (
    3.0,
    4.0,
    6.0,
)  # sigma: of a line's own, at least of any other, and of one that is on no map
APART, SURE = 0.3, 0.12  # m: between two lines of a field, and how well a new one must be known
CENTRE_GATE, CENTRE_SURE = 4.0, 0.25  # sigma, and m: of the circle's middle
REST = "line"  # kind of what is on the filter's map and is no landmark of the paper's


@dataclass(frozen=True, eq=False)
class Scene(Observation):
    """An observation, and what else its picture shows.

    Parameters
    ----------
    shared : ndarray, shape (2,)
        Covariance of pitch and roll with the lines' direction, rad^2.
    lines : ndarray, shape (N, 3)
        (x, y) of the nearest point of each line, m in the robot frame, and its direction, rad.
    centre : ndarray, shape (1, 2) or (0, 2)
        Of the centre circle, m in the robot frame.
    """

    shared: FloatArray = field(default_factory=lambda: np.zeros(2))
    lines: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    centre: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))


def scene(seen: Observation, lean: Lean, lines: FloatArray, level: CameraView) -> Scene:
    """Add to a picture's landmarks what its lines show.

    Parameters
    ----------
    seen : Observation
        The landmarks, with the compass of this lean.
    lean : Lean
        What the lines tell of the body.
    lines : ndarray, shape (N, 4)
        As `read_lines` gives them, px.
    level : CameraView
        How the camera looks, its lean taken in.
    """
    own = {each.name: getattr(seen, each.name) for each in fields(Observation)}
    found = field_lines(lines, lean, level) if np.isfinite(seen.direction_sigma) else np.zeros((0, 3))
    return Scene(**own, shared=lean.covariance[:2, 2], lines=found, centre=circle_centre(lines, level))


def field_lines(lines: FloatArray, lean: Lean, level: CameraView) -> FloatArray:
    """Where the lines that run along the field's two directions are: their nearest points and directions (N, 3)."""
    ends = lines.reshape(-1, 4)
    ground = to_ground(ends.reshape(-1, 2), level).reshape(-1, 2, 2) + level.offset
    way = ground[:, 1] - ground[:, 0]
    length = np.maximum(np.hypot(*way.T), 1e-9)
    along = np.clip(-(ground[:, 0] * way).sum(axis=1) / length**2, 0, 1)
    nearest = ground[:, 0] + along[:, None] * way
    direction = np.arctan2(way[:, 1], way[:, 0])
    pixels = np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1]) * 320 / level.size[0]
    with np.errstate(invalid="ignore"):  # what is at the horizon has no place
        kept = (length >= LEAST_LENGTH) & (pixels >= LEAST_PIXELS) & (np.hypot(*nearest.T) < FARTHEST)
        kept &= np.abs(wrap_quarter(direction - lean.direction)) < AGREES
    return np.column_stack([nearest, direction])[kept]


class WholeFilter(Protocol):
    """What `WholePicture` needs of a filter; lesson 11's EkfSlam is one."""

    state: FloatArray
    covariance: FloatArray
    kinds: list[LandmarkKind]
    indices: npt.NDArray[np.int64]

    def move(self, motion: Motion) -> None:
        """Take in a command."""
        ...

    def use_compass(self, direction: float, sigma: float) -> None:
        """Correct the heading."""
        ...

    def number(self, seen: Observation) -> None:
        """Find out which landmarks are seen, and put new ones on the map."""
        ...

    def estimate(self) -> Estimate:
        """Return what is believed now."""
        ...


class Rows(NamedTuple):
    """What some measurements tell, by a straight line about what is believed.

    Parameters
    ----------
    innovation : ndarray, shape (m,)
        Measured less expected.
    H : ndarray, shape (m, n)
        Slopes of the expected by the state.
    own : ndarray, shape (m, m)
        Covariance of their noise but for the lean's.
    slopes : ndarray, shape (m, 2)
        Of the measured by pitch and roll that were believed too small.
    """

    innovation: FloatArray
    H: FloatArray
    own: FloatArray
    slopes: FloatArray


class WholePicture(SlamAlgorithm):
    """A filter that takes in lines and the centre circle as well, and knows that one lean moves them all.

    Lines and the circle's middle are kept on the filter's own map, as landmarks of another kind: a line's c is the
    first of its two numbers, and the second means nothing.

    Parameters
    ----------
    inner : WholeFilter
        Moves, reads the compass, and numbers landmarks. It is used from here alone.
    """

    def __init__(self, inner: WholeFilter) -> None:
        """Begin where the filter is."""
        self.inner = inner
        self._axes: dict[
            int, int
        ] = {}  # of a line's number on the map: 0 where it is x = c, 1 where it is y = c
        self._circle: int | None = None

    def move(self, motion: Motion) -> None:
        """Take in a command."""
        self.inner.move(motion)

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Take in a picture."""
        seen = as_observation(measurements)
        self.inner.use_compass(seen.direction, seen.direction_sigma)
        self.inner.number(seen)
        found = [self._landmarks(seen)]
        if isinstance(seen, Scene):
            taken: set[int] = set()
            found += [self._line(line, seen.tilt, taken) for line in seen.lines]
            found += [self._centre(place, seen.tilt) for place in seen.centre]
        self._correct([rows for rows in found if rows is not None], seen)

    def estimate(self) -> Estimate:
        """Return what is believed now, of the robot and of the paper's landmarks."""
        found = self.inner.estimate()
        kept = np.array([kind != REST for kind in self.inner.kinds], dtype=bool)
        return replace(
            found,
            landmarks=np.asarray(found.landmarks).reshape(-1, 2)[kept],
            landmark_covariances=np.asarray(found.landmark_covariances).reshape(-1, 2, 2)[kept],
            kinds=tuple(kind for kind in self.inner.kinds if kind != REST),
        )

    def _landmarks(self, seen: Observation) -> Rows | None:
        """Bearings and ranges of the landmarks that have a number."""
        used = np.flatnonzero(np.asarray(self.inner.indices) >= 0)
        if not len(used):
            return None
        numbers, part, state = np.asarray(self.inner.indices)[used], seen.part(used), self.inner.state
        away = state[3:].reshape(-1, 2)[numbers] - state[:2]
        distance = np.maximum(np.hypot(*away.T), 1e-6)
        values, R = part.about(distance)
        bearing = wrap_angle(values[::2] - np.arctan2(away[:, 1], away[:, 0]) + state[2])
        scale = np.column_stack([np.ones(len(used)), (distance / part.values[:, 1]) ** 2]).ravel()
        slopes = scale[:, None] * tilt_slopes(part.values)
        H = landmark_slopes(away, distance, numbers, len(state))
        innovation = np.column_stack([bearing, values[1::2] - distance]).ravel()
        return Rows(innovation, H, R - slopes @ part.tilt @ slopes.T, slopes)

    def _line(self, line: FloatArray, tilt: FloatArray, taken: set[int]) -> Rows | None:
        """A line of the map that is not taken yet, or a new one; None where that is in doubt."""
        axis = int(abs(np.cos(line[2] + self.inner.state[2])) > np.sqrt(0.5))
        place, H, slopes = self._on_the_field(line[:2])
        h, slopes = H[axis], slopes[axis]
        own = _pixel_noise(line[:2], self.inner.state[2])[axis] ** 2 + slopes @ tilt @ slopes
        sigmas, numbers = [], [number for number, which in self._axes.items() if which == axis]
        misses = [self.inner.state[3 + 2 * number] - place[axis] for number in numbers]
        for number, miss in zip(numbers, misses, strict=True):
            row = _with_landmark(h[None], number, np.eye(2)[:1])[0]
            sigmas.append(abs(miss) / np.sqrt(row @ self.inner.covariance @ row + own))
        nearest = np.argsort(sigmas)
        if len(nearest) and sigmas[nearest[0]] < KNOWN and all(sigmas[i] > OTHER for i in nearest[1:]):
            number, miss = numbers[nearest[0]], misses[nearest[0]]
            if number in taken:  # by a longer piece of it
                return None
        elif all(each > NEW for each in sigmas) and all(abs(miss) > APART for miss in misses):
            if h @ self.inner.covariance @ h + own >= SURE**2:
                return None
            number, miss = self._put_on_map([place[axis], 0.0], [VAGUE, 1e-6]), 0.0
            self._axes[number] = axis
        else:
            return None
        taken.add(number)
        row = _with_landmark(np.pad(h, (0, len(self.inner.state) - len(h)))[None], number, np.eye(2)[:1])
        noise = _pixel_noise(line[:2], self.inner.state[2])[axis] ** 2
        return Rows(np.array([miss]), row, np.array([[noise]]), -slopes[None])

    def _centre(self, place: FloatArray, tilt: FloatArray) -> Rows | None:
        """The centre circle's middle; None where it is far from where it should be."""
        here, H, slopes = self._on_the_field(place)
        own = CENTRE_SIGMA**2 * np.eye(2)
        spread = own + slopes @ tilt @ slopes.T
        if self._circle is None:
            if np.trace(H @ self.inner.covariance @ H.T + spread) >= CENTRE_SURE**2:
                return None
            self._circle = self._put_on_map(here, [VAGUE, VAGUE])
            H = np.pad(H, ((0, 0), (0, 2)))
        H = _with_landmark(H, self._circle, np.eye(2))
        miss = self.inner.state[3 + 2 * self._circle : 5 + 2 * self._circle] - here
        S = H @ self.inner.covariance @ H.T + spread
        return Rows(miss, H, own, -slopes) if miss @ np.linalg.solve(S, miss) < CENTRE_GATE**2 else None

    def _on_the_field(self, point: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Where a point of the robot frame is (2,), its slopes by the state (2, n), and by pitch and roll (2, 2)."""
        R, (x, y) = rotation_2d(self.inner.state[2]), point
        H = np.zeros((2, len(self.inner.state)))
        H[:, :2], H[:, 2] = np.eye(2), R @ [-y, x]
        bearing, distance = np.arctan2(y, x), np.hypot(x, y)
        by_lean = tilt_slopes(np.array([[bearing, distance]]))[1]
        toward = R @ [np.cos(bearing), np.sin(bearing)]
        return self.inner.state[:2] + R @ point, H, np.outer(toward, by_lean)

    def _put_on_map(self, place: Sequence[float] | FloatArray, variances: Sequence[float]) -> int:
        """Append two numbers to the state, and return the place on the map."""
        self.inner.state = np.concatenate([self.inner.state, place])
        self.inner.covariance = block_diag(self.inner.covariance, np.diag(variances))
        self.inner.kinds.append(REST)  # type: ignore[arg-type]
        return len(self.inner.kinds) - 1

    def _correct(self, found: list[Rows], seen: Observation) -> None:
        """Take all rows in at once; the compass is taken in already, so what they share with it is taken off."""
        if not found:
            return
        size = len(self.inner.state)
        nu, slopes = (
            np.concatenate([each.innovation for each in found]),
            np.vstack([each.slopes for each in found]),
        )
        H = np.vstack([np.pad(each.H, ((0, 0), (0, size - each.H.shape[1]))) for each in found])
        R = block_diag(*(each.own for each in found)) + slopes @ seen.tilt @ slopes.T
        if np.isfinite(seen.direction_sigma) and isinstance(seen, Scene):
            shared = (
                -slopes @ seen.shared
            )  # what is too small in the lean is too large in what was measured of it
            share = shared / seen.direction_sigma**2
            nu = nu - share * wrap_quarter(seen.direction + self.inner.state[2])
            H[:, 2] += share  # a direction is less by what the heading is more
            R = R - np.outer(share, shared)
        P = self.inner.covariance
        S = H @ P @ H.T + R
        K = np.linalg.solve(S, H @ P).T
        self.inner.state = self.inner.state + K @ nu
        self.inner.state[2] = wrap_angle(self.inner.state[2])
        P = P - K @ S @ K.T
        self.inner.covariance = (P + P.T) / 2


VAGUE = 100.0  # m^2: as if nothing were known


def _with_landmark(H: FloatArray, number: int, slopes: FloatArray) -> FloatArray:
    """Slopes of a point less a landmark: of the point's (m, n), and the landmark's own (m, 2)."""
    H = H.copy()
    H[:, 3 + 2 * number : 5 + 2 * number] = -slopes
    return H


def _pixel_noise(point: FloatArray, heading: float) -> Any:
    """Standard deviations (2,) along the field's axes of a point of the robot frame, by the pixels alone, m."""
    distance, bearing = np.hypot(*point), np.arctan2(point[1], point[0]) + heading
    toward = (CAMERA_HEIGHT**2 + distance**2) / CAMERA_HEIGHT
    across = np.hypot(distance, CAMERA_HEIGHT)
    along = np.hypot(np.cos(bearing) * toward, np.sin(bearing) * across)
    aside = np.hypot(np.sin(bearing) * toward, np.cos(bearing) * across)
    return LINE_SIGMA / FOCAL * np.array([along, aside])
