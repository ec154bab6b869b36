"""What a student reads below a cell: each state told apart, each mistake its own message, never an answer."""

import os
import re
import signal
import subprocess
import sys
import threading
import warnings
from copy import copy
from dataclasses import replace
from functools import partial
from unittest import mock

import numpy as np
import pytest
import sympy

from nao_course.codec import encode
from nao_course.exercises import Between, Case, CheckFailed, Checks, Close, Exact, Points, checking, running
from nao_course.exercises.checking import grade_public
from nao_course.exercises.comparisons import Property
from nao_course.exercises.definitions import load_definitions
from nao_course.exercises.exercise import PublicExercise
from nao_course.instructor.authoring.plans import load_plan, publish, publish_exercise
from tests.toy import toy


@pytest.fixture(scope="module")
def plan():
    return load_plan(toy.HERE / "exercises" / "90_toy.py")


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    return load_definitions(toy.solutions(tmp_path_factory.mktemp("s") / "s") / "90_toy.ipynb")


@pytest.fixture(scope="module")
def public(plan, right):
    return checking.unpack(checking.pack(publish("90_toy", plan, right)))


@pytest.fixture
def check(public, monkeypatch):
    monkeypatch.delenv("NAO_COURSE_STRICT", raising=False)
    monkeypatch.delenv("NBGRADER_EXECUTION", raising=False)
    return Checks(public)


def unwritten(x, low, high):
    raise NotImplementedError


def unwritten_in_parts(x, low, high):
    if x > high:
        return high
    raise NotImplementedError("the other side")


def interrupted(x, low, high):
    raise KeyboardInterrupt


def test_each_state_is_told_apart_and_an_object_that_equals_everything_is_wrong(check):
    for function, state, text in [
        (lambda x, low, high: np.clip(x, low, high), "right", "all 3 public checks pass"),
        (unwritten, "not attempted", "90.1 clamp: not written yet."),
        (unwritten_in_parts, "raised", "your function raises NotImplementedError: the other side"),
        (lambda x, low, high: {}[x], "raised", "KeyError: 3.0 (above)"),
        (lambda x, low, high: sys.exit(), "raised", "SystemExit"),
        (lambda *_: None, "wrong", "Nothing came back (above): your answer is None: a return may be missing"),
        (lambda x, low, high: np.array([x]), "wrong", "Wrong shape (above): your answer has shape (1,)"),
        (lambda *_: "3", "wrong", "Wrong kind of answer (above): your answer is a str, not numbers"),
        (lambda x, low, high: np.nan, "wrong", "Not a number (above)"),
        (lambda x, *_: x, "wrong", "1 of 3 public checks pass. Wrong value (above): your answer is 3"),
        (lambda *_: print, "wrong", "Wrong kind of answer (above): a value of type builtin_function"),
        (interrupted, "interrupted", "stopped by you"),
        (3.0, "wrong", "expected a function, got a float"),
    ]:
        report = check("clamp", function)
        assert report.state == state
        assert text in repr(report)
        assert bool(report) == (state == "right")
        assert f'data-state="{state}"' in report._repr_html_()
    for lie in [EqualsAll(), np.array(7.0).view(Sub), [EqualsAll()]]:
        assert check("clamp", lambda x, low, high, lie=lie: lie).state == "wrong"


