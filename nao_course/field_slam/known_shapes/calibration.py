"""Extrinsic self-calibration: the constant offset of the camera's pitch and roll, estimated while the robot walks.

The camera does not look exactly where the head's joints report. The difference is constant, and the body sways about it
from picture to picture. `CameraCalibration` estimates it from what every picture shows: the right angles between the
field's lines, the centre circle, and the goal. Their shapes and sizes are known from the rules, their positions are
not. The likelihood of each picture is computed on a lattice of offsets, because it has several maxima. A single picture
of a few lines may also fit a wrong tilt, which only the next pictures exclude.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

from nao_course.field_slam.compass import (
    DIRECTION_SIGMA,
    END_SIGMA,
    FARTHEST_END,
    LEAST_LENGTH,
    LENGTHS,
    wrap_quarter,
)
from nao_course.field_slam.known_shapes.circle import RADIUS, SEGMENT_LENGTH
from nao_course.field_slam.observation import FOCAL, PIXEL_SIGMA, POST_RADIUS, TILT_SIGMAS, tilt_covariance
from nao_course.geometry import FloatArray, rotation_2d
from nao_course.sim import CameraView, Field

# Standard deviations of the offset in pitch and roll before the first picture, rad.
PRIOR_SIGMAS = (float(np.radians(5.0)), float(np.radians(3.0)))
# Standard deviation of the error that all pictures share (lens model, height of the camera), rad.
COMMON_SIGMA = float(np.radians(0.2))
STEP = float(np.radians(0.5))  # rad, between the nodes of the lattice
LATTICE = np.stack(np.meshgrid(STEP * np.arange(-36, 37), STEP * np.arange(-20, 21), indexing="ij"), axis=2)
LEAST = 3e-3  # a node whose predicted probability is a smaller part of the largest one is not evaluated
READ_SIGMAS = 2.0  # lines are searched as if the camera looked lower by as many standard deviations
# The likelihood of an outlier, where an exact measurement has 1, and the probability that a line is an outlier by its
# length on the ground: below LEAST_LENGTH, between the two LENGTHS, and above them. A goal has the third probability.
BROAD, OUTLIERS = (0.05, (1.0, 0.3, 0.1, 0.03))
CERTAIN = float(np.radians(1.0))  # largest standard deviation of an offset with which pictures are measured
BAD_PICTURE = 0.05  # probability that the likelihood of a whole picture is wrong
MOST_LINES, MOST_DIRECTIONS, MOST_CENTRES = (16, 6, 4)  # that are used, or tried; the longest first
GOAL_WIDTH = Field(2012).dimensions.goal_width  # m, by the rules
GOAL_SIGMA = 0.04  # m, of its measured width, because posts are thick and were put up by hand
FARTHEST_GOAL = 9.0  # m
# Of a segment of the centre circle: standard deviations of its distance from the centre, m, and of its direction, rad;
# least sum of likelihoods of a circle; price of a circle in log likelihood, because its position is free.
ARC_SIGMAS, LEAST_ARCS, CIRCLE_PRICE = ((0.03, 0.15), 2.5, 4.0)
ON_CIRCLE = 0.7  # probability that a line that fits the circle belongs to it


class CameraCalibration:
    """Recursive estimate of the constant offset of the camera's pitch and roll.

    The sum of the offset and of the body's sway is the tilt of the camera in a picture. The likelihood of the tilt is
    smoothed by the sway, which gives the likelihood of the offset; the logarithms of all pictures are added up.
    `sigmas` are the prior standard deviations of the offset in pitch and roll, rad; `sway` has the standard deviations
    (2,) of the body's pitch and roll in one picture, rad, or their covariance (2, 2), rad^2. The estimate is `mean`
    (2,), rad, with `covariance` (2, 2), rad^2; it is positive if the camera looks lower than assumed, or is rotated
    more to the right.
    """

    mean: FloatArray
    covariance: FloatArray

    def __init__(self, sigmas: tuple[float, float] = PRIOR_SIGMAS, sway: npt.ArrayLike = TILT_SIGMAS) -> None:
        """Start with the prior alone."""
        self._prior = -0.5 * ((LATTICE / sigmas) ** 2).sum(axis=2)
        self._log = self._prior
        self._sway = tilt_covariance(sway)
        self._summarise()

    @property
    def is_certain(self) -> bool:
        """Whether the offset is known better than a robot's sway."""
        return bool(np.sqrt(np.diag(self.covariance)).max() < CERTAIN)

    def corrected(self, view: CameraView) -> CameraView:
        """Return the view of the camera if the offset has its mean."""
        pitch, roll = self.mean.tolist()
        return replace(view, pitch=view.pitch + pitch, roll=view.roll + roll)

    def reading_view(self, view: CameraView) -> CameraView:
        """Return a view in which lines are found for all probable offsets.

        It looks lower than the mean, so the search begins higher in the picture, and lines may be wider.
        """
        low = READ_SIGMAS * float(np.sqrt(self.covariance[0, 0] - COMMON_SIGMA**2))
        view = self.corrected(view)
        return replace(view, pitch=view.pitch + low)

    def tilt_covariance(self, view: CameraView) -> FloatArray:
        """Return the covariance (2, 2) of the tilt of the robot's body in one picture, rad^2: offset and sway."""
        R = rotation_2d(-view.yaw)
        return np.asarray(R @ self.covariance @ R.T + self._sway)

    def update(self, lines: npt.ArrayLike, posts: npt.ArrayLike, view: CameraView) -> None:
        """Update the offset with lines (N, 4), (u1, v1, u2, v2), and feet of posts (P, 2), (u, v), of a picture, px.

        The lines are as `read_lines` returns them with `reading_view`. Two posts are a goal; another number is not
        used. The view is the camera's by the joints, without the offset.
        """
        R = rotation_2d(view.yaw)  # the offset turns with the head, the sway does not
        sway = np.sqrt(np.diag(R @ self._sway @ R.T)) / STEP
        predicted = _smooth(self._weights, sway)
        near = predicted > LEAST * predicted.max()
        likelihood = np.zeros(near.shape)
        likelihood[near] = likelihoods(lines, posts, view, LATTICE[near])
        smooth, prior = _smooth(likelihood, sway), np.exp(self._prior)
        usual = (prior * smooth).sum() / prior.sum()
        self._log = self._log + np.log((1 - BAD_PICTURE) * smooth / usual + BAD_PICTURE)
        self._summarise()

    def _summarise(self) -> None:
        """Compute the weights of the lattice with their mean and covariance."""
        weights = np.exp(self._log - self._log.max())
        self._weights = weights / weights.sum()
        self.mean = np.einsum("pr,prk->k", self._weights, LATTICE)
        deviation = LATTICE - self.mean
        self.covariance = np.einsum("pr,prk,prl->kl", self._weights, deviation, deviation)
        self.covariance += COMMON_SIGMA**2 * np.eye(2)


