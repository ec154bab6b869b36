"""The likelihood of a picture's measurements, with all of them used or with some of them ignored."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from nao_course.field_slam.compass import OUTLIERS, QUARTER, reading_density
from nao_course.field_slam.observation import Observation
from nao_course.geometry import FloatArray

Part = Literal["compass", "landmarks", "lines"]  # the centre circle belongs to the lines
Clutter = Literal["corner", "post", "centre", "line"]
# Density of measurements that belong to nothing on the map, because they are false or show something new: points per
# m^2, lines per m (`python -m benchmarks kidnapping`).
CLUTTER: Mapping[Clutter, float] = {"corner": 0.02, "post": 0.006, "centre": 0.002, "line": 0.025}
IGNORED = 0.3  # factor for measurements that are ignored although the map may explain them


@dataclass(frozen=True, eq=False)
class PictureLikelihood:
    """The likelihood of one picture's measurements, given the estimate before it.

    Innovations (m,) with covariance S (m, m) are of landmarks, lines and the circle that were on the map before, and
    `parts` (m,) says which part each belongs to. `others` has, for each part, the log density of its other
    measurements, and of all its measurements if it is ignored. `other_heading` is the compass's second nearest heading,
    in quarter turns from the nearest, and its log density minus the log density of the nearest.
    """

    innovation: FloatArray
    S: FloatArray
    parts: npt.NDArray[np.str_]
    others: Mapping[Part, tuple[float, float]]
    other_heading: tuple[int, float]

    def log_density(self, ignored: Collection[Part] = ()) -> float:
        """Return the log density of all measurements, if the measurements of some parts are ignored."""
        kept = np.isin(self.parts, list(ignored), invert=True)
        others = sum(densities[part in ignored] for part, densities in self.others.items())
        return gaussian_log_density(self.innovation[kept], self.S[np.ix_(kept, kept)]) + others

    def present(self, parts: Collection[Part]) -> tuple[Part, ...]:
        """Return the parts that have measurements, in the given order."""
        return tuple(part for part in parts if self.others[part][1])

    def ignored(self, parts: Collection[Part]) -> float:
        """Return the log density of all measurements of some parts, if they are ignored."""
        return sum(self.others[part][1] for part in parts)


def gaussian_log_density(innovation: FloatArray, S: FloatArray) -> float:
    """Return the log density of an innovation (m,) with covariance S (m, m); 0 if m is 0."""
    if not len(innovation):
        return 0.0
    distance = innovation @ np.linalg.solve(S, innovation)
    return float(-0.5 * (distance + np.linalg.slogdet(2 * np.pi * S)[1]))


def compass_log_densities(innovation: float, variance: float) -> tuple[float, float]:
    """Return the log densities of a compass reading, and of a reading that is independent of the heading.

    The innovation is measured minus predicted heading, rad, and its variance is in rad^2; it is infinite without a
    reading, and both results are then 0.
    """
    if not np.isfinite(variance):
        return 0.0, 0.0
    return float(np.log(reading_density(innovation, variance))), float(np.log(OUTLIERS / QUARTER))


def other_heading_of(innovation: float, variance: float) -> tuple[int, float]:
    """Return `PictureLikelihood.other_heading` of a compass reading; see `compass_log_densities`."""
    if not np.isfinite(variance):
        return 0, -np.inf
    quarter = -1 if innovation > 0 else 1
    return quarter, float((innovation**2 - (innovation + quarter * QUARTER) ** 2) / (2 * variance))


def landmark_log_densities(seen: Observation, explained: npt.ArrayLike) -> tuple[float, float]:
    """Return the log densities of the landmarks that the map does not explain, and of all if they are ignored.

    `explained` (k,) says which of the observation's k landmarks were on the map.
    """
    # A square metre at range r covers 1/r of an area in bearing (rad) and range (m).
    each = np.log([CLUTTER[of.kind] * of.range for of in seen])
    return float(each[~np.array(explained, dtype=bool)].sum()), float((each + np.log(IGNORED)).sum())


def line_log_densities(lines: int, circles: int, lines_known: int, circles_known: int) -> tuple[float, float]:
    """Return the log densities of the lines and circles that the map does not explain, and of all if ignored."""
    line, circle = np.log((CLUTTER["line"], CLUTTER["centre"]))
    new = (lines - lines_known) * line + (circles - circles_known) * circle
    return float(new), float(lines * line + circles * circle + (lines + circles) * np.log(IGNORED))