def test_a_mistakes_message_appears_for_exactly_that_mistake_in_every_kind_of_comparison(plan, check):
    for exercise in plan.exercises:
        messages = {mistake.message for mistake in exercise.mistakes}
        for mistake in exercise.mistakes:
            assert messages & set(check(exercise.name, mistake.function).lines) == {mistake.message}
        for alternative in exercise.alternatives.values():
            assert check(exercise.name, alternative)
    # One of its two wrong answers
    half_a_mistake = check("clamp", lambda x, low, high: x if x > low else -1.0)
    assert half_a_mistake.state == "wrong"
    assert not {each.message for each in plan["clamp"].mistakes} & set(half_a_mistake.lines)
    for comparison, answer, case in [
        (Between(), 7.0, Case((), expected=(0.0, 1.0))),
        (Points(), None, Case(())),
        (Exact(), "text", Case(())),
        (Exact(), {"a": 1}, Case(())),
    ]:
        reference = {"Between": 0.5, "Points": np.ones((2, 2)), "Exact": 3}[type(comparison).__name__]
        given, cases, right = (partial(copy, each) for each in (answer, [case], reference))
        mistake = replace(plan["clamp"].mistakes[0], function=given, message="that one")
        exercise = replace(plan["clamp"], public=cases, comparison=comparison, mistakes=[mistake])
        public = publish_exercise("1.1", exercise, right)
        assert "that one" in checking.grade_public(public, given).lines
        assert "that one" not in checking.grade_public(public, lambda: 99.0).lines


class EqualsAll:
    def __eq__(self, other):
        return True

    def __array__(self, dtype=None, copy=None):
        raise RuntimeError("looked at")

    def __float__(self):
        return 2.25

    __hash__ = None


class Sub(np.ndarray):
    def __eq__(self, other):
        return np.True_

    def __sub__(self, other):
        return 0.0

    __rsub__ = __sub__
    __hash__ = None


def test_no_expected_value_is_ever_shown_and_a_report_is_text(public, check):
    odd = [None, 1, "x", np.nan, [], (1.0,), np.zeros(4), {}, True, print, EqualsAll()]
    shown = [str(vars(check).keys()), *map(repr, (check, check.hint("clamp"), check.question("why", "2")))]
    for value in odd:
        report = check("clamp", lambda x, low, high, value=value: value)
        shown += [repr(report), report._repr_html_()]
    expected = {str(case.expected) for case in public.exercises[0].cases}
    assert not [text for text in shown for value in expected if value in text]

    def broken(x, low, high):
        raise ValueError("<script>alert(1)</script>")

    report = check("clamp", broken)
    assert "<script>" in repr(report)
    assert "<script>" not in report._repr_html_()
    assert "raise ValueError" in report.lines[1]


def test_each_call_gets_inputs_of_its_own_and_a_change_of_them_is_told(public, check):
    def spoils(values):
        mean = float(values[values > 0].mean()) if (values > 0).any() else 0.0
        values[:] = 99
        return mean

    before = [case.args[0].copy() for case in public.exercises[1].cases]
    for _ in range(2):
        report = check("mean_of_positive", spoils)
        assert report.state == "wrong"
        assert "changes its input" in report.lines[0]
    for case, values in zip(public.exercises[1].cases, before, strict=True):
        np.testing.assert_array_equal(case.args[0], values)


def test_an_answer_is_judged_as_it_was_and_drawing_changes_no_input(plan, check):
    buffer = np.zeros(())

    def reuses(x, low, high):
        buffer[()] = np.clip(x, low, high)
        return buffer

    assert check("clamp", reuses)

    def draws(rng):
        return float(rng.random())

    exercise = replace(plan["clamp"], public=lambda: [Case((np.random.default_rng(1),))], mistakes=[])
    assert checking.grade_public(publish_exercise("1.1", exercise, draws), draws)


@pytest.mark.parametrize("variable", ["NAO_COURSE_STRICT", "NBGRADER_EXECUTION"])
def test_strict_checks_raise_unless_they_are_right(check, monkeypatch, variable):
    monkeypatch.setenv(variable, "1")
    check("clamp", lambda x, low, high: sorted([low, x, high])[1])
    for function in (unwritten, lambda x, low, high: x, interrupted):
        with pytest.raises(CheckFailed, match=r"90\.1 clamp"):
            check("clamp", function)
    with pytest.raises(CheckFailed, match="no exercise"):
        check("nothing", unwritten)


