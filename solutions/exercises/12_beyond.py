"""Lesson 12, beyond the paper: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises import (
    Case,
    Close,
    Each,
    Exact,
    Exercise,
    LessonPlan,
    Mistake,
    Property,
    Question,
    Written,
)
from nao_course.geometry import Pose
from nao_course.lessons.beyond.particles import systematic
from nao_course.lessons.beyond.planning import Option
from nao_course.slam import range_and_bearing
from nao_course.student import earlier

Array = npt.NDArray[Any]
TURN = 2 * np.pi
predict = earlier("07:predict")
update_landmarks = earlier("07:update_landmarks")


def wrapped(angle: Any) -> Any:
    """An angle in [-pi, pi)."""
    return (angle + np.pi) % TURN - np.pi


def spread(rng: np.random.Generator, size: int, scale: float) -> Array:
    """A covariance (size, size) whose values are correlated."""
    root = rng.normal(0.0, 0.4, (size, size)) + np.eye(size) * rng.uniform(0.6, 1.2, size)
    return scale**2 * (root @ root.T)


# --- 12.1 resample ---


def _comb(shift: Callable[[int, np.random.Generator], Any], side: Any = "right", last: bool = False) -> Any:
    def function(weights: Array, rng: np.random.Generator) -> Array:
        ends = np.cumsum(weights[::-1] if last else weights)
        return np.searchsorted(ends, shift(len(weights), rng), side=side)

    return function


def _teeth(n: int, rng: np.random.Generator) -> Array:
    return (np.arange(n) + rng.random()) / n


def _walked(weights: Array, rng: np.random.Generator) -> list[int]:
    n, kept, end, number = len(weights), [], float(weights[0]), 0
    first = rng.random() / n
    for k in range(n):
        while first + k / n > end and number < n - 1:
            number += 1
            end += float(weights[number])
        kept.append(number)
    return kept


def _counted(weights: Array, rng: np.random.Generator) -> Array:
    ends = np.append(0.0, np.cumsum(weights))
    ends[-1] = 1.0
    copies = np.diff(np.ceil(len(weights) * ends - rng.random()))
    return np.repeat(np.arange(len(weights)), copies.astype(int))


def _compared(weights: Array, rng: np.random.Generator) -> Array:
    teeth = _teeth(len(weights), rng)
    ends = np.cumsum(weights)[:-1]
    return np.sum(teeth[:, None] >= ends, axis=1)


def _from_above(weights: Array, rng: np.random.Generator) -> list[int]:
    """A comb whose last tooth is shifted, in another order: as right as any."""
    n = len(weights)
    ends = np.cumsum(weights) / np.sum(weights)
    kept = [int(np.sum(ends < 1 - (k + rng_shift) / n)) for rng_shift in [rng.uniform()] for k in range(n)]
    return list(rng.permutation(kept))


def _weights(rng: np.random.Generator, n: int, peak: float) -> Array:
    logs = peak * rng.normal(0, 1, n)
    weights = np.exp(logs - logs.max())
    return weights / weights.sum()


def _draws(weights: Array, name: str = "", draws: int = 100) -> Case:
    """Weights, and the seeds to draw with; some come twice."""
    return Case((weights, [*range(draws), *range(5)]), name)


def _resample_public() -> list[Case]:
    rng = np.random.default_rng(1)
    return [
        _draws(np.array([0.5, 0.1, 0.4]), "three particles"),
        _draws(np.array([0.0, 1.0, 0.0, 0.0]), "one that has all the weight"),
        _draws(np.full(6, 1 / 6), "six of equal weight"),
        _draws(_weights(rng, 12, 1.5), "twelve particles"),
        _draws(np.array([1.0]), "a single one"),
    ]


def _resample_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        _draws(_weights(rng, n, peak), draws=draws)
        for n, peak, draws in ((3, 0.5, 300), (5, 0.5, 300), (20, 1.0, 200), (50, 2.0, 100), (200, 3.0, 30))
    ]


RESAMPLE = Exercise(
    name="resample",
    points=2,
    stars=1,
    public=_resample_public,
    hidden=_resample_hidden,
    comparison=Property(systematic),
    driver="each_seed",
    hints=(
        "The ends of the pieces are the sums of the weights up to each: np.cumsum. A tooth lies in the first piece whose end is beyond it.",
        "teeth = (np.arange(n) + rng.random()) / n, and np.searchsorted says for each tooth in which piece it lies. The last sum may be a little below 1 by rounding: divide by it.",
    ),
    mistakes=[
        Mistake(
            "each tooth drawn",
            _comb(lambda n, rng: np.sort(rng.random(n))),
            "You draw each tooth by itself. One random number shifts the whole comb: its teeth are 1/N apart (equation 12.1).",
        ),
        Mistake(
            "a shift for each tooth",
            _comb(lambda n, rng: (np.arange(n) + rng.random(n)) / n),
            "You shift each tooth by a number of its own. That is stratified resampling, and a particle may be kept once too often: one number shifts all.",
        ),
        Mistake(
            "shifted by half at most",
            _comb(lambda n, rng: (np.arange(n) + rng.random() / 2) / n),
            "Your shift goes to half of 1/N only. Then the first particles are kept too often.",
        ),
        Mistake(
            "teeth one apart",
            _comb(lambda n, rng: np.arange(n) + rng.random() / n),
            "Your teeth are 1 apart, and the line is 1 long: all but the first stand beyond it. (q + j) / N divides both.",
        ),
        Mistake(
            "N teeth on the ends",
            _comb(lambda n, rng: np.linspace(0, 1, n) + rng.random() / n),
            "np.linspace(0, 1, N) puts its last tooth at 1: they are 1/(N - 1) apart. np.arange(N) / N has them 1/N apart.",
        ),
        Mistake(
            "rng.choice",
            lambda weights, rng: rng.choice(len(weights), len(weights), p=weights),
            "You draw each particle by itself, as rng.choice does, and good ones may be lost. One comb takes each floor(N w) or ceil(N w) times.",
        ),
        Mistake(
            "shifted by up to one",
            _comb(lambda n, rng: np.arange(n) / n + rng.random()),
            "You shift the comb by a number from 0 to 1, off the line. It is shifted by one from 0 to 1/N: rng.random() / N.",
        ),
        Mistake(
            "not shifted",
            _comb(lambda n, rng: np.arange(n) / n),
            "Your comb always begins at 0. Then the first particle is kept however little it weighs: shift it by a random number.",
        ),
        Mistake(
            "in the middle",
            _comb(lambda n, rng: (np.arange(n) + 0.5) / n),
            "Your comb always stands in the same place. A particle of little weight is then kept always, or never: shift it at random.",
        ),
        Mistake(
            "weights for ends",
            lambda weights, rng: np.searchsorted(weights, _teeth(len(weights), rng)),
            "You look for the teeth among the weights. A piece ends at the sum of all weights up to its own: np.cumsum.",
        ),
        Mistake(
            "the teeth themselves",
            lambda weights, rng: _teeth(len(weights), rng),
            "You return where the teeth stand. Wanted is in which piece each stands: np.searchsorted.",
        ),
        Mistake(
            "rounded",
            lambda weights, rng: np.repeat(
                np.arange(len(weights)), np.round(len(weights) * weights).astype(int)
            ),
            "You keep the same particles each time: N w rounded, or a comb that stands still. One of weight 0.3 / N then never lives on: shift a comb at random.",
        ),
        Mistake(
            "weights kept",
            lambda weights, rng: weights[_comb(_teeth)(weights, rng)],
            "You return weights. What is wanted are the numbers of the particles that are kept.",
        ),
        Mistake(
            "from the end",
            _comb(_teeth, last=True),
            "Your pieces lie in the wrong order: the first piece belongs to the first particle.",
        ),
        Mistake(
            "counts",
            lambda weights, rng: np.bincount(_comb(_teeth)(weights, rng), minlength=len(weights)),
            "You return how often each is kept. Wanted is the number of each copy, N of them: np.repeat makes them of counts.",
        ),
        Mistake(
            "one too many",
            lambda weights, rng: _comb(_teeth)(weights, rng) + 1,
            "Your numbers are one too large: the first particle is number 0.",
        ),
    ],
    alternatives={
        "walking along": _walked,
        "counting teeth": _counted,
        "comparing all": _compared,
        "another comb, in another order": _from_above,
    },
    equivalents=dict.fromkeys(
        (
            f"return np.searchsorted({ends}, teeth)"
            for ends in ("ends", "ends * ends[-1]", "ends ** ends[-1]")
        ),
        "the last end is 1 but for rounding",
    ),
)


# --- 12.2 weigh ---


def _weigher(
    bearings: Callable[[Any], Any] = wrapped,
    towards: Callable[[Any], Any] = lambda angle: angle,
    half: float = 0.5,
    norm: Callable[[Array], float] = lambda R: 0.5 * float(np.log(np.linalg.det(TURN * R))),
    weigh: Callable[[Array, Array], Array] = lambda off, R: np.sum(off @ np.linalg.inv(R) * off, axis=1),
    turned: float = 1.0,
    after: Callable[[Array], Any] = lambda logs: logs,
    exchanged: bool = False,
    lengths: Callable[[Array], Any] = lambda away: np.hypot(*away.T),
    ranges: Callable[[Any], Any] = lambda off: off,
) -> Any:
    def function(particles: Array, landmark: Array, measurement: Array, R: Array) -> Any:
        away = landmark - particles[:, :2]
        toward = np.arctan2(*(away.T if exchanged else away.T[::-1])) - turned * particles[:, 2]
        too_far = ranges(measurement[1] - lengths(away)) + np.zeros(len(away))
        off = np.column_stack([bearings(measurement[0] - towards(toward)), too_far])
        return after(-half * weigh(off, R) - norm(R))

    return function


def _of_all_pairs(off: Array, R: Array) -> Array:
    return off @ np.linalg.inv(R) @ off.T


def _log_of_density(particles: Array, landmark: Array, measurement: Array, R: Array) -> Array:
    with np.errstate(divide="ignore"):
        return np.log(np.exp(_weigher()(particles, landmark, measurement, R)))


def _one_pose(particles: Array, landmark: Array, measurement: Array, R: Array) -> Array:
    x, y, theta = particles
    return _weigher()(np.column_stack([x, y, theta]), landmark, measurement, R)


def _weigh_by_loop(particles: Array, landmark: Array, measurement: Array, R: Array) -> list[float]:
    logs = []
    for x, y, theta in particles:
        away = complex(*landmark) - complex(x, y)
        bearing = np.angle(np.exp(1j * (measurement[0] + theta)) * away.conjugate())
        off = np.array([bearing, measurement[1] - abs(away)])
        logs.append(-0.5 * (off @ np.linalg.solve(R, off) + np.linalg.slogdet(R)[1] + 2 * np.log(TURN)))
    return logs


def _weigh_by_root(particles: Array, landmark: Array, measurement: Array, R: Array) -> Array:
    seen = range_and_bearing(particles, landmark)
    off = measurement - seen
    off[:, 0] = np.arctan2(np.sin(off[:, 0]), np.cos(off[:, 0]))
    root = np.linalg.cholesky(R)
    return (
        -0.5 * np.square(np.linalg.solve(root, off.T)).sum(axis=0)
        - np.log(np.diag(root)).sum()
        - np.log(TURN)
    )


def _weigh_by_density(particles: Array, landmark: Array, measurement: Array, R: Array) -> Array:
    from scipy.stats import multivariate_normal

    seen = range_and_bearing(particles, landmark)
    off = np.column_stack([wrapped(measurement[0] - seen[:, 0]), measurement[1] - seen[:, 1]])
    return np.atleast_1d(multivariate_normal(np.zeros(2), R).logpdf(off))


def _crowd(rng: np.random.Generator, n: int) -> Array:
    return np.column_stack([rng.uniform(0, 3, n), rng.uniform(-2, 2, n), rng.uniform(-np.pi, np.pi, n)])


def _look(rng: np.random.Generator, particles: Array) -> tuple[Array, Array, Array, Array]:
    landmark = rng.uniform((0, -2), (3, 2))
    seen = range_and_bearing(particles[0], landmark) + rng.normal(0, (0.03, 0.1))
    R = spread(rng, 2, 1.0) * np.outer((0.05, 0.2), (0.05, 0.2))
    return particles, landmark, np.array([wrapped(seen[0]), seen[1]]), R


def _weigh_public() -> list[Case]:
    rng = np.random.default_rng(12)
    beside = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.1], [0.0, 0.2, -0.1]])
    return [
        Case(
            (np.zeros((1, 3)), np.array([2.0, 0.0]), np.array([0.02, 2.1]), np.diag([0.0004, 0.01])),
            "one particle, as in the docstring",
        ),
        Case(
            (beside, np.array([2.0, 0.5]), np.array([0.25, 2.0]), np.diag([0.001, 0.02])),
            "four particles side by side",
        ),
        Case(
            (
                np.array([[2.0, 0.0, 3.1], [2.0, 0.0, -3.1]]),
                np.array([1.0, 0.0]),
                np.array([0.05, 1.0]),
                np.diag([0.01, 0.01]),
            ),
            "looking along the negative x axis",
        ),
        Case(
            (
                np.array([[2.0, 0.0, 0.0], [1.9, 0.0, 0.1]]),
                np.array([1.0, 0.05]),
                np.array([-3.12, 1.0]),
                np.diag([0.01, 0.01]),
            ),
            "a landmark right behind",
        ),
        Case(_look(rng, _crowd(rng, 8)), "bearing and range that err together"),
        Case(
            (
                np.array([[0.0, -2.0, 0.9], [2.4, 1.2, 0.9]]),
                np.array([3.0, 2.0]),
                np.array([0.05, 1.05]),
                np.diag([0.01, 0.09]),
            ),
            "a particle that is far away from where it could be",
        ),
        Case(
            (beside, np.array([1.0, 1.0]), np.array([0.8, 1.4]), np.diag([1.0, 2.0])),
            "a very poor measurement",
        ),
    ]


def _weigh_hidden(rng: np.random.Generator) -> list[Case]:
    far = np.array([3.0, 2.5]) + rng.normal(0, 0.1, 2)
    return [
        *(Case(_look(rng, _crowd(rng, int(n)))) for n in (1, 2, 10, 40, 200)),
        Case(
            (
                rng.normal((2, 0, 0), 0.02, (6, 3)),
                np.array([rng.uniform(0.5, 1.4), 0.0]),
                np.array([rng.choice((3.13, -3.13)), 1.0]),
                np.diag([0.01, 0.01]),
            )
        ),
        Case(
            (
                np.array([[0, -2, 0.5], [3, 2, 0.5]]) + rng.normal(0, 0.1, (2, 3)),
                far,
                np.array([0.2, 0.5]),
                np.diag([0.01, 0.09]),
            )
        ),
    ]


WEIGH = Exercise(
    name="weigh",
    points=2,
    stars=2,
    uses=("05:expected_measurement", "07:warp2pi"),
    public=_weigh_public,
    hidden=_weigh_hidden,
    comparison=Close(rtol=1e-6, atol=1e-6, names=("your log weights",)),
    equivalents={
        "off = np.column_stack([warp2pi(measurement[0] - bearings), measurement[1] - np.hypot(away[:, 1], away[:, 0])])": "a hypotenuse has its sides in any order"
    },
    hints=(
        "nu has a row for each particle: the bearing's difference, wrapped, and the range's. The bearing that a particle expects is arctan2 of what lies between it and the landmark, less its own heading.",
        "The quadratic form of each row: np.sum(nu @ np.linalg.inv(R) * nu, axis=1). The other term is one number: np.log(np.linalg.det(2 * np.pi * R)).",
    ),
    mistakes=[
        Mistake(
            "no wrap",
            _weigher(bearings=lambda angle: angle),
            "Your bearing is not wrapped: 6.2 rad is nearly nothing, and your particle dies of it.",
        ),
        Mistake(
            "the difference not wrapped",
            _weigher(towards=wrapped, bearings=lambda angle: angle),
            "What is expected is wrapped, and so is what was measured; their difference is not. Between 3.1 and -3.1 rad lie 0.08 rad, not 6.2: wrap the difference.",
        ),
        Mistake(
            "weights, no logarithms",
            _weigher(after=np.exp),
            "You return the weights themselves. Products of many of them end at 0: their logarithms are wanted.",
        ),
        Mistake(
            "the logarithm at last",
            _log_of_density,
            "Some of your weights are -inf: the density ended at 0 before its logarithm was taken. Compute the logarithm itself, equation 12.2.",
        ),
        Mistake(
            "one pose",
            _one_pose,
            "Taken as one pose, all particles at once do not fit: each is a row. particles[:, 0] are all x; expected_measurement takes one of them at a time.",
        ),
        Mistake(
            "one length for all",
            _weigher(lengths=np.linalg.norm),
            "np.linalg.norm makes one number of all particles. With axis=1 it makes one of each row.",
        ),
        Mistake(
            "the range wrapped, too",
            _weigher(ranges=wrapped),
            "You wrap the range as well. It is no angle: wrap nu[:, 0] alone.",
        ),
        Mistake(
            "all pairs",
            _weigher(weigh=_of_all_pairs),
            "nu @ R^-1 @ nu.T has each particle with each other, (N, N). Wanted is its diagonal: multiply row by row, and sum along axis=1.",
        ),
        Mistake(
            "the largest taken off",
            _weigher(after=lambda logs: logs - logs.max()),
            "You take off the largest. That is done later, once for all measurements: each is wanted as equation 12.2 has it.",
        ),
        Mistake(
            "no half", _weigher(half=1.0), "The half before the quadratic form is missing (equation 12.2)."
        ),
        Mistake(
            "no determinant",
            _weigher(norm=lambda R: 0.0),
            "The second term of equation 12.2 is missing: without it a poor measurement counts like a good one.",
        ),
        Mistake(
            "the determinant without 2 pi",
            _weigher(norm=lambda R: 0.5 * float(np.log(np.linalg.det(R)))),
            "Your determinant is that of R. It is that of 2 pi R, in two dimensions (2 pi)^2 times as much.",
        ),
        Mistake(
            "one 2 pi",
            _weigher(norm=lambda R: 0.5 * float(np.log(TURN * np.linalg.det(R)))),
            "You multiply the determinant by 2 pi. Every row of 2 pi R is multiplied: in two dimensions it is (2 pi)^2.",
        ),
        Mistake(
            "the determinant not halved",
            _weigher(norm=lambda R: float(np.log(np.linalg.det(TURN * R)))),
            "The half before the logarithm of the determinant is missing (equation 12.2).",
        ),
        Mistake(
            "R for its inverse",
            _weigher(weigh=lambda off, R: np.sum(off @ R * off, axis=1)),
            "You multiply by R. The difference is weighed by R's inverse.",
        ),
        Mistake(
            "diagonal only",
            _weigher(weigh=lambda off, R: np.sum(off**2 / np.diag(R), axis=1)),
            "You use R's diagonal alone. Bearing and range may err together: its other entries count, too.",
        ),
        Mistake(
            "heading forgotten",
            _weigher(turned=0.0),
            "A bearing is measured from where the particle looks: take its heading off.",
        ),
        Mistake(
            "heading added",
            _weigher(turned=-1.0),
            "You add the heading. What is expected is the landmark's direction less the heading.",
        ),
        Mistake("x for y", _weigher(exchanged=True), "arctan2 takes y first, then x."),
        Mistake(
            "normalised",
            _weigher(after=lambda logs: logs - np.log(np.sum(np.exp(logs - logs.max()))) - logs.max()),
            "You make the weights sum up to 1. That is done later, once for all measurements: each is wanted as equation 12.2 has it.",
        ),
    ],
    alternatives={
        "a loop": _weigh_by_loop,
        "a root of R": _weigh_by_root,
        "SciPy's density": _weigh_by_density,
    },
)


# --- 12.3 update_particle_landmark ---


def _little(**changed: Any) -> Any:
    def function(pose: Array, mean: Array, covariance: Array, measurement: Array, R: Array) -> Any:
        expected, slopes = _expected(pose, mean)
        expected[0] += changed.get("turned", 0) * pose[2]
        nu = measurement - expected
        if not changed.get("no_wrap"):
            nu[0] = wrapped(nu[0])
        if changed.get("wrap_both"):
            nu = wrapped(nu)
        H = slopes.T if changed.get("transposed") else slopes
        spread_there = H * covariance * H.T if changed.get("by_entries") else H @ covariance @ H.T
        S = spread_there + (0 if changed.get("no_R") else R)
        K = covariance @ H.T @ np.linalg.inv(R if changed.get("gain_of_R") else S)
        P = covariance - K @ H @ covariance
        if changed.get("covariance_kept"):
            P = covariance
        if changed.get("exchanged"):
            P = covariance - H @ K @ covariance
        if changed.get("grown"):
            P = covariance + K @ H @ covariance
        if changed.get("first_update"):
            mean = mean + K @ nu
            expected, _ = _expected(pose, mean)
            nu = measurement - expected
            return mean, P, _log(nu, S)
        moved = mean - K @ nu if changed.get("sign") else mean + K @ nu
        log = _log(nu, R if changed.get("weighed_by_R") else S)
        if changed.get("no_determinant"):
            log = float(-0.5 * nu @ np.linalg.solve(S, nu))
        if "two_pi" in changed:
            log += changed["two_pi"] * float(np.log(TURN))
        if changed.get("no_half"):
            log -= 0.5 * float(nu @ np.linalg.solve(S, nu))
        if changed.get("weight_first"):
            return log, moved, P
        if changed.get("no_weight"):
            return moved, P
        return moved, P, float(np.exp(log)) if changed.get("density") else log

    return function


def _expected(pose: Array, mean: Array) -> tuple[Array, Array]:
    dx, dy = mean - pose[:2]
    q = dx**2 + dy**2
    r = np.sqrt(q)
    return np.array([wrapped(np.arctan2(dy, dx) - pose[2]), r]), np.array(
        [[-dy / q, dx / q], [dx / r, dy / r]]
    )


def _log(nu: Array, S: Array) -> float:
    return float(-0.5 * nu @ np.linalg.solve(S, nu) - 0.5 * np.log(np.linalg.det(TURN * S)))


def _by_information(pose: Array, mean: Array, covariance: Array, measurement: Array, R: Array) -> list[Any]:
    expected, H = _expected(pose, mean)
    nu = measurement - expected
    nu[0] = np.angle(np.exp(1j * nu[0]))
    P = np.linalg.inv(np.linalg.inv(covariance) + H.T @ np.linalg.inv(R) @ H)
    S = R + H @ covariance @ H.T
    return [
        mean + P @ H.T @ np.linalg.solve(R, nu),
        P,
        -0.5 * (nu @ np.linalg.inv(S) @ nu + np.linalg.slogdet(TURN * S)[1]),
    ]


def _by_root(pose: Array, mean: Array, covariance: Array, measurement: Array, R: Array) -> tuple[Any, ...]:
    expected, H = _expected(pose, mean)
    nu = np.array([wrapped(measurement[0] - expected[0]), measurement[1] - expected[1]])
    L = np.linalg.cholesky(H @ covariance @ H.T + R)
    A, e = np.linalg.solve(L, H @ covariance), np.linalg.solve(L, nu)
    return mean + A.T @ e, covariance - A.T @ A, -0.5 * e @ e - np.log(np.diag(L)).sum() - np.log(TURN)


def _by_joseph(pose: Array, mean: Array, covariance: Array, measurement: Array, R: Array) -> tuple[Any, ...]:
    expected, H = _expected(pose, mean)
    nu = measurement - expected
    nu[0] = wrapped(nu[0])
    S = H @ covariance @ H.T + R
    K = np.linalg.solve(S, H @ covariance).T
    left = np.eye(2) - K @ H
    return mean + K @ nu, left @ covariance @ left.T + K @ R @ K.T, np.float64(_log(nu, S))


def _sight(rng: np.random.Generator) -> tuple[Array, ...]:
    pose = np.append(rng.uniform((0, -2), (3, 2)), rng.uniform(-np.pi, np.pi))
    bearing, away = rng.uniform(-np.pi, np.pi), rng.uniform(0.6, 3.5)
    toward = pose[2] + bearing
    mean = pose[:2] + away * np.array([np.cos(toward), np.sin(toward)])
    R = spread(rng, 2, 1.0) * np.outer((0.05, 0.15), (0.05, 0.15))
    seen = np.array([bearing, away]) + rng.normal(0, (0.08, 0.2))
    return pose, mean, spread(rng, 2, float(rng.uniform(0.05, 0.3))), np.array([wrapped(seen[0]), seen[1]]), R


def _little_public() -> list[Case]:
    rng = np.random.default_rng(123)
    ahead = np.zeros(3), np.array([2.0, 0.0])
    return [
        Case(
            (*ahead, 0.03 * np.eye(2), np.array([0.0, 2.2]), np.diag([0.0025, 0.01])),
            "straight ahead, as in the docstring",
        ),
        Case(
            (*ahead, 0.03 * np.eye(2), np.array([0.1, 2.0]), np.diag([0.0025, 0.01])),
            "a bearing that surprises",
        ),
        Case(
            (
                np.array([2.0, 0.0, 3.1]),
                np.array([1.0, -0.1]),
                np.diag([0.02, 0.05]),
                np.array([-0.05, 1.1]),
                np.diag([0.004, 0.02]),
            ),
            "looking along the negative x axis",
        ),
        Case(
            (
                np.array([1.0, 1.0, 0.5]),
                np.array([-0.2, 0.35]),
                np.array([[0.03, 0.01], [0.01, 0.02]]),
                np.array([-3.1, 1.3]),
                np.diag([0.004, 0.02]),
            ),
            "a landmark right behind",
        ),
        Case(_sight(rng), "beside the robot"),
        Case(_sight(rng), "behind it"),
        Case(
            (*ahead, np.eye(2), np.array([0.1, 5.5]), np.diag([0.0025, 0.01])),
            "a range that surprises by more than pi",
        ),
    ]


def _little_hidden(rng: np.random.Generator) -> list[Case]:
    behind = rng.uniform(0.5, 2), rng.uniform(-0.02, 0.02)
    return [
        *(Case(_sight(rng)) for _ in range(8)),
        Case(
            (
                np.zeros(3),
                np.array([-behind[0], behind[1]]),
                spread(rng, 2, 0.1),
                np.array([-np.sign(behind[1]) * 3.13, behind[0] + 0.1]),
                np.diag([0.004, 0.02]),
            )
        ),
        Case(
            (
                np.zeros(3),
                np.array([1.0, 0.0]),
                spread(rng, 2, 1.0),
                np.array([0.1, rng.uniform(4.5, 5.5)]),
                np.diag([0.004, 0.02]),
            )
        ),
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
        "It is lesson 06's update with a landmark for a state: H is measurement_jacobian_landmark alone, for the pose is taken as true.",
        "nu, H, S, K, then the three answers, each one line. The log weight has nu from before the correction, and S.",
    ),
    mistakes=[
        Mistake(
            "no wrap",
            _little(no_wrap=True),
            "Your innovation's bearing is not wrapped. expected_measurement wraps what it expects; the difference may still be a turn off: warp2pi(nu[0]).",
        ),
        Mistake(
            "range wrapped, too",
            _little(wrap_both=True),
            "You wrap the range as well. It is no angle: wrap nu[0] alone.",
        ),
        Mistake(
            "weighed by R",
            _little(weighed_by_R=True),
            "You weigh the particle by R. Its landmark is in doubt, too: S of equation 12.3.",
        ),
        Mistake(
            "the gain by R",
            _little(gain_of_R=True),
            "Your gain divides by R. It divides by S, which has the landmark's doubt as well.",
        ),
        Mistake("no R in S", _little(no_R=True), "R is missing in S: the measurement is not exact."),
        Mistake(
            "away from what was seen",
            _little(sign=True),
            "Your landmark moves away from where it was seen: l' = l + K nu, with nu what was measured less what was expected.",
        ),
        Mistake(
            "the covariance kept",
            _little(covariance_kept=True),
            "Your covariance is the old one: P' = P - K H P.",
        ),
        Mistake(
            "weighed afterwards",
            _little(first_update=True),
            "You weigh by what the corrected landmark would expect. The weight asks how well the particle had expected the measurement, before.",
        ),
        Mistake(
            "no determinant",
            _little(no_determinant=True),
            "The determinant is missing in your log weight: particles with a vague landmark would win (equation 12.4).",
        ),
        Mistake(
            "H K for K H",
            _little(exchanged=True),
            "You multiply H K, and it is K H: matrices do not commute, P' = P - K H P.",
        ),
        Mistake(
            "the weight first",
            _little(weight_first=True),
            "Your log weight comes first. The order is mean, covariance, log weight.",
        ),
        Mistake(
            "without a weight",
            _little(no_weight=True),
            "Your answer has two parts. The third is the log weight, the last of equation 12.4.",
        ),
        Mistake(
            "the covariance grows",
            _little(grown=True),
            "Your covariance grows. A measurement takes doubt away: P' = P - K H P.",
        ),
        Mistake(
            "the determinant without 2 pi",
            _little(two_pi=1.0),
            "Your determinant is that of S. It is that of 2 pi S, in two dimensions (2 pi)^2 times as much.",
        ),
        Mistake(
            "one 2 pi",
            _little(two_pi=0.5),
            "You multiply the determinant by 2 pi. Every row of 2 pi S is multiplied: in two dimensions it is (2 pi)^2.",
        ),
        Mistake(
            "no half",
            _little(no_half=True),
            "The half before the quadratic form is missing (equation 12.4).",
        ),
        Mistake(
            "entry by entry",
            _little(by_entries=True),
            "H * P * H.T multiplies entry by entry. The product of matrices is @.",
        ),
        Mistake("the density", _little(density=True), "You return the density. Its logarithm is wanted."),
        Mistake(
            "transposed",
            _little(transposed=True),
            "Your H is transposed: its rows are bearing and range, its columns x and y.",
        ),
    ],
    alternatives={"information": _by_information, "a root of S": _by_root, "Joseph's form": _by_joseph},
    equivalents={
        "log_weight = np.linalg.solve(S, nu) @ (-0.5 * nu) - 0.5 * np.log(np.linalg.det(2 * np.pi * S))": "a product of two vectors has them in any order",
        "return (mean + K @ nu, covariance - K @ H @ covariance, log_weight)": "NumPy's number is as good as Python's",
    },
)


# --- 12.4 intersect_rays ---


def _rays(**changed: Any) -> Any:
    def function(a: Array, u: Array, b: Array, v: Array) -> tuple[Any, Any]:
        nothing = changed.get("nothing", (np.full(3, np.nan), np.nan))
        B, c = b - a, u @ v
        below = 1 - c if changed.get("not_squared") else 1 - c**2
        if (1 - c if changed.get("near_one") else below) < changed.get("limit", 1e-12) and not changed.get(
            "parallel"
        ):
            return nothing
        with np.errstate(all="ignore"):
            along_a = (B @ u - c * (B @ v)) / below
            along_b = (c * (B @ u) - B @ v) / below
        if changed.get("sign"):
            along_b = -along_b
        looked_at = changed.get("looked_at", (along_a, along_b) if not changed.get("first") else (along_a,))
        if changed.get("second"):
            looked_at = (along_b,)
        if changed.get("both_behind"):
            looked_at = (max(along_a, along_b),)
        if min(looked_at, default=0) < 0:
            return nothing
        p, q = a + along_a * u, b + along_b * v
        point = p if changed.get("on_a") else q if changed.get("on_b") else (p + q) / 2
        if changed.get("no_origin"):
            point = (along_a * u + along_b * v) / 2
        if changed.get("summed"):
            point = p + q
        if changed.get("way"):
            return point, q - p
        gap = float(np.linalg.norm(q - p))
        return point, gap / 2 if changed.get("half") else gap**2 if changed.get("squared") else gap

    return function


def _solved(a: Array, u: Array, b: Array, v: Array) -> tuple[Any, Any]:
    t = np.linalg.solve([[u @ u, -(v @ u)], [u @ v, -(v @ v)]], [(b - a) @ u, (b - a) @ v])
    if t.min() < 0:
        return np.full(3, np.nan), np.nan
    p, q = a + t[0] * u, b + t[1] * v
    return (p + q) / 2, np.linalg.norm(p - q)


def _by_least_squares(a: Array, u: Array, b: Array, v: Array) -> list[Any]:
    A = np.column_stack([u, -v])
    (s, t), _, rank, _ = np.linalg.lstsq(A, b - a, rcond=1e-9)
    if rank < 2 or min(s, t) < 0:
        return [np.array([np.nan] * 3), float("nan")]
    return [(a + s * u + b + t * v) / 2, np.linalg.norm(A @ (s, t) - (b - a))]


def _by_cross(a: Array, u: Array, b: Array, v: Array) -> tuple[Any, Any]:
    n = np.cross(u, v)
    length = np.sqrt(n @ n)
    if length < 1e-6:
        return np.nan * a, np.nan
    s = np.linalg.det(np.array([b - a, v, n])) / length**2
    t = np.linalg.det(np.array([b - a, u, n])) / length**2
    if s < 0 or t < 0:
        return np.nan * a, np.nan
    return 0.5 * (a + s * u) + 0.5 * (b + t * v), abs((b - a) @ n) / length


def _by_equations(a: Array, u: Array, b: Array, v: Array) -> tuple[Any, Any]:
    M = np.array([[u @ u, -(v @ u)], [u @ v, -(v @ v)]])
    if abs(np.linalg.det(M)) < 1e-12:
        return np.full(3, np.nan), np.nan
    s, t = np.linalg.solve(M, np.array([(b - a) @ u, (b - a) @ v]))
    if s < 0 or t < 0:
        return np.full(3, np.nan), np.nan
    ends = np.array([a + s * u, b + t * v])
    return ends.mean(axis=0), float(np.sqrt(np.square(np.diff(ends, axis=0)).sum()))


def _unit(vector: Any) -> Array:
    return np.asarray(vector, dtype=float) / np.linalg.norm(vector)


def _eyes(rng: np.random.Generator, apart: float) -> tuple[Array, ...]:
    a = np.array([0.05, 0.0, 0.52]) + rng.normal(0, 0.01, 3)
    b = a - (0.0, 0.0, apart)
    place = np.array([rng.uniform(0.8, 4), rng.uniform(-1, 1), 0.0])
    return a, _unit(place - a + rng.normal(0, 0.005, 3)), b, _unit(place - b + rng.normal(0, 0.005, 3))


def _rays_public() -> list[Case]:
    rng = np.random.default_rng(124)
    return [
        Case(
            (np.array([0.0, 0, 1]), np.array([0.8, 0, -0.6]), np.array([0.0, 0.2, 0]), np.array([1.0, 0, 0])),
            "as in the docstring",
        ),
        Case((np.zeros(3), _unit([1, 1, 0]), np.array([2.0, 0, 0]), _unit([-1, 1, 0])), "two rays that meet"),
        Case(
            (np.array([0.05, 0, 0.52]), _unit([2, 0, -0.5]), np.array([0.05, 0, 0.47]), _unit([2, 0, -0.46])),
            "both cameras of a robot",
        ),
        Case(
            (np.zeros(3), np.array([1.0, 0, 0]), np.array([0.0, 0, 0.05]), np.array([1.0, 0, 0])),
            "parallel rays",
        ),
        Case(
            (np.zeros(3), np.array([1.0, 0, 0]), np.array([0.0, 0, 0.05]), _unit([1, 0, 0.1])),
            "rays that part",
        ),
        Case(
            (np.zeros(3), np.array([1.0, 0, 0]), np.array([1.0, 0.5, 0]), np.array([0.0, 1, 0])),
            "the second would go backwards",
        ),
        Case(
            (np.array([1.0, 0.5, 0]), np.array([0.0, 1, 0]), np.zeros(3), np.array([1.0, 0, 0])),
            "the first would go backwards",
        ),
        Case(
            (np.zeros(3), _unit([2, -1, 0]), np.array([0.0, 0, 0.05]), _unit([2, -1, 0])),
            "parallel, but for rounding",
        ),
        Case(
            (np.zeros(3), _unit([2, -1, 0]), np.array([2.0, -1.0, 0]), _unit([-2, 1, 0])),
            "face to face",
        ),
        Case(_wide(rng), "at a wide angle, near by"),
        Case(_eyes(rng, 0.2), "rays that pass each other"),
        Case(_narrow(5.0), "a landmark a hundred metres away"),
    ]


def _narrow(apart: float) -> tuple[Array, ...]:
    """Two rays, some centimetres from each other at first, that meet far away: 1 - c^2 is some 1e-7."""
    a, b, place = np.array([0.05, 0, 0.5]), np.array([0.05, 0, 0.5 - apart / 100]), np.array([100.0, 0, 0])
    return a, _unit(place - a), b, _unit(place - b)


def _side_by_side(rng: np.random.Generator) -> tuple[Array, ...]:
    """Two parallel rays, whose directions' product is 1 but for rounding."""
    a = np.array([0.05, 0.0, 0.52])
    while True:
        u = _unit([*rng.uniform((1, -1), (4, 1)), 0])
        if u @ u != 1:
            return a, u, a - (0.0, 0.0, rng.uniform(0.03, 0.5)), u.copy()


