"""False closures bend a building, and the kernel does not mind them where it begins on odometry; the sheet."""

import numpy as np

from nao_course.lessons.pose_graphs import landmark_sheet
from nao_course.lessons.pose_graphs.robust import (
    draw_false_closures,
    edge_weights,
    errors_by_false_closures,
    robust_gauss_newton,
)
from nao_course.lessons.pose_graphs.worlds import building, with_false_closures
from tests.lessons.every import text
from tests.lessons.pose_graphs.own import OWN

SOLVE, REWEIGHT = OWN["gauss_newton"], OWN["reweight"]


def test_the_kernel_lets_false_closures_go_and_keeps_true_ones():
    world = with_false_closures(building(1, 150), 10, 1)
    states = robust_gauss_newton(SOLVE, REWEIGHT, world.graph, world.odometry)
    weights = edge_weights(REWEIGHT, world.graph, states)
    assert weights[-10:].max() < 0.01
    assert np.median(weights[:-10]) > 0.5


def test_false_closures_bend_a_map_and_the_kernel_does_not_mind():
    found = errors_by_false_closures(SOLVE, REWEIGHT, (0, 10), (1, 2), 150)
    assert found.robust.max() < 0.5
    assert (found.plain[1] > 3 * found.robust[1]).all()
    assert np.array_equal(found.odometry[0], found.odometry[1])
    alt = draw_false_closures(SOLVE, REWEIGHT, found).alt
    assert "A building with 20 false loop closures" in alt and "; 10: " in alt


def test_derivatives_by_delta_x_and_delta_y_are_right_on_the_sheet_and_the_lessons_cells_have_no_symbols():
    right = ["-cos(theta)", "-sin(θ)*Δx + cos(θ)*Δy"], ["sin(theta)", "-cos(theta)*dx - sin(theta)*dy"]
    assert "All 4 entries are correct." in repr(landmark_sheet().write([*right]))
    wrong = [right[0], [right[1][0], "cos(theta)*dx + sin(theta)*dy"]]
    assert "left by theta: its sign is wrong" in repr(landmark_sheet().write(wrong))
    assert "sympy" not in text("09") and "symbols(" not in text("09")
