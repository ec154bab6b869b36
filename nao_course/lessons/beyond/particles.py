"""Particle filters with a student's functions: global localisation, and FastSLAM."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course._internal.counts import say_count
from nao_course.exercises import Close, Verdict, register
from nao_course.field_slam.drives import inside
from nao_course.geometry import FloatArray, Pose, pose_errors, wrap_angle
from nao_course.lessons.beyond.worlds import FIELD, LANDMARKS, SENSOR, moved
from nao_course.metrics import squared_distances
from nao_course.sim import Field
from nao_course.sim.drives import Function, Step
from nao_course.slam import LandmarkKind, Motion

# Density of a false measurement, 1 / (rad m): a single outlier must not remove the right particles.
CLUTTER = 1e-3


# --- global localisation ---


def anywhere(n: int, rng: np.random.Generator, field: Field = FIELD) -> FloatArray:
    """Draw particles (n, 3) all over a field, by default the half field, with any heading."""
    low, high = np.array(inside(field)) + ((-0.2, -0.2), (0.2, 0.2))
    return np.column_stack([rng.uniform(low, high, (n, 2)), rng.uniform(-np.pi, np.pi, n)])


def weigh_unnamed(
    weigh: Function, particles: FloatArray, kind: LandmarkKind, seen: FloatArray, field: Field = FIELD
) -> FloatArray:
    """Return the log weights (n,) of particles for one measurement of a landmark whose kind alone is known.

    Each landmark of this kind is equally probable, so the weight is the mean over all of them.
    """
    [R] = SENSOR.covariances(seen[None])
    marks = zip(field.detectable_positions, field.detectable_kinds, strict=True)
    places = [place for place, each in marks if each == kind]
    logs = np.array(
        [
            log_weights(weigh(particles.copy(), place.copy(), seen.copy(), R.copy()), len(particles))
            for place in places
        ]
    )
    return np.logaddexp(np.logaddexp.reduce(logs, axis=0) - np.log(len(places)), np.log(CLUTTER))


def log_weights(answer: Any, n: int) -> FloatArray:
    """Return the log weights of a student's `weigh` as an array (n,); ValueError if they are anything else."""
    logs = np.array(answer, dtype=float)
    if n == 1 and logs.ndim == 0:
        logs = logs[None]
    if logs.shape != (n,):
        raise ValueError(f"weigh must return {n} log weights, got shape {logs.shape}")
    if np.isnan(logs).any():
        raise ValueError("weigh returned NaN")
    return logs


@register
@dataclass(frozen=True)
class LogWeights(Close):
    """Close, and a single number is right for a single particle, as SciPy's ``logpdf`` returns it."""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare log weights (N,) with the expected ones."""
        return super().compare(expected, _as_row(expected, got))

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether log weights (N,) are a mistake's."""
        return super().alike(answer, _as_row(answer, got))


def _as_row(expected: Any, got: Any) -> Any:
    """Return a single number as a row, if a row of one number is expected."""
    alone = np.shape(expected) == (1,) and isinstance(got, int | float | np.number)
    return np.array([got]) if alone else got


def normalised(logs: FloatArray) -> FloatArray:
    """Return weights (n,) with sum 1 from log weights; subtracting the largest first avoids underflow."""
    weights = np.exp(logs - logs.max())
    return np.asarray(weights / weights.sum())


def effective(weights: FloatArray) -> float:
    """Return the effective number of particles: 1 over the sum of the squared weights."""
    return float(1 / np.square(weights).sum())


def chosen(answer: Any, n: int) -> npt.NDArray[np.intp]:
    """Return the n indices of a student's `resample`; ValueError if they are not indices from 0 to n - 1."""
    if answer is None:
        raise ValueError("resample returned None: does it end with return?")
    numbers = np.array(answer)
    if numbers.shape != (n,) or numbers.dtype.kind not in "iu":
        raise ValueError(
            f"resample must return {n} whole numbers, got shape {numbers.shape} of {numbers.dtype}"
        )
    if n and not 0 <= numbers.min() <= numbers.max() < n:
        raise ValueError(f"resample must return numbers from 0 to {n - 1}")
    return numbers.astype(np.intp)


