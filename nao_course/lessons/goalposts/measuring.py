"""Evaluation of a detector of goal posts: the true feet of a picture, and the feet that are found, missed or false."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, as_points
from nao_course.metrics import REACH, PointMatch, match_points
from nao_course.sim import Field, PictureTruth


@dataclass(frozen=True, eq=False)
class Feet:
    """The feet of goal posts in a picture.

    Parameters
    ----------
    pixels : ndarray, shape (K, 2)
        (u, v) of the visible feet.
    distances : ndarray, shape (K,)
        Distances from the robot over the ground in m; NaN if unknown.
    excused : ndarray, shape (M, 2)
        Feet that are hidden or outside the picture. A point near one of them counts neither as correct nor as false.
    """

    pixels: FloatArray
    distances: FloatArray
    excused: FloatArray

    @classmethod
    def of(cls, truth: PictureTruth, field: Field) -> Feet:
        """Return the feet in a picture from its ground truth and the field on which it was taken."""
        seen = [mark for mark in truth.landmarks if mark.landmark.kind == "post"]
        clear = [mark for mark in seen if not mark.occluded]
        everywhere = truth.view.project(field.posts, truth.pose)
        known = as_points([mark.pixel for mark in clear])
        known_ones = [np.isclose(known, post).all(axis=1).any() for post in everywhere]
        return cls(known, np.array([mark.distance for mark in clear]), everywhere[~np.array(known_ones)])


@dataclass(frozen=True, eq=False)
class FootMatch(PointMatch):
    """Detected and missed feet of one picture or of several.

    Parameters
    ----------
    distances : ndarray, shape (K,)
        Distances of all true feet in m.
    """

    distances: FloatArray

    def __str__(self) -> str:
        """Return the counts in words."""
        many = len(self.found)
        found = (
            f"{self.hits} of {many} {'foot' if many == 1 else 'feet'} found" if many else "no foot to find"
        )
        return f"{found}, {self.false} false"


def match_feet(points: npt.ArrayLike, feet: Feet, reach: float = REACH) -> FootMatch:
    """Match detected points with true feet, as `nao_course.metrics.match_points` does.

    Parameters
    ----------
    points : array_like, shape (N, 2)
        (u, v) of the detected points, in pixels.
    feet : Feet
        True feet.
    reach : float
        Largest distance of a point from its foot, in pixels.

    Returns
    -------
    FootMatch
        A point within `reach` of an excused foot, and of no other, is not counted.

    Raises
    ------
    ValueError
        If the points have another shape.
    """
    match = match_points(points, feet.pixels, feet.excused, reach)
    return FootMatch(match.found, match.false, feet.distances)
