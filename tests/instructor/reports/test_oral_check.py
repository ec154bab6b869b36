"""Questions for a short talk are about the student's own code, own results and own words, and the same each time."""

import json
import random

import pytest

from nao_course.exercises.exercise import Question
from nao_course.instructor.reports.oral_check import changed_line, oral_check, oral_page, results_shown
from tests.pages import HOSTILE, Page, answer, exercise, result

CODE = '''def turn(angle, step):
    """Turn by a step.

    Both are in radians."""
    # my own remark
    if angle < 0:
        angle = -angle
    return (angle
            + step)
'''
QUESTION = Question("why", "Which way?", {"left": "No.", "right": "The `x` axis."}, "right")


def notebook(*outputs, source="turn(1, 2)", role="display"):
    cell = {"cell_type": "code", "metadata": {"nao_course": {"role": role}}, "source": source}
    return json.dumps({"cells": [cell | {"outputs": list(outputs)}], "nbformat": 4}).encode()


def returned(text):
    return {"output_type": "execute_result", "data": {"text/plain": text}}


SHOWN = notebook(returned("12 cm"))


@pytest.fixture
def asked():
    """Return a function that makes the questions about a submission of one exercise."""

    def ask(*parts, code=CODE, shown=SHOWN, questions=(QUESTION,), **fields):
        made = result("ada", *(parts or (exercise(name="turn"), answer(text="It turns."))), **fields)
        return oral_check(made, {"turn": code}.get, shown, questions)

    return ask


def test_one_line_of_the_students_own_text_is_changed_and_each_submission_has_its_own_choice():
    found = {changed_line("turn", CODE, random.Random(seed)) for seed in range(50)}
    lines = {
        (each.first, each.last): {one.after for one in found if one.first == each.first} for each in found
    }
    assert lines == {(6, 6): {"if angle <= 0:"}, (7, 7): {"angle = angle"}, (8, 9): {"return angle - step"}}
    assert all(each.code == CODE for each in found)


@pytest.mark.parametrize(
    "code", ["", "def turn(:", "def turn(angle):\n    return angle", "x = 1 + 1\n" * 2000]
)
def test_code_in_which_no_line_can_be_changed_is_not_asked_about(code, asked):
    assert changed_line("turn", code, random.Random(1)) is None
    assert asked(code=code).count == 2


def test_the_same_submission_has_the_same_questions_and_another_one_may_have_others(asked):
    assert len({asked(submission="s").changed for _ in range(9)}) == 1
    assert len({asked(submission=f"{number}").changed for number in range(20)}) > 1


def test_exercises_with_the_most_points_are_asked_about():
    parts = [
        exercise(name=name, number="1", points=4.0, earned=earned)
        for name, earned in zip("abc", (1, 4, 2), strict=True)
    ]
    check = oral_check(result("ada", *parts), lambda name: CODE.replace("turn", name), b"", ())
    assert [each.exercise for each in check.changed] == ["b", "c"] and check.count == 2


@pytest.mark.parametrize(
    ("shown", "texts"),
    [
        (notebook(returned("Drawing('12 cm, \\'x\\'.')")), ["12 cm, 'x'."]),
        (notebook({"output_type": "stream", "text": ["error ", "3.5\n"]}), ["error 3.5"]),
        (notebook(returned("x" * 500 + "1"), returned("1" * 500)), ["1" * 400 + " [...]"]),
        (notebook(returned("no number")), []),
        (notebook(returned("12"), source="other_turn(1)"), []),
        (notebook(returned("all 12 checks pass"), role="check"), []),
        (notebook({"output_type": "error", "text": "line 12"}), []),
        (notebook(returned("12"))[:-9], []),
        (notebook(returned("Drawing('12' cm)")), []),
        (
            b'{"cells": [{"outputs": 3, "source": "turn", "metadata": {"nao_course": {"role": "display"}}}]}',
            [],
        ),
        (b"[]", []),
    ],
)
def test_a_result_is_a_number_below_a_cell_that_uses_an_exercise(shown, texts):
    cut = [text if len(text) < 480 else text[:400] + " [...]" for text in results_shown(shown, ["turn"])]
    assert cut == texts
    assert results_shown(shown, []) == []


def test_the_reason_is_asked_about_the_students_words_or_else_about_a_question_of_the_lesson(asked):
    assert asked().written.text == "It turns." and asked().question is None
    unwritten = asked(exercise(name="turn"), answer(text=" "))
    assert unwritten.written is None and unwritten.question is QUESTION and unwritten.count == 3
    assert asked(exercise(name="turn"), questions=()).count == 2


def test_the_page_shows_the_code_with_the_line_marked_and_the_rubric_and_escapes_what_is_hostile(asked):
    page = Page(oral_page("01_hsl_filtering", [asked(), asked(exercise(name="turn"))]))
    assert page.offences() == [] and page.tags.count("mark") == 2 and page.tags.count("ol") == 2
    assert "What happens, and for which inputs?" in page.text and "You wrote: It turns." in page.text
    assert "my own remark" in page.text and "For you: right The x axis." in page.text
    for text in HOSTILE:
        check = asked(
            exercise(name="turn"),
            answer(text=text),
            code=f"def turn(x):\n    return x + 1  # {text!r}",
            shown=notebook(returned(text + "1")),
        )
        assert Page(oral_page("01_hsl_filtering", [check])).offences() == []
    assert "nothing to ask about" in oral_page("01", [asked(exercise(name="other"), questions=(), shown=b"")])
