"""Which goal feet a detector finds: true feet of a picture, hits, misses and false ones, and sums over pictures."""

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
        (u, v) of those that can be found.
    distances : ndarray, shape (K,)
        From the robot over the ground, metres; NaN where nobody knows.
    excused : ndarray, shape (M, 2)
        Feet that are hidden, or outside the picture: to find one of them, by its post, is neither right nor wrong.
    """

    pixels: FloatArray
    distances: FloatArray
    excused: FloatArray

    @classmethod
    def of(cls, truth: PictureTruth, field: Field) -> Feet:
        """Read the feet off a picture's truth; `field` is the one it was taken on."""
        seen = [mark for mark in truth.landmarks if mark.landmark.kind == "post"]
        clear = [mark for mark in seen if not mark.occluded]
        everywhere = truth.view.project(field.posts, truth.pose)
        known = as_points([mark.pixel for mark in clear])
        known_ones = [np.isclose(known, post).all(axis=1).any() for post in everywhere]
        return cls(known, np.array([mark.distance for mark in clear]), everywhere[~np.array(known_ones)])


@dataclass(frozen=True, eq=False)
class FootMatch(PointMatch):
    """What of the feet in one picture, or in several, was found.

    Parameters
    ----------
    distances : ndarray, shape (K,)
        Of all true feet, metres.
    """

    distances: FloatArray

    def __str__(self) -> str:
        """In words."""
        feet = f"{self.hits} of {len(self.found)} feet found" if len(self.found) else "no foot to find"
        return f"{feet}, {self.false} false"


def match_feet(points: npt.ArrayLike, feet: Feet, reach: float = REACH) -> FootMatch:
    """Pair found points with true feet, as `nao_course.metrics.match_points` does.

    Parameters
    ----------
    points : array_like, shape (N, 2)
        (u, v) of what was found, pixels.
    feet : Feet
        The truth.
    reach : float
        How far a point may be from its foot, pixels.

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
