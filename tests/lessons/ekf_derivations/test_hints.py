"""What hints and messages of lesson 05 send a student to is there, in the exercise's own section."""

import re

import pytest

from nao_course.exercises.checking import read_public
from tests.paths import SOLUTIONS

NAME = "05_ekf_derivations"
TEXT = (SOLUTIONS / f"{NAME}.md").read_text(encoding="utf-8")


def equations(text):
    return set(re.findall(r"(?:equation |tag\{)(5\.\d)", text, re.IGNORECASE))


@pytest.mark.parametrize("exercise", read_public(NAME).exercises, ids=lambda each: each.name)
def test_the_equations_that_hints_and_messages_name_stand_in_the_exercises_section(exercise):
    before, _ = TEXT.split(f":exercise: {exercise.name}\n")
    section = before[before.rindex("\n## ") :]
    said = " ".join([*exercise.hints, *(each.message for each in exercise.mistakes)])
    assert equations(said) <= equations(section)
