"""A case is judged where its answers do not come from: its calls, its laws, and the exception that it asks for."""

import subprocess
import sys

import numpy as np

from nao_course.exercises import judging
from nao_course.exercises.case import Case
from nao_course.exercises.checking import grade_public, pack, unpack
from nao_course.exercises.comparisons import Close, Each, Property
from nao_course.exercises.exercise import PublicExercise, PublicLesson
from nao_course.exercises.running import Outcome, call


class Odd(type):
    """A class of classes that raises when it is asked for a name."""

    @property
    def __name__(cls):
        raise ZeroDivisionError


class SpecialError(ValueError, metaclass=Odd):
    pass


class OwnError(ValueError):
    pass


RIGHT = [ValueError, ValueError("no"), OwnError("no"), SpecialError("no"), np.linalg.LinAlgError("no")]


def exercise(comparison, *cases):
    return PublicExercise("f", "90.1", 1.0, 1, comparison, list(cases), [], ["a", "b"], "")


WRONG = [KeyError("no"), Exception("ValueError"), KeyboardInterrupt, NotImplementedError]


def test_an_exception_that_is_asked_for_is_right_and_a_check_says_what_came_instead():
    for error in [*RIGHT, *WRONG]:

        def function(value, error=error):
            raise error

        case = Case((-1.0,), "negative", raises="ValueError")
        verdict = judging.judge(Close(), case, call(function, case))
        assert verdict if error in RIGHT else verdict is None
    asked = exercise(Close(), Case((1.0,), expected=1.0), Case((-1.0,), "negative", raises="ValueError"))

    def right(value):
        if value < 0:
            raise ValueError(f"value must not be negative, got {value}")
        return value

    assert grade_public(asked, right)
    said = repr(grade_public(asked, lambda value: value))
    assert "No exception (negative): your function returns a float, but it should raise ValueError" in said
    said = repr(grade_public(asked, lambda value: {1.0: 1.0}[value]))
    assert "KeyError: -1.0 (negative)" in said and "your function should raise ValueError" in said


def test_check_data_of_the_worlds_values_is_read_back_also_by_a_process_that_has_not_imported_them():
    from nao_course.geometry import Pose
    from nao_course.slam import Measurement

    comparison = Each({0: Close(period=(0.0, 0.0, 2 * np.pi)), 1: Close(atol=0.5)})
    case = Case(({3: Pose(1.0, 2.0, 3.0)}, [Measurement(0.1, 2.0)]), expected=(Pose(1.0, 2.0, 3.0), 2.0))
    data = pack(PublicLesson("90_toy", [exercise(comparison, case)], []))
    lesson = unpack(data)
    for pose, more, right in ((None, 0.4, True), (None, 0.6, False), (Pose(), 0.0, False)):
        function = lambda poses, seen, pose=pose, more=more: (pose or poses[3], seen[0].range + more)  # noqa: E731
        assert bool(grade_public(lesson.exercises[0], function)) is right
    code = "import sys; from nao_course.exercises.checking import unpack; print(unpack(open(0, 'rb').read()))"
    run = subprocess.run([sys.executable, "-c", code], input=data, capture_output=True, check=True)
    assert b"Pose(x=1.00" in run.stdout


def test_a_gathered_answer_says_that_its_input_was_changed_and_a_law_that_raises_refuses_it():
    class Twice(Close):
        def calls(self, case):
            return [case, case]

    outcomes = iter([Outcome("value", 1.0), Outcome("value", 2.0, changed=True)])
    outcome = judging.answer(Twice(), lambda each: next(outcomes), Case((1.0,)))
    assert outcome.value == 1.0 and outcome.changed
    law = Property(lambda args, kwargs, answer: "" if answer.shape == args[0].shape else "another shape")
    case = Case((np.zeros(3),))
    assert judging.judge(law, case, Outcome("value", np.ones(3)))
    for answer, kind in ((np.ones(4), "law"), ("text", "type"), (None, "nothing")):
        verdict = judging.judge(law, case, Outcome("value", answer))
        assert verdict is not None and verdict.kind == kind
