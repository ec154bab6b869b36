"""The same drives by every way of SLAM: what a picture is taken to say, and who makes a map of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks import ROOT
from benchmarks.field_slam.detections import LANDMARKS, Seen
from nao_course.exercises import load_definitions
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.slam_on_the_field.system.compass import (
    LEAST_LENGTH,
    LEAST_SUPPORT,
    Lean,
    lean_from_lines,
    support,
)
from nao_course.lessons.slam_on_the_field.system.lines import corners_of_lines
from nao_course.lessons.slam_on_the_field.system.observation import (
    POST_RADIUS,
    POST_SIGMA,
    TILT_SIGMAS,
    Observation,
    leaning,
    observation,
)
from nao_course.lessons.slam_on_the_field.system.whole_picture import scene
from nao_course.metrics import squared_distances
from nao_course.sim import CameraView
from nao_course.slam import KINDS, LandmarkKind, Measurement, SlamAlgorithm

GROUND = load_definitions(ROOT / "solutions" / "04_distance.ipynb")
FARTHEST = 6.0  # m: what is measured farther away says nothing
CORNER_SIGMA = {"lines": 0.5, "lesson 03": 3.0}  # px at 320: of corners where lines meet, and of lesson 03's
CONSTANT = (float(np.radians(3)), 0.15)  # rad and m: what a textbook takes for R
PLACES = np.array([(mark.x, mark.y) for mark in LANDMARKS])
WRONG = 0.3  # m: a landmark on the map that is farther from every true one is none


@dataclass(frozen=True, eq=False)
class Read:
    """A picture's detections with what its lines say of the body's lean; made once for all variants."""

    seen: Seen
    lean: Lean
    level: CameraView
    corners: FloatArray

    @classmethod
    def of(cls, seen: Seen, least_support: float = LEAST_SUPPORT, least_length: float = LEAST_LENGTH) -> Read:
        """Ask the lines; where too few agree, they tell where corners are and nothing of the body."""
        lean = lean_from_lines(seen.lines, seen.view, least_support=float("-inf"), least_length=least_length)
        corners = corners_of_lines(seen.lines, leaning(seen.view, lean.pitch, lean.roll))
        if support(seen.lines, seen.view, lean) < least_support:
            lean = lean_from_lines(np.zeros((0, 4)), seen.view)
        return cls(seen, lean, leaning(seen.view, lean.pitch, lean.roll), corners)


@dataclass(frozen=True)
class Ways:
    """What a picture is taken to say.

    Parameters
    ----------
    corners : "lines" or "lesson 03"
        Where the corners come from.
    paper : bool
        Whether distances and bearings are the paper's.
    constant, shared : bool
        Whether R is the same for all measurements; whether those of a picture share one lean.
    tilt : bool
        Whether R knows of the lean at all.
    lines, compass : bool
        Whether lines tell the lean; whether they tell the heading.
    false_corners : float
        How many corners that are none are added to a picture, on average.
    post_sigma : float
        What R is told of a post's thickness, m.
    whole : bool
        Whether lines and the centre circle are seen as well, and what the lean does to compass and places together.
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
    whole: bool = False

    def __call__(self, read: Read, rng: np.random.Generator) -> Observation:
        """Make an observation of a picture."""
        seen = read.seen
        view = read.level if self.lines else seen.view
        corners = read.corners if self.corners == "lines" else seen.corners
        false = rng.uniform((10, 90), (310, 230), (rng.poisson(self.false_corners), 2))
        measured = self._measure(seen.posts, np.vstack([corners.reshape(-1, 2), false]), view)
        found = observation(
            measured, self._lean(read), CORNER_SIGMA[self.corners], post_sigma=self.post_sigma
        )
        n = len(measured)
        if self.constant:
            found = replace(found, covariance=np.diag(np.tile(np.square(CONSTANT), n)), tilt=np.zeros((2, 2)))
        elif not self.shared:
            found = replace(found, covariance=found.covariance * np.kron(np.eye(n), np.ones((2, 2))))
        if self.compass:
            lean = read.lean
            found = replace(found, direction=lean.direction, direction_sigma=lean.direction_sigma)
        return scene(found, read.lean, seen.lines, read.level) if self.whole else found

    def _lean(self, read: Read) -> FloatArray:
        """Covariance (2, 2) of the lean that R is told."""
        if not self.tilt:
            return np.zeros((2, 2))
        return read.lean.covariance[:2, :2] if self.lines else np.diag(np.square(TILT_SIGMAS))

    def _measure(self, posts: FloatArray, corners: FloatArray, view: CameraView) -> list[Measurement]:
        """Bearing and range of posts and corners, by lesson 04 or by the paper."""
        found = []
        for pixels, kind in ((posts, KINDS[1]), (corners, KINDS[0])):
            for bearing, away in self._polar(np.asarray(pixels, dtype=float).reshape(-1, 2), view):
                if 0 < away < FARTHEST:
                    found.append(_measurement(bearing, away, kind))
        return found

    def _polar(self, pixels: FloatArray, view: CameraView) -> FloatArray:
        if self.paper:  # its angles know no turned head
            bearing = GROUND["paper_bearing"](pixels, view) + view.yaw
            return np.column_stack([bearing, GROUND["paper_distance"](pixels, view)])
        polar = GROUND["ground_to_measurement"](GROUND["pixel_to_ground"](pixels, view))
        return np.asarray(polar)


def _measurement(bearing: float, away: float, kind: LandmarkKind) -> Measurement:
    return Measurement(bearing, away + (POST_RADIUS if kind == "post" else 0.0), kind)


@dataclass(frozen=True)
class Score:
    """How a drive ended.

    Parameters
    ----------
    position, heading : float
        Errors of the last pose, m and degrees.
    landmarks : float
        Median distance of the map's landmarks from the nearest of the field's, m; NaN without any.
    nees : float
        Of the last pose; 3 degrees of freedom.
    on_map, wrong : int
        Landmarks on the map, and those of them that are none of the field's.
    """

    position: float
    heading: float
    landmarks: float
    nees: float
    on_map: int
    wrong: int


def run(
    reads: Sequence[Read],
    make: Callable[[Pose], SlamAlgorithm],
    ways: Ways | None,
    seed: int,
    looks: int = 3,
) -> Score:
    """Run an algorithm over a drive; without `ways` it sees nothing."""
    algorithm, rng = make(reads[0].seen.pose), np.random.default_rng([seed, 21])
    for number, read in enumerate(reads):
        if read.seen.motion is not None:
            algorithm.move(read.seen.motion)
        if ways is not None and (looks == 3 or number % 3 == 1):
            algorithm.observe(ways(read, rng))
    found, truth = algorithm.estimate(), reads[-1].seen.pose
    away = np.array(
        [found.pose.x - truth.x, found.pose.y - truth.y, wrap_angle(found.pose.theta - truth.theta)]
    )
    nees = squared_distances(away[None], found.covariance[None])[0]
    off = np.linalg.norm(found.landmarks[:, None] - PLACES, axis=2).min(axis=1)
    typical = float(np.median(off)) if len(off) else float("nan")
    return Score(
        float(np.hypot(*away[:2])),
        float(np.degrees(abs(away[2]))),
        typical,
        float(nees),
        len(off),
        int((off > WRONG).sum()),
    )
