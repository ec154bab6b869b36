"""Body tilt and heading from the lines of the field, which are parallel or at right angles to each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nao_course.field_slam.lines import to_ground
from nao_course.field_slam.observation import TILT_SIGMAS, tilt_covariance, tilted
from nao_course.geometry import FloatArray
from nao_course.sim import CameraView

QUARTER = np.pi / 2
OUTLIERS = 0.01  # share of compass readings that have nothing to do with the heading
COMPASS_SIGMA = float(np.radians(3))  # a direction with a larger standard deviation is not used as a compass
END_SIGMA = 0.25  # px at 320: standard deviation of the end of a centre line, perpendicular to the line
# Standard deviation of a line's direction from other causes: the lens model, and lines that were laid by hand.
DIRECTION_SIGMA = float(np.radians(0.3))
# Shorter lines are not used, because more than half of them are arcs of the centre circle or upright things
# (`python -m benchmarks compass`); px at 320, and m.
LEAST_PIXELS, LEAST_LENGTH = 14.0, 0.3
# Probability that a line is not one of the field's straight lines, for lengths up to 0.45 m, up to 0.7 m, and above.
LENGTHS, OUTLIER_PROBABILITIES = ((0.45, 0.7), (0.2, 0.04, 0.01))
GRID = np.linspace(-2.6, 2.6, 9)  # tilts where the search starts, in standard deviations of the prior
# Number of lines that are used, those with the best known directions; number of them whose direction is tried as the
# field's.
MOST_LINES, MOST_STARTS = (24, 12)
MODES, STEPS = 3, 8  # local minima that are refined; Gauss-Newton steps for each
# Largest change of an angle in one step, which bounds the step where lines hardly determine the direction. In 400
# simulated pictures, no larger bound changed a result, but 2 degrees did.
LARGEST_STEP = float(np.radians(3.0))
# Between a line and the estimated direction, on the ground: up to AGREES the line supports it, above DISAGREES it
# contradicts it.
AGREES, DISAGREES = float(np.radians(4)), float(np.radians(6))
LEAST_SUPPORT = 0.5  # m of lines: a single segment of the centre circle is shorter
FARTHEST_END = 6.0  # m: the length of a line that ends farther away is too uncertain


@dataclass(frozen=True, eq=False)
class BodyTilt:
    """Tilt of the robot's body and direction of the field's lines, with their covariance.

    Pitch and roll, rad, are positive to the front and to the right; the direction, rad counterclockwise from straight
    ahead, is known modulo 90 degrees. The covariance (3, 3) of pitch, roll and direction is in rad^2.
    """

    pitch: float
    roll: float
    direction: float
    covariance: FloatArray

    @property
    def direction_sigma(self) -> float:
        """Standard deviation of the direction, rad; infinite if it is too large for a compass."""
        sigma = float(np.sqrt(self.covariance[2, 2]))
        return sigma if sigma <= COMPASS_SIGMA else float("inf")


def wrap_quarter(angle: npt.ArrayLike) -> FloatArray:
    """Wrap angles modulo 90 degrees into [-45, 45) degrees; rad."""
    return np.asarray((np.asarray(angle) + QUARTER / 2) % QUARTER - QUARTER / 2)


def reading_density(innovation: float, variance: npt.ArrayLike, outliers: float = OUTLIERS) -> FloatArray:
    """Return the density (...), per rad, of a compass reading; a share of them, `outliers`, is random.

    The innovation is measured minus predicted heading, rad, with variances (...) in rad^2.
    """
    v = np.asarray(variance, dtype=float)
    gaussian = np.exp(-0.5 * innovation**2 / v) / np.sqrt(2 * np.pi * v)
    return np.asarray((1 - outliers) * gaussian + outliers / QUARTER)


def estimate_body_tilt(
    lines: npt.ArrayLike,
    view: CameraView,
    sigmas: npt.ArrayLike = TILT_SIGMAS,
    least_support: float = LEAST_SUPPORT,
    least_length: float = LEAST_LENGTH,
) -> BodyTilt:
    """Estimate the body tilt from lines that are parallel or at right angles to each other on the ground.

    The lines (N, 4) are (u1, v1, u2, v2) in px, as `read_lines` returns them: with subpixel accuracy and without lens
    distortion. The view is the upright robot's. `sigmas` are the prior standard deviations (2,) of pitch and roll, rad,
    or their covariance (2, 2), rad^2. `least_support` is a value of `support`, m; shorter lines than `least_length`, m
    on the ground below an upright body, are not used. If too few lines agree, the tilt is zero with the prior's
    covariance, and the direction may have any value.
    """
    ends = np.asarray(lines, dtype=float).reshape(-1, 4)
    prior = tilt_covariance(sigmas)
    length = ground_lengths(ends, view)
    normals = line_normals(ends, view)
    sd = np.where(length >= least_length, direction_sigmas(ends, view), np.nan)
    count = min(MOST_LINES, np.isfinite(sd).sum())
    best = np.argsort(np.where(np.isfinite(sd), sd, np.inf), kind="stable")[:count]
    normals, sd = normals[best], sd[best]
    outlier = np.array(OUTLIER_PROBABILITIES)[np.searchsorted(LENGTHS, length[best])]
    starts = _starts(normals, sd, outlier, prior)
    unknown = BodyTilt(0.0, 0.0, 0.0, np.pad(prior, (0, 1)) + np.diag([0, 0, QUARTER**2 / 12]))
    if not len(starts):
        return unknown
    states, covariances, costs = _refine(normals, sd, outlier, prior, starts)
    mean, covariance = _mixture(states, covariances, costs)
    tilt = BodyTilt(float(mean[0]), float(mean[1]), float(wrap_quarter(mean[2])), covariance)
    return tilt if support(ends, view, tilt) >= least_support else unknown


def support(lines: npt.ArrayLike, view: CameraView, tilt: BodyTilt) -> float:
    """Return the length, m on the ground, of the lines that agree with a tilt minus the length of all others.

    Lines (N, 4) are (u1, v1, u2, v2) in px, without lens distortion, and the view is the upright robot's. Lines agree
    within 4 degrees of the direction or of a right angle to it, and contradict if they are more than 6 degrees off. The
    segments of the centre circle have all directions, so they have little support together.
    """
    level = tilted(view, tilt.pitch, tilt.roll)
    rays = _rays(np.asarray(lines, dtype=float).reshape(-1, 4), level)
    # A ray at or above the horizon gets an end so far away that its line is discarded.
    ground = level.height * rays[..., :2] / np.maximum(-rays[..., 2:], 1e-3)
    ground = ground[(np.linalg.norm(ground, axis=2) < FARTHEST_END).all(axis=1)]
    ahead, left = (ground[:, 1] - ground[:, 0]).T
    deviation = np.abs(wrap_quarter(np.arctan2(left, ahead) - tilt.direction))
    length = np.hypot(ahead, left)
    return float(length[deviation < AGREES].sum() - length[deviation > DISAGREES].sum())


def line_directions(normals: FloatArray, pitch: npt.ArrayLike, roll: npt.ArrayLike) -> FloatArray:
    """Return the directions (..., N) of lines on the ground under small body tilts.

    A line and the camera span a plane, whose normal (N, 3) is in the frame of an upright robot. When the normal is
    tilted by pitch and roll (...), rad, its horizontal part is perpendicular to the line. Directions are in rad
    counterclockwise from straight ahead.
    """
    x, y, z = normals.T
    return np.arctan2(-x - np.asarray(pitch)[..., None] * z, y - np.asarray(roll)[..., None] * z)


def _rays(ends: FloatArray, view: CameraView) -> FloatArray:
    """Return the rays (N, 2, 3) to both ends of lines (N, 4), in the robot frame."""
    right, below = ((ends.reshape(-1, 2) - view.centre) / view.focal).T
    rays = np.stack((np.ones_like(right), -right, -below), axis=1) @ view.rotation.T
    return np.asarray(rays.reshape(-1, 2, 3))


def line_normals(ends: FloatArray, view: CameraView) -> FloatArray:
    """Return the unit normals (N, 3) of the planes that lines (N, 4) and the camera span, in the robot frame."""
    rays = _rays(ends, view)
    normals = np.cross(rays[:, 0], rays[:, 1])
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-12)[:, None])


def direction_sigmas(ends: FloatArray, view: CameraView) -> FloatArray:
    """Return the standard deviations (N,) of the directions of lines on the ground, rad; NaN for unusable lines."""
    along = ends[:, 2:] - ends[:, :2]
    length = np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    aside = END_SIGMA * view.size[0] / 320 * np.column_stack([-along[:, 1], along[:, 0]]) / length
    direction = line_directions(line_normals(ends, view), 0.0, 0.0)
    variance = np.full(len(ends), DIRECTION_SIGMA**2)
    for moved in (np.hstack([aside, 0 * aside]), np.hstack([0 * aside, aside])):
        change = line_directions(line_normals(ends + moved, view), 0.0, 0.0) - direction
        variance = variance + ((change + np.pi / 2) % np.pi - np.pi / 2) ** 2
    sd = np.sqrt(variance)
    long_enough = length[:, 0] >= LEAST_PIXELS * view.size[0] / 320
    return np.where(long_enough & (sd < np.radians(20)), sd, np.nan)


def ground_lengths(ends: FloatArray, view: CameraView) -> FloatArray:
    """Return the lengths (N,) of lines (N, 4) on the ground, m; infinite for lines that reach the horizon."""
    ground = to_ground(ends.reshape(-1, 2), view).reshape(-1, 4)
    return np.nan_to_num(np.hypot(ground[:, 2] - ground[:, 0], ground[:, 3] - ground[:, 1]), nan=np.inf)


def _likelihoods(residual: FloatArray, sd: FloatArray, outlier: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two densities (..., N) of residuals in rad: for lines of the field, and for outliers of any direction."""
    inlier = (1 - outlier) * np.exp(-0.5 * (residual / sd) ** 2) / (np.sqrt(2 * np.pi) * sd)
    return np.asarray(inlier), np.asarray(outlier / QUARTER)


