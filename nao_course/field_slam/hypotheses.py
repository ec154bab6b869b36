"""Several hypotheses about a drive's data association, so that a wrong decision can be taken back.

References
----------
D. B. Reid, *An algorithm for tracking multiple targets*, IEEE Transactions on Automatic Control 24, 1979.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from copy import deepcopy
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp

from nao_course.field_slam.joint_update import JointUpdate
from nao_course.field_slam.likelihood import Part, PictureLikelihood
from nao_course.field_slam.line_observation import LineObservation
from nao_course.field_slam.observation import Observation, as_observation
from nao_course.geometry import FloatArray, wrap_angle
from nao_course.slam import Estimate, Measurement, Motion, SlamAlgorithm

MOST = 4  # hypotheses that are kept
LEAST = float(np.log(1e-5))  # log probability, relative to the best, below which a hypothesis is dropped
SAME = 0.1  # squared Mahalanobis distance below which two poses count as the same
# What a hypothesis may ignore of a picture. Without the compass it is unknown which direction a line has.
IGNORABLE: tuple[tuple[Part, ...], ...] = (
    ("landmarks",),
    ("lines",),
    ("landmarks", "lines"),
    ("compass", "lines"),
)
SMALL = 1e-8  # m^2 and rad^2: added to covariances, which are zero at the start


class Hypothesis(NamedTuple):
    """A filter that was updated by a sequence of decisions, and the log of the probability that only they are right."""

    log_probability: float
    slam: JointUpdate


class MultipleHypotheses(SlamAlgorithm):
    """Multiple hypothesis tracking: keep several filters that decided differently about ambiguous pictures.

    Each filter uses a picture as its own association demands. Copies of it ignore the picture's landmarks, its lines
    and circle, both, or its compass and lines, or use the second nearest of the compass's four headings. The
    probability of each follows from the likelihood of the measurements that it uses, and from the density of false and
    new measurements. Later pictures decide between them. At most `most` are kept after each picture. `first` is the
    filter at the start, which nobody else may use.
    """

    def __init__(self, first: JointUpdate, most: int = MOST) -> None:
        """Start with a single hypothesis."""
        self.most = most
        self.hypotheses = [Hypothesis(0.0, first)]

    @property
    def best(self) -> JointUpdate:
        """The filter of the most probable hypothesis."""
        return self.hypotheses[0].slam

    def move(self, motion: Motion) -> None:
        """Predict all hypotheses after a motion."""
        for each in self.hypotheses:
            each.slam.move(motion)

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Update all hypotheses with a picture, add copies that ignore a part of it, and keep the most probable."""
        seen = as_observation(measurements)
        before = [deepcopy(each.slam) for each in self.hypotheses]
        found = []
        for log_probability, slam in self.hypotheses:
            slam.observe(seen)
            found.append(Hypothesis(log_probability + slam.likelihood.log_density(), slam))
        least = max(each.log_probability for each in found) + LEAST
        for earlier, (log_probability, slam) in zip(before, self.hypotheses, strict=True):
            for expected, part, quarter, ignored in _alternatives(slam.likelihood, seen):
                if log_probability + expected >= least:
                    other = deepcopy(earlier)
                    other.observe(part, quarter)
                    log_density = other.likelihood.log_density() + ignored
                    found.append(Hypothesis(log_probability + log_density, other))
        self.hypotheses = self._most_probable(found)

    def estimate(self) -> Estimate:
        """Return the best hypothesis' estimate, with a pose covariance that contains its distance from the others."""
        found = self.best.estimate()
        if len(self.hypotheses) == 1:
            return found
        covariance = np.zeros((3, 3))
        for log_probability, slam in self.hypotheses:
            error = _pose_difference(slam, self.best)
            own = slam.inner.covariance[:3, :3]
            covariance += np.exp(log_probability) * (own + np.outer(error, error))
        return replace(found, covariance=covariance)

    def _most_probable(self, found: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Merge hypotheses that have become the same, drop the improbable ones, and normalise the probabilities."""
        ordered = sorted(found, key=lambda each: -each.log_probability)
        kept: list[Hypothesis] = []
        for each in ordered:
            if each.log_probability < ordered[0].log_probability + LEAST:
                break
            same = [i for i, other in enumerate(kept) if _same(each.slam, other.slam)]
            if same:
                both = np.logaddexp(kept[same[0]].log_probability, each.log_probability)
                kept[same[0]] = Hypothesis(float(both), kept[same[0]].slam)
            elif len(kept) < self.most:
                kept.append(each)
        total = logsumexp([each.log_probability for each in kept])
        kept = [Hypothesis(float(each.log_probability - total), each.slam) for each in kept]
        return sorted(kept, key=lambda each: -each.log_probability)


def _alternatives(
    likelihood: PictureLikelihood, seen: Observation
) -> Iterator[tuple[float, Observation, int, float]]:
    """Yield other ways to use a picture.

    Each is the log density that is expected of it, the observation without the parts that are ignored, the quarter
    turns of the compass, and the log density of the ignored parts.
    """
    # A picture without lines is the same with or without ignoring them.
    for parts in dict.fromkeys(filter(None, map(likelihood.present, IGNORABLE))):
        yield likelihood.log_density(parts), without(seen, parts), 0, likelihood.ignored(parts)
    quarter, difference = likelihood.other_heading
    if quarter:
        yield likelihood.log_density() + difference, seen, quarter, 0.0


def without(seen: Observation, parts: Collection[Part]) -> Observation:
    """Return an observation without some of its parts."""
    if "landmarks" in parts:
        seen = seen.part([])
    if "lines" in parts and isinstance(seen, LineObservation):
        seen = replace(seen, lines=np.zeros((0, 5)), circle=None)
    return replace(seen, direction_sigma=float("inf")) if "compass" in parts else seen


def _pose_difference(one: JointUpdate, other: JointUpdate) -> FloatArray:
    """Return the difference of two poses (3,), m and rad."""
    error = one.inner.state[:3] - other.inner.state[:3]
    error[2] = wrap_angle(error[2])
    return error


def _same(one: JointUpdate, other: JointUpdate) -> bool:
    """Return whether two hypotheses have equally many landmarks, and poses that are nearly the same."""
    if len(one.inner.kinds) != len(other.inner.kinds):
        return False
    error = _pose_difference(one, other)
    S = one.inner.covariance[:3, :3] + other.inner.covariance[:3, :3] + SMALL * np.eye(3)
    return bool(error @ np.linalg.solve(S, error) < SAME)
