"""What other pictures would have changed: winners, broken promises, and what is no table."""

import numpy as np
import pytest

from nao_course.lessons.experiments import resampling
from nao_course.lessons.experiments.paper_table import PAPER_MEANS, PAPER_SIGMAS, SETTINGS
from tests.lessons.experiments.own import table


def test_the_papers_table_has_27_rows_with_its_best_in_the_middle():
    assert len(PAPER_MEANS) == len(PAPER_SIGMAS) == 27 and list(PAPER_MEANS) == list(SETTINGS)
    assert min(PAPER_MEANS, key=PAPER_MEANS.get) == (120, 5, 40) and PAPER_MEANS[120, 5, 40] == 2.122
    assert PAPER_SIGMAS[120, 5, 40] == 0.322 and PAPER_MEANS[130, 7, 50] == 5.103


def test_a_setting_that_is_far_better_wins_every_draw_and_equal_ones_are_often_called_different():
    shares = resampling.shares_won(table())
    assert shares[SETTINGS[0]] == 1.0 and sum(shares.values()) == pytest.approx(1.0)
    costs = np.array(list(table().values()))
    assert resampling.called_different(costs, np.random.default_rng(0)) == 26  # the first is far better
    rng = np.random.default_rng(1)
    found = resampling.placebo({key: rng.normal(2, 1, 30) for key in SETTINGS}, runs=20)
    assert found.shape == (20,) and 3 < found.mean() < 20


def test_the_best_of_noise_promises_more_than_it_keeps_and_a_real_best_does_not():
    rng = np.random.default_rng(1)
    noise = resampling.optimism({key: rng.normal(2, 1, 400) for key in SETTINGS})
    assert noise.promised.mean() < 1.93 and noise.kept.mean() == pytest.approx(noise.any_setting, abs=0.06)
    real = resampling.optimism(table())
    assert real.kept.mean() == pytest.approx(real.promised.mean(), abs=0.05)


def test_a_students_table_is_sorted_by_its_means_and_what_is_no_table_is_said():
    assert list(resampling.as_table({(1, 2, 3): [4.0, 6.0], (4, 5, 6): [1.0, 2.0]})) == [(4, 5, 6), (1, 2, 3)]
    for wrong in (None, {}, [1.0], {(1, 2, 3): 1.0}, {(1, 2, 3): [1.0], (4, 5, 6): [1.0, 2.0]}):
        with pytest.raises((TypeError, ValueError), match="grid_search|one cost per scene"):
            resampling.as_table(wrong)


def test_tables_that_order_settings_alike_correlate():
    for factor, rho in ((2, 1.0), (-1, -1.0)):
        other = {key: factor * mean for key, mean in PAPER_MEANS.items()}
        assert resampling.rank_correlation(PAPER_MEANS, other) == pytest.approx(rho)
