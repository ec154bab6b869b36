"""A wrapper that updates a SLAM algorithm with the most certain picture of a stop first."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy

from nao_course.field_slam.observation import Observation, as_observation
from nao_course.slam import Estimate, Measurement, Motion, SlamAlgorithm


class SurestFirst(SlamAlgorithm):
    """Update with the pictures of a stop in order of their compass: the smallest standard deviation first.

    After a sharp turn the heading is uncertain by several degrees, and a picture with a single landmark may associate
    it with the wrong one. While the robot stands still, the pictures that measure the heading can come first. `inner`
    is updated with the pictures of a stop when the next motion is commanded. A copy computes an estimate before that,
    so the order of the updates does not depend on when estimates are requested.
    """

    def __init__(self, inner: SlamAlgorithm) -> None:
        """Start with an empty list of pictures."""
        self.inner = inner
        self._pictures: list[Observation] = []
        self._updated: SlamAlgorithm | None = None

    def move(self, motion: Motion) -> None:
        """Update with the stop's pictures, then predict."""
        self.inner = self._after_pictures()
        self._pictures, self._updated = [], None
        self.inner.move(motion)

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Keep a picture until the stop is over."""
        self._pictures.append(as_observation(measurements))
        self._updated = None

    def estimate(self) -> Estimate:
        """Return the estimate after all pictures so far."""
        return self._after_pictures().estimate()

    def _after_pictures(self) -> SlamAlgorithm:
        """Return a copy of the algorithm that is updated with the stop's pictures."""
        if self._updated is None:
            self._updated = deepcopy(self.inner)
            for each in sorted(self._pictures, key=lambda one: one.direction_sigma):
                self._updated.observe(each)
        return self._updated
