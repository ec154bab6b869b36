"""Two known mistakes made together are diagnosed as both; a single mistake keeps its own message."""

import itertools

import numpy as np
import pytest

from nao_course.codec import decode, encode
from nao_course.exercises import Case, Definitions, Exercise, LessonPlan
from nao_course.exercises.checking import grade_public
from nao_course.exercises.definitions import NotebookText
from nao_course.exercises.earlier import resolved_by
from nao_course.exercises.judging.report import TWO_ERRORS
from nao_course.instructor.authoring import plans
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.mistakes import catalogue, with_functions
from nao_course.instructor.authoring.plans import load_solution, publish, publish_exercise, solution_notebook
from tests.paths import PROJECT, SOLUTIONS

COURSE = load_course(PROJECT)
SOURCE = '''
def line(x, gain, offset):
    """Return gain x + offset, wrapped to a turn."""
    ### BEGIN SOLUTION
    scaled = gain * x
    return np.mod(scaled + offset, 360.0)
    ### END SOLUTION
'''
MISTAKES = """
    gain forgotten: scaled = gain * x => scaled = x
        The gain is missing.
    offset subtracted: scaled + offset => scaled - offset
        The offset is subtracted.
    not wrapped: np.mod(scaled + offset, 360.0) => scaled + offset
        The angle is not wrapped.
    gain squared: scaled = gain * x => scaled = gain**2 * x
        The gain is squared.
    nothing done: + return x
        The function returns its input.
"""
GAIN, OFFSET, WRAP, SQUARE, NOTHING = (line.strip() for line in MISTAKES.splitlines()[2::2])
X = np.array([-35.0, 12.5, 99.0, 300.0])


def declared(small=X[1:3]) -> Exercise:
    return Exercise(
        "line",
        1,
        public=lambda: [Case((X, 1.0, 0.0)), Case((X, 3.0, 7.5)), Case((small, 3.0, 7.5))],
        hidden=lambda rng: [Case((rng.uniform(-400, 400, 5), 2.0, 5.0))],
        hints=("Multiply.", "Add."),
        mistakes=catalogue(MISTAKES),
        alternatives={},
    )


def solution() -> Definitions:
    space = {"np": np, "__name__": "solution"}
    exec(SOURCE, space)
    return Definitions({"line": space["line"]}, namespace=space, text=NotebookText([("solution", SOURCE)]))


@pytest.fixture(scope="module")
def public():
    (exercise,) = publish("90_toy", LessonPlan([declared()]), solution()).exercises
    return exercise


def said(public, function):
    """The messages that a check shows, and whether it says that there are two errors."""
    lines = grade_public(public, function).lines
    known = {mistake.message for mistake in public.mistakes}
    return [line for line in lines if line in known or line == TWO_ERRORS]


def test_two_mistakes_together_are_diagnosed_as_both_and_a_single_one_keeps_its_message(public):
    assert said(public, lambda x, gain, offset: np.mod(x - offset, 360.0)) == [TWO_ERRORS, GAIN, OFFSET]
    assert said(public, lambda x, gain, offset: gain**2 * x + offset) == [TWO_ERRORS, WRAP, SQUARE]
    assert said(public, lambda x, gain, offset: np.mod(x + offset, 360.0)) == [GAIN]
    assert said(public, lambda x, gain, offset: x) == [NOTHING]
    # The other cases must be right or wrong as with the pair, too.

    def both_but_right_without_offset(x, gain, offset):
        return np.mod((gain if len(x) == 2 else 1.0) * x + (offset if len(x) == 2 else -offset), 360.0)

    assert grade_public(public, lambda x, gain, offset: (offset + gain * x) % 360)
    for wrong in (
        lambda x, gain, offset: np.mod(gain * x + offset, 180.0),
        lambda x, gain, offset: np.mod(x - offset, 360.0) + 1e-2,
        lambda x, gain, offset: [][0],
        both_but_right_without_offset,
    ):
        assert said(public, wrong) == []


def test_a_pair_that_fits_only_the_small_case_is_not_named():
    (public,) = publish("90_toy", LessonPlan([declared(X[1:])]), solution()).exercises
    assert said(public, lambda x, gain, offset: np.mod(x - offset, 360.0)) == [TWO_ERRORS, GAIN, OFFSET]
    assert said(public, lambda x, gain, offset: np.mod(x - (len(x) - 2) ** (gain - 1) * offset, 360.0)) == []


