"""Lesson 11's own classes on the field, and each with one of its ideas taken out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks import ROOT
from nao_course.geometry import FloatArray, Pose
from nao_course.instructor.authoring.plans import load_solution
from nao_course.lessons.slam_on_the_field.system.association import associate_jointly
from nao_course.lessons.slam_on_the_field.system.careful import SurestFirst
from nao_course.lessons.slam_on_the_field.system.compass import wrap_quarter
from nao_course.lessons.slam_on_the_field.system.observation import Observation
from nao_course.lessons.slam_on_the_field.system.whole_picture import WholePicture
from nao_course.slam import SlamAlgorithm

GATE = 4.0  # standard deviations
SOLUTION = load_solution(ROOT / "solutions" / "11_slam_on_the_field.ipynb")
EKF: Any = SOLUTION["EkfSlam"]
Make = Callable[[Pose], SlamAlgorithm]


class Refusing(EKF):
    """Refuses a compass that is far from its heading."""

    def use_compass(self, direction: float, sigma: float) -> None:
        """Ask the gate first."""
        off = wrap_quarter(-direction - self.state[2])
        near = off**2 <= self.gate**2 * (self.covariance[2, 2] + sigma**2)
        super().use_compass(direction, sigma if near else float("inf"))


class AsMeasured(Observation):
    """A picture whose ranges are taken as they were measured, whatever was expected."""

    def about(self, ranges: Any) -> tuple[FloatArray, FloatArray]:
        """Return values and covariance."""
        return self.values.ravel(), self.covariance


class BentRanges(EKF):
    """Takes a tilt for an error of the range, not of one over it."""

    def correct(self, seen: Observation) -> None:
        """Correct by ranges as they were measured."""
        super().correct(AsMeasured(seen.measurements, seen.covariance, tilt=seen.tilt))


class NewOnesAlone(EKF):
    """Takes a new landmark's error for its own: what the picture shares stays with the others."""

    def number(self, seen: Observation) -> None:
        """Note which are new."""
        before = len(self.kinds)
        super().number(seen)
        self.new = np.asarray(self.indices) >= before

    def correct(self, seen: Observation) -> None:
        """Correct by a covariance without what new ones share with any other."""
        shares = np.outer(~self.new, ~self.new) | np.eye(len(seen), dtype=bool)
        covariance = seen.covariance * np.kron(shares, np.ones((2, 2)))
        super().correct(replace(seen, covariance=covariance))


def jointly(kind: Any = EKF) -> Make:
    """Make an algorithm with joint compatibility."""
    return lambda start: kind(start, gate=GATE, association=associate_jointly)  # type: ignore[no-any-return]


def by_nearest_neighbour(start: Pose) -> SlamAlgorithm:
    """Return the lesson's filter with the lesson's own association."""
    return EKF(start, gate=GATE)  # type: ignore[no-any-return]


def surest_first(make: Make) -> Make:
    """Make an algorithm that gets a stop's pictures with the surest compass first."""
    return lambda start: SurestFirst(make(start))


def whole_picture(start: Pose) -> SlamAlgorithm:
    """Return the filter that takes in lines and the centre circle as well."""
    return WholePicture(EKF(start, gate=GATE, association=associate_jointly))


FILTER, GRAPH = jointly(), jointly(SOLUTION["GraphSlam"])
