"""A real robot's walk: its pictures, its true steps with odometry's noise, and where filter and graph say it ends.

The pictures are the same for every seed; the seeds draw the odometry's errors. images/make.py draws the maps.
The bound of the last pose is after P. Tichavský et al., *Posterior Cramér-Rao bounds for discrete-time nonlinear
filtering*, IEEE Transactions on Signal Processing 46, 1998.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, cast

import numpy as np
from matplotlib.figure import Figure
from scipy.linalg import block_diag

from benchmarks import ROOT, Result, Table, solution
from benchmarks.pictures.distance import marked, offset_of
from benchmarks.pictures.recorded_walk import identified
from benchmarks.simulator.reality import corrected_walk
from nao_course.datasets import RealPicture, read_pictures
from nao_course.field_slam.adaptive_noise import OdometryModel
from nao_course.field_slam.association import associate_jointly, landmark_jacobian
from nao_course.field_slam.compass import COMPASS_SIGMA, estimate_body_tilt, wrap_quarter
from nao_course.field_slam.demo.drive import CORNER_SIGMA, GATE, Functions, demo_functions, see_all
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.field_slam.joint_update import UNKNOWN, JointFilter, JointUpdate
from nao_course.field_slam.known_shapes.calibration import CameraCalibration
from nao_course.field_slam.observation import POST_SIGMA, Observation, observation
from nao_course.field_slam.walk import FIELD, PITCH_OFFSET, WalkFrame, real_walk, walk_view
from nao_course.geometry import FloatArray, Pose, pose_errors, rotation_2d
from nao_course.metrics import squared_distances
from nao_course.plotting import course_style, plot_estimate, plot_field, plot_path
from nao_course.plotting.legends import legend_below, source_key
from nao_course.sim import visible_landmarks
from nao_course.slam import KINDS, DeadReckoning, Estimate, Measurement, Motion, SlamAlgorithm

SEEDS = range(100, 120)
SHOWN = 100  # the seed whose maps are drawn
# A compass that errs by more has taken something else for the field's lines.
OFF_COURSE = float(np.radians(10))
Make = Callable[[Pose], SlamAlgorithm]
Classes = Mapping[str, Callable[..., SlamAlgorithm]]
HALF = 15  # pictures on which the calibration was developed
ASSUMED = ((0.0, 0.0), (4.0, 0.0), (-1.0, 3.0), (10.0, -3.0), (10.0, 3.0), (3.0, -2.0))  # degrees
LAST = range(24, 30)  # pictures without a landmark, counted from 0
# The carpet's edge in three of them, (u1, v1, u2, v2), px without lens distortion, marked by hand. Then cables hide it.
EDGE = {26: (17.0, 126.8, 73.3, 127.6), 27: (8.4, 142.5, 59.9, 143.0), 28: (0.7, 156.2, 42.2, 155.8)}
# A true pose, the observation there, and the true position (k, 2) of the landmark of each measurement, m.
Stop = tuple[Pose, Observation, FloatArray]


class AtOnce(CameraCalibration):
    """A calibration with which even the first pictures are measured at once."""

    is_certain = True


@dataclass(frozen=True)
class Options:
    """How the walk is read.

    The camera's constant offset is the robot's "own" estimate on the way, or from the "marked" points of the first
    picture, or "none", so that the angles of the joints are used. With `compass`, lines measure the heading; with
    `marked_headings`, the true headings are computed from the marked points and not those written down; with `joint`,
    the filter also uses lines and the centre circle; with `wait`, the first pictures are measured only when the robot's
    own calibration is certain enough. `assumed` are errors of pitch and roll that are added to the view from the
    joints, degrees.
    """

    calibration: Literal["own", "marked", "none"] = "own"
    compass: bool = True
    marked_headings: bool = True
    joint: bool = False
    wait: bool = True
    assumed: tuple[float, float] = (0.0, 0.0)

    def observations(
        self, functions: Functions, pictures: Sequence[RealPicture]
    ) -> tuple[list[Observation], CameraCalibration]:
        """Return the observations of all pictures, the same for all seeds, and the calibration after the last one."""
        calibration = CameraCalibration() if self.wait else AtOnce()
        pitch, roll = np.radians(self.assumed).tolist()
        pitch += PITCH_OFFSET if self.calibration == "marked" else 0.0
        frames = (
            replace(
                frame,
                view=replace(frame.view, pitch=frame.view.pitch + pitch, roll=frame.view.roll + roll),
                calibrated=self.calibration != "own",
            )
            for frame in real_walk(pictures, 0)
        )
        found = [each.observation for each in see_all(functions, frames, calibration, self.joint)]
        if not self.compass:
            found = [replace(each, direction_sigma=float("inf")) for each in found]
        return found, calibration


# Name: how the walk is read, and the class of lesson 11's solution; None: odometry.
VARIANTS: dict[str, tuple[Options, str | None]] = {
    "odometry alone": (Options(), None),
    "EKF": (Options(), "EkfSlam"),
    "graph": (Options(), "GraphSlam"),
    "EKF, joint update": (Options(joint=True), "EkfSlam"),
    "EKF, first pictures at once": (Options(wait=False), "EkfSlam"),
    "EKF, no compass": (Options(compass=False), "EkfSlam"),
    "EKF, offset from marked points": (Options(calibration="marked"), "EkfSlam"),
    "EKF, joint update, offset from marked points": (Options(calibration="marked", joint=True), "EkfSlam"),
    "EKF, camera angles from the joints only": (Options(calibration="none"), "EkfSlam"),
    "odometry alone, headings as recorded": (Options(marked_headings=False), None),
    "EKF, headings as recorded": (Options(marked_headings=False), "EkfSlam"),
    "graph, headings as recorded": (Options(marked_headings=False), "GraphSlam"),
}


@dataclass(frozen=True, eq=False)
class Walked:
    """How a walk ended: errors along and across the field (m) and of the heading (rad), NEES, the map, and the path.

    `measured_error` is the error after the last picture with a measurement; odometry alone follows. The estimated path
    (poses at each picture, or none) is kept where it is drawn: a graph's costs much.
    """

    error: FloatArray
    measured_error: FloatArray
    nees: float
    estimate: Estimate
    frames: Sequence[WalkFrame]
    path: Sequence[Pose]

    @property
    def position(self) -> float:
        """How far off, m."""
        return float(np.hypot(*self.error[:2]))


def maker(classes: Classes, name: str | None, joint: bool = False) -> Make:
    """Return a factory of the algorithm of a walk, as in the demo, or with a joint update."""
    if name is None:
        return DeadReckoning

    def make(start: Pose) -> SlamAlgorithm:
        inner = classes[name](start, OdometryNoisePerMove(), GATE, associate_jointly)
        return JointUpdate(cast(JointFilter, inner)) if joint else inner

    return make


def walk(
    pictures: Sequence[RealPicture], seed: int, seen: Sequence[Observation], options: Options, make: Make
) -> Walked:
    """Run an algorithm over one walk."""
    frames = list(real_walk(pictures, seed, options.marked_headings))
    algorithm = make(frames[0].pose)
    path: list[Pose] = []
    last = max(number for number, of in enumerate(seen) if len(of))
    for number, (frame, of) in enumerate(zip(frames, seen, strict=True)):
        if frame.motion is not None:
            algorithm.move(frame.motion)
        algorithm.observe(of)
        if seed == SHOWN:
            path.append(algorithm.estimate().pose)
        if number == last:
            measured_error = _error(algorithm.estimate(), frame)
    end = algorithm.estimate()
    error = _error(end, frames[-1])
    known = bool(end.covariance.any())
    nees = float(squared_distances(error[None], end.covariance[None])[0]) if known else float("nan")
    return Walked(error, measured_error, nees, end, frames, path)


def _error(estimate: Estimate, frame: WalkFrame) -> FloatArray:
    return pose_errors(estimate.pose.as_array(), frame.pose.as_array())


def summary(walks: Sequence[Walked]) -> dict[str, float]:
    """Return medians and tails over the seeds, m and degrees."""
    off, errors = np.array([each.position for each in walks]), np.array([each.error for each in walks])
    measured = np.array([each.measured_error for each in walks])
    along, across, heading = np.sqrt(np.mean(errors**2, axis=0)).tolist()
    nees = float(np.median([each.nees for each in walks]))
    return {
        "position": float(np.median(off)),
        "position 95 %": float(np.quantile(off, 0.95)),
        "position worst": float(off.max()),
        "along rms": along,
        "across rms": across,
        "heading rms": float(np.degrees(heading)),
        "heading rms after the last measurement": float(np.degrees(np.sqrt(np.mean(measured[:, 2] ** 2)))),
    } | ({"NEES median": nees} if np.isfinite(nees) else {})


def compass_readings(frames: Sequence[WalkFrame], seen: Sequence[Observation]) -> tuple[int, int]:
    """Return the number of pictures with a compass reading, and how many of these readings are off course."""
    away = np.array(
        [wrap_quarter(-of.direction - frame.pose.theta) for frame, of in zip(frames, seen, strict=True)]
    )
    told = np.array([of.direction_sigma <= COMPASS_SIGMA for of in seen])
    return int(told.sum()), int((told & (np.abs(away) > OFF_COURSE)).sum())


def main() -> Result:
    """Run all variants of the walk with twenty seeds."""
    pictures = read_pictures("straightwalk")
    functions = demo_functions((), ROOT / "solutions")
    classes = solution("11")
    read: dict[Options, tuple[list[Observation], CameraCalibration]] = {}
    walks: dict[str, list[Walked]] = {}
    for name, (options, algorithm) in VARIANTS.items():
        seen_by = replace(options, marked_headings=True)  # no picture depends on the true headings
        if seen_by not in read:
            read[seen_by] = options.observations(functions, pictures)
        make = maker(classes, algorithm, options.joint)
        walks[name] = [walk(pictures, seed, read[seen_by][0], options, make) for seed in SEEDS]
    found = {name: summary(each) for name, each in walks.items()}
    shown = SEEDS.index(SHOWN)
    frames = walks["EKF"][shown].frames
    seen, calibration = read[Options()]
    told, off_course = compass_readings(frames, seen)
    measured = [each.kind for of in seen for each in of]
    headings = np.degrees([frame.pose.theta for frame in frames])
    values: dict[str, Any] = {
        "variants": found,
        "bound": bounds(frames, seen, calibration),
        "shown": {name: walks[name][shown].position for name in ("odometry alone", "EKF", "graph")},
        "compass readings": told,
        "of these more than 10 degrees off": off_course,
        **{f"{kind}s measured": measured.count(kind) for kind in KINDS},
        "pictures with a measurement": sum(len(of) > 0 for of in seen),
        "largest heading by the marked points, degrees": float(np.abs(headings).max()),
        "standard deviation of these headings, degrees": float(headings[: LAST.start].std()),
        "pitch offset by the first picture, degrees": marked_offset(pictures),
        "own estimate of the offset, degrees": {
            "walk": in_degrees(calibration),
            "scenes": in_degrees(calibrated_on(functions, read_pictures("scenes"))),
        },
    }
    values["first half, range of the EKF's median error over assumed views"] = {
        name: from_assumed_views(functions, pictures[:HALF], maker(classes, "EkfSlam"), wait)
        for name, wait in (("first pictures wait", True), ("first pictures at once", False))
    }
    title = f"end of a walk of {len(pictures)} pictures and 6 m, {len(SEEDS)} seeds"
    table = Table.of(title, found, *found["EKF"], shown=".3g")
    best = Table.of("Cramér-Rao bound of the last pose", values["bound"], shown=".3g")
    notes = tuple(f"{name}: {value:.3g}" for name, value in values.items() if isinstance(value, int | float))
    return Result("field_walk", values, (table, best), notes)


def bounds(
    frames: Sequence[WalkFrame], seen: Sequence[Observation], calibration: CameraCalibration
) -> dict[str, dict[str, float]]:
    """Return the bound of the walk's last pose for several sets of measurements, m and degrees."""
    stops = [_stops(*each, calibration) for each in zip(frames, seen, strict=True)]
    found, every = ([stop[i] for stop in stops] for i in range(2))
    edge, degree = {}, dict.fromkeys(LAST, float(np.radians(1.0)))
    for number, ends in EDGE.items():
        view = frames[number].view
        prior = calibration.tilt_covariance(view)
        tilt = estimate_body_tilt(ends, calibration.corrected(view), prior, -np.inf, least_length=0.0)
        edge[number] = float(np.sqrt(tilt.covariance[2, 2]))
    # Measurements, whether the map is known, and standard deviations of further directions by the picture.
    sets: dict[str, tuple[list[Stop], bool, dict[int, float]]] = {
        "detected": (found, False, {}),
        "detected, carpet's edge": (found, False, edge),
        "detected, a direction (1°) in each of the last six": (found, False, degree),
        "detected, known map": (found, True, {}),
        "every landmark in view": (every, False, {}),
    }
    rows = {}
    for name, (at, known_map, sigmas) in sets.items():
        directed = {n: replace(at[n][1], direction_sigma=sigma) for n, sigma in sigmas.items()}
        chosen = [(pose, directed.get(n, of), places) for n, (pose, of, places) in enumerate(at)]
        P = pose_bound(chosen, OdometryNoisePerMove(), known_map)
        along, across, heading = np.sqrt(np.diag(P)).tolist()
        off = np.hypot(*np.random.default_rng(0).multivariate_normal(np.zeros(2), P[:2, :2], 100_000).T)
        rows[name] = {"position": float(np.median(off)), "position 95 %": float(np.quantile(off, 0.95))}
        rows[name] |= {"along": along, "across": across, "heading": float(np.degrees(heading))}
    return rows


