"""Particles: a robot that knows the map and not its place, and FastSLAM, by the student's functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises import register
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.beyond.worlds import INSIDE, KINDS, LANDMARKS, Step, moved, noise_of
from nao_course.metrics import squared_distances
from nao_course.slam import LandmarkKind, Motion

Function = Callable[..., Any]
CLUTTER = (
    1e-3  # density of a measurement of nothing, 1 / (rad m): one wrong look must not kill the right particles
)


# --- a robot that does not know where it is ---


def anywhere(n: int, rng: np.random.Generator) -> FloatArray:
    """Particles (n, 3) all over the half field, looking anywhere."""
    low, high = np.array(INSIDE) + ((-0.2, -0.2), (0.2, 0.2))
    return np.column_stack([rng.uniform(low, high, (n, 2)), rng.uniform(-np.pi, np.pi, n)])


def weigh_unnamed(weigh: Function, particles: FloatArray, kind: LandmarkKind, seen: FloatArray) -> FloatArray:
    """Log weights (n,) of particles by one measurement of a landmark of which only the kind is known.

    It may be any landmark of that kind, each as likely as the next: the mean of its likelihoods under all of them.
    """
    R = noise_of(seen)
    places = [place for place, each in zip(LANDMARKS, KINDS, strict=True) if each == kind]
    logs = np.array(
        [
            log_weights(weigh(particles.copy(), place.copy(), seen.copy(), R.copy()), len(particles))
            for place in places
        ]
    )
    return np.logaddexp(np.logaddexp.reduce(logs, axis=0) - np.log(len(places)), np.log(CLUTTER))


def log_weights(answer: Any, n: int) -> FloatArray:
    """What a student's `weigh` returned, as an array (n,); ValueError with a sentence if it is none."""
    logs = np.array(answer, dtype=float)
    if logs.shape != (n,):
        raise ValueError(f"weigh must return {n} log weights, got shape {logs.shape}")
    if np.isnan(logs).any():
        raise ValueError("weigh returned NaN")
    return logs


def normalised(logs: FloatArray) -> FloatArray:
    """Weights (n,) of sum 1 from log weights; the largest is taken off first, so that nothing is 0 by rounding."""
    weights = np.exp(logs - logs.max())
    return np.asarray(weights / weights.sum())


def effective(weights: FloatArray) -> float:
    """How many particles of equal weight would say as much: 1 over the sum of the squared weights."""
    return float(1 / np.square(weights).sum())


