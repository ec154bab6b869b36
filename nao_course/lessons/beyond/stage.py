"""What lesson 12 adds to the student's robot: it says where to go next, to see what is new or to be surer."""

from __future__ import annotations

from copy import copy
from itertools import pairwise

import numpy as np

from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.beyond import exploring
from nao_course.lessons.beyond.exploring import FREE, OCCUPIED, UNKNOWN, Cell, as_mask, as_steps, way_back
from nao_course.lessons.beyond.particles import NamedEkf
from nao_course.lessons.beyond.planning import STEP, options
from nao_course.lessons.beyond.worlds import INSIDE
from nao_course.plotting.drawing import say_count
from nao_course.sim import SimulatedNao, Truth, VisibleLandmark, visible_landmarks
from nao_course.slam import Estimate, LandmarkKind, Motion, place_estimate
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Look, Overlay, Sight, Stage

REACH = 3.5  # m: beyond it a range from one picture is poor (lesson 04)
DOUBT = 0.05  # m: a robot that is less sure looks back before it goes on
LOOK_BACK = 0.9  # m: so far it looks back at most
GO_ON = 0.9  # m: so far it goes on before it looks back again
OFF = float(np.radians(10.0))  # a way that is less off is walked, another one first turned to
PICTURES = "the estimate"  # lesson 11's stage
SEED = 121  # of the measurements' noise


class Explorer:
    """What a robot has seen of the half field, and where it would go.

    Parameters
    ----------
    student : StudentCode
        With find_frontiers, travel_steps and choose_move.
    """

    def __init__(self, student: StudentCode) -> None:
        """Begin with a grid of which nothing is known; where the robot may not drive it counts as occupied."""
        self._student = student
        centres = exploring.cell_centres()
        self._inside = ((centres >= INSIDE[0]) & (centres <= INSIDE[1])).all(axis=2)
        self.grid = np.where(self._inside, UNKNOWN, OCCUPIED)
        self.frontiers = np.zeros(exploring.SHAPE, dtype=bool)
        self.why = "to the nearest frontier"
        self._walked = GO_ON  # m, since it looks back, or goes on

    @property
    def part(self) -> float:
        """How much of where the robot may drive is known."""
        return float((self.grid[self._inside] == FREE).mean())

    def see(self, pose: FloatArray, yaw: float, walked: float) -> None:
        """Write down what lies before the head: 2 m far and 61 degrees wide, from a believed pose (3,), field frame."""
        seen = np.full(exploring.SHAPE, UNKNOWN)
        exploring.look(seen, np.zeros(exploring.SHAPE, dtype=bool), pose[:2], pose[2] + yaw)
        self.grid[(seen == FREE) & self._inside] = FREE
        self._walked += walked

    def next(self, slam: NamedEkf) -> Motion | None:
        """Say where to go: to the nearest frontier, or in doubt where the robot is surest; None where all is seen."""
        frontier = self._frontier(slam.state[:3])
        doubt = doubt_of(slam)
        back = self.why == "to be surer"
        if back and (doubt < DOUBT or self._walked > LOOK_BACK - 0.01):
            back, self._walked = False, 0.0
        elif not back and doubt > DOUBT and self._walked > GO_ON - 0.01:
            back, self._walked = True, 0.0
        self.why = "to be surer" if back else "to the nearest frontier"
        return self._surest(slam) if back and frontier is not None else frontier

    def _surest(self, slam: NamedEkf) -> Motion:
        offered = options(slam.state)
        number = self._student.choose_move(slam.state.copy(), slam.covariance.copy(), offered)
        if not 0 <= int(number) < len(offered):
            raise ValueError(f"choose_move must return 0 to {len(offered) - 1}, got {number!r}")
        return Motion(*offered[int(number)].control.tolist())

    def _frontier(self, pose: FloatArray) -> Motion | None:
        """A step toward the nearest frontier."""
        here = exploring.cell_of(np.clip(pose[:2], INSIDE[0], np.subtract(INSIDE[1], 1e-6)))
        free = self.grid == FREE
        free[here] = True
        steps = as_steps(self._student.travel_steps(free.copy(), here), free.shape)
        self.frontiers = as_mask(self._student.find_frontiers(self.grid.copy()), free.shape)
        ends = self.frontiers & (steps >= 0)
        if not ends.any():
            return None
        cells = np.argwhere(ends)
        row, column = cells[np.argmin(steps[ends])].tolist()
        way = way_back(steps, (row, column))
        return _toward(pose, way[min(exploring.STRIDE, len(way) - 1)], (row, column))


