"""The hidden cases of exercise 1.2 reject noise around the mean, also from a function that samples single pixels."""

from functools import partial

import numpy as np
import pytest

from nao_course.exercises import judging
from nao_course.exercises.running import call_all
from nao_course.instructor.authoring.plans import hidden_cases
from tests.lessons.every import COURSE, reference

LESSON = "01_hsl_filtering"


def mean_and_noise(lightness, n_samples, rng):
    if n_samples == 1:
        return float(rng.choice(lightness.ravel()))
    return lightness.mean() + rng.normal(0, lightness.std() / np.sqrt(n_samples))


def verdicts(function, seed):
    exercise = COURSE.plan(LESSON)["average_lightness"]
    cases = hidden_cases(exercise, reference(LESSON)[exercise.name], seed)
    outcomes = call_all(function, cases, exercise.driver, 30, partial(judging.answer, exercise.comparison))
    return [bool(judging.judge(exercise.comparison, *each)) for each in zip(cases, outcomes, strict=True)]


@pytest.mark.parametrize("seed", range(3))
def test_a_mean_with_noise_loses_the_case_of_two_pixels(seed):
    assert all(verdicts(reference(LESSON)["average_lightness"], seed))
    assert verdicts(mean_and_noise, seed) == [True, True, True, False, True]