def _smooth(values: FloatArray, sigmas: FloatArray) -> FloatArray:
    return np.asarray(gaussian_filter(values, sigmas, mode="constant", truncate=3.0))


# --- the likelihood of one picture ---


@dataclass(frozen=True, eq=False)
class _Lines:
    """N lines of a picture on the ground, for T tilts of the camera.

    Each has a direction (T, N), rad, with a variance, rad^2, in a frame with the camera's heading, a length (T, N), m,
    and a midpoint (T, N, 2), m, NaN above the horizon; `outlier` (T, N) is the probability that it is not one of the
    field's straight lines.
    """

    direction: FloatArray
    variance: FloatArray
    outlier: FloatArray
    middle: FloatArray
    length: FloatArray


def likelihoods(
    lines: npt.ArrayLike, posts: npt.ArrayLike, view: CameraView, offsets: FloatArray
) -> FloatArray:
    """Return the likelihood (T,) of a picture for offsets (T, 2) of the camera's pitch and roll; the largest one is 1.

    A line is explained by one of the field's two directions, as a segment of the centre circle, or as an outlier. The
    other parameters are described at `CameraCalibration.update`.
    """
    ends = np.asarray(lines, dtype=float).reshape(-1, 4)
    pixels = np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1])
    ends = ends[np.argsort(-pixels, kind="stable")[:MOST_LINES]]
    feet = np.asarray(posts, dtype=float).reshape(-1, 2)
    R = _rotations(view, offsets)
    on_ground = _on_ground(ends, R, view)
    arcs = _arcs(on_ground, view)
    log = np.zeros(len(offsets))
    direction, variance, outlier = on_ground.direction, on_ground.variance, on_ground.outlier
    if len(feet) == 2:
        goal_direction, goal_variance, squared = _goal(feet, R, view)
        seen = np.isfinite(squared)
        log += np.log((1 - OUTLIERS[2]) * np.where(seen, np.exp(-0.5 * squared), 0) + OUTLIERS[2] * BROAD)
        direction = np.column_stack([direction, goal_direction])
        variance = np.column_stack([variance, goal_variance])
        outlier = np.column_stack([outlier, np.where(seen, OUTLIERS[2], 1.0)])
        arcs = np.pad(arcs, ((0, 0), (0, 1)))
    if direction.shape[1] > 1:
        fit = _agreement(direction, variance, outlier, BROAD * outlier)
        circle = arcs.sum(axis=1) > LEAST_ARCS
        if circle.any():
            other = BROAD * outlier[circle] + ON_CIRCLE * arcs[circle]
            with_circle = _agreement(direction[circle], variance[circle], outlier[circle], other)
            fit[circle] = np.maximum(fit[circle], with_circle - CIRCLE_PRICE)
        log += fit
    return np.asarray(np.exp(log - log.max()))


