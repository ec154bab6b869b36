"""The stage of lesson 08 for the student's robot: the map of the drive, one linear graph for each axis."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray, Pose
from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import Estimate, LandmarkKind, Measurement, measured_points, place_estimate
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction

STEP, TURN = 0.25, np.radians(20)  # m, rad: either distance adds a new pose to the graph
GATE = 0.4  # m: a landmark of the same kind that is nearer is the same one
MOTION_EPSILON = 0.004  # m^2 for each metre; a tenth of it is added to each step
SEED = 81  # of the measurements' noise
MEASUREMENT_EPSILON = 0.002  # m^2 for a range of one metre; it grows with its square


@dataclass
class _Graph:
    """The system of each axis, which grows during the drive, and the estimates of its variables."""

    student: StudentCode
    kinds: list[str] = field(default_factory=list)  # "pose", or the landmark's kind
    systems: list[Any] = field(default_factory=lambda: [(np.zeros((0, 0)), np.zeros(0)) for _ in range(2)])
    positions: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    # of each variable, m^2, in either axis
    variances: FloatArray = field(default_factory=lambda: np.zeros(0))
    odometry: list[Pose] = field(default_factory=list)  # of the poses
    measured: int = 0

    def copy(self) -> _Graph:
        """Return a graph that can grow without changing this one."""
        systems = [(omega.copy(), xi.copy()) for omega, xi in self.systems]
        return replace(self, kinds=[*self.kinds], systems=systems, odometry=[*self.odometry])

    def new_variable(self, kind: str, at: FloatArray) -> int:
        """Add a variable to both systems, at first at (2,) in metres."""
        self.kinds.append(kind)
        self.positions = np.vstack([self.positions, at])
        self.systems = [
            (np.pad(np.asarray(omega, dtype=float), (0, 1)), np.pad(np.asarray(xi, dtype=float), (0, 1)))
            for omega, xi in self.systems
        ]
        return len(self.kinds) - 1

    def add(self, function: str, *constraint: Any) -> None:
        """Add a constraint to both systems by the student's function; its value is the last of `constraint` but one."""
        *variables, value, epsilon = constraint
        more = () if epsilon is None else (epsilon,)
        call = getattr(self.student, function)
        self.systems = [
            call(omega, xi, *variables, float(value[axis]), *more)
            for axis, (omega, xi) in enumerate(self.systems)
        ]

    def solved(self) -> None:
        """Solve both systems; the variances are relative to the start."""
        columns = [np.asarray(self.student.solve(*system), dtype=float) for system in self.systems]
        self.positions = np.column_stack(columns).reshape(len(self.kinds), 2)
        if not np.isfinite(self.positions).all():
            raise ValueError("solve must return finite numbers")
        omega = self.systems[0][0]  # both axes have the same
        self.variances = np.append(0.0, np.diag(np.linalg.inv(omega[1:, 1:])))

    @property
    def last_pose(self) -> int:
        """Number of the newest pose."""
        return max(number for number, kind in enumerate(self.kinds) if kind == "pose")

    def estimate(self, pose: Pose) -> Estimate:
        """Return the estimate of the landmarks, with the robot at `pose`, in the frame of the start."""
        marks = [number for number, kind in enumerate(self.kinds) if kind != "pose"]
        spread = self.variances[self.last_pose]
        return Estimate(
            pose,
            np.diag([spread, spread, 0.0]),
            self.positions[marks],
            self.variances[marks, None, None] * np.eye(2),
            cast("tuple[LandmarkKind, ...]", tuple(self.kinds[number] for number in marks)),
        )


def _start_or_move(graph: _Graph, odometry: Pose) -> int:
    """Add the current pose; its motion is in the frame of the start, by the heading of odometry."""
    at = np.array([odometry.x, odometry.y])
    if not graph.odometry:
        number = graph.new_variable("pose", at)
        graph.add("add_initial_position", number, at, None)
    else:
        before = graph.last_pose
        moved = at - graph.odometry[-1].as_array()[:2]
        number = graph.new_variable("pose", graph.positions[before] + moved)
        epsilon = MOTION_EPSILON * (0.1 + float(np.hypot(*moved)))
        graph.add("add_relative_motion", before, number, moved, epsilon)
    graph.odometry.append(odometry)
    return number


def _measure(graph: _Graph, pose: int, heading: float, seen: tuple[Measurement, ...]) -> None:
    """Add measurements from a pose, each of the nearest landmark of its kind or of a new landmark."""
    for each in seen:
        offset = measured_points([each], Pose(0.0, 0.0, heading))[0]
        at = graph.positions[pose] + offset
        alike = [number for number, kind in enumerate(graph.kinds) if kind == each.kind]
        away = np.hypot(*(graph.positions[alike] - at).T)
        known = alike[int(np.argmin(away))] if len(alike) and away.min() < GATE else None
        landmark = graph.new_variable(each.kind, at) if known is None else known
        graph.add(
            "add_relative_measurement", pose, landmark, offset, MEASUREMENT_EPSILON * (0.1 + each.range**2)
        )
        graph.measured += 1


def _is_new(graph: _Graph, odometry: Pose) -> bool:
    """Return whether the robot is far enough from its last pose in the graph."""
    if not graph.odometry:
        return True
    moved = graph.odometry[-1].inverse() @ odometry
    return bool(np.hypot(moved.x, moved.y) >= STEP - 1e-9 or abs(moved.theta) >= TURN - 1e-9)


def _map_the_drive(student: StudentCode, nao: SimulatedNao) -> StageFunction:
    """Fill two systems with the robot's motions and measurements, and solve them."""
    graph, truth, rng = _Graph(student), Truth(nao), np.random.default_rng(SEED)

    def look(frame: Frame) -> Overlay:
        nonlocal graph
        odometry = nao.odometry
        if _is_new(graph, odometry):
            with nao.aside(rng):  # measuring must not change how the robot slips next
                seen = nao.sense(frame.picture.camera)
            grown = graph.copy()
            pose = _start_or_move(grown, odometry)
            _measure(grown, pose, odometry.theta, seen)
            grown.solved()
            graph = (
                grown  # only now: if a function of the student's fails, the picture leaves no half of itself
            )
        since = odometry.as_array()[:2] - graph.odometry[-1].as_array()[:2]
        x, y = graph.positions[graph.last_pose] + since
        estimate = graph.estimate(Pose(float(x), float(y), odometry.theta))
        landmarks, poses = (
            say_count(len(each), noun)
            for each, noun in ((estimate.landmarks, "landmark"), (graph.odometry, "pose"))
        )
        return Overlay(
            result=estimate.landmarks,
            text=f"{landmarks} from {poses}, {say_count(graph.measured, 'measurement')}",
            estimate=place_estimate(estimate, truth.odometry_start),
        )

    return look


STAGE = Stage(
    name="map after the drive",
    lesson="08_graph_slam",
    uses=("add_initial_position", "add_relative_motion", "add_relative_measurement", "solve"),
    wire=_map_the_drive,
    estimates=True,
    simulated=True,
)
