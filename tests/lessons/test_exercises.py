"""Every exercise of every lesson keeps the rules of docs/write_a_lesson.md, by their numbers there."""

import json
import os
import subprocess
import sys
import time

import pytest

from nao_course.codec import encode
from nao_course.exercises.checking import grade_public
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.mutation import MORE_SEEDS, mutate
from nao_course.instructor.authoring.plans import SEEDS, hidden_cases, made_cases
from tests.lessons.every import (
    COURSE,
    NAMES,
    each_lesson,
    earlier_functions_are_the_references,  # noqa: F401 - for every test here
    executed,
    graded,
    public_exercise,
    reference,
    waived,
    waived_rules_are_skipped,  # noqa: F401 - for every test here
)

# Every which mutant is tried here, fewer of the lessons in which that takes minutes; `nao-course mutate` tries all.
EVERY = 6
SPARSE = {"03_hough_corners": 15, "11_slam_on_the_field": 15, "12_beyond": 12}
FEWER_SEEDS = 7  # every which seed a mutant that is said to be right must pass here
FEWEST_MUTANTS = 15  # of an exercise: fewer say nothing about its cases
EXERCISES = [(name, exercise) for name in NAMES for exercise in COURSE.plan(name).exercises]

each_exercise = pytest.mark.parametrize(
    ("name", "exercise"), EXERCISES, ids=[exercise.name for _, exercise in EXERCISES]
)


@each_exercise
def test_rubric_7_a_check_answers_within_two_seconds_and_tells_outcomes_apart(name, exercise):
    public = public_exercise(name, exercise.name)
    reference(name)
    start = time.process_time()  # the processor's time: no test fails on a machine that is busy
    report = graded(name, exercise.name)
    assert time.process_time() - start < 2
    assert report.state == "right"
    assert "grader checks your function with other" in repr(report)

    def blank(*args, **kwargs):
        raise NotImplementedError

    def raises(*args, **kwargs):
        raise ZeroDivisionError

    assert grade_public(public, blank).state == "not attempted"
    assert grade_public(public, raises).state == "raised"
    assert grade_public(public, Silent if exercise.driver == "methods" else nothing).state == "wrong"


def nothing(*args, **kwargs):
    """Answer nothing."""


class Silent:
    """A class whose methods answer nothing."""

    def __init__(self, *args, **kwargs):
        """Take whatever it is begun with."""

    def __getattr__(self, name):
        return nothing


@each_exercise
def test_rubric_8_no_two_mistakes_say_the_same_and_hidden_cases_differ_by_seed(name, exercise):
    messages = [mistake.message for mistake in exercise.mistakes]
    assert len(set(messages)) == len(messages)
    assert len(exercise.mistakes) >= 3 and len(exercise.alternatives) >= 3
    answered = hidden_cases(exercise, reference(name)[exercise.name], SEEDS[0])
    first, second = (
        encode([(each.args, each.kwargs) for each in cases])
        for cases in (answered, made_cases(exercise, SEEDS[1]))
    )
    assert first != second


@each_exercise
def test_rubric_9_two_hints(name, exercise):
    assert len(exercise.hints) == 2 and all(exercise.hints)


@each_lesson
def test_rubric_16_the_solution_scores_everything(name):
    for exercise in COURSE.plan(name).exercises:
        assert graded(name, exercise.name)
        assert public_exercise(name, exercise.name).points == exercise.points
    for _, cell in lesson_text.code_cells(executed(name), "check"):
        assert "✔" in str(cell.outputs), lesson_text.exercise_name(cell)


@pytest.mark.slow
@each_lesson
def test_hidden_cases_catch_mutants_of_the_solutions(name):
    """Mutants that are right are declared with the reason, and pass many more hidden cases."""
    if name[:2] == "00":
        pytest.skip("lesson 00 is not graded")
    if "8" in waived(name):
        pytest.skip(f"{name} waives rule 8: {waived(name)['8']}")
    every = SPARSE.get(name, EVERY)
    report = mutate(name, jobs=2, every=every, more_seeds=MORE_SEEDS[::FEWER_SEEDS])
    hidden, public, total = report.caught()
    assert total >= FEWEST_MUTANTS / every * len(COURSE.plan(name).exercises)
    assert hidden / total >= 0.97, [mutant.diff for mutant in report.survivors]
    assert public / total >= 0.85
    assert report.unknown == ()
    known = {line for trial in report.equivalents for line in trial.mutant.lines}
    for exercise in COURSE.plan(name).exercises:
        assert known.issuperset([*exercise.equivalents][::every]), (
            f"{exercise.name}: a line that is not right"
        )


def test_checks_load_no_panel_and_no_figure():
    """A check in a terminal needs no widgets, and they take most of a second to import."""
    heavy = "'ipywidgets', 'matplotlib.figure', 'nao_course.widgets'"
    modules = ("graph_slam.drivers", "experiments.intervals", "hough_corners.segments")
    imports = "\n".join(f"import nao_course.lessons.{each}" for each in modules)
    script = f"import sys\n{imports}\nprint([name for name in ({heavy}) if name in sys.modules])"
    loaded = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert loaded.stdout.strip() == "[]"


def test_set_up_cells_load_neither_matplotlib_nor_widgets(tmp_path):
    """They come with the first figure and the first panel; `so_far` looks at the stages of all lessons.

    All cells run in one process: what one of them has loaded stays loaded.
    """
    cells = {}
    for name in NAMES:
        _, cell = lesson_text.code_cells(lesson_text.read_lesson(COURSE.text(name)))[0]
        assert "so_far(" in cell.source
        cells[name] = cell.source
    script = (
        "import json, sys\n"
        "for name, cell in json.load(sys.stdin).items():\n"
        "    exec(cell, {})\n"
        "    print('LOADED', name, [each for each in ('ipywidgets', 'matplotlib') if each in sys.modules])"
    )
    ran = subprocess.run(
        [sys.executable, "-c", script],
        input=json.dumps(cells),
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"NAO_COURSE_NOTEBOOKS": str(tmp_path)},
    )
    loaded = [line for line in ran.stdout.splitlines() if line.startswith("LOADED")]
    assert loaded == [f"LOADED {name} []" for name in NAMES]