def _stops(frame: WalkFrame, seen: Observation, calibration: CameraCalibration) -> tuple[Stop, Stop]:
    """Return a stop with the measurements that fit a landmark, and one with all landmarks in the picture."""
    numbers, view = identified(frame.pose, seen), calibration.corrected(frame.view)
    marks = visible_landmarks(FIELD, frame.pose, view)
    exact = [Measurement(m.bearing, m.distance, m.landmark.detected_as or "corner") for m in marks]
    tilt = calibration.tilt_covariance(frame.view)
    ideal = observation(exact, tilt, CORNER_SIGMA, 0.0, seen.direction_sigma, POST_SIGMA)
    found = seen.part(list(numbers)), FIELD.detectable_positions[list(numbers.values())]
    places = np.array([(m.landmark.x, m.landmark.y) for m in marks]).reshape(-1, 2)
    return (frame.pose, *found), (frame.pose, ideal, places)


def pose_bound(stops: Sequence[Stop], odometry: OdometryModel, known_map: bool) -> FloatArray:
    """Return the bound (3, 3) of the last pose's covariance, m^2 and rad^2, linearised at the true poses.

    The first pose is known. Errors of different pictures, and of compass and ranges, count as independent.
    """
    places = np.unique(np.vstack([at for _, _, at in stops]), axis=0)
    P = block_diag(np.zeros((3, 3)), (0.0 if known_map else UNKNOWN) * np.eye(places.size))
    before = stops[0][0]
    for number, (pose, seen, at) in enumerate(stops):
        if number:
            step, turned = before.inverse() @ pose, block_diag(rotation_2d(before.theta), 1.0)
            F = np.eye(len(P))
            F[:3, 2] += turned @ [-step.y, step.x, 0.0]
            P = F @ P @ F.T
            P[:3, :3] += turned @ odometry.covariance(Motion(step.x, step.theta)) @ turned.T
        before, offset = pose, at - (pose.x, pose.y)
        distance, marks = np.hypot(*offset.T), np.nonzero((at[:, None] == places).all(axis=2))[1]
        H, R = landmark_jacobian(offset, distance, marks, len(P)), seen.linearised_at(distance)[1]
        if np.isfinite(seen.direction_sigma):
            H, R = np.vstack([H, np.eye(1, len(P), 2)]), block_diag(R, seen.direction_sigma**2)
        P = P - P @ H.T @ np.linalg.solve(H @ P @ H.T + R, H @ P)
    return P[:3, :3]


