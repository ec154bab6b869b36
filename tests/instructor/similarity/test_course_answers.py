"""Whoever hands in the course's own answers is listed, and no independent right answer is taken for one of them."""

import pytest

from benchmarks.course.similar import CHANGES
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.similarity.comparing import Work
from nao_course.instructor.similarity.course_answers import LEAST_PART, course_answers, same_words
from nao_course.instructor.similarity.known_code import given_code, model_answers, right_answers
from tests.paths import PROJECT

COURSE = load_course(PROJECT)
MANY = pytest.param(None, marks=pytest.mark.slow)  # all lessons


@pytest.fixture(params=["02_goalposts", "08_graph_slam", MANY])
def lessons(request):
    return [request.param] if request.param else COURSE.names()


def test_independent_right_answers_are_not_the_courses(lessons):
    for lesson in lessons:
        answers, given = right_answers(COURSE, lesson), given_code(COURSE, lesson)
        for number in range(max(map(len, answers.values()))):
            one = Work("ada", tuple(codes[number] for codes in answers.values() if number < len(codes)))
            others = {name: codes[:number] + codes[number + 1 :] for name, codes in answers.items()}
            assert course_answers([one], others, given) == []


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_copy_of_the_reference_is_the_courses_and_a_part_of_it_from_half_on(change):
    answers, given = right_answers(COURSE, "08_graph_slam"), given_code(COURSE, "08_graph_slam")
    codes = [change(codes[0]) for codes in answers.values()]
    (found,) = course_answers([Work("ada", tuple(codes)), Work("ben", tuple(given))], answers, given)
    assert found.student == "ada" and len(found.exercises) >= LEAST_PART * found.of and found.of == 5
    (alternative,) = course_answers(
        [Work("ada", tuple(codes[1] for codes in answers.values()))], answers, given
    )
    assert len(alternative.exercises) >= 3
    few = {name: codes for name, codes in answers.items() if name in found.exercises[:1]}
    assert course_answers([Work("ada", tuple(codes[0] for codes in few.values()))], answers, given) == []


@pytest.mark.slow
def test_in_how_many_lessons_a_changed_copy_of_the_reference_is_listed():
    listed = dict.fromkeys(CHANGES, 0)
    for lesson in COURSE.names():
        answers, given = right_answers(COURSE, lesson), given_code(COURSE, lesson)
        for name, change in CHANGES.items():
            work = Work("ada", tuple(change(codes[0]) for codes in answers.values()))
            listed[name] += bool(course_answers([work], {k: v[:1] for k, v in answers.items()}, given))
    assert listed == {"renamed": 12, "reformatted": 11, "reordered": 7, "all three": 4}


WORDS = "The hue stays the same when a lamp is dimmed, because all channels shrink together."


@pytest.mark.parametrize(
    ("other", "is_same"),
    [
        (WORDS, True),
        (WORDS.upper().replace(",", ""), True),
        (WORDS.replace("a lamp", "the lamp"), True),
        (f"{WORDS} I think.", True),
        (
            "Dimming a lamp changes all three channels by the same factor, and the hue does not depend on it.",
            False,
        ),
        ("", False),
    ],
)
def test_answers_with_nearly_the_same_words_are_one_group(other, is_same):
    found = same_words({"ada": {"why": WORDS}, "ben": {"why": other}, "cleo": {"how": WORDS}}, {})
    assert [each.students for each in found] == ([("ada", "ben")] if is_same else [])


def test_the_model_answer_is_named_and_few_words_or_another_question_are_no_copy():
    written = {"ada": {"why": WORDS}, "ben": {"why": "I do not know."}, "cleo": {"why": "I do not know."}}
    (found,) = same_words(written, {"why": WORDS, "how": "I do not know."})
    assert (found.students, found.is_model, found.text) == (("ada",), True, WORDS)
    assert same_words(written, {"how": WORDS}) == []


def test_every_written_question_of_the_course_has_a_model_answer_that_can_be_recognised():
    models = {name: model_answers(COURSE, name) for name in COURSE.names()}
    assert sum(map(len, models.values())) >= 10
    for of_lesson in models.values():
        for question, text in of_lesson.items():
            assert [each.is_model for each in same_words({"ada": {question: text}}, of_lesson)] == [True]