def chosen(answer: Any, n: int) -> npt.NDArray[np.intp]:
    """What a student's `resample` returned, as n numbers from 0 to n - 1; ValueError with a sentence if it is none."""
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
    """Hold the draws of `resample` against equation 12.1, whichever way they were made.

    Parameters
    ----------
    args : (weights, seeds)
        (N,), and a seed for each draw; some seeds are there twice.
    answer : list
        The draws, N numbers each.

    Returns
    -------
    str
        What no comb draws; nothing where all is well.
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
        return "the same rng gave two different answers: draw with the rng that is given"
    return _odd_counts(weights, counts)


def _odd_counts(weights: FloatArray, counts: npt.NDArray[np.intp]) -> str:
    """How counts (S, N) of particles differ from floor(N w) or ceil(N w), or their mean from N w."""
    n, draws = len(weights), len(counts)
    least, most = np.floor(n * weights + 1e-9), np.ceil(n * weights - 1e-9)
    odd = np.argwhere((counts < least) | (counts > most))
    if len(odd):
        draw, i = odd[0]
        allowed = f"{least[i]:g}" if least[i] == most[i] else f"{least[i]:g} or {most[i]:g}"
        return (
            f"particle {i} of {n}, of weight {weights[i]:.3g}, was kept {counts[draw, i]} times, "
            f"where a comb keeps it {allowed} times"
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
    weigh: Function, resample: Function, steps: Iterable[Step], rng: np.random.Generator, n: int = 1000
) -> list[FloatArray]:
    """Let a robot that knows the map find its place.

    Parameters
    ----------
    weigh, resample : callable
        The student's.
    steps : iterable of Step
        A drive; who a landmark is is not used, its kind is.
    rng : numpy.random.Generator
        Of the particles.
    n : int
        How many.

    Returns
    -------
    list of ndarray, shape (n, 3)
        The particles at first, and after each step.
    """
    particles = anywhere(n, rng)
    clouds = [particles]
    for step in steps:
        if step.motion is not None:
            particles = moved(particles, step.motion, rng.standard_normal((n, 3)))
        logs = np.zeros(n)
        for number, seen in zip(step.numbers, step.measurements, strict=True):
            logs = logs + weigh_unnamed(weigh, particles, KINDS[number], seen)
        if len(step.numbers):
            particles = particles[chosen(resample(normalised(logs), rng), n)]
        clouds.append(particles)
    return clouds


# --- FastSLAM ---


@dataclass(frozen=True)
class Belief:
    """What is believed of a pose.

    Parameters
    ----------
    pose : ndarray, shape (3,)
        Mean.
    covariance : ndarray, shape (3, 3)
        m^2, rad^2.
    """

    pose: FloatArray
    covariance: FloatArray

    def error(self, truth: FloatArray) -> FloatArray:
        """Believed less true pose (3,), the heading wrapped."""
        off = self.pose - truth
        return np.array([off[0], off[1], float(wrap_angle(off[2]))])

    def nees(self, truth: FloatArray) -> float:
        """Normalised estimation error squared; a covariance that is nearly nothing has 0.1 mm and 0.01 degrees."""
        least = np.diag([1e-8, 1e-8, np.radians(0.01) ** 2])
        return float(squared_distances(self.error(truth)[None], (self.covariance + least)[None])[0])


class FastSlam:
    """FastSLAM 1.0 (Montemerlo et al. 2002): each particle is a path with a map of its own, landmarks are named.

    Parameters
    ----------
    start : Pose
        Where the drive begins; known.
    update_particle_landmark, resample : callable
        The student's.
    n : int
        Particles.
    rng : numpy.random.Generator
        Of their motion and the resampling.
    """

    def __init__(
        self,
        start: Pose,
        update_particle_landmark: Function,
        resample: Function,
        n: int,
        rng: np.random.Generator,
    ) -> None:
        """Begin with an empty map."""
        self._update, self._resample, self._rng = update_particle_landmark, resample, rng
        self.poses = np.tile(start.as_array(), (n, 1))
        self.means = np.zeros((n, len(LANDMARKS), 2))
        self.covariances = np.zeros((n, len(LANDMARKS), 2, 2))
        self.known = np.zeros(len(LANDMARKS), dtype=bool)
        self.logs = np.zeros(n)
        self.ancestors = np.arange(n)
        self.paths = self.poses[:, None].copy()

    def move(self, motion: Motion) -> None:
        """Each particle draws an error of its own."""
        self.poses = moved(self.poses, motion, self._rng.standard_normal(self.poses.shape))

    def observe(self, numbers: Sequence[int], measurements: FloatArray) -> None:
        """Each particle corrects its own map, and is weighed by how well that expected what is seen."""
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
        """Of the particles, (n,); their sum is 1."""
        return normalised(self.logs)

    def belief(self) -> Belief:
        """Mean and covariance of the particles' poses."""
        weights = self.weights
        mean = weights @ self.poses
        mean[2] = np.arctan2(weights @ np.sin(self.poses[:, 2]), weights @ np.cos(self.poses[:, 2]))
        off = self.poses - mean
        off[:, 2] = wrap_angle(off[:, 2])
        return Belief(mean, (weights[:, None] * off).T @ off)

    def correct(self, number: int, seen: FloatArray) -> None:
        """Each particle corrects its landmark, one by one; who has all at once may do it quicker."""
        R = noise_of(seen)
        for i, pose in enumerate(self.poses):
            mean, covariance, log_weight = self._update(
                pose.copy(), self.means[i, number].copy(), self.covariances[i, number].copy(), seen.copy(), R
            )
            self.means[i, number], self.covariances[i, number] = mean, covariance
            self.logs[i] += float(log_weight)

    def _add(self, number: int, seen: FloatArray) -> None:
        """Put a landmark where each particle sees it, with the measurement's own doubt."""
        directions = self.poses[:, 2] + seen[0]
        cos, sin = np.cos(directions), np.sin(directions)
        self.means[:, number] = self.poses[:, :2] + seen[1] * np.column_stack([cos, sin])
        slopes = np.array([[-seen[1] * sin, cos], [seen[1] * cos, sin]]).transpose(2, 0, 1)
        self.covariances[:, number] = slopes @ noise_of(seen) @ slopes.transpose(0, 2, 1)
        self.known[number] = True

    def _keep(self, numbers: npt.NDArray[np.intp]) -> None:
        self.poses, self.means, self.covariances = (
            each[numbers] for each in (self.poses, self.means, self.covariances)
        )
        self.ancestors, self.paths = self.ancestors[numbers], self.paths[numbers]
        self.logs = np.zeros(len(numbers))


@dataclass(frozen=True, eq=False)
class Run:
    """How an algorithm did on a drive.

    Parameters
    ----------
    errors : ndarray, shape (S,)
        Of the position after each step, m.
    nees : ndarray, shape (S,)
        Of the pose after each step.
    ancestors, effective : ndarray, shape (S,)
        How many of the first particles have descendants; how many count. Of FastSLAM alone.
    paths : ndarray, shape (n, S + 1, 3)
        Of the particles at the end. Of FastSLAM alone.
    """

    errors: FloatArray
    nees: FloatArray
    ancestors: FloatArray
    effective: FloatArray
    paths: FloatArray


def run_fast_slam(slam: FastSlam, steps: Iterable[Step]) -> Run:
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
    return Run(errors, nees, ancestors, count, slam.paths)


class NamedEkf:
    """Lesson 07's filter on landmarks that somebody names.

    Parameters
    ----------
    start : Pose
        Known.
    predict, update_landmarks, add_landmark : callable
        The student's, of lesson 07.
    """

    def __init__(
        self, start: Pose, predict: Function, update_landmarks: Function, add_landmark: Function
    ) -> None:
        """Begin with an empty map."""
        self._predict, self._update, self._add = predict, update_landmarks, add_landmark
        self.state, self.covariance = start.as_array(), np.zeros((3, 3))
        self.known: list[int] = []

    def move(self, control: FloatArray, noise: FloatArray) -> None:
        """Take in a command (2,) and its covariance (3, 3)."""
        self.state, self.covariance = self._predict(
            self.state, self.covariance, control, noise, len(self.known)
        )

    def observe(self, numbers: Sequence[int], measurements: FloatArray) -> None:
        """Correct what is on the map, and add what is not."""
        again = [i for i, number in enumerate(numbers) if number in self.known]
        if again:
            self.state, self.covariance = self._update(
                self.state,
                self.covariance,
                [self.known.index(numbers[i]) for i in again],
                measurements[again].ravel(),
                np.array([noise_of(measurements[i]) for i in again]),
            )
        for number, seen in zip(numbers, measurements, strict=True):
            if number not in self.known:
                self.state, self.covariance = self._add(self.state, self.covariance, seen, noise_of(seen))
                self.known.append(number)

    def belief(self) -> Belief:
        """Of the pose."""
        return Belief(np.array(self.state[:3]), np.array(self.covariance[:3, :3]))