def from_assumed_views(
    functions: Functions, pictures: Sequence[RealPicture], make: Make, wait: bool
) -> list[float]:
    """Return the smallest and the largest median error at the end, m, if the view is assumed as in ASSUMED."""
    medians = []
    for assumed in ASSUMED:
        options = Options(wait=wait, assumed=assumed)
        seen, _ = options.observations(functions, pictures)
        medians.append(np.median([walk(pictures, seed, seen, options, make).position for seed in SEEDS]))
    return [float(min(medians)), float(max(medians))]


def calibrated_on(functions: Functions, pictures: Sequence[RealPicture]) -> CameraCalibration:
    """Return the calibration after some pictures in their order, from whatever poses."""
    calibration = CameraCalibration()
    frames = (WalkFrame(None, each.pixels, walk_view(each), each.pose, calibrated=False) for each in pictures)
    list(see_all(functions, frames, calibration))
    return calibration


def in_degrees(calibration: CameraCalibration) -> dict[str, float]:
    """Return the estimated offset and its standard deviations, degrees."""
    pitch, roll = np.degrees(calibration.mean).tolist()
    sigmas = np.degrees(np.sqrt(np.diag(calibration.covariance))).tolist()
    return {"pitch": pitch, "roll": roll, "pitch sigma": sigmas[0], "roll sigma": sigmas[1]}