def _wide(rng: np.random.Generator) -> tuple[Array, ...]:
    """Rays that pass each other less than a metre away, and at a wide angle."""
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
    """Rays of which one alone would have to be followed backwards: the one, then the other."""
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
        "Write B for what lies between the origins and c for the product of the directions: equation 12.5 is two lines with t_a and t_b, because each direction with itself gives 1.",
        "t_a = (B.d_a - c B.d_b) / (1 - c^2), t_b = (c B.d_a - B.d_b) / (1 - c^2). Then the two points, their middle, and the length between.",
    ),
    mistakes=[
        Mistake(
            "on the first ray",
            _rays(on_a=True),
            "Your point lies on the first ray. Neither is better: take the middle between both.",
        ),
        Mistake(
            "on the second ray",
            _rays(on_b=True),
            "Your point lies on the second ray. Neither is better: take the middle between both.",
        ),
        Mistake(
            "followed backwards",
            _rays(looked_at=()),
            "A camera does not see what lies behind it: where t_a or t_b is negative, there is no point.",
        ),
        Mistake(
            "one looked at",
            _rays(first=True),
            "You look at t_a alone. Neither ray is followed backwards: t_b may be negative, too.",
        ),
        Mistake(
            "parallel by rounding",
            _rays(parallel=True),
            "Two parallel rays meet in your answer: 1 - c^2 is some 1e-16 by rounding, hardly ever 0. Where it is below 1e-12, there is no point.",
        ),
        Mistake(
            "nothing looked at",
            _rays(looked_at=(), parallel=True),
            "Two things are not looked at: whether 1 - c^2 is nearly 0, and whether t_a or t_b is negative. In both cases there is no point.",
        ),
        Mistake(
            "one NaN",
            _rays(nothing=(np.nan, np.nan)),
            "Where there is no point, it still has three numbers: np.full(3, np.nan).",
        ),
        Mistake(
            "None",
            _rays(nothing=(None, None)),
            "Where there is no point, NaN is wanted and not None: np.full(3, np.nan), and np.nan for the length.",
        ),
        Mistake(
            "c near 1 alone",
            _rays(near_one=True),
            "Rays that face each other are parallel as well: there c is -1. 1 - c^2 is 0 for both.",
        ),
        Mistake(
            "too soon parallel",
            _rays(limit=1e-6),
            "Your rays are parallel too soon: two that meet at a hundred metres still have a point. They are where 1 - c^2 is below 1e-12.",
        ),
        Mistake(
            "t_b alone looked at",
            _rays(second=True),
            "You look at t_b alone. Neither ray is followed backwards: t_a may be negative, too.",
        ),
        Mistake(
            "both behind",
            _rays(both_behind=True),
            "You ask whether both are negative. One that is behind its camera is enough: or, not and.",
        ),
        Mistake(
            "solved without a look",
            _solved,
            "Parallel rays have no point where they pass, and np.linalg.solve raises for them: look at c before you solve.",
        ),
        Mistake(
            "c not squared",
            _rays(not_squared=True),
            "Your denominator is 1 - c. Solve equation 12.5 again: it is 1 - c squared.",
        ),
        Mistake(
            "t_b's sign",
            _rays(sign=True),
            "Your t_b has the wrong sign: put t_a and t_b back into equation 12.5.",
        ),
        Mistake(
            "from the origin",
            _rays(no_origin=True),
            "You leave out where the rays begin: o_a + t_a d_a, and o_b + t_b d_b.",
        ),
        Mistake(
            "half of the way",
            _rays(half=True),
            "Your length is from the point to a ray. Wanted is that between the rays, twice as much.",
        ),
        Mistake("the sum", _rays(summed=True), "Your point is the sum of both. The middle is half of it."),
        Mistake(
            "the way itself",
            _rays(way=True),
            "Your second answer is the way between the rays, three numbers. Wanted is its length: np.linalg.norm.",
        ),
        Mistake("the square of it", _rays(squared=True), "Your length is squared: take its root."),
    ],
    alternatives={
        "least squares": _by_least_squares,
        "a cross product": _by_cross,
        "two equations": _by_equations,
    },
    equivalents={
        **dict.fromkeys(
            (
                "B, c = (origin_b - origin_a, direction_b @ direction_a)",
                "t_a = (direction_a @ B - c * (B @ direction_b)) / (1 - c ** 2)",
                "t_a = (B @ direction_a - c * (direction_b @ B)) / (1 - c ** 2)",
                "t_b = (c * (B @ direction_a) - direction_b @ B) / (1 - c ** 2)",
                "t_b = (c * (direction_a @ B) - B @ direction_b) / (1 - c ** 2)",
            ),
            "a product of two vectors has them in any order",
        ),
        **dict.fromkeys(
            ("if 1 - c ** 2 <= 1e-12:", "if t_a <= 0 or t_b < 0:", "if t_a < 0 or t_b <= 0:"),
            "none is that number to the last bit",
        ),
        "a, b = (origin_b + t_b * direction_b, origin_a + t_a * direction_a)": "the middle is the same from both ends",
        "return ((a + b) / 2, float(np.linalg.norm(a - b)))": "a way is as long as the way back",
        "return ((a + b) / 2, np.linalg.norm(b - a))": "NumPy's number is as good as Python's",
    },
)


