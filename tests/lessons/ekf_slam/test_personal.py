"""The personal robot: other numbers for each student, and the same for all right functions."""

import numpy as np
import pytest

from nao_course._internal.personal_world import PersonalWorld
from nao_course.instructor.authoring.plans import load_plan, load_solution
from nao_course.lessons.ekf_slam.evaluation import (
    LARGEST,
    SMALLEST,
    personal_distances,
    personal_numbers,
    personal_sigmas,
    personal_table,
)
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS
from tests.paths import SOLUTIONS


@pytest.fixture(scope="module")
def functions():
    solution = load_solution(SOLUTIONS / "07_ekf_slam.ipynb")
    return [solution[name] for name in ("init_landmarks", "predict", "update", "evaluate_landmarks")]


@pytest.mark.slow
def test_no_two_students_of_a_small_class_have_the_same_numbers(functions):
    found = {
        tuple(np.round(list(personal_numbers(PersonalWorld(f"s{n}"), *functions).values()), 3))
        for n in range(30)
    }
    assert len(found) == 30


def test_the_table_ends_with_the_numbers_that_the_marker_gets(functions):
    world = PersonalWorld("ada")
    euclidean, mahalanobis = personal_numbers(world, *functions).values()
    text = str(personal_table(world, *functions))
    assert text.splitlines()[-1].split() == ["all", "five", f"{euclidean:.3f}", f"{mahalanobis:.2f}"]
    assert "robot of ada" in text


def test_a_right_filter_of_another_form_has_the_same_numbers_and_one_without_gain_others(functions):
    alternatives = load_plan(SOLUTIONS / "exercises" / "07_ekf_slam.py")["update"].alternatives
    world = PersonalWorld("bob")
    for update in alternatives.values():
        others = personal_distances(world, *functions[:2], update, functions[3])
        assert np.allclose(others, personal_distances(world, *functions), rtol=1e-6)
    world = PersonalWorld("bob")
    others = personal_distances(world, *functions[:2], lambda state, P, *rest: (state, P), functions[3])
    assert not np.allclose(others, personal_distances(world, *functions), rtol=0.05)


@pytest.mark.slow
def test_the_errors_of_the_robots_stay_in_the_range_where_the_filter_is_consistent(functions):
    means = []
    for n in range(40):
        world = PersonalWorld(f"student {n}")
        sigmas = personal_sigmas(world)
        for name in ("turn", "bearing"):
            assert SMALLEST <= getattr(sigmas, name) / getattr(OWN_SIGMAS, name) <= LARGEST
        means.append(personal_numbers(world, *functions)["mean Mahalanobis distance"])
    assert np.mean(means) == pytest.approx(1.25, abs=0.15)
