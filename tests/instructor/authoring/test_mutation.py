"""Plans are refused with reasons, mutants are made, caught, timed out and listed."""

import ast
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from nao_course.exercises import Case, Exact, LessonPlan, Mistake
from nao_course.exercises.checking import pack, unpack
from nao_course.instructor.authoring import mutation
from nao_course.instructor.authoring.mutation import make_mutants, mutate, show
from nao_course.instructor.authoring.plans import (
    PlanError,
    check_plan,
    lesson_name,
    load_plan,
    publish,
    reference,
    with_answers,
)
from tests.toy import toy


@pytest.fixture(scope="module")
def solutions(tmp_path_factory):
    return toy.solutions(tmp_path_factory.mktemp("course") / "solutions")


@pytest.fixture(scope="module")
def plan(solutions):
    return load_plan(solutions / "exercises" / "90_toy.py")


@pytest.fixture(scope="module")
def right(solutions):
    return reference("90", solutions)


def test_a_lesson_is_known_by_its_number_or_name(solutions):
    assert lesson_name("90", solutions) == lesson_name("90_toy", solutions) == "90_toy"
    with pytest.raises(PlanError, match=r"there are \['90_toy'\]"):
        lesson_name("91", solutions)


def test_a_good_plan_is_published_without_code_the_same_each_time(plan, right):
    check_plan("90_toy", plan, right)
    public = publish("90_toy", plan, right)
    assert [(each.number, each.name, each.points) for each in public.exercises] == [
        ("90.1", "clamp", 2.0),
        ("90.2", "mean_of_positive", 3.0),
    ]
    assert [case.expected for case in public.exercises[0].cases] == [2.25, 0.5, 1.125]
    assert public.exercises[0].mistakes[0].answers == {"0": 3.0}
    assert public.exercises[1].mistakes[2].answers == {"1": {"raises": "ZeroDivisionError"}}
    assert public.exercises[1].mistakes[3].answers == {}  # right, but in place
    assert pack(public) == pack(publish("90_toy", plan, right))
    back = unpack(pack(public))
    assert (back.name, len(back.exercises), back.questions[0].right) == ("90_toy", 2, "Safety")


def wrong(x, low, high):
    return 1 / 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"public": list}, "clamp: no public cases"),
        ({"hidden": lambda rng: []}, "clamp: no hidden cases"),
        ({"mistakes": []}, "clamp: 0 mistakes; at least 3 are wanted"),
        ({"alternatives": {}}, "clamp: 0 alternatives; at least 3 are wanted"),
        ({"alternatives": {"odd one": wrong}}, "clamp: alternative 'odd one' is not right"),
        (
            {"alternatives": {"odd one": lambda x, low, high: max(low, min(high, x)) + (low < 0)}},
            "clamp: alternative 'odd one' is not right in a hidden case",
        ),
        (
            {"mistakes": [Mistake("none", lambda x, low, high: max(low, min(high, x)), "m")]},
            "clamp: mistake 'none': no public case tells it from the right answer",
        ),
        (
            {"mistakes": [Mistake("none", lambda x, low, high: max(low, min(high, x)), "m")]},
            "clamp: mistake 'none': no hidden case tells it from the right answer",
        ),
        (
            {"mistakes": [Mistake(name, lambda x, low, high: x, name) for name in ("a", "b")]},
            "clamp: mistake 'b': its message is not shown",
        ),
        ({"mistakes": [Mistake("a", wrong, "m")] * 2}, "clamp: two mistakes are called 'a'"),
        ({"public": lambda: [Case((np.zeros((49, 64)), 0, 1))]}, "a picture of 64x49; 64x48 is the most"),
        ({"public": lambda: [Case(({"a": [np.zeros((480, 640, 3))]}, 0, 1))]}, "a picture of 640x480"),
        ({"public": lambda: [Case((np.random.default_rng().random(), 0, 1))]}, "not the same each time"),
        (
            {"hidden": lambda rng: [Case((np.random.default_rng().random(), 0, 1))]},
            "the same for the same seed",
        ),
        (
            {"public": lambda: [Case((object(), 0, 1))]},
            "clamp: a case cannot be sent: a value of type object",
        ),
        (
            {"public": lambda: [Case((1.0,), "too few")]},
            "clamp: the reference, case 1 'too few', gives no answer",
        ),
        ({"name": "nobody"}, "nobody: the solution notebook does not define it"),
        ({"name": "mean_of_positive"}, "mean_of_positive: the name is used twice"),
        ({"comparison": Exact(), "public": lambda: [Case((np.nan, np.nan, np.nan))]}, "not right by its own"),
    ],
)
def test_a_plan_that_would_fail_a_student_is_refused_and_says_where(plan, right, change, message):
    broken = replace(plan, exercises=[replace(plan["clamp"], **change), plan["mean_of_positive"]])
    with pytest.raises(PlanError) as refusal:
        check_plan("90_toy", broken, right)
    assert message in str(refusal.value)
    assert all(line.startswith("90_toy: ") for line in str(refusal.value).splitlines())


