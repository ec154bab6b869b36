"""The line on top of a lesson: true, short, and there in a moment whatever a notebook holds."""

import pytest

from nao_course.student import so_far, stages
from tests.student.test_notebooks import ENDLESS, needs_alarm
from tests.toy import toy

LONG = 60.0


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch, stage):
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


def test_it_says_what_the_robot_has_and_what_comes_next(here):
    toy.write(here / "90_toy.ipynb", *toy.SOLUTION)
    assert repr(so_far(seconds=LONG)) == "Your NAO so far: ✔ distances (90) · next: goal posts (91)"


def test_at_the_beginning_of_a_lesson_only_those_before_it_count(here):
    toy.write(here / "90_toy.ipynb", *toy.SOLUTION)
    assert repr(so_far("90")) == "Your NAO so far: nothing yet · next: distances (90)"
    assert repr(so_far("91", LONG)) == repr(so_far(seconds=LONG))


def test_a_lesson_that_adds_nothing_to_the_robot_says_so(here):
    toy.write(here / "90_toy.ipynb", *toy.SOLUTION)
    assert repr(so_far("92", LONG)) == (
        "Your NAO so far: ✔ distances (90) · lesson 92 adds nothing to it · next: goal posts (91)"
    )
    assert "adds nothing" not in repr(so_far("00", LONG))


def test_it_says_why_what_comes_next_is_not_there(here):
    toy.write(here / "90_toy.ipynb", toy.CLAMP, "def mean_of_positive(values):\n    return 0.0")
    assert repr(so_far(seconds=LONG)) == (
        "Your NAO so far: nothing yet · next: distances (90) "
        "(mean_of_positive of lesson 90 does not pass its check yet)"
    )


def test_before_the_first_lesson_it_says_so():
    assert repr(so_far(seconds=LONG)) == (
        "Your NAO so far: nothing yet · next: distances (90) (90_toy.ipynb is not in your folder work)"
    )


def test_at_the_end_of_the_course_nothing_comes_next(here, monkeypatch):
    monkeypatch.setattr(stages, "PLANNED", {"90": "distances"})
    toy.write(here / "90_toy.ipynb", *toy.SOLUTION)
    assert repr(so_far(seconds=LONG)) == "Your NAO so far: ✔ distances (90) · that is all the course gives it"


def test_it_is_the_same_in_html_with_nothing_of_a_students_unescaped(here):
    (here / "90_toy.ipynb").write_text('{"nbformat": 4, "cells": "<b>"}')
    line = so_far(seconds=LONG)
    assert "&lt;" not in repr(line) and "<b>" not in line._repr_html_()
    assert 'role="note"' in line._repr_html_() and "next: distances (90)" in line._repr_html_()


@needs_alarm
@pytest.mark.parametrize("cell", [ENDLESS, "def clamp(x, low, high):\n    while True:\n        pass"])
def test_a_notebook_that_never_ends_keeps_nobody_from_beginning_a_lesson(here, cell):
    toy.write(here / "90_toy.ipynb", cell, toy.MEAN)
    said = repr(so_far(seconds=0.2))
    assert "nothing yet · looking at your notebooks takes longer" in said
    assert "never end" not in said  # on a slow machine a quick look cannot tell


@needs_alarm
def test_where_its_time_is_not_enough_it_says_so(here):
    toy.write(here / "90_toy.ipynb", *toy.SOLUTION)
    said = repr(so_far(seconds=1e-6))
    assert "looking at your notebooks takes longer" in said
    assert "next" not in said  # what was not looked at may be solved
