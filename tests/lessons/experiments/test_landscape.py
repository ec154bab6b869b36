"""Figures of 27 costs say their numbers."""

import numpy as np
import pytest

from nao_course.exercises import try_out
from nao_course.lessons.experiments import landscape
from nao_course.lessons.experiments.reading import draw_agreement
from nao_course.metrics import mean_interval
from tests.lessons.every import blank
from tests.lessons.experiments.own import table


def interval(values, probability, rng):
    return mean_interval(values, probability)


@pytest.fixture(autouse=True)
def _few_scenes(monkeypatch):
    monkeypatch.setattr(landscape, "simulated_scenes", lambda: [(None, np.zeros((2, 2)))] * 30)


def noise():
    """Return a table whose best setting is no better than the others."""
    costs = table()
    costs[110, 4, 30] = costs[110, 4, 30] + 3.0
    return costs


def test_the_landscape_says_the_best_setting_and_the_payoff_searches_all_27():
    alt = landscape.draw_landscape(table(), interval).alt
    assert "yours from -1." in alt and "at 110, 4, 30" in alt and "nothing costs 2.00" in alt
    assert "Of 0 of the other 26" in alt
    tied = int(landscape.draw_landscape(noise(), interval).alt.split("Of ")[-1].split()[0])
    assert 10 < tied < 27
    asked = []

    def grid_search(scenes, *values):
        asked.append(values)
        return {key: costs[: len(scenes)] for key, costs in table().items()}

    landscape.draw_payoff(grid_search, interval)
    assert asked == [([110, 120, 130], [4, 5, 7], [30, 40, 50])] * 30


def test_without_a_table_each_figure_says_what_the_search_said():
    """It said "AttributeError: 'Message' object has no attribute 'items'", and the like."""

    missing = try_out(blank, "Finish exercise 10.3 to search.")
    for show in (
        landscape.best_settings,
        landscape.draw_beside_paper,
        lambda it: landscape.draw_landscape(it, interval),
        landscape.draw_winners,
        landscape.draw_optimism,
        landscape.broken_promise,
        draw_agreement,
    ):
        assert repr(try_out(lambda show=show: show(missing))) == "Finish exercise 10.3 to search."


@pytest.mark.slow
def test_the_papers_sigmas_winners_and_broken_promises_are_said():
    alt = landscape.draw_beside_paper(table()).alt
    assert "the paper's is from 0.32 to 2.63" in alt and "rank correlation" in alt
    assert "of the mean from 0.1" in alt
    alt = landscape.draw_winners(table()).alt
    assert "110, 4, 30: 100 %" in alt and "In 200 placebo tables of equal settings" in alt
    assert "in your table 26." in alt
    assert "divided into halves 1000 times" in landscape.draw_optimism(table()).alt
    assert landscape.broken_promise(noise()) > 0.3 > landscape.broken_promise(table())