def test_names_of_other_lessons_and_odd_questions_are_refused(plan, right):
    with pytest.raises(PlanError, match="clamp: the name is used twice"):
        check_plan("90_toy", plan, right, taken=["clamp", "other"])
    check_plan("90_toy", plan, right, taken=["other", "other"])
    question = replace(plan.questions[0], right="Neither")
    with pytest.raises(PlanError, match="why: its right answer is not one of its choices"):
        check_plan("90_toy", replace(plan, questions=[question]), right)


def test_all_that_is_wrong_is_said_at_once(plan, right):
    broken = [replace(each, mistakes=[], alternatives={}) for each in plan.exercises]
    with pytest.raises(PlanError) as refusal:
        check_plan("90_toy", LessonPlan(broken), right)
    assert len(str(refusal.value).splitlines()) == 4


def test_practice_needs_no_mistakes(plan, right):
    check_plan("90_toy", LessonPlan([replace(plan["clamp"], points=0, mistakes=[], alternatives={})]), right)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (wrong, "gives no answer: raised ZeroDivisionError"),
        (lambda x, low, high: {1}, "gives no answer: unsendable a value of type set"),
        (lambda x, low, high: [x.fill(0)][1:], "changes its input"),
    ],
)
def test_a_reference_that_fails_is_refused(plan, function, message):
    case = Case((np.ones(2), 0, 1), "first")
    with pytest.raises(PlanError, match=message):
        with_answers(plan["clamp"], [case], function)


@pytest.mark.parametrize("text", ["PLAN = 3", "", "1 / 0", "def f(:"])
def test_a_declaration_that_declares_nothing_is_refused(tmp_path, text):
    (tmp_path / "91_bad.py").write_text(text)
    with pytest.raises(PlanError, match=r"91_bad\.py: "):
        load_plan(tmp_path / "91_bad.py")
    with pytest.raises(FileNotFoundError):
        load_plan(tmp_path / "missing.py")


def test_a_lesson_that_is_not_built_is_said_so(tmp_path):
    folder = toy.solutions(tmp_path / "solutions")
    (folder / "90_toy.ipynb").unlink()
    with pytest.raises(FileNotFoundError, match="nao-course build"):
        reference("90", folder)


# Mutants

SOURCE = '''
def f(x: int | None, k=0) -> "a | b":
    """Say 1 + 1."""
    if x > k and not k:
        return -x[1:k, 0].T
    for i in range(3):
        x = np.arctan2(x, k, axis=0)
    return x - k
'''


def test_mutants_are_python_and_no_two_are_alike():
    made = make_mutants("f", SOURCE)
    assert len(made) > 60
    assert len({each.source for each in made} | {made[0].original}) == len(made) + 1
    for each in made:
        ast.parse(each.source)
        assert each.original == made[0].original
        assert "Say" not in each.source
        assert "def f(x" in each.source
        assert each.diff.count("\n+") >= 1 or each.diff.count("\n-") >= 1