def _rotations(view: CameraView, offsets: FloatArray) -> FloatArray:
    """Return the rotations (T, 3, 3) from the camera to a level frame that has its heading."""
    (sp, sr), (cp, cr) = (
        np.sin(offsets.T + [[view.pitch], [view.roll]]),
        np.cos(offsets.T + [[view.pitch], [view.roll]]),
    )
    zero = np.zeros_like(sp)
    rows = (cp, sp * sr, sp * cr), (zero, cr, -sr), (-sp, cp * sr, cp * cr)
    return np.moveaxis(np.array(rows), -1, 0)


def _rays(pixels: FloatArray, view: CameraView) -> FloatArray:
    """Return the rays (..., 3) of pixels (..., 2) without lens distortion, in the camera's frame."""
    right, below = np.moveaxis((pixels - view.centre) / view.focal, -1, 0)
    return np.stack([np.ones_like(right), -right, -below], axis=-1)


def _ground(rays: FloatArray, R: FloatArray, view: CameraView) -> FloatArray:
    """Return the points (T, N, 2) on the ground that rays (N, 3) reach, m; NaN near the horizon and above it."""
    turned = rays @ R.mT
    down = np.where(turned[..., 2] < -0.02, -turned[..., 2], np.nan)
    return np.asarray(view.height * turned[..., :2] / down[..., None])


def _on_ground(ends: FloatArray, R: FloatArray, view: CameraView) -> _Lines:
    """Return lines (N, 4) on the ground for rotations (T, 3, 3) of the camera."""
    along = ends[:, 2:] - ends[:, :2]
    aside = np.column_stack([-along[:, 1], along[:, 0]]) / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    aside = END_SIGMA * view.size[0] / 320 * aside
    first, last = _rays(ends[:, :2], view), _rays(ends[:, 2:], view)
    normal = np.cross(first, last)
    x, y, z = np.moveaxis(normal @ R.mT, -1, 0)
    square = np.maximum(x**2 + y**2, 1e-12)
    # The tilt of a cell of the lattice is known to its width.
    variance = DIRECTION_SIGMA**2 + STEP**2 / 12 * z**2 / square
    for moved in (
        np.cross(_rays(ends[:, :2] + aside, view), last),
        np.cross(first, _rays(ends[:, 2:] + aside, view)),
    ):
        dx, dy, _ = np.moveaxis((moved - normal) @ R.mT, -1, 0)
        variance = variance + ((x * dy - y * dx) / square) ** 2
    a, b = _ground(first, R, view), _ground(last, R, view)
    length = np.linalg.norm(b - a, axis=2)
    outlier = np.array(OUTLIERS)[np.searchsorted((LEAST_LENGTH, *LENGTHS), length)]
    far = np.maximum(np.linalg.norm(a, axis=2), np.linalg.norm(b, axis=2))
    near = far < FARTHEST_END  # false at the horizon
    return _Lines(np.arctan2(-x, y), variance, np.where(near, outlier, 1.0), (a + b) / 2, length)