def test_under_nbgrader_a_right_answer_writes_nothing_to_stderr_and_is_no_number(check, monkeypatch, capsys):
    """It takes a cell's value for points, and gives 0 for anything on stderr."""

    def clamp(x, low, high):
        print("here", file=sys.stderr)  # so do warnings
        return sorted([low, x, high])[1]

    assert check("clamp", clamp).state == "right"
    assert "here" in capsys.readouterr().err
    monkeypatch.setenv("NBGRADER_EXECUTION", "1")
    assert check("clamp", clamp) is None
    told = capsys.readouterr()
    assert told.err == "" and "here" in told.out and "90.1 clamp" in told.out


def test_unknown_names_are_answered_with_the_known_ones_and_hints_come_one_after_the_other(check):
    for answer in (check("clmap", unwritten), check.hint("clmap")):
        assert "['clamp', 'mean_of_positive']" in repr(answer)
    assert "['why']" in repr(check.question("how"))
    with pytest.raises(ValueError, match="no lesson '77_none'"):
        checking.lesson("77_none")
    check.hint("mean_of_positive")  # a notebook shows the last line's value only
    both = check.hint("mean_of_positive")._repr_html_()
    assert both.index("Hint 1 of 2: A mask selects.") < both.index("Hint 2 of 2") and "<pre" not in both
    again = repr(check.hint("mean_of_positive"))
    assert again.startswith("Hint 2 of 2") and "Hint 1" not in again
    assert "This is the last hint. If it is not enough, read the text above the exercise" in again
    first = repr(check.hint("clamp"))
    assert first.startswith("Hint 1") and "Call hint again" in first


def test_the_third_hint_is_a_solved_problem_with_its_code_and_what_it_prints(check):
    text = "Hint 3 of 3, a solved problem: A shift is at least 4 and at most 8 hours long. This is the last hint."
    code = 'for hours in (2, 9):\n    if hours < 4 or hours > 8:\n        print(hours, "is refused")'
    output = "# It prints:\n# 2 is refused\n# 9 is refused"
    for _ in range(2):
        assert code not in repr(check.hint("clamp"))
    for _ in range(2):  # it is repeated
        third = repr(check.hint("clamp"))
        assert third.startswith(text) and third.endswith(f"\n\n{code}\n\n{output}")
    html = check.hint("clamp")._repr_html_()
    assert html.count("<pre") == 2 and "hours &lt; 4 or" in html and f">{output}</pre>" in html


@pytest.mark.skipif(sys.platform == "win32", reason="an interrupt is a signal")
def test_an_endless_loop_can_be_interrupted_and_what_follows_works(check):
    def endless(x, low, high):
        while True:
            pass

    timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    assert check("clamp", endless).state == "interrupted"
    timer.join()
    assert check("clamp", lambda x, low, high: np.clip(x, low, high))


def of(*given, expected=0.0, comparison=None):
    """A public exercise of one case."""
    case = Case(given, expected=expected)
    return PublicExercise("f", "7.4", 1.0, 1, comparison or Close(), [case], [], [], "")


HEAVY = ["scipy", "sympy", "matplotlib", "cv2", "ipywidgets"]


def test_a_check_starts_without_what_it_does_not_need():
    code = f"import sys, nao_course.exercises; print([name for name in {HEAVY} if name in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no alarm clock")
def test_a_loop_that_never_ends_and_swallows_exceptions_is_stopped_and_the_clock_is_put_back():
    def endless(value):
        while True:
            try:
                value += 1
            except Exception:  # noqa: BLE001
                value = 0

    before = signal.getsignal(signal.SIGALRM)
    outcomes = running.call_all(endless, [Case((1,)), Case((2,))], seconds=0.2)
    assert [outcome.status for outcome in outcomes] == ["timed out"]
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0


