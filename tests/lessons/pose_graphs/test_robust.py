"""False closures bend a building; the kernel does not mind them where it begins on odometry."""

from __future__ import annotations

import numpy as np
import pytest

from nao_course.exercises import Definitions
from nao_course.instructor.authoring.plans import load_solution
from nao_course.lessons.pose_graphs.robust import (
    draw_false_closures,
    edge_weights,
    errors_by_false_closures,
    robust_gauss_newton,
)
from nao_course.lessons.pose_graphs.worlds import building, with_false_closures
from tests.paths import SOLUTIONS


@pytest.fixture(scope="module")
def own() -> Definitions:
    return load_solution(SOLUTIONS / "09_pose_graphs.ipynb")


def test_the_kernel_lets_false_closures_go_and_keeps_true_ones(own: Definitions) -> None:
    world = with_false_closures(building(1, 150), 10, 1)
    states = robust_gauss_newton(own["gauss_newton"], own["reweight"], world.graph, world.odometry)
    weights = edge_weights(own["reweight"], world.graph, states)
    assert weights[-10:].max() < 0.01
    assert np.median(weights[:-10]) > 0.5


def test_false_closures_bend_a_map_and_the_kernel_does_not_mind(own: Definitions) -> None:
    found = errors_by_false_closures(own["gauss_newton"], own["reweight"], (0, 10), (1, 2), 150)
    assert found.robust.max() < 0.5
    assert (found.plain[1] > 3 * found.robust[1]).all()
    assert np.array_equal(found.odometry[0], found.odometry[1])
    alt = draw_false_closures(own["gauss_newton"], own["reweight"], found).alt
    assert "A building with 20 false loop closures" in alt and "; 10: " in alt