def _arcs(lines: _Lines, view: CameraView) -> FloatArray:
    """Return the likelihoods (T, N) of lines as segments of the circle that fits most of them."""
    tilts, number = lines.direction.shape
    normal = np.stack([-np.sin(lines.direction), np.cos(lines.direction)], axis=-1)
    squared_range = (lines.middle**2).sum(axis=-1)
    usable = (lines.length > SEGMENT_LENGTH[0]) & (lines.length < SEGMENT_LENGTH[1])
    usable &= squared_range < FARTHEST_END**2
    per_tilt = view.height + squared_range / view.height
    radial = ARC_SIGMAS[0] ** 2 + per_tilt**2 * (STEP**2 / 12 + (PIXEL_SIGMA / 2 / FOCAL) ** 2)
    tangential = lines.variance + ARC_SIGMAS[1] ** 2
    apothem = np.sqrt(np.maximum(RADIUS**2 - lines.length**2 / 4, 0))
    best, likelihood = np.zeros(tilts), np.zeros((tilts, number))
    for i in range(min(number, MOST_CENTRES)):
        for side in (1, -1):
            outward = lines.middle - (lines.middle[:, i] + side * apothem[:, i, None] * normal[:, i])[:, None]
            distance = np.maximum(np.linalg.norm(outward, axis=-1), 1e-9)
            # The squared angle between the normal of a segment and its radius, if it is small.
            squared_angle = 2 * (1 - np.abs((outward * normal).sum(axis=-1)) / distance)
            exponent = (distance - apothem) ** 2 / radial + squared_angle / tangential
            each = np.where(usable & usable[:, i, None], np.exp(-0.5 * exponent), 0.0)
            better = each.sum(axis=1) > best
            best[better], likelihood[better] = each[better].sum(axis=1), each[better]
    return likelihood


def _goal(feet: FloatArray, R: FloatArray, view: CameraView) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the direction (T,) of a goal with its variance, and the squared normalised error of its width."""
    step = PIXEL_SIGMA * view.size[0] / 320
    moves = np.concatenate([np.zeros((1, 2, 2)), step * np.eye(4).reshape(4, 2, 2)])
    ground = _ground(_rays(view.undistort(feet) + moves, view).reshape(-1, 3), R, view)
    # The axis of a post is behind its visible foot.
    ground = (ground * (1 + POST_RADIUS / np.linalg.norm(ground, axis=2, keepdims=True))).reshape(-1, 5, 2, 2)
    across = ground[:, :, 1] - ground[:, :, 0]
    width, direction = np.linalg.norm(across, axis=2), np.arctan2(across[..., 1], across[..., 0])
    distance = np.linalg.norm(ground[:, 0].mean(axis=1), axis=1)
    by_cell = STEP**2 / 12 * (distance / view.height) ** 2
    width_variance = (
        ((width[:, 1:] - width[:, :1]) ** 2).sum(axis=1) + by_cell * width[:, 0] ** 2 + GOAL_SIGMA**2
    )
    variance = (wrap_quarter(direction[:, 1:] - direction[:, :1]) ** 2).sum(axis=1) + by_cell
    squared = np.where(distance < FARTHEST_GOAL, (width[:, 0] - GOAL_WIDTH) ** 2 / width_variance, np.nan)
    variance = variance + (GOAL_SIGMA / GOAL_WIDTH) ** 2
    return np.nan_to_num(direction[:, 0]), np.nan_to_num(variance, nan=1.0), squared


def _agreement(
    direction: FloatArray, variance: FloatArray, outlier: FloatArray, other: FloatArray
) -> FloatArray:
    """Return the log likelihood (T,) of lines (T, N) if the field has the direction that fits them best.

    The likelihood of each line without that direction is given by `other`, (T, N).
    """
    tilts, number = direction.shape
    best, chosen = np.full(tilts, -np.inf), np.zeros(tilts)
    for i in dict.fromkeys([*range(min(number, MOST_DIRECTIONS)), number - 1]):
        residual = wrap_quarter(direction - direction[:, i : i + 1])
        inlier = (1 - outlier) * np.exp(-0.5 * residual**2 / (variance + variance[:, i : i + 1]))
        fit = np.log(inlier + other).sum(axis=1)
        chosen, best = np.where(fit > best, direction[:, i], chosen), np.maximum(fit, best)
    for last in (False, False, True):
        residual = wrap_quarter(direction - chosen[:, None])
        inlier = (1 - outlier) * np.exp(-0.5 * residual**2 / variance)
        if not last:
            weight = inlier / (inlier + other) / variance
            chosen = chosen + (weight * residual).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-9)
    return np.asarray(np.log(inlier + other).sum(axis=1))