# --- 12.5 find_frontiers, 12.6 travel_steps ---


def _beside(mask: Array, *, corners: bool = False, around: bool = False, rim: bool = False) -> Array:
    rows, columns = mask.shape
    padded = np.pad(mask, 1, mode="wrap") if around else np.pad(mask, 1, constant_values=rim)
    ways = [(a, b) for a in (0, 1, 2) for b in (0, 1, 2) if corners or (a + b) % 2]
    return np.any([padded[a : a + rows, b : b + columns] for a, b in ways], axis=0)


def _inner_only(grid: Array) -> Array:
    found = np.zeros(grid.shape, dtype=bool)
    found[1:-1, 1:-1] = ((grid == 0) & _beside(grid == -1))[1:-1, 1:-1]
    return found


def _from_the_end(grid: Array) -> Array:
    """Above the first row comes the last, as grid[i - 1] has it; below the last one somebody looked."""
    unknown = grid == -1
    found = np.roll(unknown, 1, 0) | np.roll(unknown, 1, 1)
    found[:-1] |= unknown[1:]
    found[:, :-1] |= unknown[:, 1:]
    return found & (grid == 0)


def _over_the_rim(grid: Array) -> Array:
    found = np.zeros(grid.shape, dtype=bool)
    for i, j in np.argwhere(grid == 0):
        found[i, j] = -1 in (grid[i + 1, j], grid[i - 1, j], grid[i, j + 1], grid[i, j - 1])
    return found


