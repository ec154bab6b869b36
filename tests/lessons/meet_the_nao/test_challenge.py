"""The challenge of lesson 00: gates, robots that drive blind, and where they are lost."""

from __future__ import annotations

import numpy as np
import pytest

from nao_course.challenges import Board
from nao_course.challenges.running import run
from nao_course.lessons.meet_the_nao.challenge import CHALLENGE, MOST_COMMANDS, Robot, without_errors
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
    for shift in (0.26, -0.26):
        assert not passed(through(gate, shift=shift))[number]
    assert not passed(through(gate)[:1])[number] and not passed(through(gate) + [9.0, 0.0])[number]


def test_a_path_that_turns_on_the_line_of_a_gate_passes_it_once():
    gate = GATES[0]
    path = [(0.0, 0.0), (gate.x, gate.y), (gate.x + 0.5, gate.y + 0.1)]
    assert passed(path).tolist() == [True, *[False] * 7]
    assert not passed([(0.0, 0.0), (gate.x - 0.01, gate.y), (0.0, 0.2)]).any()


def test_gates_stand_on_the_half_field_apart_from_each_other():
    poles = np.vstack([gate.poles for gate in GATES])
    assert (np.abs(poles - [1.5, 0.0]) < [1.5, 2.0]).all()
    apart = np.hypot(*(poles[:, None] - poles[None]).transpose(2, 0, 1)) + 9 * np.eye(len(poles))
    assert apart.min() > 0.25 and Gate(0.0, 0.0, 0.0).poles[1].tolist() == [0.0, WIDTH / 2]


def test_without_errors_a_robot_goes_where_it_is_told():
    plan = [Motion(0.5, 0.7), Motion(-0.2, -1.0), Motion(1.0, 3.0)]
    exact = repeat_drive(plan, 1, np.random.default_rng(0), OdometryNoise(0, 0, 0, 0))[0]
    assert without_errors(plan) == pytest.approx(exact)


def test_a_robot_slips_in_the_same_way_each_time_and_no_two_alike():
    plan = [Motion(1.0, 0.5), Motion(1.0, 0.0)]
    paths = [robot.drive(plan) for robot in CHALLENGE.seeds]
    assert (CHALLENGE.seeds[0].drive(plan) == paths[0]).all()
    assert len({path[-1].tobytes() for path in paths}) == len(paths)
    steps = [robot.drive(plan[:1]) for robot in CHALLENGE.seeds]
    assert not any((other == step).all() for step in steps for other in Robot(1).others(plan[:1]))


@pytest.mark.parametrize(
    ("plan", "said"),
    [
        (lambda: None, "plan is None"),
        (Motion(1.0, 0.0), "got Motion"),
        ("forward", "got str"),
        (3.0, "got float"),
        ([(1.0, 0.0)], "Command 1 of your plan is of type"),
        ([Motion(1.0, 0.0), None], "Command 2 of your plan is of type"),
        ([Motion(0.1, 0.0)] * (MOST_COMMANDS + 1), "at most 200 commands"),
    ],
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
