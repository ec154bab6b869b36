"""A plan is loaded, its reference gives the answers, and it is published without code."""

import numpy as np
import pytest

from nao_course.exercises import Case, Close, Exact, Exercise, Mistake
from nao_course.exercises.checking import grade_public, pack, unpack
from nao_course.exercises.exercise import PublicLesson
from nao_course.exercises.judging import is_unstable
from nao_course.instructor.authoring import plans
from nao_course.instructor.authoring.perturbation import perturbed
from nao_course.instructor.authoring.plans import PlanError, lesson_name, load_plan, publish, publish_exercise
from tests.toy import toy


def test_a_lesson_is_known_by_its_number_or_name_and_a_reference_that_fails_is_refused(solutions, plan):
    assert lesson_name("90", solutions) == lesson_name("90_toy", solutions) == "90_toy"
    with pytest.raises(PlanError, match=r"there are \['90_toy'\]"):
        lesson_name("91", solutions)
    for function, message in [
        (lambda x, low, high: 1 / 0, "gives no answer: raised ZeroDivisionError"),
        (lambda x, low, high: {1}, "gives no answer: unsendable a value of type set"),
        (lambda x, low, high: [x.fill(0)][1:], "changes its input"),
    ]:
        case = Case((np.ones(2), 0, 1), "first")
        with pytest.raises(PlanError, match=message):
            plans.with_answers(plan["clamp"], [case], function)


def test_a_good_plan_is_published_without_code_the_same_each_time(plan, right):
    public = publish("90_toy", plan, right)
    clamp, mean = public.exercises
    assert (clamp.number, clamp.name, clamp.points) == ("90.1", "clamp", 2.0)
    assert (mean.number, mean.name, mean.points) == ("90.2", "mean_of_positive", 3.0)
    assert [case.expected for case in clamp.cases] == [2.25, 0.5, 1.125]
    assert clamp.mistakes[0].answers == {"0": 3.0}
    assert mean.mistakes[2].answers == {"1": {"raises": "ZeroDivisionError"}}
    assert mean.mistakes[3].answers == {}  # right, but in place
    assert pack(public) == pack(publish("90_toy", plan, right))
    back = unpack(pack(public))
    assert (back.name, len(back.exercises), back.questions[0].right) == ("90_toy", 2, "Safety")


@pytest.mark.parametrize("text", ["PLAN = 3", "", "1 / 0", "def f(:"])
def test_a_declaration_that_declares_nothing_or_is_missing_is_refused(tmp_path, text):
    (tmp_path / "91_bad.py").write_text(text)
    with pytest.raises(PlanError, match=r"91_bad\.py: "):
        load_plan(tmp_path / "91_bad.py")
    with pytest.raises(FileNotFoundError):
        load_plan(tmp_path / "missing.py")
    folder = toy.solutions(tmp_path / "solutions")
    (folder / "90_toy.ipynb").unlink()
    with pytest.raises(FileNotFoundError, match="nao-course build"):
        plans.reference("90", folder)


_DIFFERENCES = np.array([[1.1, -1.1, 0.0], [0.0, 0.7, -0.7]])
SINGULAR = _DIFFERENCES.T @ _DIFFERENCES  # but for rounding
HELD = SINGULAR + np.diag([1.0, 0, 0])


def solve(omega, xi):
    """The reference: refuses what cannot be solved."""
    if np.linalg.cond(omega) > 1e12:
        raise ZeroDivisionError("singular")
    return np.linalg.solve(omega, xi)


START = np.array([0.1, 0.2, -0.3])


def exercise_of(name, cases, *mistakes, **more):
    wrong = [Mistake(each.__name__, each, each.__name__) for each in mistakes]
    return Exercise(name, 1, lambda: cases, lambda rng: [], ("", ""), wrong, **more)


def _published(*mistakes):
    cases = [Case((SINGULAR, START), "free", raises="ZeroDivisionError"), Case((HELD, START), "held")]
    return publish_exercise("1.1", exercise_of("solve", cases, *mistakes), solve)


def elsewhere(function):
    """A function as another processor would run it: with other rounding errors."""
    rng = np.random.default_rng(99)
    return lambda *args: function(*perturbed(args, rng))


def unguarded(omega, xi):
    return np.linalg.inv(omega) @ xi


def raises_or_not(omega, xi):
    if abs(omega.sum()) < 1e-15:
        raise np.linalg.LinAlgError
    return xi / omega.sum()


def shortest(omega, xi):
    return np.linalg.pinv(omega, rcond=1e-9) @ xi


def transposed(omega, xi):
    return solve(omega, -xi)


def test_a_mistakes_answer_that_is_a_rounding_error_is_marked_and_no_other():
    mistakes = _published(unguarded, raises_or_not, shortest, transposed).mistakes
    marked = [[key for key, each in mistake.answers.items() if is_unstable(each)] for mistake in mistakes]
    assert marked == [["0"], ["0"], [], []]
    assert mistakes[1].answers["0"] == {"unstable": {"raises": "LinAlgError"}}
    # The inputs of a case are the same on each processor.
    for right, comparison, mistake in [
        (np.floor, Close(), lambda x: np.ceil(x) + 1),  # the reference, too, changes where the inputs do
        (np.round, Close(), lambda x: np.where(x == 2, 5.0, np.round(x))),  # right for all other inputs
        (np.round, Exact(), lambda x: 2 * x),  # changes no more than the inputs
    ]:
        whole = np.array([1.0, 2.0, 3.0, 4.0])
        exercise = exercise_of("whole", [Case((whole,))], mistake, comparison=comparison)
        (answer,) = publish_exercise("1.1", exercise, right).mistakes[0].answers.values()
        assert answer.tolist() == mistake(whole).tolist()
    late = np.array([1.0, 2.0, 3.0])  # digits that the comparison sees and a coarser one does not
    exercise = exercise_of(
        "late", [Case((late,))], lambda x: x + 1 + 1e-5 * np.sin(1e14 * x), comparison=Close(rtol=1e-7)
    )
    assert all(map(is_unstable, publish_exercise("1.1", exercise, np.copy).mistakes[0].answers.values()))


@pytest.mark.parametrize("mistake", [unguarded, raises_or_not, shortest, transposed])
def test_a_mistake_is_recognised_on_another_processor(mistake):
    lesson = PublicLesson("01_a", [_published(shortest, transposed, mistake)], [], [])
    (public,) = unpack(pack(lesson)).exercises
    assert grade_public(public, elsewhere(solve))
    for _ in range(3):
        assert mistake.__name__ in grade_public(public, elsewhere(mistake)).lines
