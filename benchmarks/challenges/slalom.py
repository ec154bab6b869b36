"""Entries to lesson 00's challenge: standing still, straight ahead, gate after gate, and a better order of gates."""

import numpy as np
import numpy.typing as npt

from nao_course.lessons.meet_the_nao.slalom import GATES
from nao_course.slam import Motion


def plan_through(points: npt.ArrayLike) -> list[Motion]:
    """Return commands that lead from (0, 0, 0) in straight lines through points (N, 2), m."""
    way = np.diff(np.vstack([np.zeros((1, 2)), np.asarray(points, dtype=float)]), axis=0)
    headings = np.arctan2(way[:, 1], way[:, 0])
    turns = np.diff(headings, prepend=0.0, append=headings[-1])
    turns = (turns + np.pi) % (2 * np.pi) - np.pi
    distances = np.hypot(*way.T)
    steps = zip(distances.tolist(), turns[1:].tolist(), strict=True)
    return [Motion(0.0, float(turns[0])), *(Motion(distance, turn) for distance, turn in steps)]


IN_ORDER = [(gate.x, gate.y) for gate in GATES]
BEYOND_THE_LAST = (1.9, -1.4)
# The straightest way first: found by a search over orders and points with robots that are not the board's.
BETTER = [
    (2.25, 0.41),
    (2.50, 0.94),
    (2.00, 1.55),
    (0.65, 1.15),
    (0.34, 0.03),
    (2.18, -0.50),
    (0.17, -0.72),
    (2.09, -2.09),
]

SLALOM_ENTRIES = {
    "standing still": list[Motion](),
    "straight to the goal": [Motion(3.0, 0.0)],
    "the reference": plan_through([*IN_ORDER, BEYOND_THE_LAST]),
    "a better order": plan_through(BETTER),
}