def _cost(residual: FloatArray, sd: FloatArray, outlier: FloatArray) -> FloatArray:
    """Return the robust cost (...) of residuals (..., N) in rad: quadratic near 0, and constant for outliers."""
    inlier, other = _likelihoods(residual, sd, outlier)
    return np.asarray(-2 * np.log(inlier + other).sum(axis=-1))


def _starts(normals: FloatArray, sd: FloatArray, outlier: FloatArray, prior: FloatArray) -> FloatArray:
    """Return up to MODES states (K, 3) of a grid with the lowest costs, none of them near a better one.

    The grid has the tilts of GRID, and for each of them the directions of the first lines.
    """
    grid = np.stack([each.ravel() for each in np.meshgrid(GRID, GRID, indexing="ij")])
    pitch, roll = np.linalg.cholesky(prior) @ grid
    directions = line_directions(normals, pitch, roll)  # (grid, N)
    tried = directions[:, :MOST_STARTS]
    cost = _cost(wrap_quarter(directions[:, None] - tried[..., None]), sd, outlier)  # (grid, tried)
    cost = (cost + (grid**2).sum(axis=0)[:, None]).ravel()
    states = np.stack(np.broadcast_arrays(pitch[:, None], roll[:, None], tried), axis=-1).reshape(-1, 3)
    near = np.array([*1.2 * np.sqrt(np.diag(prior)), np.radians(8.0)])
    kept: list[FloatArray] = []
    while len(kept) < MODES and len(states):
        kept.append(states[cost.argmin()])
        difference = np.abs(states - kept[-1])
        difference[:, 2] = np.abs(wrap_quarter(difference[:, 2]))
        other = (difference > near).any(axis=1)
        states, cost = states[other], cost[other]
    return np.array(kept).reshape(-1, 3)


