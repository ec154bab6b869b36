"""Mutants are made, caught, timed out and listed."""

import ast
import re

import pytest
from rich.console import Console

from nao_course.instructor.authoring import mutation
from nao_course.instructor.authoring.mutation import make_mutants, mutate, show
from nao_course.instructor.sandbox.protocol import Allowance
from tests.toy import pair, toy
from tests.toy.course import run

SOURCE = '''
def f(x: int | None, k=0) -> "a | b":
    """Say 1 + 1."""
    if x > k and not k:
        return -x[1:k, 0].T
    for i in range(3):
        x = np.arctan2(x, k, axis=0)
    return x - k
'''


@pytest.fixture(scope="module")
def made():
    return make_mutants("f", SOURCE)


def test_mutants_are_python_and_the_slips_of_arrays_and_formulas_are_among_them(made):
    assert len(made) > 60
    assert len({each.source for each in made} | {made[0].original}) == len(made) + 1
    for each in made:
        ast.parse(each.source)
        assert each.original == made[0].original
        assert "Say" not in each.source
        assert "def f(x" in each.source
        assert each.diff.count("\n+") >= 1 or each.diff.count("\n-") >= 1
    lines = {line.strip() for mutant in made for line in mutant.source.splitlines()}
    wanted = re.split("; |\n", SLIPS.strip())
    assert len(wanted) == 26 and [line for line in wanted if line not in lines] == []


SLIPS = """
if x >= k and (not k):; if x < k and (not k):; if x > k or not k:; if x > k and k:; if x > k:; if True:
if False:; return x[1:k, 0].T; return -x[2:k, 0].T; return -x[0:k, 0].T; return -x[:k, 0].T
return -x[1:, 0].T; return -x[1:k - 1, 0].T; return -x[0, 1:k].T; return -x[1:k, 1].T; return -x[1:k, 0]
return None; x = x; x = np.arctan2(k, x, axis=0); x = np.arctan2(x, k, axis=1 - 0); x = np.arctan2(x, k)
x = np.hypot(x, k, axis=0); for i in range(4):; return x + k; return k - x; return k
"""


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


def test_weak_tests_let_mutants_live_and_each_mutant_has_all_the_time_of_a_submission(tmp_path, monkeypatch):
    """From one allowance for all, those that came last would be caught for being late."""
    given = []

    class Noted(Allowance):
        def __init__(self):
            super().__init__()
            given.append(self)

    monkeypatch.setattr(mutation, "Allowance", Noted)
    weak = toy.solutions(tmp_path / "weak")
    replan(weak, "hidden=lambda rng: [Case((0.0, -1.0, 1.0))]")
    report = mutate("90", jobs=1, solutions=weak)
    assert any("return min(high, x)" in mutant.source for mutant in report.survivors)
    assert report.caught()[0] < report.caught()[1]
    assert len(given) == len(report.trials) and all(each.spent > 0 for each in given)


def replan(solutions, changed):
    with (solutions / "exercises" / "90_toy.py").open("a") as plan:
        plan.write(f"\nimport dataclasses\nPLAN = LessonPlan([dataclasses.replace(CLAMP, {changed})])\n")


@pytest.mark.slow
def test_a_mutant_that_never_ends_is_caught(tmp_path, monkeypatch):
    monkeypatch.setattr(mutation, "SHARE", 0.05)
    slow = toy.solutions(tmp_path / "slow")
    body = "def clamp(x, low, high):\n    k = 0\n    while k < 3:\n        k += 1\n    return max(low, min(high, x))"
    toy.write(slow / "90_toy.ipynb", ("solution", body), ("solution", toy.MEAN))
    monkeypatch.setattr(mutation, "_by_cosmic_ray", lambda source, operators: iter(()))
    monkeypatch.setattr(mutation, "_by_us", lambda tree: iter([("endless", body.replace("+=", "-="))]))
    report = mutate("90", jobs=1, solutions=slow)
    assert [(trial.hidden, trial.public) for trial in report.trials if trial.mutant.exercise == "clamp"] == [
        (True, True)
    ]


def test_a_mutant_that_is_said_to_be_right_is_counted_apart_unless_a_case_speaks_against_it(tmp_path):
    where = toy.solutions(tmp_path / "apart")
    right, reason = "return max(low, min(x, high))", "the smaller of two has no order"
    replan(where, f"equivalents={ {right: reason, 'return min(high, x)': 'a lie', 'x = 1': 'no line'}!r}")
    report = mutate("90", jobs=1, solutions=where)
    assert {trial.reason for trial in report.equivalents} == {reason} and report.unknown == (
        "clamp: no mutant has the line x = 1",
    )
    assert all(trial.mutant.lines == {right} for trial in report.equivalents)
    assert report.caught("clamp")[2] == len(report.trials) - len(report.equivalents)
    console = Console(record=True, width=120)
    show(report, console)
    shown = console.export_text()
    assert f"is right: {reason}" in shown and "clamp: no mutant has the line x = 1" in shown
    few = mutate("90", jobs=1, solutions=where, every=5)
    assert few.equivalents == report.equivalents and few.caught()[2] < report.caught()[2] / 2


def test_mutants_of_a_class_and_of_what_uses_an_earlier_lesson_are_caught(tmp_path, monkeypatch):
    course = pair.make_course(tmp_path)
    report = mutate("81", jobs=2, solutions=course.solutions, seeds=[1])
    for name in ("Walker", "quadruple", "walk"):
        hidden, _, total = report.caught(name)
        assert hidden / total > 0.7 and total > 2, name
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(mutation, "mutate", lambda lesson, jobs: {("81", 3): report}[lesson, jobs])
    result = run("mutate", "81", "--jobs", "3")
    assert result.exit_code == 0 and re.search(r"Walker .*%", result.output), result.output
    course.text(pair.SECOND).write_text("# edited")
    assert "was edited" in run("mutate", "81").output
