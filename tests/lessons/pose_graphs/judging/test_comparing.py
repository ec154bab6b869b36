"""How states are compared: headings by whole turns, everything else as it is."""

import numpy as np
import pytest

from nao_course.exercises import Case
from nao_course.lessons.pose_graphs import loop
from nao_course.lessons.pose_graphs.judging.comparing import SolvedStates

WORLD = loop(1, side=2)
EXPECTED = (WORLD.truth, np.array([2.0, 1.0]))
CASE = Case((WORLD.graph, WORLD.odometry, 1), expected=EXPECTED)


def changed(place, by):
    states = WORLD.truth.copy()
    states[place] += by
    return states, EXPECTED[1]


@pytest.mark.parametrize(
    ("answer", "right"),
    [
        (list(EXPECTED), True),
        (changed(5, 2 * np.pi), True),
        (changed(8, -4 * np.pi), True),
        (changed(4, 2 * np.pi), False),
        (changed(5, 0.1), False),
        (changed(5, np.nan), False),
        ((WORLD.truth, np.array([2.0, 1.1])), False),
        ((WORLD.truth[:3], EXPECTED[1]), False),
        (("no", "states"), False),
        (WORLD.truth, False),
    ],
)
def test_headings_may_differ_by_whole_turns_and_nothing_else_may(answer, right):
    assert bool(SolvedStates().judge(CASE, answer)) is right