def _after_only(grid: Array) -> Array:
    found = np.zeros(grid.shape, dtype=bool)
    found[:-1] |= (grid == -1)[1:]
    found[:, :-1] |= (grid == -1)[:, 1:]
    return found & (grid == 0)


def _by_rolling(grid: Array) -> Array:
    unknown, found = grid < 0, np.zeros(grid.shape, dtype=bool)
    found[1:] |= unknown[:-1]
    found[:-1] |= unknown[1:]
    found[:, 1:] |= unknown[:, :-1]
    found[:, :-1] |= unknown[:, 1:]
    return found & (grid == 0)


def _cell_by_cell(grid: Array) -> list[list[bool]]:
    rows, columns = grid.shape
    return [
        [
            bool(grid[i, j] == 0)
            and any(
                grid[a, b] == -1
                for a, b in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1))
                if 0 <= a < rows and 0 <= b < columns
            )
            for j in range(columns)
        ]
        for i in range(rows)
    ]


def _by_dilation(grid: Array) -> Array:
    from scipy.ndimage import binary_dilation

    return binary_dilation(grid == -1) & (grid == 0)


def _known(rng: np.random.Generator, rows: int, columns: int) -> Array:
    from scipy.ndimage import uniform_filter

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
        Case((ring,), "a known place amid the unknown"),
        Case((np.zeros((3, 4), dtype=int),), "all of it known and free"),
        Case((np.array([[0, 1, -1], [1, 1, 1], [0, 0, 0]]),), "unknown behind walls"),
        Case((np.array([[-1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]),), "an unknown corner"),
        Case((_known(rng, 8, 11),), "a room"),
    ]


