"""Lesson 09's challenge of false closures, and the kernel that is robust to them."""

import numpy as np
import pytest

from benchmarks.challenges.false_closures import FALSE_CLOSURE_ENTRIES, plain
from nao_course.lessons.pose_graphs import landmark_sheet, robust
from nao_course.lessons.pose_graphs.challenge import closure_squares, judge, make_graph
from nao_course.lessons.pose_graphs.worlds import building, position_error, with_false_closures
from tests.lessons.every import text
from tests.lessons.pose_graphs.own import OWN

CASE = make_graph(8)


def test_twenty_closures_are_false_and_mixed_and_the_true_ones_fit_the_truth():
    closing, squares = CASE.world.closures(), closure_squares(CASE.world, CASE.world.truth)
    true = closing & ~CASE.false
    assert (CASE.false.sum(), true.sum()) == (20, 24) and not (CASE.false & ~closing).any()
    assert squares[true].max() < 25 < squares[CASE.false].min()
    assert not np.array_equal(np.flatnonzero(CASE.false), np.flatnonzero(closing)[-20:])
    first, second = CASE.world.graph.edges[CASE.false].T
    runs = sum(  # false closures that follow each other agree
        ((first + 2 == late) & (second + 2 == early)).any() for late, early in zip(first, second, strict=True)
    )
    assert runs == 4 + 3 + 2 + 1


def test_the_truth_scores_nothing_wrong_wherever_it_is_put_down_and_plain_gauss_newton_much():
    perfect = judge(CASE.world.truth, CASE)
    assert perfect.score == pytest.approx(0.0, abs=1e-9) and perfect.columns["false accepted"] == 0.0
    poses = CASE.world.truth.reshape(-1, 3)
    turned = np.column_stack([-poses[:, 1] + 4.0, poses[:, 0] - 2.0, poses[:, 2] + np.pi / 2])
    assert judge(turned.ravel(), CASE).score == pytest.approx(0.0, abs=1e-9)
    wrong = position_error(CASE.world, CASE.world.odometry)
    assert judge(CASE.world.odometry, CASE).score == pytest.approx(wrong)
    graph, states = CASE.world.graph, CASE.world.odometry
    better = judge(list(FALSE_CLOSURE_ENTRIES.values())[-1](graph, states), CASE)
    believing = judge(plain(graph, states), CASE)
    assert better.score < 2.0 < 10.0 < believing.score
    assert better.columns["false accepted"] == 0.0 < believing.columns["false accepted"]


SOLVE, REWEIGHT = OWN["gauss_newton"], OWN["reweight"]


def test_false_closures_bend_a_map_and_the_kernel_lets_them_go_and_keeps_true_ones():
    world = with_false_closures(building(1, 150), 10, 1)
    states = robust.robust_gauss_newton(SOLVE, REWEIGHT, world.graph, world.odometry)
    weights = robust.edge_weights(REWEIGHT, world.graph, states)
    assert weights[-10:].max() < 0.01
    assert np.median(weights[:-10]) > 0.5
    found = robust.errors_by_false_closures(SOLVE, REWEIGHT, (0, 10), (1, 2), 150)
    assert found.robust.max() < 0.5
    assert (found.plain[1] > 3 * found.robust[1]).all()
    assert np.array_equal(found.odometry[0], found.odometry[1])
    alt = robust.draw_false_closures(SOLVE, REWEIGHT, found).alt
    assert "A building with 20 false loop closures" in alt and "; 10: " in alt


def test_derivatives_by_delta_x_and_delta_y_are_right_on_the_sheet_and_the_lessons_cells_have_no_symbols():
    right = ["-cos(theta)", "-sin(θ)*Δx + cos(θ)*Δy"], ["sin(theta)", "-cos(theta)*dx - sin(theta)*dy"]
    assert "All 4 entries are correct." in repr(landmark_sheet().write([*right]))
    wrong = [right[0], [right[1][0], "cos(theta)*dx + sin(theta)*dy"]]
    assert "left by theta: its sign is wrong" in repr(landmark_sheet().write(wrong))
    assert "sympy" not in text("09") and "symbols(" not in text("09")
