"""The measurements of one picture with their joint covariance, and the direction of the field's lines as a compass."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import assert_never, overload

import numpy as np
import numpy.typing as npt

from nao_course.codec import register
from nao_course.geometry import FloatArray, finite, rotation_3d, yaw_pitch_roll
from nao_course.sim import NAO_V4, CameraView
from nao_course.slam import LandmarkKind, Measurement

CAMERA_HEIGHT = NAO_V4.view("bottom", 0.0, float(np.radians(-31.0))).height  # m
# Standard deviations of the pitch and roll of the body in one picture, rad.
TILT_SIGMAS = (float(np.radians(1.3)), float(np.radians(0.8)))
PIXEL_SIGMA = 1.0  # px at 320: standard deviation of a landmark's position in a picture
FOCAL = NAO_V4.view("bottom").focal[0]  # px at 320
VAGUE = 1e4  # factor for the initial covariance of a new landmark, so large that it hardly affects the update
POST_RADIUS = (
    0.05  # m: the visible foot of a post is nearer by this than its axis, whose position is on the map
)
# m: standard deviation of the point that is found at a thick post's foot. It was measured within 1.5 m, where a pixel
# is 5 mm wide.
POST_SIGMA = 0.02


@register
@dataclass(frozen=True, eq=False)
class Observation(Sequence[Measurement]):
    """The measurements of one picture, as a sequence, with their joint covariance and the compass.

    Parameters
    ----------
    measurements : sequence of Measurement
        Bearings and ranges of k landmarks.
    covariance : ndarray, shape (2k, 2k)
        Joint covariance of bearing and range of each in turn, rad^2, rad m and m^2. The errors are correlated, because
        the tilt of the body changes all ranges of a picture together.
    direction : float
        Direction of the field's lines, rad counterclockwise from straight ahead, known modulo 90 degrees.
    direction_sigma : float
        Standard deviation of the direction, rad; infinite if the picture does not show enough lines.
    tilt : ndarray, shape (2, 2)
        Covariance of the body's pitch and roll, rad^2, from which the common part of `covariance` follows.

    Raises
    ------
    ValueError
        If the covariance has another shape, or the direction is not finite.
    """

    measurements: tuple[Measurement, ...]
    covariance: FloatArray
    direction: float = 0.0
    direction_sigma: float = float("inf")
    tilt: FloatArray = field(default_factory=lambda: np.zeros((2, 2)))

    def __post_init__(self) -> None:
        """Check the values and copy them."""
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
        """Return a measurement, or a tuple of measurements for a slice."""
        return self.measurements[index]

    def __len__(self) -> int:
        """Return the number of measurements."""
        return len(self.measurements)

    @property
    def values(self) -> FloatArray:
        """Bearing and range of each measurement, shape (k, 2), rad and m."""
        return values_of(self.measurements)

    def part(self, chosen: npt.ArrayLike) -> Observation:
        """Return the observation with only some measurements, by indices or a mask, and their covariance."""
        numbers = np.ravel(chosen)
        numbers = np.arange(len(self))[numbers if numbers.dtype == bool else numbers.astype(int)]
        rows = (2 * numbers[:, None] + (0, 1)).ravel()
        kept = tuple(self.measurements[i] for i in numbers)
        return replace(self, measurements=kept, covariance=self.covariance[np.ix_(rows, rows)])

    def linearised_at(self, ranges: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the measurements and their covariance, linearised at expected ranges.

        A tilt changes the inverse of the range, so an error in tilt makes a far range wrong by more. The covariance at
        a range that was measured much too long would therefore be too large. Here, the inverse range is the measured
        value, and its difference from the expected one is converted to metres at the expected range.

        Parameters
        ----------
        ranges : array_like, shape (k,)
            Expected range of each measurement, m; above 0.

        Returns
        -------
        values : ndarray, shape (2k,)
            Bearing and range of each measurement in turn, rad and m.
        covariance : ndarray, shape (2k, 2k)
            Joint covariance of the values.
        """
        expected, values = np.asarray(ranges, dtype=float), self.values
        ratio = expected / values[:, 1]
        scale = np.column_stack([np.ones(len(ratio)), ratio**2]).ravel()
        linearised = np.column_stack([values[:, 0], expected * (2 - ratio)])
        return linearised.ravel(), scale[:, None] * self.covariance * scale

    def decorrelated(self, ranges: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the measurements, linearised, with covariances for an algorithm that treats them as independent.

        All measurements contain the error of the same tilt. If they were treated as independent, k measurements would
        seem to determine the tilt with a variance k times too small. The part of the covariance that the tilt causes is
        therefore multiplied by k.

        Parameters
        ----------
        ranges : array_like, shape (k,)
            Expected range of each measurement, m; above 0. See `linearised_at`.

        Returns
        -------
        values : ndarray, shape (k, 2)
            Bearing and range of each measurement, rad and m.
        covariances : ndarray, shape (k, 2, 2)
            Covariance of each measurement.
        """
        values, R = self.linearised_at(ranges)
        k = len(self)
        values = values.reshape(k, 2)
        G = tilt_jacobian(values)
        R = R + max(k - 1, 0) * G @ self.tilt @ G.T
        return values, R.reshape(k, 2, k, 2)[np.arange(k), :, np.arange(k)]


def values_of(measurements: Iterable[Measurement]) -> FloatArray:
    """Return bearing and range of each measurement, shape (k, 2), rad and m."""
    return np.array([(each.bearing, each.range) for each in measurements], dtype=float).reshape(-1, 2)


def as_observation(measurements: Sequence[Measurement]) -> Observation:
    """Return an observation unchanged, and other measurements as an observation with the usual tilt covariance."""
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
    """Make an observation from the measurements of one picture, with their joint covariance.

    `tilt` has the standard deviations (2,) of the body's pitch and roll, rad, or their covariance (2, 2), rad^2.
    `corner_sigma` is a corner's standard deviation in a picture of 320 columns, px; a post has PIXEL_SIGMA, and on the
    ground `post_sigma`, m, in addition (see `picture_covariance`). `direction` of the field's lines and its standard
    deviation are in rad; see `Observation`.
    """
    T = tilt_covariance(tilt)
    sigmas = np.array([_pixel_sigma(each.kind, corner_sigma) for each in measurements])
    R = picture_covariance(measurements, T, sigmas, post_sigma)
    return Observation(tuple(measurements), R, direction, direction_sigma, T)


def _pixel_sigma(kind: LandmarkKind, corner_sigma: float) -> float:
    match kind:
        case "corner":
            return corner_sigma
        case "post":
            return PIXEL_SIGMA
    assert_never(kind)


def radius_of(kind: LandmarkKind) -> float:
    """Return by how much a landmark of this kind is measured nearer than its position on the map, m."""
    match kind:
        case "corner":
            return 0.0
        case "post":
            return POST_RADIUS
    assert_never(kind)


def tilt_covariance(tilt: npt.ArrayLike) -> FloatArray:
    """Return the covariance (2, 2) of pitch and roll, rad^2, from a covariance or two standard deviations in rad."""
    given = np.array(tilt, dtype=float)
    return np.diag(given**2) if given.ndim == 1 else given


def picture_covariance(
    measurements: Sequence[Measurement],
    tilt: npt.ArrayLike = TILT_SIGMAS,
    pixel_sigma: npt.ArrayLike = PIXEL_SIGMA,
    post_sigma: float = 0.0,
) -> FloatArray:
    """Return the joint covariance (2k, 2k) of the k measurements of one picture, R = D + G T Gᵀ.

    D is the diagonal covariance of the pixel noise, T the covariance of the tilt, and G the Jacobian of the
    measurements with respect to the tilt. The order is bearing and range of each measurement in turn, in rad^2, rad m
    and m^2. `tilt` has the standard deviations (2,) of pitch and roll, rad, or T (2, 2), rad^2; `pixel_sigma` is one or
    (k,) standard deviations in px of a picture of 320 columns, in both directions. `post_sigma`, m on the ground in
    both directions, is POST_SIGMA if posts are found in pictures, and 0 if they are simulated as points.
    """
    values = values_of(measurements)
    T = tilt_covariance(tilt)
    angle = np.broadcast_to(pixel_sigma, len(values))[:, None] / FOCAL
    steep = (CAMERA_HEIGHT**2 + values[:, 1] ** 2) / CAMERA_HEIGHT
    thick = np.array([post_sigma if radius_of(each.kind) else 0.0 for each in measurements])
    by_pixel = angle * np.column_stack([np.ones(len(values)), steep])
    by_thickness = np.column_stack([thick / values[:, 1], thick])
    D = np.diag((by_pixel**2 + by_thickness**2).ravel())
    G = tilt_jacobian(values)
    return D + G @ T @ G.T


def tilt_jacobian(values: FloatArray) -> FloatArray:
    """Return the Jacobian (2k, 2) of bearings and ranges (k, 2) with respect to errors of the body's pitch and roll.

    The body tilts about the point where it stands. To first order, the bearings do not change, and the inverse ranges
    of all landmarks of a picture change by (pitch cos(bearing) - roll sin(bearing)) / height of the camera. Entries are
    in rad / rad and m / rad; errors count as positive if the assumed tilt is too small.
    """
    bearing, distance = values.T
    jacobian = np.zeros((len(values), 2, 2))
    per_tilt = distance**2 / CAMERA_HEIGHT
    jacobian[:, 1, 0], jacobian[:, 1, 1] = per_tilt * np.cos(bearing), -per_tilt * np.sin(bearing)
    return jacobian.reshape(-1, 2)


def tilted(view: CameraView, pitch: float, roll: float) -> CameraView:
    """Return the view of a camera after the whole body has been tilted about the point where it stands.

    Pitch and roll are in rad, positive to the front and to the right.
    """
    torso = rotation_3d(0.0, pitch, roll)
    x, y, z = (torso @ view.position).tolist()
    camera_yaw, camera_pitch, camera_roll = yaw_pitch_roll(torso @ view.rotation)
    return replace(view, height=z, offset=(x, y), yaw=camera_yaw, pitch=camera_pitch, roll=camera_roll)
