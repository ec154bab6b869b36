"""Variants of SLAM on the same drives: which measurements are made from a picture, and which algorithm uses them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import chi2

from benchmarks import Table, solution
from benchmarks.field.detections import LANDMARKS, Seen
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.compass import LEAST_LENGTH, LEAST_SUPPORT, BodyTilt, estimate_body_tilt
from nao_course.field_slam.hypotheses import MultipleHypotheses
from nao_course.field_slam.joint_update import JointUpdate
from nao_course.field_slam.line_observation import scene
from nao_course.field_slam.lines import corners_of_lines
from nao_course.field_slam.observation import (
    POST_SIGMA,
    TILT_SIGMAS,
    Observation,
    observation,
    radius_of,
    tilted,
)
from nao_course.field_slam.surest_first import SurestFirst
from nao_course.geometry import FloatArray, Pose, pose_errors
from nao_course.metrics import squared_distances
from nao_course.sim import CameraView
from nao_course.slam import Measurement, SlamAlgorithm

GATE = 4.0  # standard deviations
FARTHEST = 6.0  # m: largest range of a measurement that is used
# Standard deviations of corners from lines, and of corners by lesson 03, px at 320.
CORNER_SIGMA = {"lines": 0.5, "lesson 03": 3.0}
CONSTANT = (float(np.radians(3)), 0.15)  # rad and m: a constant R, as in textbooks
PLACES = np.array([(mark.x, mark.y) for mark in LANDMARKS])
WRONG = 0.3  # m: an estimated landmark that is farther from every true landmark counts as wrong
INCONSISTENT = 16.3  # NEES that a consistent pose exceeds once in a thousand times
SMALL = 1e-10  # m^2 and rad^2: added to the covariance, which is zero at the start
OUTSIDE = float(chi2.ppf(0.95, 3))  # NEES outside of a pose's 95 % ellipse
OVERCONFIDENT = 20.0  # NEES of a drive that tables name
LOST = 0.15  # m: a drive that ends farther off counts as lost
Make = Callable[[Pose], SlamAlgorithm]


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
        tilt = estimate_body_tilt(
            seen.lines, seen.view, least_support=least_support, least_length=least_length
        )
        level = tilted(seen.view, tilt.pitch, tilt.roll)
        return cls(seen, tilt, level, corners_of_lines(seen.lines, level))


@dataclass(frozen=True)
class Options:
    """A variant of making measurements from a picture."""

    corners: str = "lines"  # source of the corners
    paper: bool = False  # whether distances and bearings are computed as in the paper
    # whether R is the same for all measurements; whether R contains the correlation by the common tilt
    constant: bool = False
    shared: bool = True
    lines: bool = False  # whether the tilt is estimated from lines; whether the heading is
    compass: bool = False
    false_corners: float = 0.0  # mean number of false corners that are added to a picture
    post_sigma: float = POST_SIGMA  # standard deviation of a post in R, m
    # standard deviation of a corner, px at 320; by default that of its source
    corner_sigma: float | None = None
    # whether lines and the centre circle are measured as well, with their correlation by the common tilt
    whole: bool = False

    def __call__(self, read: Read, rng: np.random.Generator) -> Observation:
        """Make an observation of a picture."""
        seen = read.seen
        view = read.level if self.lines else seen.view
        corners = read.corners if self.corners == "lines" else seen.corners
        false = rng.uniform((10, 90), (310, 230), (rng.poisson(self.false_corners), 2))
        measured = self._measure(seen.posts, np.vstack([corners.reshape(-1, 2), false]), view)
        corner_sigma = CORNER_SIGMA[self.corners] if self.corner_sigma is None else self.corner_sigma
        tilt = read.tilt.covariance[:2, :2] if self.lines else np.diag(np.square(TILT_SIGMAS))
        found = observation(measured, tilt, corner_sigma, post_sigma=self.post_sigma)
        n = len(measured)
        if self.constant:
            found = replace(found, covariance=np.diag(np.tile(np.square(CONSTANT), n)), tilt=np.zeros((2, 2)))
        elif not self.shared:
            found = replace(found, covariance=found.covariance * np.kron(np.eye(n), np.ones((2, 2))))
        if self.compass:
            found = replace(found, direction=read.tilt.direction, direction_sigma=read.tilt.direction_sigma)
        return scene(found, read.tilt, seen.lines, read.level) if self.whole else found

    def _measure(self, posts: FloatArray, corners: FloatArray, view: CameraView) -> list[Measurement]:
        """Return the bearing and range of posts and corners by lesson 04 or by the paper."""
        found = []
        for pixels, kind in ((posts, "post"), (corners, "corner")):
            for bearing, away in self._polar(np.asarray(pixels, dtype=float).reshape(-1, 2), view):
                if 0 < away < FARTHEST:
                    found.append(Measurement(bearing, away + radius_of(kind), kind))
        return found

    def _polar(self, pixels: FloatArray, view: CameraView) -> FloatArray:
        own = solution("04")
        if self.paper:  # the paper ignores the yaw of the head
            return np.column_stack(
                [own["paper_bearing"](pixels, view) + view.yaw, own["paper_distance"](pixels, view)]
            )
        return np.asarray(own["ground_to_measurement"](own["pixel_to_ground"](pixels, view)))


BEST = Options(lines=True, compass=True)


def jointly(kind: str | Callable[..., Any] = "EkfSlam") -> Make:
    """Return a factory of an algorithm of lesson 11, or of a variant of it, with joint compatibility."""

    def make(start: Pose) -> SlamAlgorithm:
        return (solution("11")[kind] if isinstance(kind, str) else kind)(  # type: ignore[no-any-return]
            start, gate=GATE, association=associate_jointly
        )

    return make


def by_nearest_neighbour(start: Pose) -> SlamAlgorithm:
    """Return the lesson's filter with the lesson's own association."""
    return solution("11")["EkfSlam"](start, gate=GATE)  # type: ignore[no-any-return]


FILTER, GRAPH = jointly(), jointly("GraphSlam")


def surest_first(make: Make) -> Make:
    """Return a factory of an algorithm that gets a stop's pictures in order of their compass."""
    return lambda start: SurestFirst(make(start))