@register
def systematic(args: tuple[Any, ...], kwargs: dict[str, Any], answer: Any) -> str:
    """Return what is wrong with the draws of `resample` by equation 12.1, however they were computed, or an empty text.

    The arguments are weights (N,) and a seed for each draw, of which some occur twice; the answer has N indices per
    draw.
    """
    weights, seeds = args
    n = len(weights)
    if len(answer) != len(seeds):
        return f"there are {len(answer)} answers to {len(seeds)} calls"
    for draw in answer:
        try:
            chosen(draw, n)
        except ValueError as error:
            return str(error)
    counts = np.array([np.bincount(np.asarray(draw), minlength=n) for draw in answer])
    first = dict(zip(reversed(seeds), counts[::-1], strict=True))
    if any((first[seed] != row).any() for seed, row in zip(seeds, counts, strict=True)):
        return "two generators with the same seed gave different answers: use only the given rng"
    return _odd_counts(weights, counts)


def _odd_counts(weights: FloatArray, counts: npt.NDArray[np.intp]) -> str:
    """Say how counts (S, N) of particles differ from floor(N w) or ceil(N w), or their mean from N w."""
    n, draws = len(weights), len(counts)
    least, most = np.floor(n * weights + 1e-9), np.ceil(n * weights - 1e-9)
    odd = np.argwhere((counts < least) | (counts > most))
    if len(odd):
        draw, i = odd[0]
        allowed = f"{least[i]:g}" if least[i] == most[i] else f"{least[i]:g} or {most[i]:g}"
        return (
            f"particle {i} of {n}, of weight {weights[i]:.3g}, was kept {say_count(int(counts[draw, i]), 'time')}; "
            f"systematic resampling allows {allowed}"
        )
    off = np.abs(counts.mean(axis=0) - n * weights)
    i = int(off.argmax())
    if off[i] > 2.5 / np.sqrt(draws):  # 5 standard deviations of a mean, at most half a copy each
        return (
            f"over {draws} calls particle {i} of {n}, of weight {weights[i]:.3g}, was kept "
            f"{counts[:, i].mean():.2f} times on average, not {n * weights[i]:.2f} times"
        )
    return ""


def find_itself(
    weigh: Function,
    resample: Function,
    steps: Iterable[Step],
    rng: np.random.Generator,
    n: int = 1000,
    field: Field = FIELD,
) -> list[FloatArray]:
    """Return the n particles (n, 3) at the start and after each step on a known map, first spread everywhere.

    Only the kinds of the landmarks are used.
    """
    particles = anywhere(n, rng, field)
    clouds = [particles]
    for step in steps:
        if step.motion is not None:
            particles = moved(particles, step.motion, rng.standard_normal((n, 3)))
        logs = np.zeros(n)
        for number, seen in zip(step.numbers, step.measurements, strict=True):
            logs = logs + weigh_unnamed(weigh, particles, field.detectable_kinds[number], seen, field)
        if len(step.numbers):
            particles = particles[chosen(resample(normalised(logs), rng), n)]
        clouds.append(particles)
    return clouds


# --- FastSLAM ---


@dataclass(frozen=True)
class ParticleBelief:
    """Estimate of a pose: mean (3,) and covariance (3, 3), in m and rad."""

    pose: FloatArray
    covariance: FloatArray

    def error(self, truth: FloatArray) -> FloatArray:
        """Return estimated minus true pose (3,), with a wrapped heading."""
        return pose_errors(self.pose, truth)

    def nees(self, truth: FloatArray) -> float:
        """Return the normalised estimation error squared, with at least 0.1 mm and 0.01 degrees of uncertainty."""
        least = np.diag([1e-8, 1e-8, np.radians(0.01) ** 2])
        return float(squared_distances(self.error(truth)[None], (self.covariance + least)[None])[0])