def test_the_advice_on_an_error_stands_below_it_and_names_the_functions_own_arguments(check):
    def one_argument(x):
        return x

    one_argument.__qualname__ = one_argument.__name__ = "clamp"
    for slip, advice in (
        (lambda *_: 1 if np.zeros(2) > 1 else 2, "no single True or False"),
        (lambda x: x, "Keep the function's first line"),
        (one_argument, "Keep the function's first line"),
        (lambda x, low, high: lowest, "since the kernel started"),  # noqa: F821
        (
            lambda pose, control, high: theta,  # noqa: F821
            "theta is a part of pose. Take it from",
        ),
        (lambda pose, control, high: d, "d is a part of control"),  # noqa: F821
    ):
        assert advice in check("clamp", slip).lines[-1]
    calls_another = lambda x, low, high: np.clip(x)  # noqa: E731
    assert "Keep the function's first line" not in repr(check("clamp", calls_another))
    report = repr(check("clamp", lambda pose, control, high: theta))  # noqa: F821
    assert "the function's arguments are pose, control and high" in report
    for kind in (float, np.uint8):
        report = repr(grade_public(of(np.zeros((2, 3), kind)), lambda values: float(values[2, 0])))
        assert "the last of n is n - 1" in report
        assert ("In a picture, the row comes first." in report) is (kind is np.uint8)
    for comparison in (Close(), Property(lambda *_: "Some are odd.")):
        assert re.search(r"\w\.$", grade_public(of(1.0, comparison=comparison), abs).lines[0])


def test_a_function_that_calls_an_unwritten_one_is_not_called_unwritten(check):
    def helper():
        raise NotImplementedError

    def clamp(x, low, high):
        return helper()

    report = check("clamp", clamp)
    assert report.state == "raised" and "helper is not written yet" in report.lines[0]
    with mock.patch.dict(checking.FAILED_CELLS._why, clamp="SyntaxError, line 2: invalid syntax"):
        report = check("clamp", np.clip)
    assert report.state == "not checked" and not report
    assert report.lines[0] == "The cell that defines clamp did not run: SyntaxError, line 2: invalid syntax."


def test_a_wrong_element_is_shown_with_the_input_it_was_made_from_unless_it_belongs_to_none():
    pixels = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    wanted = pixels.max(axis=2).astype(float)

    def one_wrong(picture):
        answer = picture.max(axis=2).astype(float)
        answer[1, 2] = 99
        return answer

    last = grade_public(of(pixels, expected=wanted), one_wrong).lines[-1]
    assert last == "There the first argument is [18, 19, 20]."
    flat = grade_public(of(wanted, expected=wanted), lambda values: values + (values == 20))
    assert "There the first argument is 20." in flat.lines
    points = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    row = grade_public(of(points, expected=points + 0), lambda given: given + (given == 4))
    assert row.lines[-1] == "The same row of the first argument is [3, 4]."
    both = of(points, expected=(points + 1, points * 2))
    row = grade_public(both, lambda given: (given + 1, given * 2 + (given == 3)))
    assert row.lines[-1] == "The same row of the first argument is [3, 4]."
    for exercise, function in [
        (of(np.array([10.0, 20, 50, 20]), expected=np.array([53.0, 20])), lambda segment: segment[:2]),
        (of(3.0, expected=3.0), lambda x: 4.0),
        (of(np.zeros(3), np.ones(2), expected=np.zeros(3)), lambda pose, control: pose + 1),
        (of(POINTS, expected=(POINTS + 1, np.eye(2))), lambda given: (given + 1, 2 * np.eye(2))),
        (of(np.eye(2), expected=(np.array([2.0, 1.0]), 0.5)), lambda given: (np.array([1.0, 1.0]), 0.5)),
        (of(POINTS[:3], expected=np.eye(6)), lambda given: np.zeros((6, 6))),
    ]:
        report = grade_public(exercise, function)
        assert not report and len(report.lines) == 1


POINTS = np.arange(12.0).reshape(6, 2)


