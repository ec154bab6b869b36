"""The algorithms of lesson 11, and variants of them in which one idea is missing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks import ROOT
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.compass import wrap_quarter
from nao_course.field_slam.hypotheses import MultipleHypotheses
from nao_course.field_slam.joint_update import JointUpdate
from nao_course.field_slam.observation import Observation
from nao_course.field_slam.surest_first import SurestFirst
from nao_course.geometry import FloatArray, Pose
from nao_course.instructor.authoring.plans import load_solution
from nao_course.slam import SlamAlgorithm

GATE = 4.0  # standard deviations
SOLUTION = load_solution(ROOT / "solutions" / "11_slam_on_the_field.ipynb")
EKF: Any = SOLUTION["EkfSlam"]
Make = Callable[[Pose], SlamAlgorithm]


class Refusing(EKF):
    """A filter that ignores a compass reading outside of its gate."""

    def use_compass(self, direction: float, sigma: float) -> None:
        """Update with the compass if it is inside the gate."""
        off = wrap_quarter(-direction - self.state[2])
        near = off**2 <= self.gate**2 * (self.covariance[2, 2] + sigma**2)
        super().use_compass(direction, sigma if near else float("inf"))


class AsMeasured(Observation):
    """An observation that is not linearised at the expected ranges."""

    def linearised_at(self, ranges: Any) -> tuple[FloatArray, FloatArray]:
        """Return the measured values and their covariance."""
        return self.values.ravel(), self.covariance


class BentRanges(EKF):
    """A filter that treats a tilt as an error of the range instead of the inverse range."""

    def correct(self, seen: Observation) -> None:
        """Update with the measured ranges."""
        super().correct(AsMeasured(seen.measurements, seen.covariance, tilt=seen.tilt))


class NewOnesAlone(EKF):
    """A filter that ignores the correlation of new landmarks' measurements with the others of the picture."""

    def number(self, seen: Observation) -> None:
        """Associate the measurements, and mark those of new landmarks."""
        before = len(self.kinds)
        super().number(seen)
        self.new = np.asarray(self.indices) >= before

    def correct(self, seen: Observation) -> None:
        """Update with a covariance without the correlations of new landmarks."""
        shares = np.outer(~self.new, ~self.new) | np.eye(len(seen), dtype=bool)
        covariance = seen.covariance * np.kron(shares, np.ones((2, 2)))
        super().correct(replace(seen, covariance=covariance))


def jointly(kind: Any = EKF) -> Make:
    """Return a factory of an algorithm with joint compatibility."""
    return lambda start: kind(start, gate=GATE, association=associate_jointly)  # type: ignore[no-any-return]


def by_nearest_neighbour(start: Pose) -> SlamAlgorithm:
    """Return the lesson's filter with the lesson's own association."""
    return EKF(start, gate=GATE)  # type: ignore[no-any-return]


def surest_first(make: Make) -> Make:
    """Return a factory of an algorithm that gets a stop's pictures in order of their compass."""
    return lambda start: SurestFirst(make(start))


def joint_update(start: Pose) -> JointUpdate:
    """Return the filter that also uses lines and the centre circle, and estimates the noise of the odometry."""
    return JointUpdate(EKF(start, gate=GATE, association=associate_jointly))


def with_hypotheses(start: Pose) -> SlamAlgorithm:
    """Return the joint update with several hypotheses about the association."""
    return MultipleHypotheses(joint_update(start))


FILTER, GRAPH = jointly(), jointly(SOLUTION["GraphSlam"])
