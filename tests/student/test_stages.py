"""The stages of the robot are those of the course's lessons."""

import re

import pytest

from nao_course import exercises
from nao_course.exercises import checking
from nao_course.exercises.lesson_names import number_of
from nao_course.student import stages
from tests.paths import SOLUTIONS

LESSONS, READ = checking.lessons, checking.read_public


@pytest.fixture(autouse=True)
def real(lesson, monkeypatch):
    monkeypatch.setattr(stages, "lessons", LESSONS)


def test_each_lessons_stage_is_planned_uses_exercises_that_there_are_and_comes_after_those_that_it_needs():
    found = stages.all_stages()
    assert [each.lesson for each in found][:1] == ["01_hsl_filtering"]
    for each in found:
        assert stages.PLANNED[number_of(each.lesson)] == each.name
    before = set()
    for each in stages.all_stages():
        names = {exercise.name for exercise in READ(each.lesson).exercises}
        assert {use for use in each.uses if ":" not in use} <= names
        assert set(each.after) <= before
        before.add(each.name)
    (labels, *_) = stages.all_stages()
    assert stages.next_planned([]) == ("01", "labels")
    assert stages.next_planned([labels]) == ("02", "goal posts")
    assert exercises.lesson is checking.lesson  # what a set-up cell calls stays light: no panel comes with it


def test_a_lessons_robot_shows_the_result_of_its_own_stage_whatever_is_solved():
    every = stages.all_stages()
    for number, name in stages.PLANNED.items():
        first, later = stages.split_after(every, number)
        assert [*first, *later] == every and first[-1].name == name
        own = first[-1]
        shown = [each for each in first if each.estimates][-1:]
        assert own in shown or not own.estimates
    assert stages.split_after(every, "") == (every, [])
    with pytest.raises(ValueError, match="upto must be the number of a lesson, as a text: 00, 01"):
        stages.split_after(every, "6")


def test_each_lesson_shows_the_robot_of_its_own_stage():
    for path in SOLUTIONS.glob("*.md"):
        arguments = re.findall(r"^my_nao\((?!nao\))(.*)\)$", path.read_text(encoding="utf-8"), re.MULTILINE)
        assert all(each.endswith(f'upto="{number_of(path.stem)}"') for each in arguments), path.name