def test_a_check_waits_twice_as_long_as_the_grader_and_twenty_seconds_at_least(monkeypatch):
    waited = []

    def timed_out(function, cases, driver, seconds, answer):
        waited.append(seconds)
        return [running.Outcome("timed out")]

    monkeypatch.setattr(running, "call_all", timed_out)
    public = of(1.0, expected=1.0)
    for seconds, most in ((1.0, 20), (10.0, 20), (45.0, 90)):
        assert f"stopped after {most} seconds" in grade_public(replace(public, seconds=seconds), abs).lines[0]
    assert waited == [20, 20, 90]


def test_a_payoff_says_which_exercises_are_missing_or_wrong_and_shows_what_can_be_drawn(check):
    def blank(*given):
        raise NotImplementedError

    def draw(**own):
        return own["clamp"](5, 0, 3)

    assert check.payoff(draw, clamp=np.clip) == 3
    assert "your exercise 90.1, which is not written" in repr(check.payoff(draw, clamp=blank))
    both = repr(check.payoff(draw, mean_of_positive=blank, clamp=blank))
    assert "your exercises 90.1, 90.2, which are not written" in both
    begun = repr(check.payoff(lambda **own: own["mean_of_positive"](), clamp=max, mean_of_positive=blank))
    assert "your exercises 90.1, 90.2, which are not finished" in begun
    drawn = check.payoff(draw, clamp=lambda x, low, high: x)
    assert repr(drawn) == "This is drawn with your exercise 90.1, which does not pass the public checks.\n5"
    assert "does not pass" in drawn._repr_html_() and "<pre>5</pre>" in drawn._repr_html_()
    fails = repr(check.payoff(lambda clamp: 1 / clamp(5, 0, 3), clamp=lambda x, low, high: 0))
    assert "needs your exercise 90.1, which does not pass" in fails and "ZeroDivisionError" in fails
    assert "ZeroDivisionError" in repr(check.payoff(lambda clamp: 1 / 0, clamp=np.clip))


def test_a_right_function_that_numpy_warns_of_or_that_uses_a_demonstrations_values_is_told_so(public, check):
    check = Checks(replace(public, demonstrated=["mean", "theta", "x"]))
    here = {"theta": sympy.Symbol("theta"), "mine": 3, "mean": 4, "np": np}
    lines = ["def clamp(x, low, high):", "[theta for _ in 'a']", "(lambda: mine)()", "np.array(x).mean()"]
    exec("\n    ".join([*lines, "return np.clip(x, low, high)"]), here)
    report = check("clamp", here["clamp"])
    assert report and "demonstrations define: theta. The grader" in repr(report)
    assert "demonstrations" not in repr(check("clamp", np.clip))

    def warns(x, low, high):
        return np.where(np.float64(0) / np.float64(0) > 0, np.nan, np.clip(x, low, high))

    for _ in range(2):  # a second check says it again
        report = check("clamp", warns)
        assert report and repr(report).count("but NumPy warns about a step of your code: invalid value") == 1
    assert "NumPy warns" not in repr(check("clamp", np.clip))

    def old(x, low, high):
        warnings.warn("do not use this", DeprecationWarning, stacklevel=1)
        return np.clip(x, low, high)

    with pytest.warns(DeprecationWarning, match="do not use this"):
        assert check("clamp", old)


def test_what_only_a_check_needs_is_decoded_when_it_is_used_and_is_what_was_packed():
    name = "05_ekf_derivations"
    checking._read.cache_clear()
    packed = checking.unpack(checking._data(name)).exercises
    for kept, wanted in zip(checking.read_public(name).exercises, packed, strict=True):
        for part in checking._WHEN_NEEDED:
            assert "_values" not in vars(getattr(kept, part))
            assert encode(list(getattr(kept, part))) == encode(getattr(wanted, part))
        assert kept.cases[0] is kept.cases[0], "it is decoded once"
    assert checking.read_public(name) is checking.read_public(name)