def _frontiers_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case((_known(rng, int(rows), int(columns)),))
        for rows, columns in ((1, 7), (6, 1), (5, 9), (12, 7), (20, 30))
    ]


FIND_FRONTIERS = Exercise(
    name="find_frontiers",
    points=2,
    stars=2,
    public=_frontiers_public,
    hidden=_frontiers_hidden,
    comparison=Exact(),
    hints=(
        "Compare the grid with itself, shifted by one cell to each of four sides. What comes in at the rim is not unknown.",
        "np.pad(grid == -1, 1) has a rim of False; padded[:-2, 1:-1] is what lies above each cell.",
    ),
    mistakes=[
        Mistake(
            "corners too",
            lambda grid: (grid == 0) & _beside(grid == -1, corners=True),
            "You count neighbours across a corner. A cell has four neighbours: left, right, above and below.",
        ),
        Mistake(
            "round the rim",
            lambda grid: (grid == 0) & _beside(grid == -1, around=True),
            "Your grid has no rim: np.roll brings the last row in before the first. What lies beyond the rim is no cell.",
        ),
        Mistake(
            "from the other end",
            _from_the_end,
            "Above your first row comes the last, and left of the first column the last one: in Python grid[-1] counts from the end.",
        ),
        Mistake(
            "without brackets",
            lambda grid: grid == 0 & _beside(grid == -1),
            "& binds before ==: put brackets around each comparison, (grid == 0) & beside.",
        ),
        Mistake(
            "over the rim",
            _over_the_rim,
            "In the last row there is no grid[i + 1, j], and in the first one grid[i - 1, j] is the last row. Look only at neighbours inside the grid, or np.pad it.",
        ),
        Mistake(
            "rim left out",
            _inner_only,
            "Your grid's rim has no frontiers. A free cell there has neighbours, too, only fewer.",
        ),
        Mistake(
            "two sides",
            _after_only,
            "You look below and to the right only. A cell has four neighbours.",
        ),
        Mistake(
            "the rim is unknown",
            lambda grid: (grid == 0) & _beside(grid == -1, rim=True),
            "You take what lies beyond the rim for unknown. There is nothing to go and see there.",
        ),
        Mistake(
            "the unknown side",
            lambda grid: (grid == -1) & _beside(grid == 0),
            "Your cells are the unknown ones. A frontier is the free cell beside: one can stand there.",
        ),
        Mistake(
            "boxes too",
            lambda grid: (grid != -1) & _beside(grid == -1),
            "You take occupied cells as well. Nobody can stand in a box: free cells only.",
        ),
        Mistake(
            "unknown cells, too",
            lambda grid: (grid <= 0) & _beside(grid == -1),
            "Unknown cells beside unknown ones are in your mask. A frontier is free.",
        ),
        Mistake(
            "beside a box",
            lambda grid: (grid == 0) & _beside(grid == 1),
            "Your cells lie beside boxes. Unknown cells are -1, occupied ones 1.",
        ),
        Mistake(
            "as numbers",
            lambda grid: np.argwhere((grid == 0) & _beside(grid == -1)),
            "You return places. Wanted is a mask of the grid's shape, True where a frontier is.",
        ),
    ],
    alternatives={"slices": _by_rolling, "cell by cell": _cell_by_cell, "dilation": _by_dilation},
    equivalents={
        **dict.fromkeys(
            (
                f"beside = unknown[:-2, 1:-1] {a} unknown[2:, 1:-1] {b} unknown[1:-1, :-2] {c} unknown[1:-1, 2:]"
                for a, b, c in ("+||", "|+|", "||+")
            ),
            "of two masks, + is or",
        ),
        "return (grid == 0) * beside": "of two masks, * is and",
        "unknown = np.pad(grid <= -1, 1)": "no cell is below -1",
    },
)


