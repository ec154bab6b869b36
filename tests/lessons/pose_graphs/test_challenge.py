"""The challenge of lesson 09: what is false, what is scored, and what is no answer."""

import numpy as np
import pytest

from benchmarks.challenges.false_closures import FALSE_CLOSURE_ENTRIES, plain
from nao_course.lessons.pose_graphs.challenge import closure_squares, judge, make_graph
from nao_course.lessons.pose_graphs.worlds import position_error

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


def test_the_truth_scores_nothing_wrong_wherever_it_is_put_down():
    perfect = judge(CASE.world.truth, CASE)
    assert perfect.score == pytest.approx(0.0, abs=1e-9) and perfect.columns["false accepted"] == 0.0
    poses = CASE.world.truth.reshape(-1, 3)
    turned = np.column_stack([-poses[:, 1] + 4.0, poses[:, 0] - 2.0, poses[:, 2] + np.pi / 2])
    assert judge(turned.ravel(), CASE).score == pytest.approx(0.0, abs=1e-9)
    wrong = position_error(CASE.world, CASE.world.odometry)
    assert judge(CASE.world.odometry, CASE).score == pytest.approx(wrong)


def test_plain_gauss_newton_believes_what_is_false_and_the_better_entry_does_not():
    graph, states = CASE.world.graph, CASE.world.odometry
    better = judge(list(FALSE_CLOSURE_ENTRIES.values())[-1](graph, states), CASE)
    believing = judge(plain(graph, states), CASE)
    assert better.score < 2.0 < 10.0 < believing.score
    assert better.columns["false accepted"] == 0.0 < believing.columns["false accepted"]
