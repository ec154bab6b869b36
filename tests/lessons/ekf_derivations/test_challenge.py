"""The challenge of lesson 05: what is asked is counted, what is named is scored, and all mistakes can be told apart."""

import copy
import re
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from benchmarks.challenges.jacobians import JACOBIAN_ENTRIES, LANDMARK, POSE, told
from nao_course.challenges.running import run
from nao_course.lessons.ekf_derivations.challenge import CHALLENGE, MOST_CALLS, WRONG, WrongJacobian, judge
from nao_course.lessons.ekf_derivations.mistakes import MISTAKES, jacobian_at, with_mistake
from tests.lessons.every import text

AT = (0.3, -0.2, 0.7), (2.1, 1.0)


def test_the_right_matrix_is_the_solutions_and_no_two_mistakes_look_alike_or_right(solution):
    names = ("measurement_jacobian_pose", "measurement_jacobian_landmark")
    assert np.allclose(jacobian_at(*AT), np.hstack([solution[name](*AT) for name in names]), atol=1e-8)
    matrices = [jacobian_at(*AT), *(with_mistake(name, *AT) for name in MISTAKES)]
    assert len({(np.round(each, 3) + 0.0).tobytes() for each in matrices}) == len(MISTAKES) + 1
    dx, dy = 1.8, 1.2  # change places, and the signs stay
    bearing = with_mistake("bearing by x, y: dx and dy swapped", *AT)[0, :2]
    distance = with_mistake("range by l_x, l_y: dx and dy swapped", *AT)[1, 3:]
    assert np.allclose(bearing, np.array([dx, -dy]) / (dx**2 + dy**2))
    assert np.allclose(distance, np.array([dy, dx]) / np.hypot(dx, dy))
    listed = re.findall(r"^- `(.+)`$", text("05").split("<summary>The seventeen")[1], re.MULTILINE)
    assert listed == list(MISTAKES)


def test_no_plan_needs_fewer_calls_than_the_text_says():
    entries = {name: tuple(np.round(with_mistake(name, *AT), 4).ravel() + 0.0) for name in MISTAKES}

    @cache
    def calls(left):
        """In sum over all that are left, by the best plan."""
        if len(left) == 1:
            return 0
        splits = [{entries[name][number] for name in left} for number in range(10)]
        return len(left) + min(
            sum(calls(frozenset(name for name in left if entries[name][number] == told)) for told in split)
            for number, split in enumerate(splits)
            if len(split) > 1
        )

    assert calls(frozenset(MISTAKES)) == 45 and round(45 / len(MISTAKES), 1) == 2.6


def test_a_right_name_scores_less_one_for_each_call():
    case = WrongJacobian(WRONG[0])
    ask = case.ask()
    assert copy.deepcopy(ask)(0, 2, *AT) == pytest.approx(1.0)
    assert ask(1, 2, *AT) == pytest.approx(0.0, abs=1e-6)
    assert judge(WRONG[0], case).score == 18
    wrong = judge(WRONG[1], case)
    assert wrong.score == -2 and wrong.columns == {"named right": 0.0, "calls": 2.0}


def test_what_is_no_question_is_said_and_costs_nothing_and_all_calls_can_be_used_up():
    case = WrongJacobian(WRONG[0])
    ask = case.ask()
    for given, said in (
        ((2, 0, *AT), "rows are 0 and 1"),
        ((0, 5, *AT), "columns 0 to 4"),
        ((0, 0, AT[1], AT[1]), r"shapes \(2,\)"),
        ((0, 0, (1, 2, 0.5), (1, 2)), "at the robot's own position"),
    ):
        with pytest.raises(ValueError, match=said):
            ask(*given)
    assert case.asked.calls == 0
    for _ in range(MOST_CALLS):
        ask(0, 0, *AT)
    with pytest.raises(RuntimeError, match="used up"):
        ask(0, 0, *AT)


def mean_calls(entry):
    """Over the whole catalogue, each mistake as likely as any other."""
    calls = []
    for name in MISTAKES:
        asked = []

        def ask(row, column, *at, name=name, asked=asked):
            asked.append((row, column))
            return told(name, (row, column))

        assert entry(ask) == name
        calls.append(len(asked))
    return np.mean(calls)


def test_the_lessons_numbers_of_calls_are_those_of_the_entries():
    entries = [JACOBIAN_ENTRIES[name] for name in ("brute force", "the reference", "a better plan")]
    assert [round(float(mean_calls(each)), 1) for each in entries] == [10.0, 4.4, 2.6]
    runs = [run(CHALLENGE, each) for each in entries]
    assert [round(each.columns["calls"], 1) for each in runs] == [10.0, 3.6, 2.4]
    assert all(before.score < after.score for before, after in pairwise(runs))
    assert "number 1: 5 calls, plus 1 for -1" in CHALLENGE.figure(runs[-1]).alt
    assert (POSE, LANDMARK) == AT