def _poured(**changed: Any) -> Any:
    def function(free: Array, start: tuple[int, int]) -> Array:
        steps = np.full(free.shape, 0 if changed.get("zeros") else -1)
        seen = np.zeros(free.shape, dtype=bool)
        steps[start], seen[start] = (1 if changed.get("from_one") else 0), True
        wave = deque([start])
        ways = [(1, 0), (-1, 0), (0, 1), (0, -1)]
        if changed.get("corners"):
            ways += [(1, 1), (1, -1), (-1, 1), (-1, -1)]
        while wave:
            row, column = wave.pop() if changed.get("deep") else wave.popleft()
            for a, b in ways:
                i, j = row + a, column + b
                if changed.get("around"):
                    i, j = i % free.shape[0], j % free.shape[1]
                if 0 <= i < free.shape[0] and 0 <= j < free.shape[1] and not seen[i, j]:
                    if free[i, j] or changed.get("through"):
                        steps[i, j], seen[i, j] = steps[row, column] + 1, True
                        wave.append((i, j))
                    elif changed.get("onto"):
                        steps[i, j], seen[i, j] = steps[row, column] + 1, True
        return steps

    return function


def _one_sweep(free: Array, start: tuple[int, int]) -> Array:
    steps = np.full(free.shape, free.size)
    steps[start] = 0
    for i, j in np.argwhere(free):
        beside = [
            steps[a, b]
            for a, b in ((i - 1, j), (i, j - 1), (i + 1, j), (i, j + 1))
            if 0 <= a < free.shape[0] and 0 <= b < free.shape[1]
        ]
        steps[i, j] = min(steps[i, j], min(beside, default=free.size) + 1)
    return np.where(steps < free.size, steps, -1)


def _over_the_end(free: Array, start: tuple[int, int]) -> Array:
    steps, wave = np.full(free.shape, -1), [start]
    steps[start] = 0
    for i, j in wave:
        for cell in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            if free[cell] and steps[cell] == -1:
                steps[cell] = steps[i, j] + 1
                wave.append(cell)
    return steps


def _begun_with_zeros(free: Array, start: tuple[int, int]) -> Array:
    """0 says both: nobody was here, and here it starts."""
    steps, wave = np.zeros(free.shape, dtype=int), [start]
    for i, j in wave:
        for cell in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            inside = 0 <= cell[0] < free.shape[0] and 0 <= cell[1] < free.shape[1]
            if inside and free[cell] and not steps[cell]:
                steps[cell] = steps[i, j] + 1
                wave.append(cell)
    return steps


def _below_the_end(free: Array, start: tuple[int, int]) -> Array:
    """The far rim is looked at, the near one is not."""
    steps, wave = np.full(free.shape, -1), [start]
    steps[start] = 0
    for i, j in wave:
        for cell in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            inside = cell[0] < free.shape[0] and cell[1] < free.shape[1]
            if inside and free[cell] and steps[cell] < 0:
                steps[cell] = steps[i, j] + 1
                wave.append((cell[0] % free.shape[0], cell[1] % free.shape[1]))
    return steps


def _exchanged(free: Array, start: tuple[int, int]) -> Array:
    column, row = start
    return _poured()(free, (row, column))


def _straight(free: Array, start: tuple[int, int]) -> Array:
    rows, columns = np.indices(free.shape)
    return np.where(free, np.abs(rows - start[0]) + np.abs(columns - start[1]), -1)


def _as_a_whole(free: Array, start: tuple[int, int], most: float = np.inf) -> Array:
    steps, wet = np.full(free.shape, -1), np.zeros(free.shape, dtype=bool)
    wet[start], steps[start], count = True, 0, 0
    while True:
        new = _beside(wet) & free & ~wet
        if count >= most or not new.any():
            return steps
        count += 1
        steps[new] = count
        wet |= new


def _by_relaxing(free: Array, start: tuple[int, int]) -> Array:
    cost = np.full(np.add(free.shape, 2), np.inf)
    cost[start[0] + 1, start[1] + 1] = 0
    inner = cost[1:-1, 1:-1]
    while True:
        before = inner.copy()
        best = np.min([cost[:-2, 1:-1], cost[2:, 1:-1], cost[1:-1, :-2], cost[1:-1, 2:]], axis=0) + 1
        inner[free] = np.minimum(inner, best)[free]
        if np.array_equal(before, inner):
            return np.where(np.isfinite(inner), inner, -1).astype(int)


def _by_graph(free: Array, start: tuple[int, int]) -> Array:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    numbers = np.arange(free.size).reshape(free.shape)
    pairs = (
        [np.ravel(side) for side in (numbers[:, :-1], numbers[:-1])],
        [np.ravel(side) for side in (numbers[:, 1:], numbers[1:])],
    )
    first, second = np.concatenate(pairs[0]), np.concatenate(pairs[1])
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
    rng = np.random.default_rng(126)
    spiral = np.array(
        [[1, 1, 1, 1, 1], [0, 0, 0, 0, 1], [1, 1, 1, 0, 1], [1, 0, 0, 0, 1], [1, 1, 1, 1, 1]], dtype=bool
    )
    return [
        Case((np.array([[True, False, True], [True, True, True]]), (0, 0)), "as in the docstring"),
        Case((np.ones((4, 6), dtype=bool), (1, 2)), "an empty room"),
        Case((spiral, (0, 0)), "a way that winds"),
        Case(
            (np.array([[True, True, False, True], [True, True, False, True]]), (1, 0)), "what no way leads to"
        ),
        Case((np.ones((1, 1), dtype=bool), (0, 0)), "a single cell"),
        Case(_maze(rng, 8, 9), "a maze"),
        Case(_winding(21, 12), "a way of more than 127 steps"),
        Case((np.ones((54, 44), dtype=bool), (3, 20)), "an empty room as large as the panel's"),
    ]


