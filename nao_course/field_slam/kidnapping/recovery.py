"""A wrapper that notices when the robot was carried away, and that finds the robot's pose on the map again.

There are two explanations of the pictures of a stop. Either the robot is where the filter predicts it, or it is
anywhere on the field, which a few candidates represent. Their probabilities are updated with each stop by Bayes' rule.
A small probability of a kidnapping flows from the filter to all other poses before each stop, so no decision is final.

References
----------
S. Thrun, W. Burgard, D. Fox, *Probabilistic Robotics*, MIT Press, 2005: sections 7.1 and 8.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from nao_course.field_slam.compass import wrap_quarter
from nao_course.field_slam.joint_update import JointUpdate
from nao_course.field_slam.kidnapping.candidates import Area, Candidates, compass_likelihood
from nao_course.field_slam.likelihood import KnownMap, PositionLikelihood
from nao_course.field_slam.line_observation import StopView
from nao_course.field_slam.observation import Observation, as_observation
from nao_course.geometry import Pose
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement, Motion, SlamAlgorithm

_LENGTH, _WIDTH = Field(2012).dimensions.length, Field(2012).dimensions.width
AREA: Area = ((0.0, -_WIDTH / 2), (_LENGTH / 2, _WIDTH / 2))  # m: the half field
KIDNAPPED = 1e-5  # probability that the robot is carried away before a stop
LOST = 0.95  # the robot is lost if the probability of all other poses is larger
FOUND = 0.99  # least probability of the candidate that ends the search
# Number of stops before the first test: until then, the robot is mostly surrounded by things that are not on its map,
# and a place on the map that is similar by chance would explain them better.
LEAST_STOPS = 15
TRUSTED = 1e-3  # a map is kept as a copy to return to if the probability of all other poses is smaller
POSITION_SIGMA = 0.05  # m: is added to a candidate, because the same pictures correct it again
# One motion in twenty may be three times as inaccurate, because a robot that slipped was not carried away.
SLIPS, SLIP_FACTOR = 0.05, 3.0
NEAR = 0.5  # m: a robot that slipped is nearer to the predicted position


@dataclass(frozen=True, eq=False)
class _Belief:
    """The filter with its probability, and the candidates with the remaining probability.

    While the robot is lost, `tracked`, the probability that the filter is right, is 0, and only its map is used, not
    its pose. `trusted` is a copy from the last stop at which the robot was certainly not lost, `stops` counts the
    motions, and `kidnappings` how often the filter's pose was found to be wrong.
    """

    slam: JointUpdate
    trusted: JointUpdate
    tracked: float
    elsewhere: Candidates
    stops: int = 0
    kidnappings: int = 0


class KidnapRecovery(SlamAlgorithm):
    """Notice a kidnapping within few stops, find the pose on the map again, and continue with the filter.

    The pictures of a stop are used together when the next motion is commanded, the one with the most certain compass
    first, as `SurestFirst` does. While the robot is lost, its map does not change. A robot with an almost empty map
    cannot notice a kidnapping. Stops without a compass are not tested, because a candidate needs the heading. Nobody
    else may use `inner`. `area` is the lower left and the upper right corner of where the robot can be, m in the map
    frame.
    """

    def __init__(self, inner: JointUpdate, area: Area = AREA) -> None:
        """Start with a filter that is certainly right."""
        self._belief = _Belief(inner, deepcopy(inner), 1.0, Candidates.none(area))
        self._pictures: list[Observation] = []
        self._updated: _Belief | None = None

    @property
    def lost(self) -> bool:
        """Whether the robot does not know where it is."""
        return self._after_pictures().tracked == 0

    @property
    def lost_probability(self) -> float:
        """Probability that the robot is not where the filter estimates it."""
        return 1.0 if self.lost else self._after_pictures().elsewhere.total

    @property
    def kidnappings(self) -> int:
        """How often the robot has noticed that its pose was wrong."""
        return self._after_pictures().kidnappings

    def move(self, motion: Motion) -> None:
        """Update with the stop's pictures, then predict."""
        belief = self._after_pictures()
        self._pictures, self._updated = [], None
        elsewhere = belief.elsewhere.moved(motion, belief.slam.odometry.covariance(motion))
        if belief.tracked:
            belief.slam.move(motion)
        self._belief = replace(belief, elsewhere=elsewhere, stops=belief.stops + 1)

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Keep a picture until the stop is over."""
        self._pictures.append(as_observation(measurements))
        self._updated = None

    def estimate(self) -> Estimate:
        """Return the estimate after all pictures so far; the most probable candidate while the robot is lost."""
        belief = self._after_pictures()
        found = belief.slam.estimate()
        if belief.tracked:
            return found
        mean = belief.elsewhere.poses[0]
        return replace(found, pose=Pose.from_array(mean), covariance=belief.elsewhere.covariance(mean))

    def _after_pictures(self) -> _Belief:
        """Return the belief after the stop's pictures; its filter is a copy."""
        if self._updated is None:
            stop = StopView.of(self._pictures)
            belief = self._belief
            if np.isfinite(stop.heading_sigma):
                belief = self._compare(stop) if belief.stops >= LEAST_STOPS else belief
                self._updated = self._decide(belief)
            else:
                slam = self._with_pictures(belief.slam) if belief.tracked else belief.slam
                self._updated = replace(belief, slam=slam)
        return self._updated

    def _compare(self, stop: StopView) -> _Belief:
        """Return the belief whose probabilities, but not whose filter, are updated with a stop."""
        belief, known = self._belief, self._belief.trusted.known_map
        elsewhere, logs = belief.elsewhere.aligned(stop).updated(stop, known, KIDNAPPED)
        there = -np.inf
        if belief.tracked:
            there = np.log((1 - KIDNAPPED) * belief.tracked) + self._log_likelihood(stop, known)
        total = np.logaddexp(there, logsumexp(logs))
        elsewhere = replace(elsewhere, probabilities=np.exp(logs - total))
        return replace(belief, tracked=float(np.exp(there - total)), elsewhere=elsewhere)

    def _decide(self, belief: _Belief) -> _Belief:
        """Return the belief after a decision: keep the filter, give it up, or put it where the robot was found."""
        others = belief.elsewhere
        if (belief.tracked and others.total <= LOST) or not len(others.positions):
            slam = self._with_pictures(belief.slam)
            safe = others.total < TRUSTED
            return replace(belief, slam=slam, trusted=deepcopy(slam) if safe else belief.trusted)
        noticed = belief.kidnappings + int(belief.tracked > 0)
        others = replace(others, probabilities=others.probabilities / others.total)
        found = float(others.probabilities[1])
        if found < FOUND:
            return _Belief(belief.trusted, belief.trusted, 0.0, others, belief.stops, noticed)
        slam, covariance = deepcopy(belief.trusted), np.diag(np.full(3, others.heading_sigma**2))
        covariance[:2, :2] = others.covariances[0] + POSITION_SIGMA**2 * np.eye(2)
        slam.place(Pose.from_array(others.poses[0]), covariance)
        others.probabilities[1] = 0.0
        return _Belief(self._with_pictures(slam), belief.trusted, found, others, belief.stops, noticed)

    def _with_pictures(self, slam: JointUpdate) -> JointUpdate:
        """Return a copy of a filter that is updated with the stop's pictures."""
        slam = deepcopy(slam)
        for each in sorted(self._pictures, key=lambda one: one.direction_sigma):
            slam.observe(each)
        return slam

    def _log_likelihood(self, stop: StopView, known: KnownMap) -> float:
        """Return the log-likelihood of a stop if the filter is right, averaged over the filter's Gaussian.

        Laplace's approximation is used at the most probable position.
        """
        inner = self._belief.slam.inner
        mean, P = inner.state[:3], inner.covariance[:3, :3]
        innovation, S = float(wrap_quarter(stop.heading - mean[2])), P[2, 2] + stop.heading_sigma**2
        gain = P[:, 2] / S
        mean, P = mean + gain * innovation, P - np.outer(gain, P[2])
        likelihood = PositionLikelihood(stop, known, float(mean[2]))
        near = np.hypot(*(likelihood.positions - mean[:2]).T) < NEAR
        starts = np.vstack([mean[:2], likelihood.positions[near]])
        information = np.asarray(np.linalg.inv(P[:2, :2]), dtype=float)
        evidence = [
            np.log(share) + likelihood.fit(starts, mean[:2], information / factor**2)[2].max()
            for share, factor in ((1 - SLIPS, 1.0), (SLIPS, SLIP_FACTOR))
        ]
        return float(np.log(compass_likelihood(innovation, S)) + logsumexp(evidence))