def _refine(
    normals: FloatArray, sd: FloatArray, outlier: FloatArray, prior: FloatArray, states: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Optimise states (K, 3) by robust Gauss-Newton; return states, covariances (K, 3, 3) and costs (K,)."""
    prior_information = np.pad(np.linalg.inv(prior), (0, 1)) + np.diag([0, 0, 1e-6])
    for _ in range(STEPS):
        residual, J = _residuals(normals, states)
        inlier, other = _likelihoods(residual, sd, outlier)
        weight = inlier / (inlier + other)
        freedom = np.maximum(weight.sum(axis=1) - 1, 1.0)
        scale = np.maximum(1.0, (weight * (residual / sd) ** 2).sum(axis=1) / freedom)
        weighted = J * (weight / sd**2 / scale[:, None])[:, None]
        information = weighted @ J.mT + prior_information
        gradient = (weighted @ residual[..., None])[..., 0] + states @ prior_information * (1, 1, 0)
        change = np.linalg.solve(information, gradient[..., None])[..., 0]
        states = states - np.clip(change, -LARGEST_STEP, LARGEST_STEP)
    residual, _ = _residuals(normals, states)
    tilts = states[:, :2]
    cost = _cost(residual, sd, outlier) + (tilts @ prior_information[:2, :2] * tilts).sum(axis=1)
    return states, np.linalg.inv(information), cost


def _residuals(normals: FloatArray, states: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the angles (K, N) from lines to the nearest of the field's directions, and their Jacobian (K, 3, N)."""
    x, y, z = normals.T
    left, ahead = -x - states[:, :1] * z, y - states[:, 1:2] * z
    square = left**2 + ahead**2
    J = np.stack([-ahead * z / square, left * z / square, -np.ones_like(square)], axis=1)
    return wrap_quarter(np.arctan2(left, ahead) - states[:, 2:]), J


def _mixture(states: FloatArray, covariances: FloatArray, costs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the mean (3,) and the covariance (3, 3) of a mixture whose weights follow from the costs."""
    weight = np.exp(-(costs - costs.min()) / 2)
    weight /= weight.sum()
    best = states[costs.argmin()]
    states = np.column_stack([states[:, :2], best[2] + wrap_quarter(states[:, 2] - best[2])])
    mean = weight @ states
    deviation = states - mean
    return mean, np.einsum("k,kij->ij", weight, covariances + deviation[:, :, None] * deviation[:, None])