def _winding(rows: int, columns: int) -> tuple[Array, tuple[int, int]]:
    """Lanes to and fro, with a wall between each two and a door at one end of it."""
    free = np.ones((rows, columns), dtype=bool)
    free[1::2] = False
    free[1::4, -1] = free[3::4, 0] = True
    return free, (0, 0)


def _steps_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case(_maze(rng, int(rows), int(columns)))
        for rows, columns in ((5, 8), (9, 4), (15, 15), (1, 12), (25, 30))
    ] + [Case(_winding(2 * int(rng.integers(9, 13)) + 1, int(rng.integers(14, 18))))]


TRAVEL_STEPS = Exercise(
    name="travel_steps",
    points=3,
    stars=3,
    public=_steps_public,
    hidden=_steps_hidden,
    comparison=Exact(),
    hints=(
        "Keep a list of cells that were reached and whose neighbours were not looked at yet. Take them in the order in which they came.",
        "wave = [start]; take wave.pop(0), and give each free neighbour that still has -1 one step more than it; append that to wave.",
    ),
    mistakes=[
        Mistake(
            "across corners",
            _poured(corners=True),
            "Your steps lead across corners. A step leads to one of four neighbours.",
        ),
        Mistake(
            "the last first",
            _poured(deep=True),
            "You take the cell that came last, and follow one way to its end: its steps are too many. Take the one that came first, wave.pop(0).",
        ),
        Mistake("through boxes", _poured(through=True), "Your way leads through cells that are not free."),
        Mistake(
            "onto boxes",
            _poured(onto=True),
            "Cells that are not free have steps in your answer. No way leads onto them: -1.",
        ),
        Mistake(
            "straight",
            _straight,
            "You count rows and columns between. A way around what stands there is longer, and may not exist.",
        ),
        Mistake(
            "0 where none leads",
            _poured(zeros=True),
            "Cells that no way leads to have 0 in your answer, as if one stood there: -1.",
        ),
        Mistake(
            "from one",
            _poured(from_one=True),
            "You begin with 1. To where it stands the robot takes no step.",
        ),
        Mistake(
            "below the end",
            _below_the_end,
            "Row -1 and column -1 are inside for you: an index is at least 0, too, or it counts from the end.",
        ),
        Mistake(
            "begun with zeros",
            _begun_with_zeros,
            "0 is the start's number of steps and cannot mean not reached yet as well: fill with -1 at first.",
        ),
        Mistake(
            "over the end",
            _over_the_end,
            "Beyond the last row there is no cell, and row -1 is the last one: ask whether a neighbour is inside before you look at it.",
        ),
        Mistake(
            "infinite",
            lambda free, start: np.where(_poured()(free, start) < 0, np.inf, _poured()(free, start)),
            "Where no way leads you have infinity, and so your steps are floats. Wanted are whole numbers, and -1 there.",
        ),
        Mistake(
            "row and column exchanged",
            _exchanged,
            "Your wave starts in another cell, if there is one: start is (row, column), and steps[row, column].",
        ),
        Mistake(
            "one sweep",
            _one_sweep,
            "You go over the grid once. A way that winds comes back to where you have been: repeat until nothing changes, or pour water.",
        ),
        Mistake(
            "twenty sweeps",
            lambda free, start: _as_a_whole(free, start, 20),
            "You stop after a fixed number of rounds. A way that winds may be as long as the room has cells: go on until nothing changes.",
        ),
        Mistake(
            "a hundred sweeps",
            lambda free, start: _as_a_whole(free, start, 100),
            "A hundred rounds are enough for most rooms, and not for all: a way that winds may be as long as the room has cells. Go on until nothing changes.",
        ),
        Mistake(
            "rows and columns sweeps",
            lambda free, start: _as_a_whole(free, start, sum(free.shape)),
            "You stop after as many rounds as there are rows and columns. A way that winds is longer: go on until nothing changes.",
        ),
        Mistake(
            "round the rim",
            _poured(around=True),
            "Your way leads over the rim and in on the other side: a negative index counts from the end.",
        ),
    ],
    alternatives={"as a whole": _as_a_whole, "relaxing": _by_relaxing, "SciPy's Dijkstra": _by_graph},
    equivalents={
        "inside = 0 <= cell[0] != free.shape[0] and 0 <= cell[1] < free.shape[1]": "a neighbour is one row beyond at most",
        "inside = 0 <= cell[0] < free.shape[0] and 0 <= cell[1] != free.shape[1]": "a neighbour is one column beyond at most",
        "for cell in ((row - 1, column), (row + 1, column), (row, column + 1), (row, column - 1)):": "neighbours come in any order",
    },
)


# --- 12.7 choose_move ---


def _doubt_after(state: Array, covariance: Array, option: Any, **changed: Any) -> tuple[Array, Array]:
    k = (len(state) - 3) // 2
    noise = np.zeros((3, 3)) if changed.get("no_noise") else option.control_covariance
    found = predict(state, covariance, option.control, noise, k)
    if changed.get("old_covariance") and len(option.indices):
        found = found[0], covariance
    if len(option.indices) and not changed.get("blind"):
        found = update_landmarks(*found, option.indices, option.measurements, option.measurement_covariance)
    return found


def _chooser(measure: Callable[[Array], float], pick: Any = np.argmin, **changed: Any) -> Any:
    def function(state: Array, covariance: Array, options: Any) -> int:
        return int(pick([measure(_doubt_after(state, covariance, each, **changed)[1]) for each in options]))

    return function


def _carried_over(state: Array, covariance: Array, options: Any) -> int:
    """The belief after one option is that before the next."""
    doubts = []
    for option in options:
        state, covariance = _doubt_after(state, covariance, option)
        doubts.append(_position(covariance))
    return int(np.argmin(doubts))


def _look_first(state: Array, covariance: Array, options: Any) -> int:
    doubts = []
    for option in options:
        found = update_landmarks(
            state, covariance, option.indices, option.measurements, option.measurement_covariance
        )
        k = (len(state) - 3) // 2
        doubts.append(_position(predict(*found, option.control, option.control_covariance, k)[1]))
    return int(np.argmin(doubts))


def _last_of_equals(state: Array, covariance: Array, options: Any) -> int:
    doubts = [_position(_doubt_after(state, covariance, option)[1]) for option in options]
    return len(doubts) - 1 - int(np.argmin(doubts[::-1]))


def _itself(state: Array, covariance: Array, options: Any) -> Any:
    return options[_in_order(state, covariance, options)]


def _too_few(state: Array, covariance: Array, options: Any) -> int:
    doubts = []
    for option in options:
        m = len(option.indices)
        found = predict(state, covariance, option.control, option.control_covariance, m)
        if m:
            found = update_landmarks(
                *found, list(range(m)), option.measurements, option.measurement_covariance
            )
        doubts.append(_position(found[1]))
    return int(np.argmin(doubts))


def _position(P: Array) -> float:
    return float(P[0, 0] + P[1, 1])


def _with_heading(P: Array) -> float:
    return float(np.trace(P[:3, :3]))


def _area(P: Array) -> float:
    return float(np.linalg.det(P[:2, :2]))


def _summed_roots(P: Array) -> float:
    return float(np.sqrt(P[0, 0]) + np.sqrt(P[1, 1]))


def _most_landmarks(state: Array, covariance: Array, options: Any) -> int:
    return int(np.argmax([len(each.indices) for each in options]))


def _in_order(state: Array, covariance: Array, options: Any) -> int:
    best, least = 0, np.inf
    for number, option in enumerate(options):
        doubt = np.trace(_doubt_after(state, covariance, option)[1][:2, :2])
        if doubt < least:
            best, least = number, doubt
    return best


def _by_ranking(state: Array, covariance: Array, options: Any) -> Any:
    roots = [np.hypot(*np.sqrt(np.diag(_doubt_after(state, covariance, each)[1])[:2])) for each in options]
    return np.argsort(roots, kind="stable")[0]


def _without_landmarks(state: Array, covariance: Array, options: Any) -> int:
    """Only what is seen stays in the state: the same pose."""

    def doubt(option: Any) -> float:
        rows = [0, 1, 2, *(3 + 2 * i + c for i in option.indices for c in (0, 1))]
        own = Option(
            option.control,
            option.control_covariance,
            list(range(len(option.indices))),
            option.measurements,
            option.measurement_covariance,
        )
        return _position(_doubt_after(state[rows], covariance[np.ix_(rows, rows)], own)[1])

    return min(range(len(options)), key=lambda number: doubt(options[number]))


