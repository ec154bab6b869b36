"""Lesson 12's stage of the control panel: it chooses the next move, to explore or to reduce the uncertainty."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.field_slam.drives import INSIDE
from nao_course.geometry import FloatArray, wrap_angle
from nao_course.lessons.beyond import exploring
from nao_course.lessons.beyond.exploring import FREE, OCCUPIED, UNKNOWN, Cell, as_mask, as_steps, way_back
from nao_course.lessons.beyond.planning import STEP, options
from nao_course.robot import Robot
from nao_course.sim import SimulatedNao
from nao_course.sim.drives import NamedEkf
from nao_course.slam import Estimate, Motion, place_estimate
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.named_landmarks import FollowedRobot, new_motions, start_of
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction

REACH = 3.5  # m: beyond it the range from one picture is inaccurate (lesson 04)
MOST_SIGMA = (
    0.05  # m: with a larger standard deviation the robot returns to known landmarks before it goes on
)
RETURN = 0.9  # m: longest way of such a return
GO_ON = 0.9  # m: shortest way between two returns
OFF = float(np.radians(10.0))  # a smaller turn is not made before walking
PICTURES = "estimate"  # lesson 11's stage
SEED = 121  # of the measurements' noise


class Followed(NamedTuple):
    """The pose and the landmarks in the field frame after a picture, with what was walked before it, m.

    `state` is (3 + 2n,) with its `covariance`, and `pixels` are the measured landmarks in the picture.
    """

    state: FloatArray
    covariance: FloatArray
    walked: float
    pixels: list[tuple[float, float]]
    estimate: Estimate


class Explorer:
    """The part of the half field that a robot has seen, and the choice of its next move."""

    def __init__(self, student: StudentCode) -> None:
        """Start with an unknown grid; cells where the robot may not drive count as occupied."""
        self._student = student
        centres = exploring.cell_centres()
        self._inside = ((centres >= INSIDE[0]) & (centres <= INSIDE[1])).all(axis=2)
        self.grid = np.where(self._inside, UNKNOWN, OCCUPIED)
        self.frontiers = np.zeros(exploring.SHAPE, dtype=bool)
        self.why = "to the nearest frontier"
        self._walked = GO_ON  # m, since it began to return or to go on

    @property
    def part(self) -> float:
        """Known fraction of the cells where the robot may drive."""
        return float((self.grid[self._inside] == FREE).mean())

    def see(self, pose: FloatArray, yaw: float, walked: float) -> None:
        """Mark the area ahead of the head, 2 m far and 61 degrees wide, from an estimated pose (3,), field frame."""
        seen = np.full(exploring.SHAPE, UNKNOWN)
        exploring.mark_visible(seen, np.zeros(exploring.SHAPE, dtype=bool), pose[:2], pose[2] + yaw)
        self.grid[(seen == FREE) & self._inside] = FREE
        self._walked += walked

    def next(self, state: FloatArray, covariance: FloatArray) -> Motion | None:
        """Return the next move: to the nearest frontier, or a return if the pose is uncertain; None if all is seen."""
        frontier = self._frontier(state[:3])
        sigma = position_sigma(covariance)
        back = self.why == "to localise better"
        if back and (sigma < MOST_SIGMA or self._walked > RETURN - 0.01):
            back, self._walked = False, 0.0
        elif not back and sigma > MOST_SIGMA and self._walked > GO_ON - 0.01:
            back, self._walked = True, 0.0
        self.why = "to localise better" if back else "to the nearest frontier"
        return self._most_certain(state, covariance) if back and frontier is not None else frontier

    def _most_certain(self, state: FloatArray, covariance: FloatArray) -> Motion:
        offered = options(state)
        number = self._student.choose_move(state.copy(), covariance.copy(), offered)
        if not 0 <= int(number) < len(offered):
            raise ValueError(f"choose_move must return 0 to {len(offered) - 1}, got {number!r}")
        return Motion(*offered[int(number)].control.tolist())

    def _frontier(self, pose: FloatArray) -> Motion | None:
        """Return a step toward the nearest frontier, or None if there is no frontier."""
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


def position_sigma(covariance: FloatArray) -> float:
    """Return the standard deviation of the position, m: the root of the sum of both variances."""
    return float(np.sqrt(covariance[0, 0] + covariance[1, 1]))


def _toward(pose: FloatArray, there: Cell, goal: Cell) -> Motion:
    """Return a turn toward the path, or a step along it; the robot only turns to a frontier that is very close."""
    centres = exploring.cell_centres()
    near = np.hypot(*(centres[goal] - pose[:2])) < STEP
    off = centres[goal if near else there] - pose[:2]
    turn = float(wrap_angle(np.arctan2(off[1], off[0]) - pose[2]))
    return Motion(0.0, turn) if abs(turn) > OFF else Motion(float(np.clip(np.hypot(*off), 0.1, STEP)), 0.0)


def _by_names(student: StudentCode, nao: SimulatedNao) -> Callable[[Frame], Followed]:
    """Follow a simulated robot from its true pose, with landmarks that are measured by name."""
    start, kinds = nao.field.pose.inverse() @ start_of(nao), nao.field.detectable_kinds
    slam = NamedEkf(start, student.predict, student.update_landmarks, student.add_landmark)
    robot = FollowedRobot(slam, nao, REACH, SEED)

    def follow(frame: Frame) -> Followed:
        seen, walked = robot.follow(frame.picture.view)
        slam = robot.slam
        return Followed(slam.state, slam.covariance, walked, seen.pixels, slam.estimate(kinds))

    return follow


def _by_pictures(nao: Robot) -> Callable[[Frame], Followed]:
    """Follow a real robot by lesson 11's estimate, whose landmarks are taken as independent of each other."""
    done = 0

    def follow(frame: Frame) -> Followed:
        nonlocal done
        if PICTURES not in frame.results:
            raise ValueError("a real robot explores by lesson 11's estimate, which is missing")
        own = place_estimate(frame.results[PICTURES], nao.field.pose.inverse())
        motions = new_motions(nao, done)
        done += len(motions)
        state = np.concatenate([own.pose.as_array(), own.landmarks.ravel()])
        covariance = np.zeros((len(state), len(state)))
        covariance[:3, :3] = own.covariance
        for number, each in enumerate(own.landmark_covariances):
            covariance[2 * number + 3 : 2 * number + 5, 2 * number + 3 : 2 * number + 5] = each
        return Followed(state, covariance, sum(abs(each.distance) for each in motions), [], own)

    return follow


