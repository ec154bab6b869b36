"""The challenge of lesson 08: gains agree with the inverse, and wrong answers get a message."""

import numpy as np
import pytest

from benchmarks.challenges.measurement_choice import CHOICE_ENTRIES
from nao_course.challenges.running import run
from nao_course.lessons.graph_slam.challenge import CHALLENGE, judge, make_graph

GRAPH = make_graph(3)


def after(graph, chosen):
    pose, landmark, epsilon = graph.candidates[chosen]
    row = np.zeros(len(graph.xi))
    row[pose], row[landmark] = -1.0, 1.0
    return np.linalg.inv(graph.omega + np.outer(row, row) / epsilon)


def test_a_candidates_gain_is_how_much_the_sum_of_variances_falls():
    before = np.trace(np.linalg.inv(GRAPH.omega))
    gains = [before - np.trace(after(GRAPH, chosen)) for chosen in range(len(GRAPH.candidates))]
    assert GRAPH.gains() == pytest.approx(np.array(gains))
    assert GRAPH.worst_after(7) == pytest.approx(np.sqrt(np.diag(after(GRAPH, 7)).max()))


def test_the_best_choice_scores_one_and_none_scores_nothing():
    best = int(np.argmax(GRAPH.gains()))
    assert judge(best, GRAPH).score == judge(np.int64(best), GRAPH).score == 1.0
    none = judge(-1, GRAPH)
    assert none.score == 0.0 and none.columns["better candidates"] == len(GRAPH.candidates)


def test_graphs_differ_are_held_and_can_be_made_again():
    graphs = [make_graph(seed) for seed in CHALLENGE.seeds]
    assert len({graph.omega.tobytes() for graph in graphs}) == len(graphs) == 40
    assert all(np.linalg.eigvalsh(graph.omega)[0] > 0 for graph in graphs)
    assert (make_graph(3).omega == GRAPH.omega).all() and make_graph(3).candidates == GRAPH.candidates


def test_rules_by_one_quantity_fail_and_the_figure_counts_the_best_choices():
    *naive, best = (run(CHALLENGE, entry) for entry in CHOICE_ENTRIES.values())
    assert max(each.score for each in naive) < 0.5 and best.score == pytest.approx(1.0)
    assert "the best candidate in 40 of them" in CHALLENGE.figure(best).alt
