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
from nao_course.lessons.slam_on_the_field.system.circle import Circle, find_circle
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

LEAST_LENGTH = 0.45  # m: a shorter line may be none of the field's
LEAST_PIXELS = 20.0  # at 320
FARTHEST = 4.0  # m: of a line's nearest point
LINE_SIGMA = 1.2  # px at 320
CENTRE_SIGMA = 0.025  # m
KNOWN = 3.0  # sigma: a line of the map is no farther than that
OTHER = 4.0  # and any other is farther
NEW = 6.0  # a new one is so far from all
APART = 0.3  # m: between two lines of a field
SURE = 0.12  # m: so well a new line's place must be known
CENTRE_GATE = 4.0  # sigma
CENTRE_SURE = 0.25  # m
UNKNOWN = 100.0  # m^2: variance of what is new
REST: Any = (
    "rest"  # kind of lines and the circle's middle on the filter's map: they are no landmarks of the paper's
)


@dataclass(frozen=True, eq=False)
class Scene(Observation):
    """An observation, and what else its picture shows.

    Parameters
    ----------
    shared : ndarray, shape (2,)
        Covariance of pitch and roll with the lines' direction, rad^2.
    lines : ndarray, shape (N, 3)
        (x, y) of the nearest point that is seen of each line, m in the robot frame, and its direction, rad.
    circle : Circle, optional
        The centre circle.
    """

    shared: FloatArray = field(default_factory=lambda: np.zeros(2))
    lines: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    circle: Circle | None = None


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

    Returns
    -------
    Scene
        Without lines where they tell no heading: along which of the field's directions they run is not known.
    """
    own = {each.name: getattr(seen, each.name) for each in fields(Observation)}
    found = field_lines(lines, lean, level) if np.isfinite(seen.direction_sigma) else np.zeros((0, 3))
    return Scene(**own, shared=lean.covariance[:2, 2], lines=found, circle=find_circle(lines, level))


def field_lines(lines: FloatArray, lean: Lean, level: CameraView) -> FloatArray:
    """Where the lines that run along the field's two directions are: their nearest points and directions (N, 3)."""
    ends = np.asarray(lines, dtype=float).reshape(-1, 4)
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
        Of the innovation by pitch and roll that were believed too small.
    """

    innovation: FloatArray
    H: FloatArray
    own: FloatArray
    slopes: FloatArray


class WholePicture(SlamAlgorithm):
    """A filter that takes in lines and the centre circle as well, and knows that one lean moves them all.

    Lines and the circle's middle are kept on the filter's own map, as landmarks of another kind: a line's c is the
    first of its two numbers, and the second means nothing. The update is exact to first order; the gates before it
    leave out what the compass has told of the lean already, so that they are a little wide.

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
            known = len(self.inner.kinds)
            found += [self._line(line, seen.tilt, known, taken) for line in seen.lines]
            found += [self._middle(seen.circle, seen)] if seen.circle else []
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

    def _line(self, line: FloatArray, tilt: FloatArray, known: int, taken: set[int]) -> Rows | None:
        """A line of the map as it was (its first `known` landmarks), not taken yet, or a new one; None in doubt."""
        axis = int(abs(np.cos(line[2] + self.inner.state[2])) > np.sqrt(0.5))
        places, H, by_lean = self._on_the_field(line[:2])
        place, h, slopes = places[axis], H[axis], by_lean[axis] @ tilt_slopes(_polar(line[:2]))[1:]
        pixels = _pixel_noise(line[:2], self.inner.state[2])[axis] ** 2
        own = pixels + slopes @ tilt @ slopes
        P = self.inner.covariance
        numbers = [number for number, which in self._axes.items() if which == axis]
        misses = {number: self.inner.state[3 + 2 * number] - place for number in numbers}
        rows = {number: _less_landmark(h[None], number, np.eye(1, 2)) for number in numbers if number < known}
        sigmas = {n: abs(misses[n]) / np.sqrt((row @ P @ row.T).item() + own) for n, row in rows.items()}
        nearest = sorted(sigmas, key=sigmas.__getitem__)
        if nearest and sigmas[nearest[0]] < KNOWN and all(sigmas[other] > OTHER for other in nearest[1:]):
            number = nearest[0]
            if number in taken:  # by a longer piece of it
                return None
        else:
            far = all(each > NEW for each in sigmas.values()) and all(
                abs(each) > APART for each in misses.values()
            )
            if not far or h @ P @ h + own >= SURE**2:
                return None
            number = self._put_on_map([place, 0.0], [UNKNOWN, 1e-6])
            self._axes[number], misses[number] = axis, 0.0
            rows[number] = _less_landmark(np.pad(h, (0, 2))[None], number, np.eye(1, 2))
        taken.add(number)
        return Rows(np.array([misses[number]]), rows[number], np.array([[pixels]]), -slopes[None])

    def _middle(self, circle: Circle, seen: Observation) -> Rows | None:
        """The centre circle's middle; None where it is far from where it should be."""
        here, H, _ = self._on_the_field(circle.centre)
        slopes = rotation_2d(self.inner.state[2]) @ circle.slopes
        own = CENTRE_SIGMA**2 * np.eye(2)
        spread = own + slopes @ seen.tilt @ slopes.T
        if self._circle is None:
            in_doubt = np.isinf(seen.direction_sigma)  # what the pieces are of
            if in_doubt or np.trace(H @ self.inner.covariance @ H.T + spread) >= CENTRE_SURE**2:
                return None
            self._circle = self._put_on_map(here, [UNKNOWN, UNKNOWN])
            H = np.pad(H, ((0, 0), (0, 2)))
        H = _less_landmark(H, self._circle, np.eye(2))
        miss = self.inner.state[3 + 2 * self._circle : 5 + 2 * self._circle] - here
        S = H @ self.inner.covariance @ H.T + spread
        return Rows(miss, H, own, -slopes) if miss @ np.linalg.solve(S, miss) < CENTRE_GATE**2 else None

    def _on_the_field(self, point: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Where a point of the robot frame is (2,), its slopes by the state (2, n), and by its range (2, 1)."""
        R, (x, y) = rotation_2d(self.inner.state[2]), point
        H = np.zeros((2, len(self.inner.state)))
        H[:, :2], H[:, 2] = np.eye(2), R @ [-y, x]
        return self.inner.state[:2] + R @ point, H, (R @ point / max(np.hypot(x, y), 1e-9))[:, None]

    def _put_on_map(self, place: Sequence[float] | FloatArray, variances: Sequence[float]) -> int:
        """Append two numbers to the state, and return the place on the map."""
        self.inner.state = np.concatenate([self.inner.state, place])
        self.inner.covariance = block_diag(self.inner.covariance, np.diag(variances))
        self.inner.kinds.append(REST)
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
        with_rows = P @ H.T
        S = R + H @ with_rows
        K = np.linalg.solve(S, with_rows.T).T
        self.inner.state = self.inner.state + K @ nu
        self.inner.state[2] = wrap_angle(self.inner.state[2])
        P = P - K @ S @ K.T
        self.inner.covariance = (P + P.T) / 2


def _less_landmark(H: FloatArray, number: int, slopes: FloatArray) -> FloatArray:
    """Slopes of a point less a landmark: of the point's (m, n), and the landmark's own (m, 2)."""
    H = H.copy()
    H[:, 3 + 2 * number : 5 + 2 * number] = -slopes
    return H


def _polar(point: FloatArray) -> FloatArray:
    """Bearing and range (1, 2) of a point (2,) of the robot frame."""
    x, y = point
    return np.array([[np.arctan2(y, x), np.hypot(x, y)]])


def _pixel_noise(point: FloatArray, heading: float) -> FloatArray:
    """Standard deviations (2,) along the field's axes of a point of the robot frame, by the pixels alone, m."""
    bearing, distance = _polar(point)[0]
    bearing = bearing + heading
    toward = CAMERA_HEIGHT + distance**2 / CAMERA_HEIGHT
    across = np.hypot(distance, CAMERA_HEIGHT)
    along = np.hypot(np.cos(bearing) * toward, np.sin(bearing) * across)
    aside = np.hypot(np.sin(bearing) * toward, np.cos(bearing) * across)
    return LINE_SIGMA / FOCAL * np.array([along, aside])
