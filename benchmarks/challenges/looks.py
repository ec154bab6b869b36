"""Entries to lesson 06's challenge: no measurement, near landmarks, the smallest covariance, a consistent filter."""

from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks import solution
from nao_course.geometry import wrap_angle
from nao_course.slam import range_and_bearing

Array = npt.NDArray[np.float64]
BEARING, RANGE = float(np.radians(1.5)), 0.05  # as the robot's sensors have them: rad, part of the range
ITERATIONS = 8
SAMPLES = 64  # poses by which a look is judged before it is taken


def _jacobian(pose: Array, landmark: Array) -> Array:
    dx, dy = landmark - pose[:2]
    r = np.hypot(dx, dy)
    return np.array([[dy / r**2, -dx / r**2, -1.0], [-dx / r, -dy / r, 0.0]])


def _noise(distance: float) -> Array:
    return np.diag([BEARING**2, (RANGE * distance) ** 2])


def no_measurement(pose: Array, covariance: Array, landmarks: Array, sensor: Any) -> Any:
    """Return the given estimate without any measurement."""
    return pose, covariance


def nearest(pose: Array, covariance: Array, landmarks: Array, sensor: Any) -> Any:
    """Measure the three landmarks that are nearest to the estimated pose."""
    localize = solution("06")["localize"]
    for number in np.argsort(np.hypot(*(landmarks - pose[:2]).T))[:3]:
        measured, noise = sensor.measure(int(number))
        pose, covariance = localize(pose, covariance, measured, landmarks[number], noise)
    return pose, covariance


def greedy(pose: Array, covariance: Array, landmarks: Array, sensor: Any) -> Any:
    """Choose each time the landmark after which the determinant of the filter's covariance is smallest."""
    localize = solution("06")["localize"]
    for _ in range(3):
        left = []
        for landmark in landmarks:
            expected = range_and_bearing(pose, landmark[None])[0]
            left.append(np.linalg.det(localize(pose, covariance, expected, landmark, _noise(expected[1]))[1]))
        number = int(np.argmin(left))
        measured, noise = sensor.measure(number)
        pose, covariance = localize(pose, covariance, measured, landmarks[number], noise)
    return pose, covariance


def better(pose: Array, covariance: Array, landmarks: Array, sensor: Any) -> Any:
    """Choose by the mean over sampled poses, and fit all measurements together."""
    rng = np.random.default_rng(0)
    prior, information = pose.copy(), np.linalg.inv(covariance)
    taken: list[tuple[Array, Array, Array]] = []
    for _ in range(3):
        samples = rng.multivariate_normal(pose, covariance, SAMPLES)
        number = int(np.argmax([_gain(samples, covariance, landmark) for landmark in landmarks]))
        taken.append((landmarks[number], *sensor.measure(number)))
        pose, covariance = _fit(prior, information, taken)
    return pose, covariance


def _gain(samples: Array, covariance: Array, landmark: Array) -> float:
    """Return the expected logarithm by which a measurement shrinks the covariance, with H at each sample."""
    gains = []
    for sample in samples:
        slopes = _jacobian(sample, landmark)
        noise = _noise(float(np.hypot(*(landmark - sample[:2]))))
        gains.append(np.log(np.linalg.det(slopes @ covariance @ slopes.T + noise) / np.linalg.det(noise)))
    return float(np.mean(gains))


def _fit(prior: Array, information: Array, taken: list[tuple[Array, Array, Array]]) -> tuple[Array, Array]:
    """Return the most probable pose after all measurements, by Gauss-Newton from several starts, and its covariance."""
    root, fits = np.linalg.cholesky(information).T, []
    weighted = [(*each, np.linalg.inv(np.linalg.cholesky(each[2]))) for each in taken]

    def linearised(pose: Array) -> tuple[Array, Array]:
        rows, residuals = [root], [root @ (pose - prior)]
        for landmark, measured, _, weight in weighted:
            off = range_and_bearing(pose, landmark[None])[0] - measured
            off[0] = wrap_angle(off[0])
            rows.append(weight @ _jacobian(pose, landmark))
            residuals.append(weight @ off)
        return np.concatenate(rows), np.concatenate(residuals)

    for turn in (0.0, 0.5, -0.5):
        pose = prior + (0.0, 0.0, turn)
        for _ in range(ITERATIONS):
            J, off = linearised(pose)
            pose = pose - np.linalg.solve(J.T @ J, J.T @ off)
        J, off = linearised(pose)
        fits.append((off @ off, pose, np.linalg.inv(J.T @ J)))
    _, (x, y, heading), covariance = min(fits, key=lambda fit: fit[0])
    return np.array([x, y, wrap_angle(heading)]), covariance


LOOK_ENTRIES = {
    "no measurement": no_measurement,
    "the three nearest": nearest,
    "the reference": greedy,
    "a better filter": better,
}