def marked_offset(pictures: Sequence[RealPicture]) -> float:
    """Return the constant offset of the camera by the walk's first picture, whose pose is known; degrees."""
    return float(np.degrees(offset_of(marked(corrected_walk(pictures))[:1])))


@course_style()
def draw_maps() -> bytes:
    """Return a PNG: the maps at the end of one walk over the true field."""
    pictures = read_pictures("straightwalk")
    seen, _ = Options().observations(demo_functions((), ROOT / "solutions"), pictures)
    classes = solution("11")
    makers = {name: maker(classes, VARIANTS[name][1]) for name in ("odometry alone", "EKF", "graph")}
    walks = {name: walk(pictures, SHOWN, seen, Options(), make) for name, make in makers.items()}
    odometry, png = walks.pop("odometry alone"), io.BytesIO()
    figure = Figure(figsize=(11, 4.6))
    for number, (name, each) in enumerate(walks.items(), start=1):
        ax = figure.add_subplot(1, len(walks), number)
        source = name.lower()
        plot_field(FIELD, ax)
        plot_path(odometry.path, ax, "odometry", robot=False)
        plot_path([frame.pose for frame in each.frames], ax)
        plot_path(each.path, ax, source, robot=False)
        plot_estimate(each.estimate, ax, source)
        off, by_odometry = 100 * each.position, 100 * odometry.position
        ax.set_title(f"{name}: {off:.0f} cm off; odometry: {by_odometry:.0f} cm", fontsize=10)
    names = {"truth": "true path", "odometry": "odometry", "ekf": "EKF, 95 %", "graph": "graph, 95 %"}
    legend_below(figure, [source_key(source, name) for source, name in names.items()])
    figure.savefig(png, dpi=110, bbox_inches="tight", metadata={"Software": None})
    return png.getvalue()