def _explore(student: StudentCode, nao: Robot) -> StageFunction:
    """Begin where the robot was put, follow its commands, update with each picture, and choose the next move."""
    follow = _by_names(student, nao) if isinstance(nao, SimulatedNao) else _by_pictures(nao)
    explorer = Explorer(student)

    def show(frame: Frame) -> Overlay:
        now = follow(frame)
        explorer.see(now.state[:3], nao.head[0], now.walked)
        motion = explorer.next(now.state, now.covariance)
        ends = exploring.cell_centres()[explorer.frontiers]
        # With it, the map shows lesson 11's estimate, which has other landmarks.
        by_pictures = PICTURES in frame.results
        known = say_count(len(now.estimate.landmarks), "landmark")
        own = f", {known} on the map, standard deviation {position_sigma(now.covariance):.2f} m"
        return Overlay(
            result=motion,
            pixels=np.reshape(now.pixels, (-1, 2)),
            text=f"{explorer.part:.0%} seen{'' if by_pictures else own}; "
            + (explorer.why if motion else "everything is seen"),
            estimate=None if by_pictures else place_estimate(now.estimate, nao.field.pose),
            motion=motion,
            cells=nao.field.pose.to_parent(ends) if len(ends) else ends,
            finish="" if motion else "The whole field is seen",
        )

    return show


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