def doubt_of(slam: NamedEkf) -> float:
    """Root of the sum of the position's two variances, m."""
    return float(np.sqrt(slam.covariance[0, 0] + slam.covariance[1, 1]))


def _toward(pose: FloatArray, there: Cell, goal: Cell) -> Motion:
    """Turn to where the way leads, or walk it; a frontier at one's feet is turned to, to see what lies beyond."""
    centres = exploring.cell_centres()
    near = np.hypot(*(centres[goal] - pose[:2])) < STEP
    off = centres[goal if near else there] - pose[:2]
    turn = float(wrap_angle(np.arctan2(off[1], off[0]) - pose[2]))
    return Motion(0.0, turn) if abs(turn) > OFF else Motion(float(np.clip(np.hypot(*off), 0.1, STEP)), 0.0)


def _explore(student: StudentCode, nao: SimulatedNao) -> Look:
    """Begin where the robot stands, which it knows; follow the commands, take each picture in, and say where to go."""
    truth, rng = Truth(nao), np.random.default_rng(SEED)
    marks = [mark for mark in nao.field.landmarks if mark.kind != "cross"]
    kinds: list[LandmarkKind] = ["post" if mark.kind == "post" else "corner" for mark in marks]
    start = nao.field.pose.inverse() @ truth.odometry_start
    slam = NamedEkf(start, student.predict, student.update_landmarks, student.add_landmark)
    explorer, done = Explorer(student), 0

    def look(sight: Sight) -> Overlay:
        nonlocal slam, done
        now, path, walked = copy(slam), nao.odometry_path, 0.0
        now.known = list(slam.known)
        for before, after in pairwise(path[done:]):
            step = before.inverse() @ after
            noise = nao.odometry_noise.covariance(Motion(step.x, step.theta))
            now.move(np.array([step.x, step.theta]), noise)
            walked += abs(step.x)
        seen = [
            mark
            for mark in visible_landmarks(nao.field, truth.pose, sight.picture.view)
            if mark.landmark in marks and not mark.occluded and mark.distance <= REACH
        ]
        now.observe([marks.index(mark.landmark) for mark in seen], _measured(nao, seen, rng))
        slam, done = now, len(path) - 1
        explorer.see(slam.state[:3], nao.head[0], walked)
        motion = explorer.next(slam)
        ends = exploring.cell_centres()[explorer.frontiers]
        by_pictures = PICTURES in sight.results  # who maps by pictures keeps the map and its board
        return Overlay(
            result=motion,
            pixels=[mark.pixel for mark in seen],
            points=Pose.from_array(slam.state[:3]).to_local(ends) if len(ends) else ends,
            text=f"{explorer.part:.0%} seen, {say_count(len(slam.known), 'landmark')} on the map, "
            f"sure to {doubt_of(slam):.2f} m; {explorer.why if motion else 'all is seen'}"
            + ("; the map shows the estimate of lesson 11" if by_pictures else ""),
            estimate=None if by_pictures else place_estimate(_estimate(slam, kinds), nao.field.pose),
            motion=motion,
        )

    return look


def _measured(nao: SimulatedNao, seen: list[VisibleLandmark], rng: np.random.Generator) -> FloatArray:
    """Bearings and ranges (n, 2) that the simulator measures of landmarks which it names; rad, m."""
    noise = nao.sensor_noise
    rows = [
        (
            mark.bearing + noise.bearing * rng.standard_normal(),
            max(mark.distance * (1 + noise.range_fraction * rng.standard_normal()), 0.05),
        )
        for mark in seen
    ]
    return np.array(rows).reshape(-1, 2)


def _estimate(slam: NamedEkf, kinds: list[LandmarkKind]) -> Estimate:
    """What is believed, field frame."""
    size = len(slam.state)
    own = [slam.covariance[n : n + 2, n : n + 2] for n in range(3, size, 2)]
    return Estimate(
        Pose.from_array(slam.state[:3]),
        slam.covariance[:3, :3],
        slam.state[3:].reshape(-1, 2),
        np.array(own).reshape(-1, 2, 2),
        tuple(kinds[number] for number in slam.known),
    )


STAGE = Stage(
    name="next move",
    lesson="12_beyond",
    uses=(
        "find_frontiers",
        "travel_steps",
        "choose_move",
        "07:predict",
        "07:update_landmarks",
        "07:add_landmark",
    ),
    wire=_explore,
    estimates=True,
    drives=True,
)
