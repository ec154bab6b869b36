"""Numbers of personal worlds: what a lesson concludes holds in each world, and right functions agree on the numbers."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from nao_course._internal.personal_world import PersonalWorld
from nao_course.exercises.earlier import resolved_by
from nao_course.instructor.authoring.plans import solutions_beside
from nao_course.instructor.commands.personal_numbers import numbers_of
from nao_course.lessons import beyond, distance, hsl_filtering, localization
from nao_course.lessons.distance.personal import personal_landmarks
from nao_course.lessons.hsl_filtering.payoff import GREEN, YELLOW
from nao_course.lessons.hsl_filtering.personal import personal_example
from nao_course.metrics import band
from tests.lessons.every import COURSE, own, quoted_with_the_locked_opencv, quotes, text
from tests.paths import PROJECT

QUESTIONS = {"01": hsl_filtering, "04": distance, "06": localization, "12": beyond}
USED = {
    "01": ("rgb_to_hsl", "hue_mask", "calibrate_hue"),
    "04": ("measurement_covariance",),
    "06": ("localize",),
    "12": ("choose_move",),
}
WORLDS = 20

each_lesson = pytest.mark.parametrize("number", QUESTIONS)


@cache
def numbers(number, student):
    """Return the numbers of a student's world, by the solution."""
    return numbers_of(PersonalWorld(student), QUESTIONS[number].personal_numbers, own(number))


def conclusion_holds(number, found):
    """Return whether the numbers of a world show what the lesson concludes from them."""
    first, second, *third = found.values()
    if number == "01":  # one pixel moves the limit into the carpet's hues
        return first < 70 and second > 120 and third[0] > 35
    if number == "04":  # with zeros, a mean of three ranges seems much more certain than it is
        return first > 1.4 * second
    if number == "06":  # over all drives the filter is consistent, but the means of the drives vary too much
        low, high = band(3, 40)
        return low < first < high and second > 1.1 * np.sqrt(2 * 3 / 30) and third[0] > 0.4
    return second > 1.1 * first and third[0] > 20  # exploring shows more and costs certainty


@quoted_with_the_locked_opencv
@each_lesson
def test_the_lessons_answer_quotes_the_numbers_of_the_example_world(number):
    assert conclusion_holds(number, numbers(number, ""))
    quotes(text(number), *(f"{value:.3f}" for value in numbers(number, "").values()))


@pytest.mark.slow
@each_lesson
def test_the_conclusion_holds_in_each_world_and_no_two_worlds_have_the_same_numbers(number):
    found = [numbers(number, f"student{n}") for n in range(WORLDS)]
    assert all(conclusion_holds(number, each) for each in found)
    assert len({tuple(np.round(list(each.values()), 3)) for each in found}) == WORLDS


@pytest.mark.slow
@each_lesson
def test_right_functions_of_another_form_have_the_same_numbers(number):
    name, compute = *COURSE.names([number]), QUESTIONS[number].personal_numbers
    expected = list(numbers(number, "ada").values())
    with resolved_by(solutions_beside(PROJECT / "solutions" / f"{name}.ipynb")):
        for used in USED[number]:
            for other in COURSE.plan(name)[used].alternatives.values():
                changed = replace(own(number), namespace=own(number).namespace | {used: other})
                found = numbers_of(PersonalWorld("ada"), compute, changed)
                assert list(found.values()) == pytest.approx(expected, rel=2e-6)


def test_a_stray_pixel_is_of_the_carpet_and_another_one_for_each_student():
    examples = [personal_example(PersonalWorld(name)) for name in ("ada", "bob")]
    for pixels, labels, stray in examples:
        assert pixels.shape == (*labels.shape, 3) and labels[stray] == GREEN
        assert (hsl_filtering.without_edges(labels == YELLOW)).sum() > 1000
    assert not np.array_equal(examples[0][0], examples[1][0]) and examples[0][2] != examples[1][2]


def test_a_limit_that_one_pixel_cannot_move_keeps_the_carpet_green():
    functions = own("01")

    def quantiles(hue, saturation, epsilon):
        return tuple(np.quantile(hue[saturation > 0], (0.01, 0.99)))

    found = hsl_filtering.personal_numbers(
        PersonalWorld("ada"), functions["rgb_to_hsl"], functions["hue_mask"], quantiles
    )
    clean, stray, carpet = found.values()
    assert abs(stray - clean) < 0.1 and carpet < 1


def test_the_landmarks_are_in_the_picture_and_with_zeros_nothing_is_gained_by_all_of_r():
    view, measure = distance.usual_view(), own("04")["measurement_covariance"]
    for n in range(100):
        points, tilt_sigma = personal_landmarks(PersonalWorld(f"student{n}"))
        assert view.project(points).min() > 0 and (view.project(points) < view.size).all()
        assert 0.5 < np.degrees(tilt_sigma) < 2

    def blocks(*given):
        return measure(*given) * np.kron(np.eye(3), np.ones((2, 2)))

    whole, zeros = distance.personal_numbers(PersonalWorld("ada"), blocks).values()
    assert whole == pytest.approx(zeros) == pytest.approx(list(numbers("04", "ada").values())[1])


@each_lesson
def test_the_question_has_the_numbers_that_its_cell_shows(number):
    (question,) = (each for each in COURSE.plan(*COURSE.names([number])).written if each.numbers)
    assert question.numbers is QUESTIONS[number].personal_numbers
    assert "tools.personal_numbers" in text(number)
