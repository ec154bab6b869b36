"""What one picture tells about landmarks: measurements, how sure they are together, and the lines as a compass."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import overload

import numpy as np
import numpy.typing as npt

from nao_course.exercises.codec import register
from nao_course.geometry import FloatArray, finite, rotation_3d, yaw_pitch_roll
from nao_course.sim import NAO_V4, CameraView
from nao_course.slam import Measurement

CAMERA_HEIGHT = NAO_V4.view("bottom", 0.0, float(np.radians(-31.0))).height  # m
TILT_SIGMAS = (float(np.radians(1.3)), float(np.radians(0.8)))  # pitch and roll of a body in one picture
PIXEL_SIGMA = 1.0  # px at 320, of a landmark in a picture
FOCAL = NAO_V4.view("bottom").focal[0]  # px at 320
VAGUE = 1e4  # by how much a new landmark's covariance is larger at first: as if nothing were known of it
POST_RADIUS = 0.05  # m: a post's foot is that much nearer than its middle, which the map holds
POST_SIGMA = 0.02  # m: which point of a thick post's foot a picture gives; measured within 1.5 m, where a pixel is 5 mm


@register
@dataclass(frozen=True, eq=False)
class Observation(Sequence[Measurement]):
    """All measurements of one picture: a sequence of them, and what they have in common.

    Parameters
    ----------
    measurements : sequence of Measurement
        k of them.
    covariance : ndarray, shape (2k, 2k)
        Of bearing and range of each in turn, rad^2, rad m and m^2: one lean of the body moves all of them together.
    direction : float
        Of the field's lines, rad from straight ahead to the left, known modulo 90 degrees.
    direction_sigma : float
        Of that, rad; infinite where no lines tell.
    tilt : ndarray, shape (2, 2)
        Of the body's pitch and roll, rad^2: the part of the covariance that all measurements share.

    Raises
    ------
    ValueError
        If the covariance has another shape.
    """

    measurements: tuple[Measurement, ...]
    covariance: FloatArray
    direction: float = 0.0
    direction_sigma: float = float("inf")
    tilt: FloatArray = field(default_factory=lambda: np.zeros((2, 2)))

    def __post_init__(self) -> None:
        """Check the shapes."""
        object.__setattr__(self, "measurements", tuple(self.measurements))
        n = 2 * len(self.measurements)
        covariance = (
            np.array(self.covariance, dtype=float).reshape(n, n) if n == 0 else np.array(self.covariance)
        )
        if covariance.shape != (n, n):
            raise ValueError(f"Observation: covariance must have shape ({n}, {n}), got {covariance.shape}")
        object.__setattr__(self, "covariance", covariance)
        object.__setattr__(self, "direction", finite("Observation: direction (rad)", self.direction))

    @overload
    def __getitem__(self, index: int) -> Measurement: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Measurement, ...]: ...
    def __getitem__(self, index: int | slice) -> Measurement | tuple[Measurement, ...]:
        """Return a measurement, or several."""
        return self.measurements[index]

    def __len__(self) -> int:
        """How many measurements."""
        return len(self.measurements)

    @property
    def values(self) -> FloatArray:
        """Bearing and range of each, (k, 2); rad and m."""
        return values_of(self.measurements)

    def covariance_of(self, chosen: npt.ArrayLike) -> FloatArray:
        """Joint covariance (2m, 2m) of m of the measurements (numbers from 0)."""
        return self.part(chosen).covariance

    def part(self, chosen: npt.ArrayLike) -> Observation:
        """Return some of the measurements (numbers from 0), with their joint covariance and the same lean and lines."""
        numbers = np.array(chosen, dtype=int).ravel()
        rows = (2 * numbers[:, None] + (0, 1)).ravel()
        kept = tuple(self.measurements[i] for i in numbers)
        return replace(self, measurements=kept, covariance=self.covariance[np.ix_(rows, rows)])

    def about(self, ranges: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the same measurements as a straight line about expected ranges shows them.

        A lean changes 1 / range, so the error of a range that is measured far too long looks larger than it is. Here
        1 / range is measured; its difference from the expected one comes as metres at the expected range.

        Parameters
        ----------
        ranges : array_like, shape (k,)
            What is expected of each, m, above 0.

        Returns
        -------
        values : ndarray, shape (2k,)
            Bearing and range of each in turn.
        covariance : ndarray, shape (2k, 2k)
            Of them.
        """
        expected, values = np.asarray(ranges, dtype=float), self.values
        ratio = expected / values[:, 1]
        scale = np.column_stack([np.ones(len(ratio)), ratio**2]).ravel()
        straight = np.column_stack([values[:, 0], expected * (2 - ratio)])
        return straight.ravel(), scale[:, None] * self.covariance * scale

    def apart(self, ranges: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the same measurements for somebody who takes them one by one, as if they were independent.

        They share one lean. Each gets its share of the covariance k times, so that k of them together know the lean no
        better than they do.

        Parameters
        ----------
        ranges : array_like, shape (k,)
            What is expected of each, m, above 0: see `about`.

        Returns
        -------
        values : ndarray, shape (k, 2)
            Bearing and range of each.
        covariances : ndarray, shape (k, 2, 2)
            Of them.
        """
        values, R = self.about(ranges)
        k = len(self)
        values = values.reshape(k, 2)
        G = tilt_slopes(values)
        R = R + max(k - 1, 0) * G @ self.tilt @ G.T
        return values, R.reshape(k, 2, k, 2)[np.arange(k), :, np.arange(k)]


def values_of(measurements: Iterable[Measurement]) -> FloatArray:
    """Bearing and range of each measurement, (k, 2); rad and m."""
    return np.array([(each.bearing, each.range) for each in measurements], dtype=float).reshape(-1, 2)


def as_observation(measurements: Sequence[Measurement]) -> Observation:
    """Return an observation as it is, and plain measurements as those of a body that leans as usual."""
    if isinstance(measurements, Observation):
        return measurements
    return observation(measurements)


def observation(
    measurements: Sequence[Measurement],
    tilt: npt.ArrayLike = TILT_SIGMAS,
    corner_sigma: float = PIXEL_SIGMA,
    direction: float = 0.0,
    direction_sigma: float = float("inf"),
    post_sigma: float = 0.0,
) -> Observation:
    """Put the measurements of one picture together with what their errors have in common.

    Parameters
    ----------
    measurements : sequence of Measurement
        k of them.
    tilt, post_sigma : array_like, float
        See `picture_covariance`.
    corner_sigma : float
        Of a corner in a picture 320 wide, px; a post's is PIXEL_SIGMA.
    direction, direction_sigma : float
        Of the field's lines; see `Observation`.
    """
    T = tilt_covariance(tilt)
    sigmas = np.array([corner_sigma if each.kind == "corner" else PIXEL_SIGMA for each in measurements])
    R = picture_covariance(measurements, T, sigmas, post_sigma)
    return Observation(tuple(measurements), R, direction, direction_sigma, T)


def tilt_covariance(tilt: npt.ArrayLike) -> FloatArray:
    """Return the covariance (2, 2) of pitch and roll, given as such or as two standard deviations, rad."""
    given = np.array(tilt, dtype=float)
    return np.diag(given**2) if given.ndim == 1 else given


def picture_covariance(
    measurements: Sequence[Measurement],
    tilt: npt.ArrayLike = TILT_SIGMAS,
    pixel_sigma: npt.ArrayLike = PIXEL_SIGMA,
    post_sigma: float = 0.0,
) -> FloatArray:
    """Return the joint covariance of the measurements of one picture, R = D + G T Gᵀ.

    Parameters
    ----------
    measurements : sequence of Measurement
        k of them.
    tilt : array_like, shape (2,) or (2, 2)
        Standard deviations of the body's pitch and roll, rad, or their covariance, rad^2.
    pixel_sigma : float or array_like, shape (k,)
        Of a landmark in a picture 320 wide, px, in both directions.
    post_sigma : float
        Of a post besides, m on the ground in both directions: POST_SIGMA where it is found in a picture, and 0 where
        posts are drawn as points.

    Returns
    -------
    ndarray, shape (2k, 2k)
        Of bearing and range of each in turn.
    """
    values = values_of(measurements)
    T = tilt_covariance(tilt)
    angle = np.broadcast_to(pixel_sigma, len(values))[:, None] / FOCAL
    steep = (CAMERA_HEIGHT**2 + values[:, 1] ** 2) / CAMERA_HEIGHT
    thick = post_sigma * np.array([each.kind == "post" for each in measurements])
    by_pixel = angle * np.column_stack([np.ones(len(values)), steep])
    by_thickness = np.column_stack([thick / values[:, 1], thick])
    D = np.diag((by_pixel**2 + by_thickness**2).ravel())
    G = tilt_slopes(values)
    return D + G @ T @ G.T


def tilt_slopes(values: FloatArray) -> FloatArray:
    """How measurements change with the error of the body's lean.

    The body leans about the point it stands on. Then bearings stay as they are, and 1 / range changes for all of a
    picture's landmarks in the same way: by (pitch cos(bearing) - roll sin(bearing)) / height of the camera.

    Parameters
    ----------
    values : ndarray, shape (k, 2)
        Bearing and range, rad and m.

    Returns
    -------
    ndarray, shape (2k, 2)
        Slopes of what is measured by pitch and roll that were believed too small, rad / rad and m / rad.
    """
    bearing, distance = values.T
    slopes = np.zeros((len(values), 2, 2))
    inverse = distance**2 / CAMERA_HEIGHT
    slopes[:, 1, 0], slopes[:, 1, 1] = inverse * np.cos(bearing), -inverse * np.sin(bearing)
    return slopes.reshape(-1, 2)


def leaning(view: CameraView, pitch: float, roll: float) -> CameraView:
    """Return the view of the same camera when the whole body leans about the point it stands on.

    Parameters
    ----------
    view : CameraView
        Of the upright robot.
    pitch, roll : float
        Rad, positive to the front and to the right.

    Returns
    -------
    CameraView
        Its height, offset and angles moved along.
    """
    torso = rotation_3d(0.0, pitch, roll)
    x, y, z = (torso @ view.position).tolist()
    yaw, down, lean = yaw_pitch_roll(torso @ view.rotation)
    return replace(view, height=z, offset=(x, y), yaw=yaw, pitch=down, roll=lean)
