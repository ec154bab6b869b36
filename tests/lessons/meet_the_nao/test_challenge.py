"""The challenge of lesson 00: gates, robots that drive blind, and where they are lost."""

from itertools import permutations

import numpy as np
import pytest

from benchmarks.challenges.slalom import SLALOM_ENTRIES, plan_through
from nao_course.challenges import Board
from nao_course.challenges.running import run
from nao_course.lessons.meet_the_nao.challenge import CHALLENGE, Robot, without_errors
from nao_course.lessons.meet_the_nao.slalom import GATES, WIDTH, Gate, passed
from nao_course.sim import OdometryNoise, repeat_drive
from nao_course.slam import Motion


def through(gate, length=0.4, shift=0.0):
    """A step straight through a gate, `shift` metres to the left of its middle."""
    heading = np.radians(gate.heading_deg)
    ahead, left = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
    middle = np.array([gate.x, gate.y]) + shift * left
    return np.array([middle - length / 2 * ahead, middle + length / 2 * ahead])


@pytest.mark.parametrize("number", range(len(GATES)))
def test_a_gate_is_passed_between_its_poles_from_either_side_and_nowhere_else(number):
    gate = GATES[number]
    assert np.hypot(*(gate.poles[1] - gate.poles[0])) == pytest.approx(WIDTH)
    for step in (through(gate), through(gate)[::-1], through(gate, shift=0.24), through(gate, shift=-0.24)):
        assert passed(step)[number]
    for path in (through(gate, shift=0.26), through(gate, shift=-0.26), through(gate)[:1]):
        assert not passed(path)[number]


def test_gates_stand_apart_and_each_robot_slips_in_its_own_way():
    gate = GATES[0]
    path = [(0.0, 0.0), (gate.x, gate.y), (gate.x + 0.5, gate.y + 0.1)]
    assert passed(path).tolist() == [True, *[False] * 7]
    assert not passed([(0.0, 0.0), (gate.x - 0.01, gate.y), (0.0, 0.2)]).any()
    poles = np.vstack([gate.poles for gate in GATES])
    assert (np.abs(poles - [1.5, 0.0]) < [1.5, 2.0]).all()
    apart = np.hypot(*(poles[:, None] - poles[None]).transpose(2, 0, 1)) + 9 * np.eye(len(poles))
    assert apart.min() > 0.25 and Gate(0.0, 0.0, 0.0).poles[1].tolist() == [0.0, WIDTH / 2]
    plan = [Motion(0.5, 0.7), Motion(-0.2, -1.0), Motion(1.0, 3.0)]
    exact = repeat_drive(plan, 1, np.random.default_rng(0), OdometryNoise(0, 0, 0, 0))[0]
    assert without_errors(plan) == pytest.approx(exact)
    paths = [robot.drive(plan) for robot in CHALLENGE.seeds]
    assert (CHALLENGE.seeds[0].drive(plan) == paths[0]).all()
    assert len({path[-1].tobytes() for path in paths}) == len(paths)
    steps = [robot.drive(plan[:1]) for robot in CHALLENGE.seeds]
    assert not any((other == step).all() for step in steps for other in Robot(1).others(plan[:1]))


@pytest.mark.parametrize(
    ("plan", "said"), [(lambda: None, "plan is None"), (3.0, "float"), ([(1.0, 0.0)], "Command 1")]
)
def test_what_is_no_plan_is_said_once_and_tried_on_no_more_robots_than_two(plan, said):
    came = run(CHALLENGE, plan)
    (problem,) = came.problems()
    assert said in problem and "stopped after" in came.stopped.lower() and not came.complete


def test_the_figure_counts_robots_at_each_gate(tmp_path):
    first = np.arctan2(GATES[0].y, GATES[0].x)
    report = Board(CHALLENGE, tmp_path).enter([Motion(0.0, float(first)), Motion(0.9, 0.0)])
    drawing = report.figure
    counts = np.sum([each.kept[2] for each in report.run.results], axis=0)
    assert f"gate 1: {counts[0]}" in drawing.alt and counts[0] >= 15 and report.score == counts.sum() / 20
    field, bars = drawing.figure.axes
    assert [bar.get_width() for bar in bars.patches] == counts.tolist()
    assert "gates, mean of 20 robots" in field.get_title(loc="left")
    for empty in ([], None):
        came = run(CHALLENGE, lambda plan=empty: plan)
        assert "gate 8: 0" in CHALLENGE.figure(came).alt


