"""An interval of random draws is judged by its ends over several generators."""

import numpy as np
import pytest

from nao_course.lessons.experiments.intervals import SEEDS, Interval, with_generators
from nao_course.metrics import mean_interval
from tests.lessons.experiments.own import OWN

VALUES = np.random.default_rng(8).exponential(2.0, 25)
RIGHT = with_generators(OWN["bootstrap_interval"], VALUES, 0.9)


def judged(function):
    return Interval().compare(RIGHT, with_generators(function, VALUES, 0.9))


def test_the_references_interval_is_right_and_is_scipys():
    assert judged(OWN["bootstrap_interval"])
    assert judged(lambda values, probability, rng: mean_interval(rng.permutation(values), probability))


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda v, p, rng: None, "None"),
        (lambda v, p, rng: "wide", "two numbers"),
        (lambda v, p, rng: (1.0, 2.0, 3.0), r"shape (3,)"),
        (lambda v, p, rng: (np.nan, 2.0), "NaN"),
        (lambda v, p, rng: mean_interval(v, p), "same for every rng"),
        (lambda v, p, rng: OWN["bootstrap_interval"](v, p, np.random.default_rng()), "same rng"),
        (lambda v, p, rng: OWN["bootstrap_interval"](v, p, rng)[::-1], "above the upper"),
        (lambda v, p, rng: OWN["bootstrap_interval"](v, 0.8, rng), "is too high"),
        (
            lambda v, p, rng: np.full(2, rng.choice(v, (2000, len(v))).mean()),
            "both ends of your interval are equal",
        ),
        (
            lambda v, p, rng: np.quantile(rng.choice(v, (len(v), 2000)).mean(axis=1), [0.05, 0.95]),
            "times too narrow",
        ),
        (lambda v, p, rng: OWN["bootstrap_interval"](v, 0.99, rng), "is too low"),
        (
            lambda v, p, rng: np.quantile(rng.choice(v, (100, len(v))).mean(axis=1), [0.05, 0.95]),
            "vary too much",
        ),
    ],
)
def test_what_is_wrong_is_named(answer, said):
    verdict = judged(answer)
    assert not verdict and said in verdict.text


def test_equal_values_have_an_interval_without_a_width_whatever_the_generator():
    same = with_generators(OWN["bootstrap_interval"], np.full(5, 2.5), 0.9)
    assert Interval().compare(same, same)


def test_a_mistake_is_recognised_by_its_ends_and_not_by_its_digits():
    wide = with_generators(lambda v, p, rng: OWN["bootstrap_interval"](v, 0.99, rng), VALUES, 0.9)
    again = with_generators(
        lambda v, p, rng: np.add(OWN["bootstrap_interval"](v, 0.99, rng), 1e-3), VALUES, 0.9
    )
    assert Interval().alike(wide, again) and not Interval().alike(wide, RIGHT)


def test_an_answer_that_is_not_drawn_is_recognised_by_its_digits():
    """A generator of one's own with a seed was told that its ends are a normal curve's."""
    own = with_generators(
        lambda v, p, rng: OWN["bootstrap_interval"](v, p, np.random.default_rng(1)), VALUES, 0.9
    )
    half = 1.645 * VALUES.std() / 5
    normal = with_generators(lambda v, p, rng: (v.mean() - half, v.mean() + half), VALUES, 0.9)
    near = with_generators(lambda v, p, rng: (v.mean() - 1.01 * half, v.mean() + 1.01 * half), VALUES, 0.9)
    assert Interval().alike(normal, near) and not Interval().alike(normal, own)


def test_without_replacement_all_generators_give_the_same_but_for_the_last_digit():
    mean = with_generators(lambda v, p, rng: (np.mean(rng.permutation(v)),) * 2, VALUES, 0.9)
    verdict = Interval().compare(RIGHT, mean)
    assert "same for every rng" in verdict.text


def test_the_first_generator_comes_again():
    assert SEEDS[0] == SEEDS[-1] and len(set(SEEDS)) > 3
