"""Which mistake a wrong answer is taken for, also where a mistake's own answers are rounding errors."""

import numpy as np
import pytest

from nao_course.exercises import Case, Close
from nao_course.exercises.exercise import PublicExercise, PublicMistake
from nao_course.exercises.judging import explain
from nao_course.exercises.running import Outcome

ANY = {"unstable": np.array([1e16, -3e15])}
TABLE = {
    "exact": {"0": 1.0, "1": 2.0},
    "unstable": {"0": 1.0, "1": ANY},
    "unstable in both": {"0": ANY, "1": ANY},
    "unstable in one": {"0": ANY},
    "another formula": {"0": {"unstable": 4.0}},
    "raises, or not": {"1": {"unstable": {"raises": "LinAlgError"}}},
}


def exercise_with(mistakes, cases):
    cases = [Case((), expected=0.0)] * cases
    return PublicExercise("solve", "1.1", 1.0, 1, Close(), cases, mistakes, [], "")


def told(*answers, mistakes=tuple(TABLE)):
    """The message for these answers to two cases whose right answers are 0."""
    exercise = exercise_with([PublicMistake(each, TABLE[each]) for each in mistakes], 2)
    outcomes = [each if isinstance(each, Outcome) else Outcome("value", each) for each in answers]
    return set(explain(exercise, outcomes, "").lines) & set(TABLE)


RAISED = Outcome("raised", text="LinAlgError: Singular matrix")


def test_any_wrong_outcome_matches_an_unstable_case_and_stable_cases_have_to_match():
    for other in [5.0, np.array([2e12, 1.0]), np.nan, None, RAISED]:
        assert told(1.0, other) == {"unstable"}
        assert told(other, 0.0) == {"unstable in one"}
        assert told(0.0, other) == {"raises, or not"}
    assert told(1.0, 0.0, mistakes=["unstable", "unstable in both", "raises, or not"]) == set()
    assert told(7.0, 5.0, mistakes=["exact", "unstable"]) == set()
    assert told(7.0, 5.0) == {"unstable in both"}


def test_the_mistake_with_the_most_answers_that_are_the_same_is_told():
    """The author's own processor tells mistakes apart that others cannot."""
    for order in [1, -1]:
        mistakes = list(TABLE)[::order]
        assert told(1.0, 2.0, mistakes=mistakes) == {"exact"}
        assert told(1.0, 3.0, mistakes=mistakes) == {"unstable"}
        assert told(1.1, 2.0, mistakes=mistakes) == {"unstable in both"}
        assert told(4.0, 0.0, mistakes=mistakes) == {"another formula"}, "an unstable answer that is the same"
        assert told(5.0, 0.0) == {"unstable in one"}


@pytest.mark.parametrize("driver", ["methods", ""])
def test_a_mistake_in_a_method_is_recognised_before_the_other_methods_are_right(driver):
    cases = [Case((), each, expected=0.0) for each in ("move: one", "move: two", "turn: one")]
    mistakes = [PublicMistake("late", {"0": 1.0, "2": 5.0}), PublicMistake("both", {"0": 1.0, "1": 2.0})]
    exercise = PublicExercise("Walker", "1.1", 1.0, 1, Close(), cases, mistakes, [], driver)
    for answers, message in (((1.0, 0.0, 7.0), "late"), ((1.0, 2.0, 7.0), "both")):
        lines = explain(exercise, [Outcome("value", each) for each in answers], "").lines
        assert (message in lines) == (driver == "methods"), lines
    lines = explain(exercise, [Outcome("value", each) for each in (0.0, 2.0, 7.0)], "").lines
    assert not {"late", "both"} & set(lines)


def test_no_mistake_is_told_by_what_is_not_written_or_of_a_method_that_is_right():
    """A mistake may leave other methods unwritten, because only the cases of its own method recognise it."""
    unwritten = {"raises": "NotImplementedError"}
    cases = [Case((), each, expected=0.0) for each in ("move: one", "turn: one", "turn: two")]
    mistakes = [PublicMistake("move", {"0": 1.0, "1": unwritten, "2": unwritten})]
    mistakes += [PublicMistake("both", {"0": 1.0, "1": 2.0})]
    exercise = PublicExercise("Walker", "1.1", 1.0, 1, Close(), cases, mistakes, [], "methods")
    blank = Outcome("raised", text="NotImplementedError: Walker.turn is not written yet")
    for answers, named in (
        ((0.0, blank, blank), set()),
        ((1.0, blank, blank), {"move"}),
        ((1.0, 0.0, 0.0), {"move"}),
        ((1.0, 7.0, 0.0), {"move"}),
        ((0.0, 2.0, 0.0), set()),
    ):
        outcomes = [each if isinstance(each, Outcome) else Outcome("value", each) for each in answers]
        lines = explain(exercise, outcomes, "").lines
        assert {"move", "both"} & set(lines) == named, answers


def test_only_a_process_that_ended_is_said_to_end_python():
    for reason, ends in (
        ("it called base too often", ""),
        ("its answer could not be read", ""),
        ("the process ended itself with status 3", "it ends Python itself; "),
    ):
        lines = explain(exercise_with([], 1), [Outcome("died", text=reason)], "").lines
        assert lines == (f"1.1 solve: {ends}{reason}.",)