def joint_update(start: Pose) -> JointUpdate:
    """Return the filter that also uses lines and the centre circle, and estimates the noise of the odometry."""
    return JointUpdate(FILTER(start))  # type: ignore[arg-type]


def with_hypotheses(start: Pose) -> SlamAlgorithm:
    """Return the joint update with several hypotheses about the association."""
    return MultipleHypotheses(joint_update(start))


@dataclass(frozen=True)
class Score:
    """The errors at the end of a drive."""

    position: float  # errors of the last pose, m and degrees
    heading: float
    # median distance of the estimated landmarks from the nearest true landmark, m; NaN without landmarks
    landmarks: float
    nees: float  # NEES of the last pose, with 3 degrees of freedom
    on_map: int  # number of landmarks on the map, and number of wrong landmarks among them
    wrong: int
    misled: int  # the stop after which the estimate was inconsistent until the end, or -1


def run(reads: Sequence[Read], make: Make, options: Options | None, seed: int, pictures: int = 3) -> Score:
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
    return Score(
        float(np.hypot(*away[:2])),
        float(np.degrees(abs(away[2]))),
        float(np.median(off)) if len(off) else float("nan"),
        float(nees),
        len(off),
        int((off > WRONG).sum()),
        misled,
    )


def summary(scores: Sequence[Score]) -> dict[str, float]:
    """Return medians and tails over drives."""
    each = {name: np.array([asdict(score)[name] for score in scores]) for name in asdict(scores[0])}
    position = each["position"]
    return {
        "drives": len(scores),
        "position": float(np.median(position)),
        "position 95 %": float(np.quantile(position, 0.95)),
        "position worst": float(position.max()),
        "heading": float(np.median(each["heading"])),
        "landmarks": float(np.median(each["landmarks"])) if np.isfinite(each["landmarks"]).all() else 0.0,
        "NEES mean": float(each["nees"].mean()),
        "NEES median": float(np.median(each["nees"])),
        "outside": float((each["nees"] > OUTSIDE).mean()),
        "on the map": float(each["on_map"].mean()),
        "wrong": float(each["wrong"].mean()),
        "lost": float((position > LOST).mean()),
    }


def named(scores: Mapping[tuple[str, str], Mapping[int, Score]]) -> list[dict[str, Any]]:
    """Return which drives of several hypotheses are lost or overconfident, by condition and seed."""
    return [
        {
            "condition": condition,
            "seed": seed,
            "off (m)": score.position,
            "NEES": score.nees,
            "misled at stop": score.misled,
        }
        for (condition, algorithm), of in scores.items()
        for seed, score in of.items()
        if algorithm == "several hypotheses" and (score.position > LOST or score.nees > OVERCONFIDENT)
    ]


def named_table(found: Sequence[Mapping[str, Any]]) -> Table:
    """Return a table of the drives that `named` found."""
    return Table(
        f"several hypotheses, ends over {LOST:g} m off or with a NEES above {OVERCONFIDENT:g}; stop -1: consistent",
        ("condition", "seed", "off (m)", "NEES", "misled at stop"),
        tuple(tuple(each.values()) for each in found),
    )


ENDS = (
    "drives",
    "position",
    "position 95 %",
    "position worst",
    "heading",
    "NEES mean",
    "NEES median",
    "outside",
    "lost",
)
