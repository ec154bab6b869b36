"""A grid of poses: the probability of each place on the field and each of the compass's four headings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter, shift

from nao_course.field_slam.compass import QUARTER, reading_density, wrap_quarter
from nao_course.field_slam.kidnapping.likelihood import KnownMap, StopView, log_likelihood
from nao_course.geometry import FloatArray, wrap_angle
from nao_course.slam import Motion

CELL = 0.1  # m
SMOOTHING = 0.5 * CELL  # m: standard deviation that stands for the size of a cell
CLUSTER = 0.35  # m: radius of the neighbourhood of a pose that counts as one hypothesis
COMPASS_OUTLIERS = 0.02  # probability that the compass is wrong


Area = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True, eq=False)
class PoseGrid:
    """Probabilities of poses on a grid.

    The area is its lower left and its upper right corner, m, map frame. The weights (4, nx, ny) are probabilities of
    each cell with each of four headings, 90 degrees apart from `heading` (rad) on; their sum may be less than 1.
    `heading_sigma` (rad) holds if the quarter is known, and is infinite before the first compass.
    """

    area: Area
    weights: FloatArray
    heading: float = 0.0
    heading_sigma: float = float("inf")

    @classmethod
    def empty(cls, area: Area) -> PoseGrid:
        """Return a grid with probability 0."""
        (left, low), (right, high) = area
        shape = (4, round((right - left) / CELL), round((high - low) / CELL))
        return cls(area, np.zeros(shape))

    @property
    def total(self) -> float:
        """Sum of all probabilities."""
        return float(self.weights.sum())

    @property
    def positions(self) -> FloatArray:
        """Centres of the cells, shape (nx ny, 2), m."""
        corner, (_, nx, ny) = self.area[0], self.weights.shape
        x, y = corner[0] + CELL * (np.arange(nx) + 0.5), corner[1] + CELL * (np.arange(ny) + 0.5)
        return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)

    def moved(self, motion: Motion, noise: FloatArray) -> PoseGrid:
        """Return the grid after a motion with a covariance (3, 3) of errors along, across and in turn, m^2, rad^2."""
        sigma = float(np.hypot(np.sqrt(noise[0, 0]), np.radians(2) * abs(motion.distance))) / CELL
        weights = np.zeros_like(self.weights)
        if self.total > 0:
            for quarter, layer in enumerate(self.weights):
                theta = self.heading + quarter * QUARTER
                step = motion.distance / CELL * np.array([np.cos(theta), np.sin(theta)])
                weights[quarter] = gaussian_filter(shift(layer, step, order=1), max(sigma, 0.3))
        sigma_turn = float(np.hypot(self.heading_sigma, np.sqrt(noise[2, 2])))
        return replace(self, weights=weights, heading=self.heading + motion.turn, heading_sigma=sigma_turn)

    def aligned(self, stop: StopView) -> PoseGrid:
        """Return the grid with the headings of a stop's compass, weighted by how well they fit the grid's."""
        difference = float(wrap_quarter(stop.heading - self.heading))
        factor = compass_likelihood(difference, self.heading_sigma**2 + stop.heading_sigma**2)
        return replace(
            self,
            weights=factor * self.weights,
            heading=self.heading + difference,
            heading_sigma=stop.heading_sigma,
        )

    def plus_uniform(self, probability: float) -> PoseGrid:
        """Return the grid with a probability added that is spread over all cells."""
        return replace(self, weights=self.weights + probability / self.weights.size)

    def log_likelihood(self, stop: StopView, known: KnownMap, half_view: float) -> FloatArray:
        """Return the log-likelihood of a stop for each cell, shape (4, nx, ny)."""
        positions = self.positions
        layers = [
            log_likelihood(stop, known, self.heading + quarter * QUARTER, positions, SMOOTHING, half_view)
            for quarter in range(4)
        ]
        return np.reshape(layers, self.weights.shape)

    def best(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the most probable hypothesis: mean (3,), covariance (3, 3) and its cells (4, nx, ny).

        The mean is in the map frame, m and rad, the covariance in m^2 and rad^2, and the cells are near the mean.
        """
        smooth = np.stack([gaussian_filter(layer, 1.0) for layer in self.weights])
        quarter = int(smooth.max(axis=(1, 2)).argmax())
        positions = self.positions
        mean = positions[smooth[quarter].argmax()]
        for _ in range(2):
            near = np.hypot(*(positions - mean).T) <= CLUSTER
            weight = near * self.weights[quarter].ravel()
            mean = weight @ positions / weight.sum()
        offset = positions - mean
        covariance = np.zeros((3, 3))
        covariance[:2, :2] = (weight[:, None] * offset).T @ offset / weight.sum() + SMOOTHING**2 * np.eye(2)
        covariance[2, 2] = self.heading_sigma**2
        members = np.zeros(self.weights.shape, dtype=bool)
        members[quarter] = (np.hypot(*(positions - mean).T) <= CLUSTER).reshape(self.weights.shape[1:])
        return np.append(mean, self.heading + quarter * QUARTER), covariance, members

    def covariance(self, mean: FloatArray) -> FloatArray:
        """Return the mean square (3, 3) of the deviations of all poses from one pose (3,), m^2 and rad^2."""
        positions = np.tile(self.positions, (4, 1))
        headings = np.repeat(self.heading + QUARTER * np.arange(4), len(positions) // 4)
        deviation = np.column_stack([positions - mean[:2], wrap_angle(headings - mean[2])])
        weights = self.weights.ravel() / self.total
        own = np.diag([SMOOTHING**2, SMOOTHING**2, self.heading_sigma**2])
        return np.asarray((weights[:, None] * deviation).T @ deviation + own)


def compass_likelihood(innovation: float, variance: float) -> float:
    """Return the likelihood of a compass reading relative to a reading in any direction."""
    if not np.isfinite(variance):
        return 1.0
    return QUARTER * float(reading_density(innovation, variance, COMPASS_OUTLIERS))
