"""Exercises of lesson 12, beyond the paper: cases, common mistakes, and alternative solutions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.ndimage import binary_dilation, uniform_filter
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.stats import multivariate_normal

from nao_course.exercises import (
    Case,
    Close,
    Each,
    Exact,
    Exercise,
    LessonPlan,
    Property,
    Question,
    Sibling,
    Written,
)
from nao_course.geometry import Pose, wrap_angle
from nao_course.instructor.authoring.mistakes import catalogue
from nao_course.lessons.beyond import personal_numbers
from nao_course.lessons.beyond.particles import LogWeights, systematic
from nao_course.lessons.beyond.planning import Option
from nao_course.slam import range_and_bearing
from nao_course.student import earlier

Array = npt.NDArray[Any]
TURN = 2 * np.pi
expected_measurement = earlier("05:expected_measurement")
measurement_jacobian_landmark = earlier("05:measurement_jacobian_landmark")
warp2pi = earlier("07:warp2pi")
predict = earlier("07:predict")
update_landmarks = earlier("07:update_landmarks")


def correlated(rng: np.random.Generator, size: int, scale: float) -> Array:
    """Return a covariance (size, size) with correlated entries."""
    root = rng.normal(0.0, 0.4, (size, size)) + np.eye(size) * rng.uniform(0.6, 1.2, size)
    return scale**2 * (root @ root.T)


def _floats(*values: Any) -> tuple[Array, ...]:
    return tuple(np.array(each, dtype=float) for each in values)


def _tabled(table: dict[str, Any], drawn: Callable[[], tuple[Array, ...]]) -> list[Case]:
    """Return the cases of a table whose last column holds variances; a case that is None is drawn."""
    return [
        Case(_floats(*given[:-1], np.diag(given[-1])) if given else drawn(), name)
        for name, given in table.items()
    ]


def _innovation(pose: Array, landmark: Array, measurement: Array) -> Array:
    off = measurement - range_and_bearing(pose, landmark)
    off[..., 0] = wrap_angle(off[..., 0])
    return off


# --- 12.1 resample ---
def _counted(weights: Array, rng: np.random.Generator) -> Array:
    ends = np.append(0.0, np.cumsum(weights))
    ends[-1] = 1.0
    copies = np.diff(np.ceil(len(weights) * ends - rng.random()))
    return np.repeat(np.arange(len(weights)), copies.astype(int))


def _from_above(weights: Array, rng: np.random.Generator) -> list[int]:
    """Shift the comb from its last tooth, and return the particles in another order."""
    teeth = 1 - (np.arange(len(weights)) + rng.uniform()) / len(weights)
    ends = np.cumsum(weights) / np.sum(weights)
    return list(rng.permutation([int(np.sum(ends < tooth)) for tooth in teeth]))


def _weights(rng: np.random.Generator, n: int, peak: float) -> Array:
    logs = peak * rng.normal(0, 1, n)
    weights = np.exp(logs - logs.max())
    return weights / weights.sum()


def _draws(weights: Array, name: str = "", draws: int = 100) -> Case:
    """Return a case of weights and the seeds to draw with; some seeds occur twice."""
    return Case((weights, [*range(draws), *range(5)]), name)


RESAMPLE = Exercise(
    name="resample",
    points=2,
    public=lambda: [
        _draws(np.array([0.5, 0.1, 0.4]), "three particles"),
        _draws(np.array([0.0, 1.0, 0.0, 0.0]), "one particle with all the weight"),
        _draws(np.full(6, 1 / 6), "six particles of equal weight"),
        _draws(_weights(np.random.default_rng(1), 12, 1.5), "twelve particles"),
        _draws(np.array([1.0]), "a single particle"),
    ],
    hidden=lambda rng: [
        _draws(_weights(rng, n, peak), draws=draws)
        for n, peak, draws in ((3, 0.5, 300), (5, 0.5, 300), (20, 1.0, 200), (50, 2.0, 100), (200, 3.0, 30))
    ],
    comparison=Property(systematic),
    driver="each_seed",
    hints=(
        "The end of each interval is the sum of all weights up to and including its own: np.cumsum. A tooth belongs to the first interval whose end is beyond it.",
        "teeth = (np.arange(n) + rng.random()) / n. np.searchsorted finds the interval of each tooth. The last end can be slightly below 1 because of rounding, so divide all ends by it.",
    ),
    sibling=Sibling(
        "Songs fill a playlist as weights fill the interval from 0 to 1: np.cumsum returns their ends, and np.searchsorted finds the song that is played at a given time.",
        """
        import numpy as np

        minutes = np.array([10, 3, 22, 15])
        until = minutes.cumsum()
        print(until, np.searchsorted(until, [0, 12, 15, 30, 45], side="right"))
        """,
        "[10 13 35 50] [0 1 2 2 3]",
    ),
    mistakes=catalogue("""
        each tooth drawn: (np.arange(n) + rng.random()) / n => np.sort(rng.random(n))
            You draw each tooth separately. In systematic resampling a single random number shifts the whole comb, and its teeth are 1/N apart (equation 12.1).
        a shift for each tooth: rng.random() => rng.random(n)
            You draw a separate shift for each tooth. This is stratified resampling, which can copy a particle once too often. Draw one number for all teeth.
        teeth one apart: (np.arange(n) + rng.random()) / n => np.arange(n) + rng.random() / n
            Your teeth are 1 apart, but the whole line has length 1, so all teeth except the first are outside. In (q + j) / N both q and j are divided by N.
        N teeth on the ends: (np.arange(n) + rng.random()) / n => np.linspace(0, 1, n) + rng.random() / n
            The teeth of np.linspace(0, 1, N) are 1/(N - 1) apart, and the last one is at 1. Use np.arange(N) / N, whose spacing is 1/N.
        rng.choice: + return rng.choice(len(weights), len(weights), p=weights)
            rng.choice draws each particle independently, so good particles can be lost. Systematic resampling copies each particle floor(N w) or ceil(N w) times.
        shifted by up to one: (np.arange(n) + rng.random()) / n => np.arange(n) / n + rng.random()
            Your shift goes up to 1, which moves teeth off the line. The largest shift is 1/N: rng.random() / N.
        shift divided twice: rng.random() => rng.random() / n
            Your shift is nearly the same in each call: either it goes only up to 1/N^2, because you divide by N twice, or it does not come from rng. Draw q with rng.random(), and divide it by N once.
        half of the shift: rng.random() => 0.5 * rng.random()
            Your shift goes only up to 1/(2 N), so some parts of the line are never reached. Draw q from 0 to 1 and divide it by N.
        whole copies, the others drawn: + n = len(weights)
            + copies = np.floor(n * weights).astype(int)
            + others = n * weights - copies
            + drawn = rng.choice(n, n - copies.sum(), p=others / others.sum() if others.sum() else None)
            + return np.concatenate([np.repeat(np.arange(n), copies), drawn])
            You copy each particle floor(N w) times and draw the others with rng.choice. This is residual resampling, which can copy a particle more than ceil(N w) times. Shift one comb by a single random number instead.
        one interval on: + n, kept, i = len(weights), [], 0
            + ends = np.cumsum(weights)
            + for tooth in (np.arange(n) + rng.random()) / n:
            +     if tooth > ends[i]:
            +         i += 1
            +     kept.append(i)
            + return np.array(kept)
            You go on by at most one interval for each tooth. The next tooth can lie several intervals farther on: use while instead of if.
        teeth from one: np.arange(n) + rng.random() => np.arange(1, n + 1) + rng.random()
            Your teeth are 1/N too far to the right, and the last one is beyond the line. In equation 12.1 j goes from 0 to N - 1.
        not shifted: (np.arange(n) + rng.random()) / n => np.arange(n) / n
            Your comb always starts at 0, so the first particle is kept even if its weight is tiny. Shift the comb by a random number.
        in the middle: rng.random() => 0.5
            ends[-1], teeth) => ends[-1], teeth, side="right")
            Your comb is always at the same place, so a particle with a small weight is kept always or never. Shift the comb by a random number.
        weights for ends: ends / ends[-1], teeth => weights, teeth
            You search for the teeth among the weights. An interval ends at the sum of all weights up to its own: np.cumsum.
        the teeth themselves: np.searchsorted(ends / ends[-1], teeth) => teeth
            You return the positions of the teeth. Return the index of the interval that contains each tooth: np.searchsorted.
        rounded: + return np.repeat(np.arange(len(weights)), np.round(len(weights) * weights).astype(int))
            You return the same particles each time, as rounding N w or a fixed comb does. A particle of weight 0.3 / N can then never survive. Shift the comb by a random number.
        weights kept: np.searchsorted(ends / ends[-1], teeth) => weights[np.searchsorted(ends / ends[-1], teeth)]
            You return weights. Return the indices of the particles instead.
        from the end: np.cumsum(weights) => np.cumsum(weights[::-1])
            Your intervals are in reverse order. The first interval belongs to the first particle.
        counts: np.searchsorted(ends / ends[-1], teeth) => np.bincount(np.searchsorted(ends / ends[-1], teeth), minlength=n)
            You return how often each particle is kept. Return N indices instead; np.repeat converts counts into indices.
        one too many: ends[-1], teeth) => ends[-1], teeth) + 1
            Your indices are one too large. The first particle has index 0.
        one too few: ends[-1], teeth) => ends[-1], teeth) - 1
            Your indices are one too small. np.searchsorted already returns 0 for a tooth in the first interval.
        sorted: np.cumsum(weights) => np.cumsum(np.sort(weights)[::-1])
            You sort the weights first, so your indices belong to other particles. Lay the intervals in the order of the particles.
    """),
    alternatives={
        "comparing all": lambda weights, rng: np.sum(
            (np.arange(len(weights))[:, None] + rng.random()) / len(weights) >= np.cumsum(weights)[:-1],
            axis=1,
        ),
        "counting teeth": _counted,
        "another comb, in another order": _from_above,
    },
    equivalents={
        f"return np.searchsorted({ends}, teeth)": "the last end is 1 up to rounding"
        for ends in ("ends", "ends * ends[-1]", "ends ** ends[-1]")
    },
)


# --- 12.2 weigh ---
def _one_by_one(particles: Array, landmark: Array, measurement: Array, R: Array) -> list[float]:
    logs = []
    for x, y, theta in particles:
        away = complex(*landmark) - complex(x, y)
        bearing = np.angle(np.exp(1j * (measurement[0] + theta)) * away.conjugate())
        off = np.array([bearing, measurement[1] - abs(away)])
        logs.append(-0.5 * (off @ np.linalg.solve(R, off) + np.linalg.slogdet(R)[1] + 2 * np.log(TURN)))
    return logs


def _by_root_of_R(particles: Array, landmark: Array, measurement: Array, R: Array) -> Array:
    root = np.linalg.cholesky(R)
    scaled = np.linalg.solve(root, _innovation(particles, landmark, measurement).T)
    return -0.5 * np.square(scaled).sum(axis=0) - np.log(TURN * np.diag(root).prod())


def _by_density(particles: Array, landmark: Array, measurement: Array, R: Array) -> Any:
    off = _innovation(particles, landmark, measurement)
    return multivariate_normal(np.zeros(2), R).logpdf(off)  # a single number for one particle


def _crowd(rng: np.random.Generator, n: int) -> Array:
    return np.column_stack([rng.uniform(0, 3, n), rng.uniform(-2, 2, n), rng.uniform(-np.pi, np.pi, n)])


def _measured(rng: np.random.Generator, particles: Array) -> tuple[Array, Array, Array, Array]:
    landmark = rng.uniform((0, -2), (3, 2))
    seen = range_and_bearing(particles[0], landmark) + rng.normal(0, (0.03, 0.1))
    R = correlated(rng, 2, 1.0) * np.outer((0.05, 0.2), (0.05, 0.2))
    seen[0] = wrap_angle(seen[0])
    return particles, landmark, seen, R


_BESIDE = [[0, 0, 0], [0.1, 0, 0], [0, 0, 0.1], [0, 0.2, -0.1]]
_APART = [[0, -2, 0.9], [2.4, 1.2, 0.9]]
# Particles, landmark, measurement, and variances of bearing and range.
_WEIGHED: dict[str, Any] = {
    "one particle, as in the docstring": ([[0, 0, 0]], [2, 0], [0.02, 2.1], [0.0004, 0.01]),
    "four particles side by side": (_BESIDE, [2, 0.5], [0.25, 2], [0.001, 0.02]),
    "facing along the negative x axis": ([[2, 0, 3.1], [2, 0, -3.1]], [1, 0], [0.05, 1], [0.01, 0.01]),
    "a landmark right behind": ([[2, 0, 0], [1.9, 0, 0.1]], [1, 0.05], [-3.12, 1], [0.01, 0.01]),
    "correlated errors of bearing and range": None,
    "a particle far from the true pose": (_APART, [3, 2], [0.05, 1.05], [0.01, 0.09]),
    "a very inaccurate measurement": (_BESIDE, [1, 1], [0.8, 1.4], [1, 2]),
}


def _weigh_public() -> list[Case]:
    rng = np.random.default_rng(12)
    cases = _tabled(_WEIGHED, lambda: _measured(rng, _crowd(rng, 8)))
    for particles, landmark, measurement, _ in (case.args for case in cases):
        # The calls of a loop over the particles are recorded like the reference's
        expected = np.array([expected_measurement(each, landmark) for each in particles])
        warp2pi(measurement[0] - expected[:, 0])
        for off in measurement - expected:
            warp2pi(off)
            warp2pi(off[0])
    return cases


def _weigh_hidden(rng: np.random.Generator) -> list[Case]:
    far = np.array([3.0, 2.5]) + rng.normal(0, 0.1, 2)
    measured = [_measured(rng, _crowd(rng, n)) for n in (1, 2, 10, 40, 200)]
    behind = rng.normal((2, 0, 0), 0.02, (6, 3)), (rng.uniform(0.5, 1.4), 0), (rng.choice((3.13, -3.13)), 1)
    away = np.array([[0, -2, 0.5], [3, 2, 0.5]]) + rng.normal(0, 0.1, (2, 3))
    return [
        *map(Case, measured),
        Case((*_floats(*behind), np.diag([0.01, 0.01]))),
        Case((away, far, np.array([0.2, 0.5]), np.diag([0.01, 0.09]))),
    ]


WEIGH = Exercise(
    name="weigh",
    points=2,
    stars=2,
    uses=("05:expected_measurement", "07:warp2pi"),
    public=_weigh_public,
    hidden=_weigh_hidden,
    comparison=LogWeights(rtol=1e-6, atol=1e-6, names=("your log weights",)),
    equivalents={
        "off = np.column_stack([warp2pi(measurement[0] - bearings), measurement[1] - np.hypot(away[:, 1], away[:, 0])])": "a hypotenuse has its sides in any order"
    },
    hints=(
        "nu has one row for each particle: the difference of the bearings, wrapped, and the difference of the ranges. The expected bearing is the arctan2 of the offset from particle to landmark, minus the particle's heading.",
        "The quadratic form of each row is np.sum(nu @ np.linalg.inv(R) * nu, axis=1). The second term is a single number: np.log(np.linalg.det(2 * np.pi * R)).",
    ),
    sibling=Sibling(
        "A quadratic form for each row needs the products of the rows with the matrix, times the rows, added up along each row.",
        """
        import numpy as np

        M = np.array([[2.0, 0.5], [0.5, 1.0]])
        speeds = np.array([[1.0, 0.0], [0.0, 3.0], [2.0, -1.0]])
        momenta = speeds @ M
        print((momenta * speeds).sum(axis=1) / 2)
        print([float(v @ M @ v) / 2 for v in speeds])
        """,
        """
        [1.  4.5 3.5]
        [1.0, 4.5, 3.5]
        """,
    ),
    mistakes=catalogue("""
        no wrap: warp2pi(measurement[0] - bearings) => measurement[0] - bearings
            Your difference of bearings is not wrapped. A difference of 6.2 rad is nearly zero as a direction, but it makes the weight of a correct particle tiny.
        the difference not wrapped: warp2pi(measurement[0] - bearings) => measurement[0] - warp2pi(bearings)
            Your expected bearing is wrapped, but your difference is not. 3.1 and -3.1 rad are 0.08 rad apart, not 6.2, so wrap the difference.
        weights, no logarithms: return -0.5 => logs = -0.5
            + return np.exp(logs)
            You return densities. Return their logarithms, because a product of many densities underflows to 0.
        the logarithm at last: return -0.5 => logs = -0.5
            + return np.log(np.exp(logs))
            Some of your log weights are -inf, because you computed the density first and it underflowed to 0. Compute the logarithm directly (equation 12.2).
        one pose: + x, y, theta = particles
            + particles = np.column_stack([x, y, theta])
            You use all particles as one pose. Each row is a pose, so particles[:, 0] holds all x. expected_measurement accepts only one pose: call it in a loop, or compute bearings and ranges from the columns.
        one length for all: np.hypot(away[:, 0], away[:, 1]) => np.linalg.norm(away) + 0 * bearings
            np.linalg.norm returns one number for the whole array. With axis=1 it returns one number for each row.
        the range wrapped, too: measurement[1] - np.hypot(away[:, 0], away[:, 1]) => warp2pi(measurement[1] - np.hypot(away[:, 0], away[:, 1]))
            You also wrap the difference of the ranges. A range is not an angle, so wrap only nu[:, 0].
        all pairs: np.sum(off @ np.linalg.inv(measurement_covariance) * off, axis=1) => off @ np.linalg.inv(measurement_covariance) @ off.T
            nu @ R^-1 @ nu.T combines every particle with every other one and has shape (N, N). You need only its diagonal: multiply element by element and sum along axis=1.
        the largest taken off: return -0.5 => logs = -0.5
            + return logs - logs.max()
            You subtract the largest log weight. This is done later, for all measurements together; return the values of equation 12.2.
        no half: -0.5 * squares => -squares
            The factor 1/2 of the quadratic form is missing (equation 12.2).
        no determinant: 0.5 * np.log(np.linalg.det(2 * np.pi * measurement_covariance)) => 0
            The second term of equation 12.2 is missing: -1/2 log det(2 pi R). Without it, weights for measurements of different accuracy cannot be compared.
        the determinant without 2 pi: 2 * np.pi * measurement_covariance => measurement_covariance
            You use the determinant of R, but equation 12.2 has the determinant of 2 pi R. In two dimensions it is (2 pi)^2 times as large.
        one 2 pi: np.linalg.det(2 * np.pi * measurement_covariance) => 2 * np.pi * np.linalg.det(measurement_covariance)
            You multiply the determinant by 2 pi. The factor 2 pi applies to each row of R, so in two dimensions the determinant grows by (2 pi)^2.
        the determinant not halved: 0.5 * np.log => np.log
            The factor 1/2 before the logarithm of the determinant is missing (equation 12.2).
        the determinant added: - 0.5 * np.log => + 0.5 * np.log
            You add the term with the determinant, but equation 12.2 subtracts it: a large R makes the density smaller.
        R for its inverse: np.linalg.inv(measurement_covariance) => measurement_covariance
            You multiply by R. The quadratic form contains the inverse of R.
        diagonal only: off @ np.linalg.inv(measurement_covariance) * off => off**2 / np.diag(measurement_covariance)
            You use only the diagonal of R. The errors of bearing and range may be correlated, so the other entries matter, too.
        heading forgotten: - particles[:, 2] => - 0
            A bearing is measured relative to the robot's heading. Subtract the heading from the landmark's direction.
        heading added: - particles[:, 2] => + particles[:, 2]
            You add the heading. The expected bearing is the landmark's direction minus the heading.
        x for y: np.arctan2(away[:, 1], away[:, 0]) => np.arctan2(away[:, 0], away[:, 1])
            The arguments of arctan2 are in the wrong order: y comes first, then x.
        from the landmark: landmark - particles[:, :2] => particles[:, :2] - landmark
            Your vector goes from the landmark to the particle, so your bearings are off by half a turn. Subtract the particle from the landmark.
        summed over particles: axis=1 => axis=0
            You sum over the particles. The rows of nu are particles and its columns are bearing and range: sum over the columns, with axis=1.
        logarithm to the base 10: np.log(np =>> np.log10(np
            You use np.log10. The logarithm of a density is the natural one: np.log.
        normalised: return -0.5 => logs = -0.5
            + return logs - logs.max() - np.log(np.sum(np.exp(logs - logs.max())))
            You normalise the weights. This is done later, for all measurements together; return the values of equation 12.2.
    """),
    alternatives={"a loop": _one_by_one, "a root of R": _by_root_of_R, "SciPy's density": _by_density},
)


# --- 12.3 update_particle_landmark ---
def _by_information(pose: Array, mean: Array, covariance: Array, measurement: Array, R: Array) -> list[Any]:
    H, nu = measurement_jacobian_landmark(pose, mean), _innovation(pose, mean, measurement)
    P = np.linalg.inv(np.linalg.inv(covariance) + H.T @ np.linalg.inv(R) @ H)
    S = R + H @ covariance @ H.T
    log = -0.5 * (nu @ np.linalg.inv(S) @ nu + np.linalg.slogdet(TURN * S)[1])
    return [mean + P @ H.T @ np.linalg.solve(R, nu), P, log]


def _by_root(pose: Array, mean: Array, covariance: Array, measurement: Array, R: Array) -> tuple[Any, ...]:
    H, nu = measurement_jacobian_landmark(pose, mean), _innovation(pose, mean, measurement)
    L = np.linalg.cholesky(H @ covariance @ H.T + R)
    A, e = np.linalg.solve(L, H @ covariance), np.linalg.solve(L, nu)
    return mean + A.T @ e, covariance - A.T @ A, -0.5 * e @ e - np.log(np.diag(L)).sum() - np.log(TURN)


def _by_joseph(pose: Array, mean: Array, covariance: Array, measurement: Array, R: Array) -> tuple[Any, ...]:
    H, nu = measurement_jacobian_landmark(pose, mean), _innovation(pose, mean, measurement)
    S = H @ covariance @ H.T + R
    K = np.linalg.solve(S, H @ covariance).T
    left = np.eye(2) - K @ H
    return mean + K @ nu, left @ covariance @ left.T + K @ R @ K.T, multivariate_normal(cov=S).logpdf(nu)


def _observed(rng: np.random.Generator) -> tuple[Array, ...]:
    pose = np.append(rng.uniform((0, -2), (3, 2)), rng.uniform(-np.pi, np.pi))
    bearing, away = rng.uniform(-np.pi, np.pi), rng.uniform(0.6, 3.5)
    toward = pose[2] + bearing
    mean = pose[:2] + away * np.array([np.cos(toward), np.sin(toward)])
    R = correlated(rng, 2, 1.0) * np.outer((0.05, 0.15), (0.05, 0.15))
    seen = np.array([bearing, away]) + rng.normal(0, (0.08, 0.2))
    seen[0] = wrap_angle(seen[0])
    return pose, mean, correlated(rng, 2, float(rng.uniform(0.05, 0.3))), seen, R


_WIDE, _OBLIQUE = np.diag([0.02, 0.05]), [[0.03, 0.01], [0.01, 0.02]]
# Pose, landmark, its covariance, measurement, and variances of bearing and range.
_UPDATED: dict[str, Any] = {
    "straight ahead, as in the docstring": ([0, 0, 0], [2, 0], 0.03 * np.eye(2), [0, 2.2], [0.0025, 0.01]),
    "a large innovation in bearing": ([0, 0, 0], [2, 0], 0.03 * np.eye(2), [0.1, 2], [0.0025, 0.01]),
    "facing along the negative x axis": ([2, 0, 3.1], [1, -0.1], _WIDE, [-0.05, 1.1], [0.004, 0.02]),
    "a landmark right behind": ([1, 1, 0.5], [-0.2, 0.35], _OBLIQUE, [-3.1, 1.3], [0.004, 0.02]),
    "beside the robot": None,
    "behind it": None,
    "an innovation in range larger than pi": ([0, 0, 0], [2, 0], np.eye(2), [0.1, 5.5], [0.0025, 0.01]),
}


def _little_public() -> list[Case]:
    rng = np.random.default_rng(123)
    return _tabled(_UPDATED, lambda: _observed(rng))


def _little_hidden(rng: np.random.Generator) -> list[Case]:
    x, y = rng.uniform(0.5, 2), rng.uniform(-0.02, 0.02)
    observed = [_observed(rng) for _ in range(8)]
    behind = [0, 0, 0], [-x, y], correlated(rng, 2, 0.1), [-np.sign(y) * 3.13, x + 0.1]
    ahead = [0, 0, 0], [1, 0], correlated(rng, 2, 1.0), [0.1, rng.uniform(4.5, 5.5)]
    return [
        *map(Case, observed),
        *(Case((*_floats(*each), np.diag([0.004, 0.02]))) for each in (behind, ahead)),
    ]


UPDATE_PARTICLE_LANDMARK = Exercise(
    name="update_particle_landmark",
    points=3,
    stars=2,
    uses=("05:expected_measurement", "05:measurement_jacobian_landmark", "07:warp2pi"),
    public=_little_public,
    hidden=_little_hidden,
    comparison=Each(
        (
            Close(atol=1e-8, names=("your mean",)),
            Close(atol=1e-8, names=("your covariance",)),
            Close(atol=1e-6, names=("your log weight",)),
        )
    ),
    hints=(
        "This is lesson 06's update with the landmark as the state. H is measurement_jacobian_landmark alone, because the pose is assumed to be true.",
        "Compute nu, H, S and K, then the three results, each in one line. The log weight uses S and the nu from before the update.",
    ),
    sibling=Sibling(
        "How probable a measurement was is computed with the prediction from before the measurement, and the variance of their difference is the sum of both variances.",
        """
        import numpy as np

        rng = np.random.default_rng(4)
        mean, variance, noise, measured = 12.0, 4.0, 1.0, 15.0  # a temperature
        density = np.exp(-((measured - mean) ** 2) / (2 * (variance + noise)))
        density /= np.sqrt(2 * np.pi * (variance + noise))
        readings = rng.normal(mean, np.sqrt(variance), 400000) + rng.normal(0, np.sqrt(noise), 400000)
        near = np.mean(np.abs(readings - measured) < 0.1) / 0.2
        print(f"{density:.2f}, and by counting {near:.2f}")
        """,
        "0.07, and by counting 0.07",
    ),
    mistakes=catalogue("""
        no wrap: warp2pi(nu[0]) => nu[0]
            The bearing of your innovation is not wrapped. Although expected_measurement returns a wrapped bearing, the difference can still be off by a full turn: warp2pi(nu[0]).
        range wrapped, too: nu[0] = warp2pi(nu[0]) => nu = warp2pi(nu)
            You also wrap the range. A range is not an angle, so wrap only nu[0].
        weighed by R: solve(S, nu) => solve(measurement_covariance, nu)
            np.pi * S => np.pi * measurement_covariance
            Your weight uses R. The landmark is uncertain as well, so use S of equation 12.3.
        the gain by R: np.linalg.inv(S) => np.linalg.inv(measurement_covariance)
            Your gain uses the inverse of R. It needs the inverse of S, which includes the uncertainty of the landmark.
        no R in S: H.T + measurement_covariance => H.T
            Your S does not include R, as if the measurement had no noise.
        away from the measurement: mean + K @ nu => mean - K @ nu
            Your landmark moves away from the measurement. The update is l' = l + K nu, where nu is measured minus expected.
        weighed by the updated landmark: return mean + K @ nu, covariance - K @ H @ covariance => return mean, covariance
            np.linalg.inv(S) => np.linalg.inv(S)
            + mean, covariance = mean + K @ nu, covariance - K @ H @ covariance
            + nu = measurement - expected_measurement(pose, mean)
            + nu[0] = warp2pi(nu[0])
            + S = H @ covariance @ H.T + measurement_covariance
            You compute the weight from the mean and the covariance after the update. The weight measures how well the particle predicted the measurement, so use nu and S from before it.
        the covariance kept: covariance - K @ H @ covariance => covariance
            You return the old covariance. The update is P' = P - K H P.
        weighed afterwards: return mean + K @ nu => return mean
            np.linalg.inv(S) => np.linalg.inv(S)
            + mean = mean + K @ nu
            + nu = measurement - expected_measurement(pose, mean)
            You compute the weight from the updated landmark. The weight measures how well the particle predicted the measurement, so use the innovation from before the update.
        no determinant: 0.5 * np.log(np.linalg.det(2 * np.pi * S)) => 0
            The term -1/2 log det(2 pi S) is missing in your log weight. Without it, particles with an uncertain landmark get weights that are too large (equation 12.4).
        the determinant added: - 0.5 * np.log => + 0.5 * np.log
            You add the term with the determinant, but equation 12.4 subtracts it: a large S makes the density smaller.
        H K for K H: K @ H @ covariance => H @ K @ covariance
            You multiply H K. Matrices do not commute: the update is P' = P - K H P.
        the weight first
            return mean + K @ nu, covariance - K @ H @ covariance, float(log_weight) => return float(log_weight), mean + K @ nu, covariance - K @ H @ covariance
            You return the log weight first. The order is mean, covariance, log weight.
        without a weight: K @ H @ covariance, float(log_weight) => K @ H @ covariance
            You return two values. The third is the log weight, the last part of equation 12.4.
        the covariance grows: covariance - K => covariance + K
            Your covariance grows. A measurement reduces the uncertainty: P' = P - K H P.
        the determinant without 2 pi: 2 * np.pi * S => S
            You use the determinant of S, but equation 12.4 has the determinant of 2 pi S. In two dimensions it is (2 pi)^2 times as large.
        one 2 pi: np.linalg.det(2 * np.pi * S) => 2 * np.pi * np.linalg.det(S)
            You multiply the determinant by 2 pi. The factor 2 pi applies to each row of S, so in two dimensions the determinant grows by (2 pi)^2.
        no half: -0.5 * nu => -nu
            The factor 1/2 of the quadratic form is missing (equation 12.4).
        the determinant not halved: 0.5 * np.log => np.log
            The factor 1/2 before the logarithm of the determinant is missing (equation 12.4).
        the determinant, no logarithm: np.log(np.linalg.det(2 * np.pi * S)) => np.linalg.det(2 * np.pi * S)
            You subtract the determinant itself. Equation 12.4 has its logarithm: np.log(np.linalg.det(2 * np.pi * S)).
        R in the quadratic form: solve(S, nu) => solve(measurement_covariance, nu)
            Your quadratic form uses the inverse of R, although the determinant uses S. Use S in both terms of equation 12.4.
        R in the determinant: np.pi * S => np.pi * measurement_covariance
            Your determinant uses R, although the quadratic form uses S. Use S in both terms of equation 12.4.
        quadratic form added: -0.5 * nu => 0.5 * nu
            You add the quadratic form. Equation 12.4 subtracts it: a large innovation makes the measurement less probable.
        the negative of it: float(log_weight) => float(-log_weight)
            Your log weight has the wrong sign. Both terms of equation 12.4 are subtracted.
        entries of I minus K H: covariance - K @ H @ covariance => (np.eye(2) - K @ H) * covariance
            (I - K H) * P multiplies element by element. The matrix product is @.
        nu before K: mean + K @ nu => mean + nu @ K
            nu @ K multiplies with the transpose of K. The update is l' = l + K nu: K @ nu.
        K H alone: covariance - K @ H @ covariance => covariance - K @ H
            You subtract K H. The update subtracts K H P: P' = P - K H P.
        1 minus K H: covariance - K @ H @ covariance => (1 - K @ H) @ covariance
            1 - K @ H subtracts K H from a matrix of ones. Use the identity matrix: (np.eye(2) - K @ H) @ P, which is P - K @ H @ P.
        I minus K H: covariance - K @ H @ covariance => np.eye(2) - K @ H
            You return I - K H. Multiply it by P: (I - K H) P is the same as P - K H P.
        H not transposed in the gain: K = covariance @ H.T => K = covariance @ H
            Your gain is P H S^-1, but it needs the transpose of H: K = P H^T S^-1 (equation 12.3).
        a weight in an array: float(log_weight) => np.array([log_weight])
            Your log weight is an array of shape (1,). Return a single number: nu @ np.linalg.solve(S, nu) is one if nu has the shape (2,).
        H on the other side: S = H @ covariance @ H.T => S = H.T @ covariance @ H
            Your S is H^T P H + R. It must be H P H^T + R (equation 12.3).
        the gain without P: K = covariance @ H.T => K = H.T
            Your gain does not include P. It is K = P H^T S^-1 (equation 12.3).
        entry by entry: H @ covariance @ H.T => H * covariance * H.T
            H * P * H.T multiplies element by element. The matrix product is @.
        the density: float(log_weight) => float(np.exp(log_weight))
            You return the density. Return its logarithm.
        transposed: landmark(pose, mean) => landmark(pose, mean).T
            Your H is transposed. Its rows are bearing and range, its columns x and y.
    """),
    alternatives={"information": _by_information, "a root of S": _by_root, "Joseph's form": _by_joseph},
    equivalents={
        "log_weight = np.linalg.solve(S, nu) @ (-0.5 * nu) - 0.5 * np.log(np.linalg.det(2 * np.pi * S))": "a dot product is commutative",
        "return (mean + K @ nu, covariance - K @ H @ covariance, log_weight)": "NumPy's number is as good as Python's",
    },
)


# --- 12.4 intersect_rays ---
def _passing(a: Array, u: Array, b: Array, v: Array, s: float, t: float) -> tuple[Any, Any]:
    """Return midpoint and distance of two points on the rays, if both are ahead."""
    ends = np.array([a + s * u, b + t * v]) if s >= 0 and t >= 0 else np.full((2, 3), np.nan)
    return ends.mean(axis=0), float(np.linalg.norm(ends[1] - ends[0]))


def _by_lstsq(a: Array, u: Array, b: Array, v: Array) -> Any:
    (s, t), _, rank, _ = np.linalg.lstsq(np.column_stack([u, -v]), b - a, rcond=1e-9)
    return list(_passing(a, u, b, v, *((s, t) if rank == 2 else (-1, -1))))


def _by_cross(a: Array, u: Array, b: Array, v: Array) -> Any:
    n = np.cross(u, v)
    volumes = [np.linalg.det(np.array([b - a, other, n])) for other in (v, u)]
    return _passing(a, u, b, v, *((-1, -1) if n @ n < 1e-12 else volumes / (n @ n)))


def _by_equations(a: Array, u: Array, b: Array, v: Array) -> Any:
    M = np.array([[u @ u, -(v @ u)], [u @ v, -(v @ v)]])
    parallel = abs(np.linalg.det(M)) < 1e-12
    return _passing(a, u, b, v, *((-1, -1) if parallel else np.linalg.solve(M, [(b - a) @ u, (b - a) @ v])))


def _unit(vector: Any) -> Array:
    return np.asarray(vector, dtype=float) / np.linalg.norm(vector)


def _eyes(rng: np.random.Generator, apart: float) -> tuple[Array, ...]:
    a = np.array([0.05, 0.0, 0.52]) + rng.normal(0, 0.01, 3)
    b = a - (0.0, 0.0, apart)
    place = np.array([rng.uniform(0.8, 4), rng.uniform(-1, 1), 0.0])
    return a, _unit(place - a + rng.normal(0, 0.005, 3)), b, _unit(place - b + rng.normal(0, 0.005, 3))


# Origins and directions of two rays.
_RAYS = {
    "as in the docstring": ([0, 0, 1], [0.8, 0, -0.6], [0, 0.2, 0], [1, 0, 0]),
    "two rays that meet": ([0, 0, 0], [1, 1, 0], [2, 0, 0], [-1, 1, 0]),
    "both cameras of a robot": ([0.05, 0, 0.52], [2, 0, -0.5], [0.05, 0, 0.47], [2, 0, -0.46]),
    "parallel rays": ([0, 0, 0], [1, 0, 0], [0, 0, 0.05], [1, 0, 0]),
    "diverging rays": ([0, 0, 0], [1, 0, 0], [0, 0, 0.05], [1, 0, 0.1]),
    "the second ray points away": ([0, 0, 0], [1, 0, 0], [1, 0.5, 0], [0, 1, 0]),
    "the first ray points away": ([1, 0.5, 0], [0, 1, 0], [0, 0, 0], [1, 0, 0]),
    "parallel up to rounding": ([0, 0, 0], [2, -1, 0], [0, 0, 0.05], [2, -1, 0]),
    "face to face": ([0, 0, 0], [2, -1, 0], [2, -1, 0], [-2, 1, 0]),
}


def _rays_public() -> list[Case]:
    rng = np.random.default_rng(124)
    return [
        *(Case((*_floats(a), _unit(u), *_floats(b), _unit(v)), name) for name, (a, u, b, v) in _RAYS.items()),
        Case(_wide(rng), "nearby rays at a wide angle"),
        Case(_eyes(rng, 0.2), "rays that do not meet"),
        Case(_narrow(5.0), "a landmark 100 m away"),
    ]


def _narrow(apart: float) -> tuple[Array, ...]:
    """Return two rays from close origins that meet far away: 1 - c^2 is about 1e-7."""
    a, b, place = np.array([0.05, 0, 0.5]), np.array([0.05, 0, 0.5 - apart / 100]), np.array([100.0, 0, 0])
    return a, _unit(place - a), b, _unit(place - b)


def _side_by_side(rng: np.random.Generator) -> tuple[Array, ...]:
    """Return two parallel rays; the dot product of their directions differs from 1 by rounding."""
    a = np.array([0.05, 0.0, 0.52])
    while True:
        u = _unit([*rng.uniform((1, -1), (4, 1)), 0])
        if u @ u != 1:
            return a, u, a - (0.0, 0.0, rng.uniform(0.03, 0.5)), u.copy()


def _wide(rng: np.random.Generator) -> tuple[Array, ...]:
    """Return two rays at a wide angle that pass each other less than a metre away."""
    a, u = rng.normal(0, 1, 3), _unit(rng.normal(0, 1, 3))
    side = _unit(np.cross(u, rng.normal(0, 1, 3)))
    v = _unit(side + rng.uniform(0.2, 0.6) * rng.choice((-1, 1)) * u)
    near = a + rng.uniform(0.2, 0.8) * u + rng.uniform(0.02, 0.1) * np.cross(u, side)
    return a, u, near - rng.uniform(0.2, 0.8) * v, v


def _face_to_face(rng: np.random.Generator) -> tuple[Array, ...]:
    a, u, _, _ = _side_by_side(rng)
    return a, u, a + rng.uniform(1, 3) * u, -u


def _rays_hidden(rng: np.random.Generator) -> list[Case]:
    met = [Case(_eyes(rng, float(apart))) for apart in (0.05, 0.3, 0.5, -0.4, 0.2, 0.8)]
    a, u, b, v = _eyes(rng, 0.4)
    c, w, d, _ = _eyes(rng, 0.5)
    return [
        *met,
        Case((a, -u, b, -v)),
        Case((c, w, d, _unit(w + (0.0, 0.0, -0.2)))),
        *(Case(case) for case in _one_behind(rng)),
        Case(_side_by_side(rng)),
        Case(_face_to_face(rng)),
        Case(_narrow(rng.uniform(4, 6))),
        *(Case(_wide(rng)) for _ in range(3)),
    ]


def _one_behind(rng: np.random.Generator) -> list[tuple[Array, ...]]:
    """Return two cases in which one ray alone points away: first one, then the other."""
    a, u, v = np.zeros(3), np.array([1.0, 0, 0]), _unit([rng.uniform(-0.3, 0.3), 1, rng.uniform(-0.3, 0.3)])
    meet = np.array([rng.uniform(0.5, 2), 0.0, rng.uniform(0.01, 0.1)])
    b = meet + rng.uniform(0.5, 2) * v
    return [(a, u, b, v), (b, v, a, u)]


INTERSECT_RAYS = Exercise(
    name="intersect_rays",
    points=2,
    stars=2,
    public=_rays_public,
    hidden=_rays_hidden,
    comparison=Each((Close(atol=1e-7, names=("your point",)), Close(atol=1e-8, names=("your gap",)))),
    hints=(
        "Let B be the vector from origin a to origin b, and c the dot product of the directions. Equation 12.5 becomes two lines in t_a and t_b, because each direction times itself is 1.",
        "t_a = (B.d_a - c B.d_b) / (1 - c^2) and t_b = (c B.d_a - B.d_b) / (1 - c^2). Then compute the two points, their midpoint and their distance.",
    ),
    sibling=Sibling(
        "At the closest point a small change along the direction does not change the distance, so a dot product is zero, and this is an equation for the unknown factor: here for two ships.",
        """
        import numpy as np

        apart, closing = np.array([6.0, 2.0]), np.array([-3.0, 1.0])  # km, and km/h of one seen from the other
        hours = -(apart @ closing) / (closing @ closing)  # (apart + hours closing) . closing = 0
        nearest = apart + hours * closing
        print(f"{np.linalg.norm(nearest):.2f} km after {hours:.1f} h", round(abs(nearest @ closing), 6))
        """,
        "3.79 km after 1.6 h 0.0",
    ),
    mistakes=catalogue("""
        on the first ray: (a + b) / 2 => a
            Your point is on the first ray. Both rays are equally uncertain, so return the midpoint between them.
        on the second ray: (a + b) / 2 => b
            Your point is on the second ray. Both rays are equally uncertain, so return the midpoint between them.
        followed backwards: t_a < 0 or t_b < 0 => False
            You return a point behind a camera. If t_a or t_b is negative, return NaN.
        t_a alone: t_a < 0 or t_b < 0 => t_a < 0
            You check only t_a. If t_b is negative, the point is behind the other camera, so return NaN as well.
        parallel by rounding: 1 - c**2 < 1e-12 => False
            You return a point for parallel rays. Because of rounding, 1 - c^2 is about 1e-16 and hardly ever exactly 0. Return NaN if it is below 1e-12.
        nothing checked: 1 - c**2 < 1e-12 => False
            t_a < 0 or t_b < 0 => False
            Two checks are missing: whether 1 - c^2 is nearly 0, and whether t_a or t_b is negative. Return NaN in both cases.
        one NaN: np.full(3, np.nan) =>> np.nan
            If there is no point, you return a single NaN for it. The point still has three coordinates: np.full(3, np.nan).
        NaN alone: np.full(3, np.nan), np.nan =>> np.nan
            If there is no point, you return only one value. Return two: np.full(3, np.nan) for the point and np.nan for the length.
        None: np.full(3, np.nan), np.nan =>> None, None
            If there is no point, you return None. Return np.full(3, np.nan) for the point and np.nan for the length.
        None if parallel: if 1 - c**2 < 1e-12: => if 1 - c**2 < 1e-12:
            +     return None
            If the rays are parallel, you return None. Return two values: np.full(3, np.nan) for the point and np.nan for the length.
        None alone: np.full(3, np.nan), np.nan =>> None
            If there is no point, you return None. Return two values: np.full(3, np.nan) for the point and np.nan for the length.
        c near 1 alone: 1 - c**2 < 1e-12 => 1 - c < 1e-12
            Rays in opposite directions are parallel as well, with c = -1. Check 1 - c^2, which is 0 in both cases.
        too soon parallel: 1e-12 => 1e-6
            You treat rays as parallel too early. Two rays that meet at a distance of 100 m still have a point; the limit for 1 - c^2 is 1e-12.
        t_b alone: t_a < 0 or t_b < 0 => t_b < 0
            You check only t_b. If t_a is negative, the point is behind the other camera, so return NaN as well.
        both behind: t_a < 0 or t_b < 0 => t_a < 0 and t_b < 0
            You return NaN only if t_a and t_b are both negative. One negative value is enough: use or instead of and.
        solved unchecked: 1 - c**2 < 1e-12 => False
            t_b = (c * (B @ direction_a) - B @ direction_b) / (1 - c**2) => pass
            t_a = (B @ direction_a - c * (B @ direction_b)) / (1 - c**2) => A = np.array([direction_a, -direction_b])
            + t_a, t_b = np.linalg.solve((A @ A.T) * [[1, 1], [-1, -1]], [B @ direction_a, B @ direction_b])
            np.linalg.solve raises an error for parallel rays, because the matrix is singular. Check 1 - c^2 before you solve.
        c not squared: c**2 =>> c
            Your denominator is 1 - c. Solve equation 12.5 again: the denominator is 1 - c^2.
        c not squared below: / (1 - c**2) =>> / (1 - c)
            You divide by 1 - c. The square is missing: both denominators are 1 - c^2.
        t_b's sign: t_b = (c * (B @ direction_a) - B @ direction_b) => t_b = (B @ direction_b - c * (B @ direction_a))
            Your t_b has the wrong sign, so you return NaN for points ahead and a value for a point behind one camera. In the second part of equation 12.5 t_b has the factor +1: put your solution back into it.
        t_b's sign, not checked: t_b = (c * (B @ direction_a) - B @ direction_b) => t_b = (B @ direction_b - c * (B @ direction_a))
            t_a < 0 or t_b < 0 => False
            Your t_b has the wrong sign, so your second point lies behind its camera. In the second part of equation 12.5 t_b has the factor +1: put your solution back into it. Then return NaN if t_a or t_b is negative.
        t_a's sign: t_a = (B @ direction_a - c * (B @ direction_b)) => t_a = (c * (B @ direction_b) - B @ direction_a)
            Your t_a has the wrong sign, so you return NaN for points ahead. In the first part of equation 12.5 t_a has the factor -1: put your solution back into it.
        both signs: B, c = origin_b - origin_a => B, c = origin_a - origin_b
            Your t_a and t_b both have the wrong sign, so you return NaN for points ahead and a point for rays that meet behind the cameras. The baseline is B = o_b - o_a, and the denominator is 1 - c^2.
        t_a's sign, not checked: t_a = (B @ direction_a - c * (B @ direction_b)) => t_a = (c * (B @ direction_b) - B @ direction_a)
            t_a < 0 or t_b < 0 => False
            Your t_a has the wrong sign, so your first point lies behind its camera. In the first part of equation 12.5 t_a has the factor -1: put your solution back into it. Then return NaN if t_a or t_b is negative.
        both signs, not checked: B, c = origin_b - origin_a => B, c = origin_a - origin_b
            t_a < 0 or t_b < 0 => False
            Your t_a and t_b both have the wrong sign, so your points lie behind the cameras. The baseline is B = o_b - o_a, and the denominator is 1 - c^2. Then return NaN if t_a or t_b is negative.
        t_b's sign, nothing checked: t_b = (c * (B @ direction_a) - B @ direction_b) => t_b = (B @ direction_b - c * (B @ direction_a))
            1 - c**2 < 1e-12 => False
            t_a < 0 or t_b < 0 => False
            Your t_b has the wrong sign: put your solution back into the second part of equation 12.5, where t_b has the factor +1. You also need two checks: return NaN if 1 - c^2 is nearly 0, and if t_a or t_b is negative.
        t_a's sign, nothing checked: t_a = (B @ direction_a - c * (B @ direction_b)) => t_a = (c * (B @ direction_b) - B @ direction_a)
            1 - c**2 < 1e-12 => False
            t_a < 0 or t_b < 0 => False
            Your t_a has the wrong sign: put your solution back into the first part of equation 12.5, where t_a has the factor -1. You also need two checks: return NaN if 1 - c^2 is nearly 0, and if t_a or t_b is negative.
        both signs, nothing checked: B, c = origin_b - origin_a => B, c = origin_a - origin_b
            1 - c**2 < 1e-12 => False
            t_a < 0 or t_b < 0 => False
            Your t_a and t_b both have the wrong sign: the baseline is B = o_b - o_a, and the denominator is 1 - c^2. You also need two checks: return NaN if 1 - c^2 is nearly 0, and if t_a or t_b is negative.
        t_a for t_b: origin_a + t_a * direction_a, origin_b + t_b * direction_b => origin_a + t_b * direction_a, origin_b + t_a * direction_b
            You exchange t_a and t_b. The first ray is at o_a + t_a d_a, and the second at o_b + t_b d_b.
        a sign in the sum: (c * (B @ direction_a) - B @ direction_b) => (c * (B @ direction_a) + B @ direction_b)
            Your t_b adds the two terms, but B . d_b has a minus sign. Solve the second part of equation 12.5 again.
        from the origin: (a + b) / 2 => (t_a * direction_a + t_b * direction_b) / 2
            Your point does not include the origins of the rays: it is between o_a + t_a d_a and o_b + t_b d_b.
        half of the length: np.linalg.norm(b - a) => np.linalg.norm(b - a) / 2
            Your length is the distance from the midpoint to a ray. Return the distance between the rays, which is twice as long.
        the sum: (a + b) / 2 => a + b
            Your point is the sum of both points. The midpoint is half of it.
        the vector: float(np.linalg.norm(b - a)) => b - a
            Your second value is the vector between the rays. Return its length: np.linalg.norm.
        the square of it: np.linalg.norm(b - a) => np.linalg.norm(b - a) ** 2
            Your length is squared. Return its square root.
    """),
    alternatives={"least squares": _by_lstsq, "a cross product": _by_cross, "two equations": _by_equations},
    equivalents={
        "B, c = (origin_b - origin_a, direction_b @ direction_a)": "a dot product is commutative",
        "t_a = (direction_a @ B - c * (B @ direction_b)) / (1 - c ** 2)": "a dot product is commutative",
        "t_a = (B @ direction_a - c * (direction_b @ B)) / (1 - c ** 2)": "a dot product is commutative",
        "t_b = (c * (B @ direction_a) - direction_b @ B) / (1 - c ** 2)": "a dot product is commutative",
        "t_b = (c * (direction_a @ B) - B @ direction_b) / (1 - c ** 2)": "a dot product is commutative",
        "if 1 - c ** 2 <= 1e-12:": "no value in the cases is exactly this number",
        "if t_a <= 0 or t_b < 0:": "no value in the cases is exactly this number",
        "if t_a < 0 or t_b <= 0:": "no value in the cases is exactly this number",
        "a, b = (origin_b + t_b * direction_b, origin_a + t_a * direction_a)": "the midpoint is symmetric",
        "return ((a + b) / 2, float(np.linalg.norm(a - b)))": "a distance is symmetric",
        "return ((a + b) / 2, np.linalg.norm(b - a))": "NumPy's number is as good as Python's",
    },
)


# --- 12.5 find_frontiers, 12.6 travel_steps ---
def _beside(mask: Array) -> Array:
    padded = np.pad(mask, 1)
    return padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:]


def _by_rolling(grid: Array) -> Array:
    unknown, found = grid < 0, np.zeros(grid.shape, dtype=bool)
    found[1:] |= unknown[:-1]
    found[:-1] |= unknown[1:]
    found[:, 1:] |= unknown[:, :-1]
    found[:, :-1] |= unknown[:, 1:]
    return found & (grid == 0)


def _cell_by_cell(grid: Array) -> list[list[bool]]:
    unknown = {tuple(cell) for cell in np.argwhere(grid == -1)}
    beside = [(1, 0), (-1, 0), (0, 1), (0, -1)]
    return [
        [
            bool(value == 0 and any((i + a, j + b) in unknown for a, b in beside))
            for j, value in enumerate(row)
        ]
        for i, row in enumerate(grid)
    ]


def _known(rng: np.random.Generator, rows: int, columns: int) -> Array:
    smooth = uniform_filter(rng.normal(0, 1, (rows, columns)), 3)
    grid = np.where(smooth < np.quantile(smooth, 0.4), -1, 0)
    grid[rng.random(grid.shape) < 0.15] = 1
    return grid


def _frontiers_public() -> list[Case]:
    rng = np.random.default_rng(125)
    ring = np.full((5, 5), -1)
    ring[1:4, 1:4] = 0
    return [
        Case((np.array([[0, 0, -1], [0, 1, -1]]),), "as in the docstring"),
        Case((ring,), "a known area inside the unknown"),
        Case((np.zeros((3, 4), dtype=int),), "everything known and free"),
        Case((np.array([[0, 1, -1], [1, 1, 1], [0, 0, 0]]),), "unknown behind walls"),
        Case((np.array([[-1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]),), "an unknown corner"),
        Case((_known(rng, 8, 11),), "a room"),
    ]


FIND_FRONTIERS = Exercise(
    name="find_frontiers",
    points=2,
    stars=2,
    public=_frontiers_public,
    hidden=lambda rng: [Case((_known(rng, *size),)) for size in ((1, 7), (6, 1), (5, 9), (12, 7), (20, 30))],
    comparison=Exact(),
    hints=(
        "Compare the grid with copies of itself that are shifted by one cell to each of the four sides. Cells that come in from outside are not unknown.",
        "np.pad(grid == -1, 1) adds a border of False, and then padded[:-2, 1:-1] is the row above each cell.",
    ),
    sibling=Sibling(
        "An array is compared with shifted copies of itself, and a border is added first so that every element has neighbours: here peaks of a path through hills.",
        """
        import numpy as np

        height = np.array([5.0, 3.0, 4.0, 8.0, 8.5, 2.0, 6.0])
        padded = np.pad(height, 1, constant_values=-np.inf)
        print((height > padded[:-2]) & (height > padded[2:]))
        """,
        "[ True False False False  True False  True]",
    ),
    mistakes=catalogue("""
        corners too: unknown[1:-1, 2:] => unknown[1:-1, 2:] | unknown[:-2, :-2] | unknown[:-2, 2:] | unknown[2:, :-2] | unknown[2:, 2:]
            You also count diagonal neighbours. A cell has four neighbours: left, right, above and below.
        around the edge: np.pad(grid == -1, 1) => np.pad(grid == -1, 1, mode="wrap")
            Your grid wraps around: np.roll moves the last row before the first one. There are no cells outside the grid.
        from the other end: np.pad(grid == -1, 1) => np.pad(grid == -1, 1)
            + unknown[0, 1:-1], unknown[1:-1, 0] = grid[-1] == -1, grid[:, -1] == -1
            You use the last row as the neighbour above the first row, and the last column as the one left of the first. In Python grid[-1] counts from the end, so check that an index is at least 0.
        without brackets: (grid == 0) & beside => grid == 0 & beside
            In Python & binds more tightly than ==. Put brackets around each comparison: (grid == 0) & beside.
        outside the grid: + found = np.zeros(grid.shape, dtype=bool)
            + for i, j in np.argwhere(grid == 0):
            +     found[i, j] = -1 in (grid[i + 1, j], grid[i - 1, j], grid[i, j + 1], grid[i, j - 1])
            + return found
            In the last row grid[i + 1, j] does not exist, and in the first row grid[i - 1, j] is the last row. Check that a neighbour is inside the grid, or use np.pad.
        edge left out: return (grid == 0) & beside => found = (grid == 0) & beside
            + found[[0, -1]] = found[:, [0, -1]] = False
            + return found
            You return no frontiers at the edge of the grid. Free cells at the edge have neighbours, too, only fewer.
        two sides: unknown[:-2, 1:-1] | unknown[2:, 1:-1] | unknown[1:-1, :-2] | => unknown[2:, 1:-1] |
            You check only the neighbours below and to the right. A cell has four neighbours.
        the outside is unknown: np.pad(grid == -1, 1) => np.pad(grid == -1, 1, constant_values=True)
            You treat cells outside the grid as unknown. They do not exist, so they make no frontier.
        the unknown side: grid == -1, 1 => grid == 0, 1
            (grid == 0) => (grid == -1)
            You return the unknown cells. A frontier is the free cell beside an unknown cell, because the robot can stand there.
        boxes too: (grid == 0) => (grid != -1)
            You also return occupied cells. A frontier is a free cell.
        any cell beside an unknown one: (grid == 0) & beside => beside
            You return all cells beside an unknown cell, also unknown and occupied ones. A frontier is a free cell.
        dilated alone: (grid == 0) & beside => (grid == -1) | beside
            You return the unknown cells and all their neighbours. Keep only the free cells: (grid == 0) & ...
        beside a box: grid == -1 => grid == 1
            You return cells beside boxes. Unknown cells are -1, occupied cells are 1.
        as numbers: (grid == 0) & beside => np.argwhere((grid == 0) & beside)
            You return the indices of the cells. Return a boolean mask with the shape of the grid.
    """),
    alternatives={
        "slices": _by_rolling,
        "cell by cell": _cell_by_cell,
        "dilation": lambda grid: binary_dilation(grid == -1) & (grid == 0),
    },
    equivalents={
        **{
            f"beside = unknown[:-2, 1:-1] {a} unknown[2:, 1:-1] {b} unknown[1:-1, :-2] {c} unknown[1:-1, 2:]": "for masks, + means or"
            for a, b, c in ("+||", "|+|", "||+")
        },
        "return (grid == 0) * beside": "for masks, * means and",
        "unknown = np.pad(grid <= -1, 1)": "no cell is below -1",
    },
)


def _as_a_whole(free: Array, start: tuple[int, int]) -> Array:
    steps, new, count = np.full(free.shape, -1), np.zeros(free.shape, dtype=bool), 0
    new[start] = True
    while new.any():
        steps[new], count = count, count + 1
        new = _beside(new) & free & (steps < 0)
    return steps


def _by_relaxing(free: Array, start: tuple[int, int]) -> Array:
    cost = np.full(np.add(free.shape, 2), np.inf)
    cost[start[0] + 1, start[1] + 1] = 0
    inner = cost[1:-1, 1:-1]
    for _ in range(free.size):
        best = np.min([cost[:-2, 1:-1], cost[2:, 1:-1], cost[1:-1, :-2], cost[1:-1, 2:]], axis=0) + 1
        inner[free] = np.minimum(inner, best)[free]
    return np.where(np.isfinite(inner), inner, -1).astype(int)


def _by_graph(free: Array, start: tuple[int, int]) -> Array:
    numbers = np.arange(free.size).reshape(free.shape)
    first = np.concatenate([numbers[:, :-1].ravel(), numbers[:-1].ravel()])
    second = np.concatenate([numbers[:, 1:].ravel(), numbers[1:].ravel()])
    both = np.ravel(free)[first] & np.ravel(free)[second]
    edges = coo_array((np.ones(both.sum()), (first[both], second[both])), shape=(free.size, free.size))
    found = dijkstra(edges.tocsr(), directed=False, indices=int(numbers[start]), unweighted=True)
    return np.where(np.isfinite(found), found, -1).astype(int).reshape(free.shape)


def _maze(rng: np.random.Generator, rows: int, columns: int) -> tuple[Array, tuple[int, int]]:
    free = rng.random((rows, columns)) > 0.3
    start = int(rng.integers(rows)), int(rng.integers(columns))
    free[start] = True
    return free, start


def _steps_public() -> list[Case]:
    rng = np.random.default_rng(128)  # a maze in which the order of the neighbours changes no wrong answer
    spiral = np.array([list(row) for row in ("11111", "00001", "11101", "10001", "11111")]) == "1"
    return [
        Case((np.array([[True, False, True], [True, True, True]]), (0, 0)), "as in the docstring"),
        Case((np.ones((4, 6), dtype=bool), (1, 2)), "an empty room"),
        Case((spiral, (0, 0)), "a winding path"),
        Case((np.tile([True, True, False, True], (2, 1)), (1, 0)), "cells that cannot be reached"),
        Case((np.ones((1, 1), dtype=bool), (0, 0)), "a single cell"),
        Case(_maze(rng, 8, 9), "a maze"),
        Case(_winding(21, 12), "a path of more than 127 steps"),
        Case((np.ones((54, 44), dtype=bool), (3, 20)), "an empty room as large as the panel's"),
    ]


def _winding(rows: int, columns: int) -> tuple[Array, tuple[int, int]]:
    """Return lanes with walls between them; each wall has a door at one end."""
    free = np.ones((rows, columns), dtype=bool)
    free[1::2] = False
    free[1::4, -1] = free[3::4, 0] = True
    return free, (0, 0)


TRAVEL_STEPS = Exercise(
    name="travel_steps",
    points=3,
    stars=3,
    public=_steps_public,
    hidden=lambda rng: [
        *(Case(_maze(rng, *size)) for size in ((5, 8), (9, 4), (15, 15), (1, 12), (25, 30))),
        Case(_winding(2 * int(rng.integers(9, 13)) + 1, int(rng.integers(14, 18)))),
    ],
    comparison=Close(rtol=0, atol=1e-9),  # floats are right if they are whole numbers
    hints=(
        "Keep a list of cells that have been reached, but whose neighbours have not been visited yet. Process the cells in the order in which they were reached.",
        "Start with wave = [start]. Take wave.pop(0), give each free neighbour that still has -1 one step more than the cell, and append this neighbour to wave.",
    ),
    sibling=Sibling(
        "What is reached first is processed first, and everybody who is reached for the first time gets one step more than the person before: here friends of friends.",
        """
        knows = {"Ann": ["Ben", "Eva"], "Ben": ["Ann", "Cem"], "Eva": ["Cem"], "Cem": ["Dan"], "Fay": []}
        steps = {"Ann": 0}
        waiting = ["Ann"]
        while waiting:
            person = waiting.pop(0)
            for friend in knows.get(person, []):
                if friend not in steps:  # a later, longer way does not count
                    steps[friend] = steps[person] + 1
                    waiting.append(friend)
        print(steps)  # nobody leads to Fay
        """,
        "{'Ann': 0, 'Ben': 1, 'Eva': 1, 'Cem': 2, 'Dan': 3}",
    ),
    mistakes=catalogue("""
        diagonal steps: (row, column - 1)): => (row, column - 1), *((row + i, column + j) for i in (1, -1) for j in (1, -1))):
            Your steps can be diagonal. A step leads to one of the four neighbours.
        the last first: wave.pop(0) => wave.pop()
            You process the newest cell first, which follows a single path to its end and gives too many steps. Process the oldest cell first: wave.pop(0).
        the last first, upwards: wave.pop(0) => wave.pop()
            ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)) => ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1))
            You process the newest cell first, which follows a single path to its end and gives too many steps. Use wave.pop(0), which takes the oldest cell.
        by recursion: np.full(free.shape, -1) => np.full(free.shape, -1)
            + def follow(row, column, count):
            +     inside = 0 <= row < free.shape[0] and 0 <= column < free.shape[1]
            +     if inside and free[row, column] and steps[row, column] < 0:
            +         steps[row, column] = count
            +         for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            +             follow(row + down, column + right, count + 1)
            + follow(*start, 0)
            + return steps
            Your function follows one path to its end before it tries the others, as recursion does, so it gives too many steps. Keep the cells in a list, and process the oldest one first.
        through boxes: inside and free[cell] => inside
            Your path leads through cells that are not free.
        onto boxes: inside and free[cell] => inside
            wave.append(cell) => wave += [cell] if free[cell] else []
            You give steps to cells that are not free. They cannot be reached, so they must have -1.
        straight: + rows, columns = np.indices(free.shape)
            + return np.where(free, np.abs(rows - start[0]) + np.abs(columns - start[1]), -1)
            You count the rows and columns between the cells. A path around obstacles is longer, and it may not exist.
        0 for unreachable: return steps => return np.maximum(steps, 0)
            Unreachable cells have 0 in your result, as if the robot were already there. They must have -1.
        from one: steps[start] = 0 => steps[start] = 1
            Your start has 1. The robot is already there, so it takes 0 steps.
        index below 0: 0 <= cell =>> cell
            You accept negative indices. In Python index -1 is the last row or column, so your wave leaves the grid at one side and enters it at the opposite side. Check that both indices are at least 0.
        row below 0: inside = 0 <= cell[0] => inside = cell[0]
            You accept negative row indices. In Python index -1 is the last row, so your wave leaves the grid at one side and enters it at the opposite side. Check that the row is at least 0.
        row below 0, columns first: inside = 0 <= cell[0] => inside = cell[0]
            ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)) => ((row, column + 1), (row, column - 1), (row - 1, column), (row + 1, column))
            You accept negative row indices. In Python index -1 is the last row, so your wave leaves the grid at one side and enters it at the opposite side. Check that the row is at least 0. Rows and columns are counted from 0.
        column below 0: and 0 <= cell[1] => and cell[1]
            You accept negative column indices. In Python index -1 is the last column, so your wave leaves the grid at one side and enters it at the opposite side. Check that the column is at least 0.
        one too far: cell[0] < free.shape[0] and 0 <= cell[1] < free.shape[1] => cell[0] <= free.shape[0] and 0 <= cell[1] <= free.shape[1]
            You access cells outside the grid. The last row has index free.shape[0] - 1, so compare with < instead of <=.
        edge left out: 0 <= cell =>> 0 < cell
            Your wave never enters row 0 or column 0. They are inside the grid: compare with 0 <= instead of 0 <.
        shape exchanged: cell[0] < free.shape[0] and 0 <= cell[1] < free.shape[1] => cell[0] < free.shape[1] and 0 <= cell[1] < free.shape[0]
            You compare rows with the number of columns. free.shape is (rows, columns), so a row index is below free.shape[0] and a column index below free.shape[1].
        started with zeros: np.full(free.shape, -1) => np.zeros(free.shape, dtype=int)
            steps[cell] < 0 => not steps[cell]
            You use 0 for cells that have not been reached, but the start has 0 as well. Fill the array with -1 at first.
        started with zeros, boxes at last: np.full(free.shape, -1) => np.zeros(free.shape, dtype=int)
            steps[cell] < 0 => not steps[cell]
            return steps => return np.where(free, steps, -1)
            You use 0 for cells that have not been reached, but the start has 0 as well. Fill the array with -1 at first, and then the boxes need no step of their own.
        outside the grid: if inside and free => if free
            You access neighbours outside the grid: an index that is too large raises an IndexError, and -1 is the last row or column. Check that a neighbour is inside before you access it.
        outside the grid, upwards: if inside and free => if free
            ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)) => ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1))
            You access neighbours outside the grid: an index that is too large raises an IndexError, and -1 is the last row or column. Check that a neighbour is inside before you use its index.
        infinite: return steps => return np.where(steps < 0, np.inf, steps)
            Unreachable cells have infinity in your result. They must have -1.
        NaN for unreachable: return steps => return np.where(steps < 0, np.nan, steps)
            Unreachable cells have NaN in your result. They must have -1.
        the type of free: np.full(free.shape, -1) => np.full_like(free, -1)
            np.full_like(free, -1) has the type of free, so it holds True and False. Use np.full(free.shape, -1).
        no step at the start: steps[start] = 0 => pass
            Your start has no steps at the beginning, so it is counted as a cell that has not been reached. Set steps[start] to 0 before the loop.
        the start visited again: steps[cell] < 0 => (steps[cell] < 0 or cell == tuple(start) and steps[cell] == 0)
            Your start ends with 2 steps, because the wave comes back from its neighbours. Mark the start as visited before the loop.
        row and column exchanged: + start = start[::-1]
            Your wave starts in another cell. start is (row, column), in the same order as steps[row, column].
        one sweep: np.full(free.shape, -1) => np.full(free.shape, free.size)
            while wave: => for row, column in np.argwhere(free):
            row, column = wave.pop(0) => pass
            inside and free[cell] and steps[cell] < 0 => inside
            steps[cell] = steps[row, column] + 1 => steps[row, column] = min(steps[row, column], steps[cell] + 1)
            return steps => return np.where(steps < free.size, steps, -1)
            You go over the grid only once, but a winding path returns to rows that you have already passed. Repeat until nothing changes, or use breadth-first search.
        a hundred sweeps: return steps => return np.where(steps > 100, -1, steps)
            You stop after a hundred rounds. A winding path can have nearly as many steps as the grid has cells, so continue until nothing changes.
        rows and columns sweeps: return steps => return np.where(steps > sum(free.shape), -1, steps)
            You stop after as many rounds as the grid has rows and columns. A winding path is longer, so continue until nothing changes.
    """),
    alternatives={"as a whole": _as_a_whole, "relaxing": _by_relaxing, "SciPy's Dijkstra": _by_graph},
    equivalents={
        "inside = 0 <= cell[0] != free.shape[0] and 0 <= cell[1] < free.shape[1]": "a neighbour is at most one row outside",
        "inside = 0 <= cell[0] < free.shape[0] and 0 <= cell[1] != free.shape[1]": "a neighbour is at most one column outside",
        "for cell in ((row - 1, column), (row + 1, column), (row, column + 1), (row, column - 1)):": "neighbours come in any order",
    },
)


# --- 12.7 choose_move ---
def _after(state: Array, covariance: Array, option: Any) -> tuple[Array, Array]:
    found = predict(state, covariance, option.control, option.control_covariance, (len(state) - 3) // 2)
    if len(option.indices):
        found = update_landmarks(*found, option.indices, option.measurements, option.measurement_covariance)
    return found


def _least(measure: Callable[[Array], float]) -> Callable[..., int]:
    """Return a rule that chooses the option with the smallest value of a measure of the covariance."""
    return lambda state, covariance, options: int(
        np.argmin([measure(_after(state, covariance, each)[1]) for each in options])
    )


def _most_landmarks(state: Array, covariance: Array, options: Any) -> int:
    return int(np.argmax([len(each.indices) for each in options]))


def _carried_over(state: Array, covariance: Array, options: Any) -> int:
    variances = []
    for option in options:
        state, covariance = _after(state, covariance, option)
        variances.append(np.trace(covariance[:2, :2]))
    return int(np.argmin(variances))


def _in_order(state: Array, covariance: Array, options: Any) -> int:
    best, least = 0, np.inf
    for number, option in enumerate(options):
        variance = np.trace(_after(state, covariance, option)[1][:2, :2])
        if variance < least:
            best, least = number, variance
    return best


def _by_ranking(state: Array, covariance: Array, options: Any) -> Any:
    roots = [np.hypot(*np.sqrt(np.diag(_after(state, covariance, each)[1])[:2])) for each in options]
    return np.argsort(roots, kind="stable")[0]


def _without_landmarks(state: Array, covariance: Array, options: Any) -> int:
    """Keep only the observed landmarks in the state; the pose stays the same."""

    def variance(number: int) -> float:
        seen = options[number].indices
        rows = [0, 1, 2, *(3 + 2 * i + c for i in seen for c in (0, 1))]
        own = replace(options[number], indices=list(range(len(seen))))
        return float(np.trace(_after(state[rows], covariance[np.ix_(rows, rows)], own)[1][:2, :2]))

    return min(range(len(options)), key=variance)


def _situation(rng: np.random.Generator, k: int, moves: int) -> tuple[Array, Array, list[Option]]:
    pose = np.append(rng.uniform((0.5, -1), (2, 1)), rng.uniform(-np.pi, np.pi))
    landmarks = rng.uniform((0, -2), (3, 2), (k, 2))
    covariance = correlated(rng, 3 + 2 * k, 0.1)
    options = []
    for _ in range(moves):
        control = np.array([rng.uniform(0, 0.4), rng.uniform(-1.5, 1.5)])
        after = (Pose.from_array(pose) @ Pose(control[0], 0.0, control[1])).as_array()
        seen = [i for i in rng.permutation(k).tolist() if rng.random() < 0.5]
        expected = range_and_bearing(after, landmarks[seen]).reshape(-1, 2)
        noises = np.array([np.diag([0.03**2, (0.05 * r) ** 2]) for _, r in expected]).reshape(-1, 2, 2)
        sigmas = 0.1 * control[0] + 0.01, 0.05 * control[0] + 0.01, 0.02 + 0.1 * abs(control[1])
        options.append(Option(control, np.diag(np.square(sigmas)), seen, expected.ravel(), noises))
    return np.append(pose, landmarks), covariance, options


def _moves_public() -> list[Case]:
    def drawn(k: int, moves: int, seed: int) -> tuple[Array, Array, list[Option]]:
        return _situation(np.random.default_rng([127, k, seed]), k, moves)

    state, covariance, offered = drawn(2, 3, 0)
    cases = [
        Case((state, covariance, [*offered, *offered]), "each move offered twice"),
        Case(drawn(2, 6, 10), "two landmarks, six moves"),
        Case(drawn(3, 7, 4), "three landmarks, seven moves"),
        Case(drawn(4, 8, 2), "four landmarks, eight moves"),
        Case(drawn(4, 8, 4), "four others"),
        Case(drawn(0, 5, 0), "nothing on the map yet"),
        Case(drawn(0, 5, 11), "nothing on the map yet, other moves"),
        Case(drawn(6, 9, 3), "six landmarks, nine moves"),
        Case(drawn(4, 1, 0), "a single move"),
    ]
    for before, P, options in (case.args for case in cases):
        for option in (each for each in options if not each.indices):
            # An update without a measurement is recorded like the reference's calls
            after = predict(before, P, option.control, option.control_covariance, len(before[3:]) // 2)
            update_landmarks(*after, option.indices, option.measurements, option.measurement_covariance)
    return cases


def _deciding(rng: np.random.Generator, k: int, moves: int, other: Callable[..., int]) -> Case:
    """Return a situation in which another rule chooses another move."""
    while True:
        situation = _situation(rng, k, moves)
        if other(*situation) != _in_order(*situation):
            return Case(situation)


def _moves_hidden(rng: np.random.Generator) -> list[Case]:
    state, covariance, offered = _situation(rng, 3, 4)
    measures = (
        lambda P: np.linalg.det(P[:2, :2]),
        lambda P: np.sqrt(P[0, 0]) + np.sqrt(P[1, 1]),
        lambda P: np.trace(P[:3, :3]),
        lambda P: P[0, 0],
        lambda P: P[1, 1],
    )
    others = [*map(_least, measures), _most_landmarks, _carried_over]
    return [
        Case((state, covariance, [*offered, *offered])),
        *(_deciding(rng, 4, 8, other) for other in others),
        *(Case(_situation(rng, k, moves)) for k, moves in ((1, 6), (2, 8), (6, 9), (8, 9), (0, 5), (10, 9))),
    ]


CHOOSE_MOVE = Exercise(
    name="choose_move",
    points=3,
    stars=3,
    uses=("07:predict", "07:update_landmarks"),
    public=_moves_public,
    hidden=_moves_hidden,
    comparison=Exact(),
    hints=(
        "Let the filter compute the covariance after each option: predict with the option's control, then update_landmarks with the measurements that the option expects. Do not change the real state.",
        "The sum is P[0, 0] + P[1, 1] of the covariance after both steps. np.argmin returns the first of several equal values. If an option shows no landmarks, skip the update.",
    ),
    sibling=Sibling(
        "Each option is tried on its own copy of the present state, and the index of the best result is returned: here the variance of a position after a walk with or without a signpost.",
        """
        import numpy as np


        def after(variance, walk, sign):
            variance = variance + walk  # a new number: the given one stays as it is
            return 1 / (1 / variance + 1 / sign) if sign else variance


        results = [after(0.5, walk, sign) for walk, sign in ((0.1, None), (0.8, 0.2), (0.3, 2.0))]
        print(np.round(results, 3), int(np.argmin(results)))
        """,
        "[0.6   0.173 0.571] 1",
    ),
    mistakes=catalogue("""
        the largest: np.argmin => np.argmax
            You choose the move with the largest uncertainty. Use np.argmin.
        without measurements: if option.indices: => if False:
            You leave out the expected measurements, so the shortest move always wins. Call update_landmarks after predict.
        without noise: option.control_covariance, k => np.zeros((3, 3)), k
            Your moves have no noise. Pass the option's control_covariance to predict.
        the whole map: after[1][0, 0] + after[1][1, 1] => np.trace(after[1])
            You sum the variances of pose and map. Sum only the two variances of the position (equation 12.7).
        the heading, too: after[1][0, 0] + after[1][1, 1] => np.trace(after[1][:3, :3])
            You add the variance of the heading, in rad^2, to the variances of the position, in m^2. Sum only the variances of x and y.
        determinant: after[1][0, 0] + after[1][1, 1] => np.linalg.det(after[1][:2, :2])
            You compare determinants (or their logarithms), which measure the area of the ellipse. A long and thin ellipse has a small area. Equation 12.7 is the sum of the two variances.
        determinant of the pose: after[1][0, 0] + after[1][1, 1] => np.linalg.slogdet(after[1][:3, :3])[1]
            You compare the determinant of the whole pose (or its logarithm), which includes the heading. Equation 12.7 is the sum of the variances of x and y.
        determinant of everything: after[1][0, 0] + after[1][1, 1] => np.linalg.slogdet(after[1])[1]
            You compare the determinant of the whole covariance (or its logarithm), which measures the entropy of pose and map. Equation 12.7 is the sum of the variances of x and y.
        largest eigenvalue: after[1][0, 0] + after[1][1, 1] => np.linalg.eigvalsh(after[1][:2, :2])[-1]
            You compare the largest eigenvalue, the variance along the longest axis of the ellipse. Equation 12.7 is the sum of the variances of x and y.
        the map alone: after[1][0, 0] + after[1][1, 1] => np.trace(after[1][3:, 3:])
            You sum the variances of the landmarks. Equation 12.7 is the sum of the variances of the position, x and y.
        the covariances of x and y: after[1][0, 0] + after[1][1, 1] => after[1][0, 1] + after[1][1, 0]
            You add the two entries off the diagonal, which are the covariance of x and y. The variances are P[0, 0] and P[1, 1].
        x alone: after[1][0, 0] + after[1][1, 1] => after[1][0, 0]
            You use only the variance of x. Add the variance of y.
        carried over: variances.append => variances.append
            + state, covariance = after
            Your second option starts where the first one ended, because you overwrite state and covariance in the loop. Every option must start from the given state.
        not moved: predict(state, covariance, option.control, option.control_covariance, k) => (state, covariance)
            You leave out the prediction, so a move costs nothing. Call predict first, and then update_landmarks with its results.
        one landmark: seen = option.indices, option.measurements, option.measurement_covariance => seen = option.indices[:1], option.measurements[:2], option.measurement_covariance[:1]
            You use only the first landmark of each option. Pass all of its indices, measurements and covariances to update_landmarks.
        measured before the move: predict(state, covariance, option.control, option.control_covariance, k) => state, covariance
            variances.append(after[1][0, 0] + after[1][1, 1]) => after = predict(*after, option.control, option.control_covariance, k)
            + variances.append(after[1][0, 0] + after[1][1, 1])
            You update before you predict. The landmarks of an option are seen after its move.
        standard deviations: after[1][0, 0] + after[1][1, 1] => np.sqrt(after[1][0, 0]) + np.sqrt(after[1][1, 1])
            You sum standard deviations. Equation 12.7 is the sum of the variances.
        the last of equals: np.argmin(variances) => len(variances) - 1 - np.argmin(variances[::-1])
            If several options are equal, you return the last one. Return the first one: compare with < instead of <=.
        always the first: int(np.argmin(variances)) => 0
            You always return 0. If you search for the smallest sum in a loop, start with np.inf, because no sum is below 0.
        the sum itself: int(np.argmin(variances)) => float(np.min(variances))
            You return the smallest sum. Return the index of its option: np.argmin.
        the option itself: return int(np.argmin(variances)) => return options[np.argmin(variances)]
            You return the option. Return its index: np.argmin of the sums.
        k of the option: control_covariance, k => control_covariance, len(option.indices)
            seen = option.indices, => seen = list(range(len(option.indices))),
            predict needs the number of landmarks on the map, (len(state) - 3) // 2, and update_landmarks needs the option's indices.
        the old covariance: update_landmarks(*after => update_landmarks(after[0], covariance
            You pass the covariance from before the move to update_landmarks. Pass both results of predict.
        the old state: update_landmarks(*after => update_landmarks(state, after[1]
            You pass the state from before the move to update_landmarks, so H is computed at the wrong pose. Pass both results of predict.
        state and covariance from before: update_landmarks(*after => update_landmarks(state, covariance
            You pass the state and covariance from before the move to update_landmarks, so the move has no effect. Pass both results of predict.
        sum of the block: after[1][0, 0] + after[1][1, 1] => np.sum(after[1][:2, :2])
            You sum all four entries of the block for x and y. Sum only the two variances on its diagonal.
        norm of the block: after[1][0, 0] + after[1][1, 1] => np.linalg.norm(after[1][:2, :2])
            You compare np.linalg.norm of the block for x and y, which squares its entries. Equation 12.7 is the sum of the two variances.
        empty options last: variances.append(after[1][0, 0] + after[1][1, 1]) => variances.append(after[1][0, 0] + after[1][1, 1] if option.indices else np.inf)
            You skip the options that show nothing. Such an option still has a covariance after its move: skip the update, not the option.
        empty options left out: variances.append(after[1][0, 0] + after[1][1, 1]) => variances += [after[1][0, 0] + after[1][1, 1]] if option.indices else []
            You leave out the options that show nothing, so the other indices change. Such an option still has a covariance after its move: skip the update, not the option.
        all sums: return int(np.argmin(variances)) => return variances
            You return the list of all sums. Return the index of the smallest one: np.argmin.
        most landmarks: after[1][0, 0] + after[1][1, 1] => -len(option.indices)
            You choose the move with the most landmarks in view. One landmark with a small covariance can help more than three uncertain ones, so compare the covariances.
    """),
    alternatives={"in order": _in_order, "by ranking": _by_ranking, "only what is seen": _without_landmarks},
    equivalents={
        **{
            f"k = {other}": "lesson 07's reference predict gets the number of landmarks from the state"
            for other in (
                *(
                    f"len(state[3:]) {sign} 2"
                    for sign in ("+", "-", "*", "/", "%", "**", ">>", "<<", "|", "&", "^")
                ),
                *("len(state[3:]) // 3", "len(state[3:]) // 1", "len(state[3:])", "2", "len(state[:]) // 2"),
                *("len(state[4:]) // 2", "len(state[2:]) // 2", "state[3:] // 2"),
            )
        },
        "if True:": "lesson 07's reference update_landmarks changes nothing without measurements",
        "return np.argmin(variances)": "NumPy's number is as good as Python's",
    },
)


PLAN = LessonPlan(
    exercises=[
        RESAMPLE,
        WEIGH,
        UPDATE_PARTICLE_LANDMARK,
        INTERSECT_RAYS,
        FIND_FRONTIERS,
        TRAVEL_STEPS,
        CHOOSE_MOVE,
    ],
    questions=[
        Question(
            "how_many_particles",
            "Two thousand particles were enough for a pose. With 10 cm and 10 degrees between neighbours it would take about 40,000. How many would a pose and ten landmarks need at this spacing?",
            {
                "Eleven times as many, because each landmark is one more unknown position.": "The numbers multiply instead of adding up: each position of the first landmark can occur with each position of the second.",
                "Twenty times as many, because there are twenty more numbers.": "Each number multiplies the count by its number of steps. It does not add to it.",
                "About a thousand to the power of ten times as many.": "Each landmark has about 1000 positions with a spacing of 10 cm on the half field, and each combination is another map. That is 10 to the power of 30.",
            },
            "About a thousand to the power of ten times as many.",
        ),
        Question(
            "why_overconfident",
            "FastSLAM's covariance is computed from the spread of its particles. Why is it too small when only few of the initial particles have descendants?",
            {
                "The particles forget how the drive began.": "On the contrary: all of them remember the same beginning.",
                "All particles share the error of one beginning, and a shared error does not appear in their spread.": "The first part of the path is a single sample. Its error is in every map and in every pose, and nothing in the cloud shows it.",
                "Resampling reduces the noise of the odometry.": "Each particle still draws its errors from the same distribution. Only the variety of their pasts is lost.",
            },
            "All particles share the error of one beginning, and a shared error does not appear in their spread.",
        ),
        Question(
            "when_both_pay",
            "At 320x240 and 2 m, one camera and two cameras are about equally good. And at 4 m?",
            {
                "Two cameras are better, because tilt causes a larger error at a longer distance.": "It does: the error is four times as large as at 2 m. But the error of the pixels is also four times as large, because the two rays intersect at half the angle.",
                "One camera is better, because the two rays are nearly parallel.": "They are, and a pixel causes an error four times as large as at 2 m. But so does the tilt for one camera.",
                "They are still equally good, because both errors grow with the square of the distance.": "The distance cancels in their ratio. The ratio depends only on the angle of a pixel compared with the tilt, and so on the resolution.",
            },
            "They are still equally good, because both errors grow with the square of the distance.",
        ),
        Question(
            "greedy",
            "After the start with its back to the goal, your choice ended with a larger standard deviation than random moves. Why?",
            {
                "It plans only one move ahead. With two moves it would have turned to the goal.": "Two moves ahead its map is just as empty, so it would not expect to see anything there either.",
                "Landmarks that are not on its map count for nothing, so for some moves it keeps looking at the only landmark that it has found.": "Each option contains only landmarks of the map. The goal is not on it, so no option promises anything in that direction. Random moves are not biased in this way: after four moves they have found five landmarks (median), your choice one.",
                "With its back to the goal its odometry is worse.": "The odometry errors are the same everywhere, and after the first four moves both drives are equally uncertain.",
            },
            "Landmarks that are not on its map count for nothing, so for some moves it keeps looking at the only landmark that it has found.",
        ),
    ],
    written=[
        Written(
            "when_to_stop",
            points=2,
            question="Your robot can explore, or return to what it knows. When is which of the two better, and by which rule would you let it decide? Give the three numbers of your own drives.",
            rubric="1 point: exploring increases the uncertainty of the pose (odometry noise, new landmarks as uncertain as the pose) and adds to the map; returning reduces the uncertainty (a loop is closed). 1 point: a rule that combines both in one measure: the expected entropy or summed variance of pose and map, or a limit for the uncertainty of the pose above which the robot returns to what it knows. Subtract half a point if the three numbers of the personal world are missing.",
            numbers=personal_numbers,
        )
    ],
)
