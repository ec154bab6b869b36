"""Entries of lesson 12's challenge: standing still, a circle, the lesson's choice, and a search for what is new."""

from collections.abc import Callable, Mapping
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks import solution
from nao_course.field_slam.drives import INSIDE
from nao_course.lessons.beyond.planning import in_a_circle
from nao_course.lessons.beyond.worlds import AHEAD, FIELD, ODOMETRY, SENSOR
from nao_course.sim.drives import NamedEkf
from nao_course.slam import Motion, range_and_bearing

Array = npt.NDArray[np.float64]
Belief = tuple[list[int], Array, Array]

LANDMARKS = 10
# Tuned on seeds 100 to 115.
WORTH = 20.0  # bits of a landmark that is seen for the first time
DISCOUNT = 0.9  # of what a later move would show
FAR = 0.5  # how much less a place counts that takes more moves: a power of their number
CELL = 0.25  # m: of the carpet that was looked at or not
DISTANCES, TURNS = (0.0, 0.3), np.radians((-90.0, -55.0, -25.0, 0.0, 25.0, 55.0, 90.0))
WAYS = np.array(  # turn, walk, turn
    list(product(np.radians((-90, -50, 0, 50, 90)), (0.3, 0.9, 1.5), np.radians((-90, -45, 0, 45, 90))))
)


def _filter(robot: Any) -> NamedEkf:
    """Return lesson 07's filter at a robot's start, after the first measurements."""
    ekf = solution("07")
    slam = NamedEkf(robot.start, *(ekf[name] for name in ("predict", "update_landmarks", "add_landmark")))
    slam.observe(*robot.look())
    return slam


def _said(slam: NamedEkf) -> Belief:
    return list(slam.known), slam.state, slam.covariance


def stand_still(robot: Any) -> Belief:
    """Measure once at the start."""
    return _said(_filter(robot))


def _by(choose: Callable[..., int]) -> Callable[[Any], Belief]:
    """Drive by a choice among the lesson's options."""

    def entry(robot: Any) -> Belief:
        slam = _filter(robot)
        while robot.moves_left:
            offered = robot.options(slam.state)
            option = offered[choose(slam.state.copy(), slam.covariance.copy(), offered)]
            robot.move(option)
            slam.move(option.control, option.control_covariance)
            slam.observe(*robot.look())
        return _said(slam)

    return entry


def _lessons_choice(state: Array, covariance: Array, offered: Any) -> int:
    return int(solution("12")["choose_move"](state, covariance, offered))


def _cells() -> Array:
    x0, y0, x1, y1 = FIELD.carpet
    xs, ys = np.meshgrid(np.arange(x0 + CELL / 2, x1, CELL), np.arange(y0 + CELL / 2, y1, CELL))
    return np.column_stack([xs.ravel(), ys.ravel()])


def better(robot: Any) -> Belief:
    """Choose each time the move after which the map contains the most bits."""
    ekf = solution("07")
    slam, cells = _filter(robot), _cells()
    unseen = ~AHEAD.sees(slam.state[:3], cells)
    while robot.moves_left:
        control = _best(ekf, slam, cells, unseen)
        slam.move(np.array(control), robot.move(control))
        slam.observe(*robot.look())
        unseen &= ~AHEAD.sees(slam.state[:3], cells)
    return _said(slam)


def _best(
    ekf: Mapping[str, Any], slam: NamedEkf, cells: Array, unseen: npt.NDArray[np.bool_]
) -> tuple[float, float]:
    missing = LANDMARKS - len(slam.known)
    worth = WORTH * missing / max(int(unseen.sum()), 1)
    best, most = (0.0, 0.0), -np.inf
    for distance, turn in product(DISTANCES, TURNS.tolist()):
        after = _after(slam.state[:3], distance, turn)
        if not ((after[:2] >= INSIDE[0]) & (after[:2] <= INSIDE[1])).all():
            continue
        new = unseen & AHEAD.sees(after, cells)
        left = unseen & ~new
        later = _shown(after, left, cells)
        bits = _certainty(ekf, slam, distance, turn, after) + worth * (new.sum() + DISCOUNT * later)
        if bits > most:
            best, most = (distance, turn), bits
    return best


def _shown(pose: Array, unseen: npt.NDArray[np.bool_], cells: Array) -> float:
    """Return the most unseen cells that a turn, a walk and another turn can show, per move."""
    turn, distance, last = WAYS.T
    heading = pose[2] + turn
    there = pose[:2] + distance[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    inside = ((there >= INSIDE[0]) & (there <= INSIDE[1])).all(axis=1)
    poses = np.column_stack([there, heading + last])[inside]
    if not len(poses) or not unseen.any():
        return 0.0
    counts = AHEAD.sees(poses[:, None], cells[unseen]).sum(axis=1)
    return float((counts / (distance[inside] / 0.3) ** FAR).max())


def _after(pose: Array, distance: float, turn: float) -> Array:
    way = distance * np.array([np.cos(pose[2]), np.sin(pose[2]), 0.0])
    return np.asarray(pose + way + (0.0, 0.0, turn))


def _certainty(ekf: Mapping[str, Any], slam: NamedEkf, distance: float, turn: float, after: Array) -> float:
    """Return the bits of the map after a move and new measurements, as predicted by the filter."""
    noise = ODOMETRY.covariance(Motion(distance, turn))
    belief = ekf["predict"](slam.state, slam.covariance, np.array([distance, turn]), noise, len(slam.known))
    landmarks = slam.state[3:].reshape(-1, 2)
    seen = np.flatnonzero(AHEAD.sees(after, landmarks)) if slam.known else np.zeros(0, int)
    if len(seen):
        expected = range_and_bearing(after, landmarks[seen])
        noise = SENSOR.covariances(expected)
        belief = ekf["update_landmarks"](*belief, seen.tolist(), expected.ravel(), noise)
    covariance = belief[1][3:, 3:] + 1e-9 * np.eye(len(belief[0]) - 3)
    return -0.5 * float(np.linalg.slogdet(covariance)[1]) / float(np.log(2))


MAP_ENTRIES = {
    "standing still": stand_still,
    "the paper's way, a fixed plan": _by(in_a_circle),
    "the reference": _by(_lessons_choice),
    "a better one": better,
}
