"""Answers of a worker are judged within the time of one case, and as they come."""

import tracemalloc
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.exercises import Close
from nao_course.exercises.running import Outcome
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.grader import SubmissionGrader
from nao_course.instructor.autograding.tries import Allowances
from nao_course.instructor.collecting.files import Files
from tests.toy import chain


@pytest.fixture(scope="module")
def assignment(tmp_path_factory):
    return prepare(chain.make_course(tmp_path_factory.mktemp("course")), "90", chain.SECRET)


def grader_with(assignment, call):
    """Return a grader of submissions whose worker is a function, and its first task."""
    worker = SimpleNamespace(call=call)
    grader = SubmissionGrader(worker, assignment, Files(b"{}"), None, lambda: False, Allowances(chain.RIGHT))
    return grader, assignment.tasks[0]


def test_all_calls_of_a_case_have_the_time_of_one(assignment):
    class Many(Close):
        def calls(self, case):
            return [case] * 60

    given = []

    def call(name, case, driver, seconds):
        given.append(seconds)
        grader.shares[name].spend(0.75)
        return Outcome("value", 1.0)

    grader, task = grader_with(assignment, call)
    public = replace(task.public, comparison=Many(), seconds=10.0)
    assert grader.answer(public, task.hidden[0]).status == "timed out"
    assert given == [10.0 - 0.75 * n for n in range(14)]


def test_large_answers_are_judged_as_they_come_and_not_kept(assignment):
    grader, task = grader_with(assignment, lambda *_: Outcome("value", np.zeros(2**18)))
    public = replace(task.public, cases=task.public.cases[:1] * 4)
    tracemalloc.start()
    assert grader.hidden(replace(task, hidden=task.hidden[:1] * 40, public=public)).state == "wrong"
    lines, last = grader.public(public)
    assert tracemalloc.get_traced_memory()[1] < 15 * 2**20  # of 80 MB
    tracemalloc.stop()
    assert "Wrong shape" in lines[0] and last.value is None
