"""Sixty looks: what stays symmetric passes; a filter that would end a long drive in nonsense does not."""

import numpy as np
import pytest

from nao_course.instructor.authoring.plans import load_plan
from nao_course.lessons.ekf_slam.filters.many_looks import even_after_all, look_after_look
from tests.paths import SOLUTIONS

SEEDS = range(8)


@pytest.fixture(scope="module")
def exercise():
    plan = load_plan(SOLUTIONS / "exercises" / "07_ekf_slam.py")
    return next(each for each in plan.exercises if each.name == "update_landmarks")


@pytest.fixture(scope="module")
def cases(exercise):
    drawn = [exercise.hidden(np.random.default_rng(seed))[-1] for seed in SEEDS]
    assert all(np.ndim(case.args[0]) == 2 for case in drawn)
    return drawn


def after_60(function, case):
    with np.errstate(all="ignore"):
        return look_after_look(function, *case.args)


def test_the_solution_stays_symmetric_to_1e_12_and_every_right_form_agrees_with_it(own, exercise, cases):
    for case in cases:
        state, covariance = after_60(own["update_landmarks"], case)
        assert np.abs(covariance - covariance.T).max() < 1e-12
        for form in exercise.alternatives.values():
            other, spread = after_60(form, case)
            assert even_after_all(case.args, {}, (other, spread)) == ""
            assert other == pytest.approx(state, abs=1e-8) and spread == pytest.approx(covariance, abs=2e-9)


def test_a_form_that_lets_rounding_grow_is_told_after_sixty_looks_and_not_after_one(exercise, cases):
    wrong = [each.function for each in exercise.mistakes if each.name.endswith("never made symmetric")]
    assert len(wrong) == 4
    for case in cases:
        states, covariance, indices, measurements, R = case.args
        first = states[:1], covariance, indices[:1], measurements[:1], R
        for function in wrong:
            assert "differs from its transpose" in even_after_all(case.args, {}, after_60(function, case))
            assert even_after_all(first, {}, look_after_look(function, *first)) == ""


def test_a_filter_that_has_no_number_left_or_raises_on_the_way_is_lopsided_too(cases):
    case = cases[0]
    nothing = case.args[0][-1], np.full_like(case.args[1], np.nan)
    assert "all there is" in even_after_all(case.args, {}, nothing)
    looks = 0

    def raising(state, covariance, *others):
        nonlocal looks
        looks += 1
        if looks > 5:
            raise np.linalg.LinAlgError
        return state, covariance + np.triu(covariance)

    assert even_after_all(case.args, {}, look_after_look(raising, *case.args)) != ""


def test_one_look_is_an_ordinary_call(own):
    state, P = np.array([0.0, 0.0, 0.0, 2.0, 0.0]), np.diag([0.01, 0.01, 0.0, 0.03, 0.01])
    z, R = np.array([0.0, 2.5]), np.eye(2) * 0.01
    called = look_after_look(own["update_landmarks"], state, P, [0], z, R)
    plain = own["update_landmarks"](state, P, [0], z, R)
    assert all(np.array_equal(one, other) for one, other in zip(called, plain, strict=True))
    assert even_after_all((state,), {}, (state, np.triu(np.ones((5, 5))))) == ""