class FastSlam:
    """FastSLAM 1.0 (Montemerlo et al. 2002): each particle is a path with its own map; association is known.

    The first pose is known. `update_particle_landmark` and `resample` are the student's; `n` is the number of
    particles.
    """

    def __init__(
        self,
        start: Pose,
        update_particle_landmark: Function,
        resample: Function,
        n: int,
        rng: np.random.Generator,
    ) -> None:
        """Start with an empty map."""
        self._update, self._resample, self._rng = update_particle_landmark, resample, rng
        self.poses = np.tile(start.as_array(), (n, 1))
        self.means = np.zeros((n, len(LANDMARKS), 2))
        self.covariances = np.zeros((n, len(LANDMARKS), 2, 2))
        self.known = np.zeros(len(LANDMARKS), dtype=bool)
        self.logs = np.zeros(n)
        self.ancestors = np.arange(n)
        self.paths = self.poses[:, None].copy()

    def move(self, motion: Motion) -> None:
        """Move all particles, each with its own error."""
        self.poses = moved(self.poses, motion, self._rng.standard_normal(self.poses.shape))

    def observe(self, numbers: Sequence[int], measurements: FloatArray) -> None:
        """Update the map and the weight of each particle, and resample if the weights are too uneven."""
        for number, seen in zip(numbers, measurements, strict=True):
            if self.known[number]:
                self.correct(int(number), seen)
            else:
                self._add(int(number), seen)
        if effective(self.weights) < len(self.poses) / 2:
            self._keep(chosen(self._resample(self.weights, self._rng), len(self.poses)))
        self.paths = np.concatenate([self.paths, self.poses[:, None]], axis=1)

    @property
    def weights(self) -> FloatArray:
        """Weights of the particles (n,), with sum 1."""
        return normalised(self.logs)

    def belief(self) -> ParticleBelief:
        """Return mean and covariance of the particles' poses."""
        weights = self.weights
        mean = weights @ self.poses
        mean[2] = np.arctan2(weights @ np.sin(self.poses[:, 2]), weights @ np.cos(self.poses[:, 2]))
        off = self.poses - mean
        off[:, 2] = wrap_angle(off[:, 2])
        return ParticleBelief(mean, (weights[:, None] * off).T @ off)

    def correct(self, number: int, seen: FloatArray) -> None:
        """Update a landmark in each particle, one after another; a benchmark overrides this with a faster version."""
        [R] = SENSOR.covariances(seen[None])
        for i, pose in enumerate(self.poses):
            mean, covariance, log_weight = self._update(
                pose.copy(), self.means[i, number].copy(), self.covariances[i, number].copy(), seen.copy(), R
            )
            self.means[i, number], self.covariances[i, number] = mean, covariance
            self.logs[i] += float(log_weight)

    def _add(self, number: int, seen: FloatArray) -> None:
        """Add a landmark to each particle's map, with the covariance of its first measurement."""
        directions = self.poses[:, 2] + seen[0]
        cos, sin = np.cos(directions), np.sin(directions)
        self.means[:, number] = self.poses[:, :2] + seen[1] * np.column_stack([cos, sin])
        jacobians = np.array([[-seen[1] * sin, cos], [seen[1] * cos, sin]]).transpose(2, 0, 1)
        self.covariances[:, number] = (
            jacobians @ SENSOR.covariances(seen[None]) @ jacobians.transpose(0, 2, 1)
        )
        self.known[number] = True

    def _keep(self, numbers: npt.NDArray[np.intp]) -> None:
        self.poses, self.means, self.covariances = (
            each[numbers] for each in (self.poses, self.means, self.covariances)
        )
        self.ancestors, self.paths = self.ancestors[numbers], self.paths[numbers]
        self.logs = np.zeros(len(numbers))


@dataclass(frozen=True, eq=False)
class ParticleRun:
    """Errors of an algorithm on a drive of S steps: of the position, in m, and the NEES of the pose, each (S,).

    FastSLAM adds the number of initial particles with descendants and the effective number of particles, each (S,), and
    the paths of its n particles at the end (n, S + 1, 3).
    """

    errors: FloatArray
    nees: FloatArray
    ancestors: FloatArray
    effective: FloatArray
    paths: FloatArray


def run_fast_slam(slam: FastSlam, steps: Iterable[Step]) -> ParticleRun:
    """Run FastSLAM along a drive."""
    rows = []
    for step in steps:
        if step.motion is not None:
            slam.move(step.motion)
        slam.observe(step.numbers.tolist(), step.measurements)
        belief = slam.belief()
        rows.append(
            (
                float(np.hypot(*belief.error(step.pose)[:2])),
                belief.nees(step.pose),
                len(set(slam.ancestors.tolist())),
                effective(slam.weights),
            )
        )
    errors, nees, ancestors, count = np.array(rows).T
    return ParticleRun(errors, nees, ancestors, count, slam.paths)
