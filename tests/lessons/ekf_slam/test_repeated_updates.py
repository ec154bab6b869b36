"""Sixty updates: forms that keep the covariance symmetric pass, and forms that amplify rounding errors do not."""

import numpy as np
import pytest

from nao_course.exercises import Mistake
from nao_course.instructor.authoring.mistakes import Change, changed
from nao_course.instructor.authoring.plans import load_plan, load_solution
from nao_course.lessons.ekf_slam.bent_map.runs import run_filter
from nao_course.lessons.ekf_slam.filters.repeated_updates import repeated_updates, stays_symmetric
from tests.paths import SOLUTIONS

SEEDS = range(8)
RETURN = "return state, np.subtract(covariance, reduction, out=reduction) => whole = H @ np.eye(len(state))[columns]"
GAIN = "+ K = covariance @ whole.T @ L_inverse.T @ L_inverse"
KEPT = "(np.eye(len(state)) - K @ whole)"
NEVER_MADE_SYMMETRIC = (
    "covariance - K @ whole @ covariance",
    f"{KEPT} @ covariance",
    "covariance - K @ (whole @ covariance @ whole.T + joint_noise(measurement_covariance, m)) @ K.T",
    f"{KEPT} @ covariance @ {KEPT}.T + K @ joint_noise(measurement_covariance, m) @ K.T",
)


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
        return repeated_updates(function, *case.args)


def test_the_solution_stays_symmetric_to_1e_12_and_every_right_form_agrees_with_it(own, exercise, cases):
    for case in cases:
        state, covariance = after_60(own["update_landmarks"], case)
        assert np.abs(covariance - covariance.T).max() < 1e-12
        for form in exercise.alternatives.values():
            other, covariance_of_form = after_60(form, case)
            assert stays_symmetric(case.args, {}, (other, covariance_of_form)) == ""
            assert other == pytest.approx(state, abs=1e-8)
            assert covariance_of_form == pytest.approx(covariance, abs=2e-9)


def test_a_form_that_amplifies_rounding_errors_fails_after_sixty_updates_and_not_after_one(cases):
    solution = load_solution(SOLUTIONS / "07_ekf_slam.ipynb")
    wrong = [
        changed(
            "update_landmarks", Mistake("", Change((RETURN, GAIN, f"+ return state, {form}")), ""), solution
        )
        for form in NEVER_MADE_SYMMETRIC
    ]
    for case in cases:
        states, covariance, indices, measurements, R = case.args
        first = states[:1], covariance, indices[:1], measurements[:1], R
        for function in wrong:
            assert "transpose" in stays_symmetric(case.args, {}, after_60(function, case))
            assert stays_symmetric(first, {}, repeated_updates(function, *first)) == ""


def test_the_lessons_numbers_for_rounding_errors_hold(own, exercise, cases):
    solution = load_solution(SOLUTIONS / "07_ekf_slam.ipynb")
    functions = own["predict"], own["update_landmarks"], own["add_landmark"]
    (public,) = [case for case in exercise.public() if np.ndim(case.args[0]) == 2]
    right, symmetric = after_60(own["update_landmarks"], public)[1], run_filter(functions).landmarks
    for form in NEVER_MADE_SYMMETRIC:
        change = Change((RETURN, GAIN, f"+ return state, {form}"))
        function = changed("update_landmarks", Mistake("", change, ""), solution)
        assert 0.01 < np.abs(after_60(function, public)[1] - right).max() <= 2.01
        on_the_drive = run_filter((functions[0], function, functions[2])).landmarks
        assert np.abs(on_the_drive - symmetric).max() < 1e-12


def test_a_filter_that_returns_nan_or_raises_on_the_way_fails_and_one_update_is_an_ordinary_call(cases, own):
    case = cases[0]
    nothing = case.args[0][-1], np.full_like(case.args[1], np.nan)
    assert "infinitely much" in stays_symmetric(case.args, {}, nothing)
    calls = 0

    def raising(state, covariance, *others):
        nonlocal calls
        calls += 1
        if calls > 5:
            raise np.linalg.LinAlgError
        return state, covariance + np.triu(covariance)

    assert stays_symmetric(case.args, {}, repeated_updates(raising, *case.args)) != ""
    state, P = np.array([0.0, 0.0, 0.0, 2.0, 0.0]), np.diag([0.01, 0.01, 0.0, 0.03, 0.01])
    z, R = np.array([0.0, 2.5]), np.eye(2) * 0.01
    called = repeated_updates(own["update_landmarks"], state, P, [0], z, R)
    plain = own["update_landmarks"](state, P, [0], z, R)
    assert all(np.array_equal(one, other) for one, other in zip(called, plain, strict=True))
    assert stays_symmetric((state,), {}, (state, np.triu(np.ones((5, 5))))) == ""
