"""Intervals are judged by their ends over several generators, and resampling shows what other pictures would change."""

import numpy as np
import pytest

from nao_course.lessons.experiments import resampling
from nao_course.lessons.experiments.intervals import SEEDS, Interval, each_once, with_generators
from nao_course.lessons.experiments.paper_table import PAPER_MEANS, PAPER_SIGMAS, SETTINGS
from nao_course.metrics import mean_interval
from tests.lessons.experiments.own import OWN, table

VALUES = np.random.default_rng(8).exponential(2.0, 25)
RIGHT = with_generators(OWN["bootstrap_interval"], VALUES, 0.9)


def drawn(function):
    return with_generators(function, VALUES, 0.9)


def judged(function):
    return Interval().compare(RIGHT, drawn(function))


def means(shape, axis):
    """Return a bootstrap whose draws have another shape."""

    def interval(v, p, rng):
        return np.quantile(rng.choice(v, shape).mean(axis=axis), [0.05, 0.95])

    return interval


def test_the_references_interval_is_right_and_is_scipys_and_equal_values_have_one_without_a_width():
    assert SEEDS[0] == SEEDS[-1] and len(set(SEEDS)) > 3  # the first generator comes again
    assert judged(OWN["bootstrap_interval"])
    assert judged(lambda values, probability, rng: mean_interval(rng.permutation(values), probability))
    same = with_generators(OWN["bootstrap_interval"], np.full(5, 2.5), 0.9)
    assert Interval().compare(same, same)


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda v, p, rng: None, "None"),
        (lambda v, p, rng: (1.0, 2.0, 3.0), r"shape (3,)"),
        (lambda v, p, rng: (np.nan, 2.0), "NaN"),
        (lambda v, p, rng: mean_interval(v, p), "same for every rng"),
        (lambda v, p, rng: OWN["bootstrap_interval"](v, p, np.random.default_rng()), "same rng"),
        (lambda v, p, rng: OWN["bootstrap_interval"](v, p, rng)[::-1], "above the upper"),
        (lambda v, p, rng: OWN["bootstrap_interval"](v, 0.8, rng), "is too high"),
        (lambda v, p, rng: np.full(2, rng.choice(v, (2000, len(v))).mean()), "ends of your interval are"),
        (means((25, 2000), axis=1), "times too narrow"),
        (lambda v, p, rng: OWN["bootstrap_interval"](v, 0.99, rng), "is too low"),
        (means((100, 25), axis=1), "vary too much between generators; draw at least 2000"),
    ],
)
def test_what_is_wrong_is_named(answer, said):
    verdict = judged(answer)
    assert not verdict and said in verdict.text


def test_a_number_of_hits_occurs_once_and_a_mask_is_no_list_of_numbers():
    assert each_once((), {}, np.array([1, 4, 7])) == each_once((), {}, np.array([True, True])) == ""
    assert "several times" in each_once((), {}, [1, 4, 4])


def test_a_mistake_is_recognised_by_its_ends_if_it_is_drawn_and_else_by_its_digits():
    """A generator of one's own with a seed was told that its ends are a normal curve's."""
    wide = drawn(lambda v, p, rng: OWN["bootstrap_interval"](v, 0.99, rng))
    again = drawn(lambda v, p, rng: np.add(OWN["bootstrap_interval"](v, 0.99, rng), 1e-3))
    assert Interval().alike(wide, again) and not Interval().alike(wide, RIGHT)
    seeded = drawn(lambda v, p, rng: OWN["bootstrap_interval"](v, p, np.random.default_rng(1)))
    half = 1.645 * VALUES.std() / 5
    normal, near = (
        drawn(lambda v, p, rng, part=part: (v.mean() - part * half, v.mean() + part * half))
        for part in (1, 1.01)
    )
    assert Interval().alike(normal, near) and not Interval().alike(normal, seeded)


def test_the_papers_table_has_27_rows_and_a_students_table_is_sorted_by_its_means():
    assert len(PAPER_MEANS) == len(PAPER_SIGMAS) == 27 and list(PAPER_MEANS) == list(SETTINGS)
    assert min(PAPER_MEANS, key=PAPER_MEANS.get) == (120, 5, 40) and PAPER_MEANS[120, 5, 40] == 2.122
    assert PAPER_SIGMAS[120, 5, 40] == 0.322 and PAPER_MEANS[130, 7, 50] == 5.103
    assert list(resampling.as_table({(1, 2, 3): [4.0, 6.0], (4, 5, 6): [1.0, 2.0]})) == [(4, 5, 6), (1, 2, 3)]
    for wrong in (None, {}, [1.0], {(1, 2, 3): 1.0}, {(1, 2, 3): [1.0], (4, 5, 6): [1.0, 2.0]}):
        with pytest.raises((TypeError, ValueError), match="grid_search|one cost per scene"):
            resampling.as_table(wrong)
    for factor, rho in ((2, 1.0), (-1, -1.0)):
        other = {key: factor * mean for key, mean in PAPER_MEANS.items()}
        assert resampling.rank_correlation(PAPER_MEANS, other) == pytest.approx(rho)


def test_a_setting_that_is_far_better_wins_every_draw_and_the_best_of_noise_promises_more_than_it_keeps():
    shares = resampling.shares_won(table())
    assert shares[SETTINGS[0]] == 1.0 and sum(shares.values()) == pytest.approx(1.0)
    costs = np.array(list(table().values()))
    assert resampling.called_different(costs, np.random.default_rng(0)) == 26  # the first is far better
    rng = np.random.default_rng(1)
    found = resampling.placebo({key: rng.normal(2, 1, 30) for key in SETTINGS}, runs=20)
    assert found.shape == (20,) and 3 < found.mean() < 20
    rng = np.random.default_rng(1)
    noise = resampling.optimism({key: rng.normal(2, 1, 400) for key in SETTINGS})
    assert noise.promised.mean() < 1.93 and noise.kept.mean() == pytest.approx(noise.any_setting, abs=0.06)
    real = resampling.optimism(table())
    assert real.kept.mean() == pytest.approx(real.promised.mean(), abs=0.05)