def _situation(rng: np.random.Generator, k: int, moves: int) -> tuple[Array, Array, list[Option]]:
    pose = np.append(rng.uniform((0.5, -1), (2, 1)), rng.uniform(-np.pi, np.pi))
    landmarks = rng.uniform((0, -2), (3, 2), (k, 2))
    covariance = spread(rng, 3 + 2 * k, 0.1)
    options = []
    for _ in range(moves):
        control = np.array([rng.uniform(0, 0.4), rng.uniform(-1.5, 1.5)])
        after = (Pose.from_array(pose) @ Pose(control[0], 0.0, control[1])).as_array()
        seen = [i for i in rng.permutation(k).tolist() if rng.random() < 0.5]
        expected = range_and_bearing(after, landmarks[seen]).reshape(-1, 2)
        noises = np.array([np.diag([0.03**2, (0.05 * r) ** 2]) for _, r in expected]).reshape(-1, 2, 2)
        noise = np.diag(
            np.square([0.1 * control[0] + 0.01, 0.05 * control[0] + 0.01, 0.02 + 0.1 * abs(control[1])])
        )
        options.append(Option(control, noise, seen, expected.ravel(), noises))
    return np.append(pose, landmarks), covariance, options


def _moves_public() -> list[Case]:
    def drawn(k: int, moves: int, seed: int) -> tuple[Array, Array, list[Option]]:
        return _situation(np.random.default_rng([127, k, seed]), k, moves)

    state, covariance, offered = drawn(2, 3, 0)
    return [
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


def _telling(rng: np.random.Generator, k: int, moves: int, other: Callable[..., int]) -> Case:
    """A situation in which another rule chooses another move."""
    while True:
        situation = _situation(rng, k, moves)
        if other(*situation) != _in_order(*situation):
            return Case(situation)


def _moves_hidden(rng: np.random.Generator) -> list[Case]:
    state, covariance, offered = _situation(rng, 3, 4)
    others: list[Any] = [
        _chooser(measure)
        for measure in (
            _area,
            _summed_roots,
            _with_heading,
            lambda P: float(P[0, 0]),
            lambda P: float(P[1, 1]),
        )
    ]
    return [
        Case((state, covariance, [*offered, *offered])),
        *(_telling(rng, 4, 8, other) for other in (*others, _most_landmarks, _carried_over)),
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
        "Ask your filter what it would believe: predict with the option's control, then update_landmarks with what the option expects to see. The real state stays as it is.",
        "The sum is P[0, 0] + P[1, 1] of the covariance after both. np.argmin of the list takes the first of equals. Where nothing is seen there is nothing to update.",
    ),
    mistakes=[
        Mistake(
            "the largest",
            _chooser(_position, np.argmax),
            "You take the move after which the robot knows least.",
        ),
        Mistake(
            "without a look",
            _chooser(_position, blind=True),
            "You leave out what will be seen: then the shortest move wins always. Let update_landmarks take it in.",
        ),
        Mistake(
            "without noise",
            _chooser(_position, no_noise=True),
            "Your moves cost nothing: predict wants the option's control_covariance.",
        ),
        Mistake(
            "the whole map",
            _chooser(lambda P: float(np.trace(P))),
            "You sum all variances of the map. The position's two are asked for.",
        ),
        Mistake(
            "the heading, too",
            _chooser(_with_heading),
            "You add the heading's variance, in rad squared, to the position's, in m squared. The position's two are asked for.",
        ),
        Mistake(
            "determinant",
            _chooser(_area),
            "You compare the ellipses' areas. A long thin one has a small area: the sum of the two variances is asked for.",
        ),
        Mistake(
            "x alone",
            _chooser(lambda P: float(P[0, 0])),
            "You look at x alone. The variances of x and y are summed.",
        ),
        Mistake(
            "carried over",
            _carried_over,
            "Your second option begins where the first one ended: state and covariance are overwritten in the loop. Each option begins with what was given.",
        ),
        Mistake(
            "the look before the move",
            _look_first,
            "You update before you predict. What an option shows is seen after its move.",
        ),
        Mistake(
            "y alone",
            _chooser(lambda P: float(P[1, 1])),
            "You look at y alone. The variances of x and y are summed.",
        ),
        Mistake(
            "the longest axis",
            _chooser(lambda P: float(np.linalg.eigvalsh(P[:2, :2]).max())),
            "You compare the ellipses' longest axes. The sum of the two variances is asked for.",
        ),
        Mistake(
            "standard deviations",
            _chooser(_summed_roots),
            "You sum the standard deviations. The variances are summed, P'_xx + P'_yy (equation 12.7).",
        ),
        Mistake(
            "the last of equals",
            _last_of_equals,
            "Of equal options you take the last one. The first is asked for: < and not <=.",
        ),
        Mistake(
            "the option itself",
            _itself,
            "You return the option. Its number is asked for: np.argmin of the sums.",
        ),
        Mistake(
            "k of the option",
            _too_few,
            "predict wants how many landmarks the map has, (len(state) - 3) // 2, and update_landmarks which ones are seen: the option's indices.",
        ),
        Mistake(
            "the old covariance",
            _chooser(_position, old_covariance=True),
            "update_landmarks gets the covariance from before the move: both that predict returns go in.",
        ),
        Mistake(
            "most landmarks",
            _most_landmarks,
            "You take the move that shows most landmarks. One that is well known tells more than three that are not: ask the covariance.",
        ),
    ],
    alternatives={"in order": _in_order, "by ranking": _by_ranking, "only what is seen": _without_landmarks},
    equivalents={
        **dict.fromkeys(
            (
                *(
                    f"k = len(state[3:]) {sign} 2"
                    for sign in ("+", "-", "*", "/", "%", "**", ">>", "<<", "|", "&", "^")
                ),
                *(
                    f"k = {other}"
                    for other in ("len(state[3:]) // 3", "len(state[3:]) // 1", "len(state[3:])", "2")
                ),
                *(
                    f"k = {other}"
                    for other in ("len(state[4:]) // 2", "len(state[2:]) // 2", "state[3:] // 2")
                ),
                "k = len(state[:]) // 2",
            ),
            "predict of the solution of lesson 07 sees by the state how many landmarks there are",
        ),
        "if True:": "update_landmarks of the solution of lesson 07 takes in nothing as nothing",
        "return np.argmin(doubts)": "NumPy's number is as good as Python's",
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
            "Two thousand particles cover a pose: 10 cm, 10 cm and 10 degrees between neighbours would take some 40,000. How many would a pose and ten landmarks need at the same spacing?",
            {
                "Eleven times as many: one more unknown place for each landmark.": "Places do not add up, they multiply: each place of the first landmark can go with each of the second.",
                "Twenty times as many, for twenty more numbers.": "Each number multiplies the count by its steps; it does not add to it.",
                "About a thousand to the power of ten times as many.": "Each landmark has some 1000 places of 10 cm on the half field, and each combination is another map: 10 to the power of 30.",
            },
            "About a thousand to the power of ten times as many.",
        ),
        Question(
            "why_overconfident",
            "FastSLAM's covariance is the scatter of its particles. Why is it too small when few ancestors are left?",
            {
                "The particles forget how the drive began.": "They remember it too well: all of them remember the same beginning.",
                "All share the errors of one beginning, and what all share does not scatter.": "The path's first part is one sample. Its error is in every map and in every pose, and nothing in the cloud shows it.",
                "Resampling makes the noise of odometry smaller.": "Each particle still draws its errors from the same distribution. What is lost is how different their pasts are.",
            },
            "All share the errors of one beginning, and what all share does not scatter.",
        ),
        Question(
            "when_both_pay",
            "At 320x240 and 2 m one camera and both are about equally good. And at 4 m?",
            {
                "Both are better: lean costs more from afar.": "It does, four times as much as at 2 m. So does a pixel: the rays cross under half the angle, and near each other a small error of an angle shifts the crossing far.",
                "One camera is better: from afar the two rays are nearly parallel.": "They are, and a pixel costs four times as much as at 2 m. So does the lean for one camera.",
                "As good as each other: both errors grow with the square of the distance.": "There is no r in their ratio. What decides is a pixel's angle beside the lean: the resolution.",
            },
            "As good as each other: both errors grow with the square of the distance.",
        ),
        Question(
            "greedy",
            "From the blind start your choice ended less sure than chance. Why?",
            {
                "It looks only one move ahead. With two it would have turned to the goal.": "Two moves ahead its map is as empty as one move ahead: there, too, it would expect to see nothing.",
                "What is not on its map counts for nothing, so for some moves it keeps looking at the one landmark that it has found.": "Each option shows what the map knows. The goal is not on it, and so no option promises anything over there. Chance has no such prejudice: after four moves it has found five landmarks (median), your choice one.",
                "With its back to the goal it errs more at each move.": "Odometry errs by the same everywhere: over the first four moves both know equally little.",
            },
            "What is not on its map counts for nothing, so for some moves it keeps looking at the one landmark that it has found.",
        ),
    ],
    written=[
        Written(
            "when_to_stop",
            points=2,
            question="Your robot may explore, or look again at what it knows. When is which one better, and how would you let it decide?",
            rubric="1 point: exploring raises the pose's doubt (odometry's noise, new landmarks as uncertain as the pose) and adds to the map; looking again lowers the doubt (a loop is closed). "
            "1 point: a rule that weighs both in one measure: the expected entropy or summed variance of pose and map, or a limit for the pose's doubt beyond which the robot goes back to what it knows.",
        )
    ],
)
