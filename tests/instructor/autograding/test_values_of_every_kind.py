"""What a lesson hands over is judged alike by `check`, in the terminal, by `student.functions` and in grading."""

import pickle
import tracemalloc
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from nao_course import cli
from nao_course.exercises import Close, checking
from nao_course.exercises.checking import Checks, pack, unpack
from nao_course.exercises.definitions import load_definitions
from nao_course.exercises.exercise import PublicLesson
from nao_course.exercises.running import Outcome
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.grader import SubmissionGrader, grade
from nao_course.instructor.autograding.tries import Allowances
from nao_course.instructor.collecting.files import Files
from nao_course.instructor.collecting.submissions import Submission
from nao_course.student import notebooks as student
from nao_course.student import overview
from tests.toy import values

AMPLE = 60.0  # seconds for a call that has to succeed, however busy the machine


@pytest.fixture(scope="module")
def assignment(tmp_path_factory):
    course = values.make_course(tmp_path_factory.mktemp("course"))
    prepared = prepare(course, "92", b"a secret of sixteen bytes, or more")
    return replace(pickle.loads(pickle.dumps(prepared)), seconds=AMPLE)


@pytest.fixture
def public(assignment, monkeypatch):
    """The lesson as a student's copy reads it."""
    lesson = unpack(pack(PublicLesson(values.LESSON, [task.public for task in assignment.tasks], [])))
    for module in (student, checking):
        monkeypatch.setattr(module, "read_public", {values.LESSON: lesson}.__getitem__)
    monkeypatch.setattr(overview, "read_summary", {values.LESSON: lesson}.__getitem__)
    monkeypatch.setattr(overview, "lessons", lambda: [values.LESSON])
    return lesson


def hand_in(folder, functions=None):
    path = folder / f"{values.LESSON}.ipynb"
    path.write_bytes(values.notebook(functions))
    return path


@pytest.mark.parametrize("right", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_the_grader_judges_values_of_every_kind(assignment, warm_server, tmp_path, right):
    path = hand_in(tmp_path, {} if right else values.WRONG)
    result = grade(Submission("ada", values.LESSON, path, file="a.ipynb"), assignment, warm_server, "full")
    found = {each.name: each.state for each in result.exercises}
    assert found == dict.fromkeys(values.RIGHT, "right" if right else "wrong"), result.exercises
    assert result.earned == (len(values.RIGHT) if right else 0)


def test_check_the_terminal_and_student_functions_judge_them_alike(public, tmp_path):
    for functions, right in ((None, True), (values.WRONG, False)):
        path = hand_in(tmp_path, functions)
        defined = load_definitions(path)
        reports = {name: Checks(public)(name, defined[name]) for name in values.RIGHT}
        assert {name: bool(report) for name, report in reports.items()} == dict.fromkeys(values.RIGHT, right)
        assert list(student.functions(values.LESSON, tmp_path)) == (list(values.RIGHT) if right else [])
        said = CliRunner().invoke(cli.app, ["check", str(path)])
        assert said.exit_code == (0 if right else 1), said.output
    assert "H delta is not -b" in repr(reports["step"])
    assert "for every rng" in repr(reports["draw"])


def grader_with(assignment, name, call):
    """Return a grader of submissions whose worker is a function, and a task."""
    worker = SimpleNamespace(call=call)
    grader = SubmissionGrader(worker, assignment, Files(b"{}"), None, lambda: False, Allowances(values.RIGHT))
    return grader, next(task for task in assignment.tasks if task.public.name == name)


def test_all_calls_of_a_case_have_the_time_of_one(assignment):
    class Many(Close):
        def calls(self, case):
            return [case] * 60

    given = []

    def call(name, case, driver, seconds):
        given.append(seconds)
        grader.shares[name].spend(0.75)
        return Outcome("value", 1.0)

    grader, task = grader_with(assignment, "draw", call)
    public = replace(task.public, comparison=Many(), seconds=10.0)
    assert grader.answer(public, task.hidden[0]).status == "timed out"
    assert given == [10.0 - 0.75 * n for n in range(14)]


def test_large_answers_are_judged_as_they_come_and_not_kept(assignment):
    grader, task = grader_with(assignment, "move", lambda *_: Outcome("value", np.zeros(2**18)))
    public = replace(task.public, cases=task.public.cases[:1] * 4)
    tracemalloc.start()
    assert grader.hidden(replace(task, hidden=task.hidden[:1] * 40, public=public)).state == "wrong"
    lines, last = grader.public(public)
    assert tracemalloc.get_traced_memory()[1] < 15 * 2**20  # of 80 MB
    tracemalloc.stop()
    assert "Wrong kind" in lines[0] and last.value is None