def test_changes_of_the_same_place_are_no_pair_and_a_pair_stores_a_small_answer_and_no_code(public):
    """A gain cannot be missing and squared; what returns its input at once hides every other mistake."""
    pairs = [set(pair.mistakes) for pair in public.pairs]
    assert {0, 3} not in pairs
    assert not any(4 in pair for pair in pairs)
    assert sorted(map(sorted, pairs)) == [[0, 1], [0, 2], [1, 3], [2, 3]]
    for pair in public.pairs:
        assert set(pair.answers) <= set(map(str, pair.wrong))
        assert len(encode(pair)) < 1000
        assert all(not callable(answer) for answer in pair.answers.values())
    assert decode(encode(public), trusted=True).pairs[0].mistakes == (0, 1)
    assert encode(public) == encode(publish("90_toy", LessonPlan([declared()]), solution()).exercises[0])


def with_one_more(mistake):
    text = f"{MISTAKES}    {mistake}\n        Another one.\n"
    plan = LessonPlan([Exercise(**{**vars(declared()), "mistakes": catalogue(text)})])
    (exercise,) = publish("90_toy", plan, solution()).exercises
    return exercise


def test_two_pairs_with_the_same_answers_or_one_that_is_right_by_rounding_alone_are_left_out():
    exercise = with_one_more("gain is one: scaled = gain * x => scaled = 1.0 * x")
    assert not any({0, 5} & set(pair.mistakes) for pair in exercise.pairs)
    assert said(exercise, lambda x, gain, offset: np.mod(x - offset, 360.0)) == []
    exercise = with_one_more("exact: scaled = gain * x => scaled = gain * x + 99.0 * (gain != 3.0)")
    assert {2, 5} not in [set(pair.mistakes) for pair in exercise.pairs]


def test_two_mistakes_that_never_end_together_are_left_out(monkeypatch):
    monkeypatch.setattr("nao_course.instructor.authoring.plans.PAIR_SECONDS", 0.05)
    source = SOURCE.replace(
        "scaled = gain * x",
        "step = turns = 1\n    while turns < 3:\n        turns += step\n    scaled = gain * x",
    )
    text = MISTAKES + "    no step: step = turns = 1 => step, turns = 0, 3\n        There is no step.\n"
    text += "    from 0: while turns < 3 => while turns < 3 or offset and not step\n        It begins at 0.\n"
    space = {"np": np, "__name__": "solution"}
    exec(source, space)
    right = Definitions({"line": space["line"]}, namespace=space, text=NotebookText([("solution", source)]))
    plan = with_functions(LessonPlan([Exercise(**{**vars(declared()), "mistakes": catalogue(text)})]), right)
    public = publish_exercise("1.1", plan.exercises[0], right["line"])
    assert {5, 6} <= set(itertools.chain(*((i, j) for i, j, _ in plan.exercises[0].pairs())))
    assert not any(set(pair.mistakes) == {5, 6} for pair in public.pairs)


REAL = {"04": ["pixel_to_ground"], "06": ["covariance_ellipse"], "07": ["predict"]}
LONG = {"04", "07"}


@pytest.mark.parametrize(
    "lesson", [pytest.param(each, marks=[pytest.mark.slow] if each in LONG else []) for each in REAL]
)
def test_many_pairs_of_a_lesson_are_recognised_and_nothing_right_is(lesson):
    """The stored answers are those that the pair gives; every right alternative and single mistake stays what it is."""
    notebook = solution_notebook(lesson, SOLUTIONS)
    reference = load_solution(notebook)
    with resolved_by(plans.solutions_beside(notebook)):
        plan = with_functions(COURSE.plan(notebook.stem), reference)
        for name in REAL[lesson]:
            exercise = plan[name]
            public = publish_exercise("1.1", exercise, reference[name])
            kept = {pair.mistakes for pair in public.pairs}
            pairs = {(i, j): function for i, j, function in exercise.pairs()}
            assert len(kept) > 0.35 * len(pairs)
            messages = [mistake.message for mistake in public.mistakes]
            for i, j in sorted(kept)[::12]:
                assert said(public, pairs[i, j]) == [TWO_ERRORS, messages[i], messages[j]]
            for mistake in exercise.mistakes:
                assert said(public, mistake.function) == [mistake.message]
            for alternative in (reference[name], *exercise.alternatives.values()):
                assert grade_public(public, alternative), name
                assert said(public, alternative) == []