@pytest.mark.parametrize(
    "line",
    [
        *("if x >= k and (not k):", "if x < k and (not k):", "if x > k or not k:", "if x > k and k:"),
        *("if x > k:", "if True:", "if False:", "return x[1:k, 0].T", "return -x[2:k, 0].T"),
        *("return -x[0:k, 0].T", "return -x[:k, 0].T", "return -x[1:, 0].T", "return -x[1:k - 1, 0].T"),
        *("return -x[0, 1:k].T", "return -x[1:k, 1].T", "return -x[1:k, 0]", "return None"),
        *("x = np.arctan2(k, x, axis=0)", "x = np.arctan2(x, k, axis=1 - 0)", "x = np.arctan2(x, k)"),
        *(
            "x = np.hypot(x, k, axis=0)",
            "x = x",
            "for i in range(4):",
            "return x + k",
            "return k - x",
            "return k",
        ),
    ],
)
def test_the_slips_of_arrays_and_formulas_are_among_them(line):
    assert any(
        line in [each.strip() for each in mutant.source.splitlines()] for mutant in make_mutants("f", SOURCE)
    )


def test_a_lessons_mutants_are_caught_and_the_rest_is_listed(solutions):
    report = mutate("90", jobs=2, solutions=solutions)
    hidden, public, total = report.caught()
    assert total == len(report.trials) > 25
    assert hidden / total > 0.8
    assert public <= hidden
    kept = {mutant.source for mutant in report.survivors}
    assert len(kept) == total - hidden
    assert all("+++ " in mutant.diff for mutant in report.survivors)
    console = Console(record=True, width=120)
    show(report, console)
    text = console.export_text()
    assert f"{hidden} ({hidden / total:.0%})" in text
    assert all(line in text for mutant in report.survivors for line in mutant.diff.splitlines()[2:3])


def test_weak_tests_let_mutants_live(tmp_path):
    weak = toy.solutions(tmp_path / "weak")
    plan = weak / "exercises" / "90_toy.py"
    plan.write_text(
        plan.read_text() + "\nimport dataclasses\nPLAN = LessonPlan([dataclasses.replace(CLAMP, "
        "hidden=lambda rng: [Case((0.0, -1.0, 1.0))])])\n"
    )
    report = mutate("90", jobs=1, solutions=weak)
    assert any("return min(high, x)" in mutant.source for mutant in report.survivors)
    assert report.caught()[0] < report.caught()[1]


def test_a_mutant_that_never_ends_is_caught(tmp_path, monkeypatch):
    monkeypatch.setattr(mutation, "SECONDS", 0.5)
    slow = toy.solutions(tmp_path / "slow")
    body = "def clamp(x, low, high):\n    k = 0\n    while k < 3:\n        k += 1\n    return max(low, min(high, x))"
    toy.write(slow / "90_toy.ipynb", ("solution", body), ("solution", toy.MEAN))
    monkeypatch.setattr(mutation, "_by_cosmic_ray", lambda source: iter(()))
    monkeypatch.setattr(mutation, "_by_us", lambda tree: iter([("endless", body.replace("+=", "-="))]))
    report = mutate("90", jobs=1, solutions=slow)
    assert [(trial.hidden, trial.public) for trial in report.trials if trial.mutant.exercise == "clamp"] == [
        (True, True)
    ]


def test_a_mutant_that_is_said_to_be_right_is_counted_apart_unless_a_case_speaks_against_it(tmp_path):
    where = toy.solutions(tmp_path / "apart")
    plan = where / "exercises" / "90_toy.py"
    said = {
        "return max(low, min(x, high))": "the smaller of two has no order",
        "return min(high, x)": "a lie",
    }
    plan.write_text(
        plan.read_text() + "\nimport dataclasses\n"
        f"PLAN = LessonPlan([dataclasses.replace(CLAMP, equivalents={said!r})])\n"
    )
    report = mutate("90", jobs=1, solutions=where)
    assert {trial.reason for trial in report.equivalents} == {"the smaller of two has no order"}
    assert all(trial.mutant.lines == {"return max(low, min(x, high))"} for trial in report.equivalents)
    assert report.caught("clamp")[2] == len(report.trials) - len(report.equivalents)
    console = Console(record=True, width=120)
    show(report, console)
    assert "is right: the smaller of two has no order" in console.export_text()
