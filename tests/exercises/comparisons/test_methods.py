"""A class is judged by what its methods return in turn, and the message says which of them and in which call."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.codec import register
from nao_course.exercises import Case, Exercise, LessonPlan, Mistake, calls, over_log
from nao_course.exercises.checking import grade_public, pack, unpack
from nao_course.exercises.comparisons import Close, Exact, Methods, Property, first_items
from nao_course.exercises.running import call
from nao_course.instructor.authoring.plan_checks import check_plan
from nao_course.instructor.authoring.plans import publish
from nao_course.slam import SlamAlgorithm


class Filter:
    """The reference: a mean that follows what is measured."""

    def __init__(self, start, gain):
        self.mean, self.gain = np.array([start]), gain

    def move(self, by):
        self.mean += by

    def observe(self, value):
        self.mean += self.gain * (value - self.mean)
        return 2

    def estimate(self):
        return self.mean  # the array itself, which later calls change


CASES = [
    calls("estimate", ("move", 1.0), "estimate", ("observe", 3.0), "estimate", given=(0.0, 0.5), name="once"),
    calls(("move", 1.0), ("move", 2.0), "estimate", given=(1.0, 0.5), name="twice"),
]


class NoGain(Filter):
    def observe(self, value):
        self.mean[:] = value
        return 2


class Plain(Filter):
    def __init__(self, start, gain):
        self.mean, self.gain = start, gain

    def observe(self, value):
        self.mean = (1 - self.gain) * self.mean + self.gain * value
        return 2

    def estimate(self):
        return (self.mean,)


def changed(name, **methods):
    """Return a filter with other methods."""
    return type(name, (Filter,), methods)


EXERCISE = Exercise(
    "Filter",
    1,
    lambda: CASES,
    lambda rng: [
        calls(("move", float(rng.normal())), ("observe", 2.0), "estimate", given=(0.0, 0.3)) for _ in range(2)
    ],
    ("a", "b"),
    [
        Mistake("no gain", NoGain, "Weigh what you see."),
        Mistake("forgets", changed("Forgets", move=lambda self, by: None), "A motion moves the mean."),
    ],
    {"numbers": Plain, "inherited": changed("Mine"), "again": Filter},
    comparison=Methods({"observe": Exact()}, Close()),
    driver="methods",
)


@pytest.fixture(scope="module")
def public():
    (exercise,) = unpack(pack(publish("02_filters", LessonPlan([EXERCISE]), {"Filter": Filter}))).exercises
    return exercise


def said(public, made_by):
    report = grade_public(public, made_by)
    return report.state, report.lines[0]


def test_a_plan_with_a_class_passes_all_that_a_plan_is_checked_for():
    check_plan("02_filters", LessonPlan([EXERCISE]), {"Filter": Filter})

    class Greedy:
        def take(self, values):
            values.append(1)

    assert call(Greedy, calls(("take", [2])), "methods").changed
    assert not call(Greedy, Case(((), [])), "methods").changed


def test_each_call_is_compared_as_it_was_when_it_was_made_and_what_returns_nothing_returns_no_value(public):
    names = [name for name, _ in public.cases[0].expected]
    assert names == ["estimate", "move", "estimate", "observe", "estimate"]
    assert [float(value[0]) for name, value in public.cases[0].expected if name == "estimate"] == [0, 1, 2]
    assert grade_public(public, Filter) and grade_public(public, Plain)
    state, line = said(public, NoGain)
    assert state == "wrong" and "(once): estimate, call 3: 1 of 1 element of your answer is wrong" in line
    assert "Weigh what you see." in grade_public(public, NoGain).lines
    chatty = said(public, changed("Chatty", move=lambda self, by: 7))[1]
    assert "move, call 1: your answer is an int; this method returns nothing" in chatty
    state, line = said(public, changed("Chained", move=lambda self, by: self))
    assert state == "wrong" and "move, call 1: a value of type Chained cannot be sent; return numbers" in line


def blank(self, *_):
    raise NotImplementedError


def test_what_is_blank_is_told_by_its_name(public):
    class Blank:
        def __init__(self, start, gain):
            self.start = start

        move = blank

        def estimate(self):
            """Say where it is."""
            self.scale = 2.0  # a line that the lesson gives
            raise NotImplementedError

    assert said(public, Blank) == ("not attempted", "2.1 Filter: not written yet.")

    class Half(Filter):
        def observe(self, value):
            raise NotImplementedError

    state, line = said(public, Half)
    assert state == "raised" and "Half.observe is not written yet (once)" in line and "raises" not in line

    def helper(self):
        raise NotImplementedError

    calls_it = changed("Helper", observe=lambda self, value: self.helper(), helper=helper)
    assert "helper is not written yet" in said(public, calls_it)[1]


def test_a_missing_method_a_constructor_that_raises_and_a_call_that_raises_say_so(public):
    lacking = type("Lacking", (), {"__init__": lambda self, *_: None, "estimate": lambda self: 0.0})
    assert "Lacking has no method move" in said(public, lacking)[1]
    raises = changed("Raises", __init__=lambda self, start, gain: start / 0)
    assert "raises ZeroDivisionError: float division by zero in making one (once)" in said(public, raises)[1]
    later = changed("Later", estimate=lambda self: float(self.mean[0]) if self.mean[0] != 2 else 1 / 0)
    assert "in estimate, call 3 (once)" in said(public, later)[1]
    few = type("Few", (), {"__init__": lambda self: None})
    assert said(public, few)[0] == "raised" and "in making one" in said(public, few)[1]
    assert "pass the class itself, without brackets" in said(public, Filter(0.0, 1.0))[1]


def test_a_log_becomes_calls_and_the_first_items_of_a_generator_an_answer():
    case = over_log([(None, [1.0]), (2.0, [])], given=(0.0,), name="still, then on", every=2)
    log = [("observe", ([1.0],)), ("move", (2.0,)), ("observe", ([],)), ("estimate", ())]
    assert case.args == ((0.0,), log)
    assert case.name == "still, then on"

    def count_by(step):
        value = [0]
        while True:
            value[0] += step
            yield value

    assert call(count_by, first_items(3, 2), "items").value == [[2], [4], [6]]
    assert call(lambda: iter([1]), first_items(3), "items").value == [1]
    assert call(lambda: None, first_items(3), "items").value is None
    assert "item 1: a value of type object" in call(lambda: [object()], first_items(1), "items").text


def test_a_method_is_compared_by_its_own_comparison_and_answers_belong_to_their_calls(public):
    whole = replace(EXERCISE.comparison, by={"observe": Exact()})
    wrong = [(name, 2.0 if name == "observe" else value) for name, value in public.cases[0].expected]
    text = whole.compare(public.cases[0].expected, wrong).text
    assert text.startswith("observe, call 1: your answer holds")
    assert Methods().compare(public.cases[0].expected, wrong)
    case = replace(calls(("echo", 1.0), ("echo", 2.0)), expected=[("echo", 1.0), ("echo", 2.0)])
    lawful = Methods({"echo": Property(answers_its_argument)})
    assert lawful.judge(case, case.expected)
    assert lawful.judge(case, [("echo", 1.0), ("echo", 1.0)]).text.startswith("echo, call 2: ")
    for got in [None, [], [("move", None)], [1, 2, 3, 4, 5], [("a", 1)] * 5, [["estimate", 1]] * 5]:
        case = public.cases[0]
        assert not public.comparison.compare(case.expected, got)
        assert not public.comparison.alike(case.expected, got)
    expected = [("move", None), ("estimate", 1.0)]
    assert Methods().compare(expected, expected) and Methods().alike(expected, expected)
    for other in ([("estimate", None), ("move", 1.0)], [("move", 7), ("estimate", 1.0)]):
        assert not Methods().compare(expected, other) and not Methods().alike(expected, other)


@register
def answers_its_argument(args, kwargs, answer):
    return "" if answer == args[0] else "it is not what went in"


PARTS = [
    calls((".mean", np.array([2.0])), ("move", 1.0), ".mean", given=(0.0, 0.5), name="move: forwards"),
    calls((".mean", np.array([2.0])), ("observe", 4.0), ".mean", given=(0.0, 0.5), name="observe: halfway"),
]


def parts_of(made_by):
    exercise = replace(EXERCISE, public=lambda: PARTS, mistakes=[], alternatives={})
    (public,) = publish("02_filters", LessonPlan([exercise]), {"Filter": Filter}).exercises
    return grade_public(public, made_by)


def test_an_attribute_is_assigned_and_read_so_that_a_method_is_tested_alone():
    assert parts_of(Filter)
    report = parts_of(NoGain)
    assert "1 of 2 public checks pass" in report.lines[0] and "(observe: halfway): mean: " in report.lines[0]
    assert report.lines[-1] == "These parts are right: move."
    case = calls(".heading")
    verdict = Methods().judge(replace(case, expected=[(".heading", None)]), [(".heading", 1.0)])
    assert not verdict and "heading should be None here" in verdict.text
    mine = type("Mine", (SlamAlgorithm,), {"move": lambda *_: None, "observe": lambda *_: None})
    assert call(mine, over_log([(None, [])]), "methods").text == "AttributeError: Mine has no method estimate"
    outcome = call(Filter, calls(".variance", given=(0.0, 0.5)), "methods")
    assert outcome.status == "raised" and "Filter has no attribute variance" in outcome.text
