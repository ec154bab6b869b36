"""Variants of SLAM on the same drives: which measurements are made from a picture, and which algorithm uses them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks import ROOT
from benchmarks.field.field_slam.detections import LANDMARKS, Seen
from nao_course.exercises import load_definitions
from nao_course.field_slam.compass import LEAST_LENGTH, LEAST_SUPPORT, BodyTilt, tilt_from_lines
from nao_course.field_slam.joint_update import scene
from nao_course.field_slam.lines import corners_of_lines
from nao_course.field_slam.observation import (
    POST_SIGMA,
    TILT_SIGMAS,
    Observation,
    observation,
    radius_of,
    tilted,
)
from nao_course.geometry import FloatArray, Pose, pose_errors
from nao_course.metrics import squared_distances
from nao_course.sim import CameraView
from nao_course.slam import Measurement, SlamAlgorithm

GROUND = load_definitions(ROOT / "solutions" / "04_distance.ipynb")
FARTHEST = 6.0  # m: largest range of a measurement that is used
# Standard deviations of corners from lines, and of corners by lesson 03, px at 320.
CORNER_SIGMA = {"lines": 0.5, "lesson 03": 3.0}
CONSTANT = (float(np.radians(3)), 0.15)  # rad and m: a constant R, as in textbooks
PLACES = np.array([(mark.x, mark.y) for mark in LANDMARKS])
WRONG = 0.3  # m: an estimated landmark that is farther from every true landmark counts as wrong
INCONSISTENT = 16.3  # NEES that a consistent pose exceeds once in a thousand times
SMALL = 1e-10  # m^2 and rad^2: added to the covariance, which is zero at the start


@dataclass(frozen=True, eq=False)
class Read:
    """The detections of a picture, with the body tilt from its lines; computed once for all variants."""

    seen: Seen
    tilt: BodyTilt
    level: CameraView
    corners: FloatArray

    @classmethod
    def of(cls, seen: Seen, least_support: float = LEAST_SUPPORT, least_length: float = LEAST_LENGTH) -> Read:
        """Estimate the tilt from the lines, and find the corners where they meet, as the demo does."""
        tilt = tilt_from_lines(seen.lines, seen.view, least_support=least_support, least_length=least_length)
        level = tilted(seen.view, tilt.pitch, tilt.roll)
        return cls(seen, tilt, level, corners_of_lines(seen.lines, level))


@dataclass(frozen=True)
class Options:
    """A variant of making measurements from a picture.

    Parameters
    ----------
    corners : "lines" or "lesson 03"
        Source of the corners.
    paper : bool
        Whether distances and bearings are computed as in the paper.
    constant, shared : bool
        Whether R is the same for all measurements; whether R contains the correlation by the common tilt.
    tilt : bool
        Whether R contains the uncertainty of the tilt.
    lines, compass : bool
        Whether the tilt is estimated from lines; whether the heading is.
    false_corners : float
        Mean number of false corners that are added to a picture.
    post_sigma : float
        Standard deviation of a post in R, m.
    corner_sigma : float, optional
        Standard deviation of a corner, px at 320; by default that of its source.
    whole : bool
        Whether lines and the centre circle are measured as well, with their correlation by the common tilt.
    """

    corners: str = "lines"
    paper: bool = False
    constant: bool = False
    tilt: bool = True
    shared: bool = True
    lines: bool = False
    compass: bool = False
    false_corners: float = 0.0
    post_sigma: float = POST_SIGMA
    corner_sigma: float | None = None
    whole: bool = False

    def __call__(self, read: Read, rng: np.random.Generator) -> Observation:
        """Make an observation of a picture."""
        seen = read.seen
        view = read.level if self.lines else seen.view
        corners = read.corners if self.corners == "lines" else seen.corners
        false = rng.uniform((10, 90), (310, 230), (rng.poisson(self.false_corners), 2))
        measured = self._measure(seen.posts, np.vstack([corners.reshape(-1, 2), false]), view)
        corner_sigma = CORNER_SIGMA[self.corners] if self.corner_sigma is None else self.corner_sigma
        found = observation(measured, self._tilt_covariance(read), corner_sigma, post_sigma=self.post_sigma)
        n = len(measured)
        if self.constant:
            found = replace(found, covariance=np.diag(np.tile(np.square(CONSTANT), n)), tilt=np.zeros((2, 2)))
        elif not self.shared:
            found = replace(found, covariance=found.covariance * np.kron(np.eye(n), np.ones((2, 2))))
        if self.compass:
            tilt = read.tilt
            found = replace(found, direction=tilt.direction, direction_sigma=tilt.direction_sigma)
        return scene(found, read.tilt, seen.lines, read.level) if self.whole else found

    def _tilt_covariance(self, read: Read) -> FloatArray:
        """Return the covariance (2, 2) of the tilt in R."""
        if not self.tilt:
            return np.zeros((2, 2))
        return read.tilt.covariance[:2, :2] if self.lines else np.diag(np.square(TILT_SIGMAS))

    def _measure(self, posts: FloatArray, corners: FloatArray, view: CameraView) -> list[Measurement]:
        """Return the bearing and range of posts and corners by lesson 04 or by the paper."""
        found = []
        for pixels, kind in ((posts, "post"), (corners, "corner")):
            for bearing, away in self._polar(np.asarray(pixels, dtype=float).reshape(-1, 2), view):
                if 0 < away < FARTHEST:
                    found.append(Measurement(bearing, away + radius_of(kind), kind))
        return found

    def _polar(self, pixels: FloatArray, view: CameraView) -> FloatArray:
        if self.paper:  # the paper ignores the yaw of the head
            bearing = GROUND["paper_bearing"](pixels, view) + view.yaw
            return np.column_stack([bearing, GROUND["paper_distance"](pixels, view)])
        polar = GROUND["ground_to_measurement"](GROUND["pixel_to_ground"](pixels, view))
        return np.asarray(polar)


@dataclass(frozen=True)
class Score:
    """The errors at the end of a drive.

    Parameters
    ----------
    position, heading : float
        Errors of the last pose, m and degrees.
    landmarks : float
        Median distance of the estimated landmarks from the nearest true landmark, m; NaN without landmarks.
    nees : float
        NEES of the last pose, with 3 degrees of freedom.
    on_map, wrong : int
        Number of landmarks on the map, and number of wrong landmarks among them.
    misled : int
        The stop after which the estimate was inconsistent until the end, or -1.
    """

    position: float
    heading: float
    landmarks: float
    nees: float
    on_map: int
    wrong: int
    misled: int


def run(
    reads: Sequence[Read],
    make: Callable[[Pose], SlamAlgorithm],
    options: Options | None,
    seed: int,
    pictures: int = 3,
) -> Score:
    """Run an algorithm over a drive; without `options`, it gets no measurements."""
    algorithm, rng, misled = make(reads[0].seen.pose), np.random.default_rng([seed, 21]), -1
    for number, read in enumerate(reads):
        if read.seen.motion is not None:
            algorithm.move(read.seen.motion)
        if options is not None and (pictures == 3 or number % 3 == 1):
            algorithm.observe(options(read, rng))
        if number % 3 == 2:
            found = algorithm.estimate()
            away = pose_errors(found.pose.as_array(), read.seen.pose.as_array())
            nees = squared_distances(away[None], found.covariance[None] + SMALL * np.eye(3))[0]
            if nees < INCONSISTENT:
                misled = -1
            elif misled < 0:
                misled = number // 3
    off = np.linalg.norm(found.landmarks[:, None] - PLACES, axis=2).min(axis=1)
    typical = float(np.median(off)) if len(off) else float("nan")
    return Score(
        float(np.hypot(*away[:2])),
        float(np.degrees(abs(away[2]))),
        typical,
        float(nees),
        len(off),
        int((off > WRONG).sum()),
        misled,
    )