CENTRES = np.array([(gate.x, gate.y) for gate in GATES])
BEST_ORDER = (3, 4, 5, 6, 7, 8, 1, 2)


def through_centres(order):
    """A plan through the centres of the gates, and 0.4 m beyond the last of them."""
    points = CENTRES[np.array(order) - 1]
    beyond = points[-1] + 0.4 * (points[-1] - points[-2]) / np.hypot(*(points[-1] - points[-2]))
    return plan_through([*points, beyond])


def mean_score(plan, robots, seed):
    """The score with many robots, as `passed` counts it, but for all of them at once."""

    def cross(a, b):
        return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]

    paths = repeat_drive(plan, robots, np.random.default_rng(seed))[..., None, :2]
    right, left = np.array([gate.poles for gate in GATES]).transpose(1, 0, 2)
    step, behind = np.diff(paths, axis=1), cross(left - right, paths - right) < 0
    between = cross(step, right - paths[:, :-1]) * cross(step, left - paths[:, :-1]) <= 0
    return ((behind[:, :-1] != behind[:, 1:]) & between).any(axis=1).sum() / robots


def test_the_scores_of_orders_that_lesson_00_states():
    """The best order through the centres, and a better one through other points, which the board shows."""
    better = SLALOM_ENTRIES["a better order"]
    plans = through_centres(BEST_ORDER), through_centres(range(1, 9)), better
    assert [mean_score(plan, 4000, 99) for plan in plans] == pytest.approx([5.07, 4.7, 5.36], abs=0.04)
    paths = repeat_drive(better, 20, np.random.default_rng(3))
    assert mean_score(better, 20, 3) == np.mean([passed(path[:, :2]).sum() for path in paths])
    planned = without_errors(better)[:, :2]
    assert passed(planned).tolist() == [*[True] * 7, False]
    (x, y), (dx, dy) = planned[-2], planned[-1] - planned[-2]
    assert GATES[7].poles[0, 1] - (y + (GATES[7].x - x) / dx * dy) == pytest.approx(0.02, abs=0.005)


def test_what_lesson_00_says_of_its_plan_and_of_the_reference():
    """Whoever misses gate 2 passes beside it; with the reference, a robot may pass it on its way to gate 3."""
    plan = [Motion(0.0, np.radians(26.6)), Motion(0.67, np.radians(-67.2)), Motion(1.3, 0.0)]
    ends = np.array([robot.drive(plan)[-2:, :2] for robot in CHALLENGE.seeds])
    off = np.hypot(*(ends[:, 1] - without_errors(plan)[-1, :2]).T)
    assert off.mean() == pytest.approx(0.18, abs=0.005)
    through = [passed(end)[1] for end in ends]
    assert sum(through) == 18 and (ends[:, 1, 0] > GATES[1].x).all()
    paths = [robot.drive(SLALOM_ENTRIES["the reference"])[:, :2] for robot in CHALLENGE.seeds]
    assert np.sum([passed(path) for path in paths], axis=0)[[0, 1, 2, 7]].tolist() == [20, 20, 13, 3]
    assert sum(not passed(path[:4])[1] for path in paths) >= 10  # not before the turn in gate 2


@pytest.mark.slow
def test_no_order_through_the_centres_is_better_than_the_one_that_lesson_00_names():
    """All orders with forty robots each, and the sixty best of them with 4000."""
    orders = list(permutations(range(1, 9)))
    few = [mean_score(through_centres(order), 40, number) for number, order in enumerate(orders)]
    best = sorted(zip(few, orders, strict=True), reverse=True)[:60]
    assert max((mean_score(through_centres(order), 4000, 99), order) for _, order in best)[1] == BEST_ORDER
