"""A function that draws random samples is judged by the law of its answers."""

import numpy as np
import pytest

from nao_course.exercises.comparisons.sampling import Sampled, sampling_law


def law(function, values=None, n_samples=40, repeats=300):
    values = np.arange(100.0).reshape(10, 10) if values is None else values
    return sampling_law(function, values, n_samples, repeats)


def sample(values, n_samples, rng):
    return values.ravel()[rng.integers(0, values.size, n_samples)].mean()


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (
            lambda v, n, rng: np.random.default_rng().choice(v.ravel(), n).mean(),
            "the same rng gave two different",
        ),
        (lambda v, n, rng: v.mean(), "whatever rng it gets"),
        (
            lambda v, n, rng: v.ravel()[np.random.default_rng(7).integers(0, v.size, n)].mean(),
            "whatever rng it gets",
        ),
        (lambda v, n, rng: rng.choice(v.ravel()), "the scatter of your answers"),
        (lambda v, n, rng: 2 * sample(v, n, rng), "the mean of your answers"),
        (lambda v, n, rng: None, "a return may be missing"),
    ],
)
def test_a_random_sample_is_judged_by_its_law(function, said):
    assert said in Sampled().compare(law(sample), law(function)).text


def test_another_way_to_draw_the_same_sample_is_right():
    for right in (
        lambda v, n, rng: rng.choice(v.ravel(), n, replace=False).mean(),
        lambda v, n, rng: rng.permutation(v.ravel())[:n].mean(),
    ):
        assert Sampled().compare(law(sample), law(right))


def test_a_sample_of_one_kind_is_like_another_of_its_kind():
    def own(v, n, rng):
        return np.random.default_rng().choice(v.ravel(), n).mean()

    assert Sampled().alike(law(own), law(own))
    assert not Sampled().alike(law(own), law(sample))
    assert Sampled().alike(None, None) and not Sampled().alike(None, law(sample))


@pytest.mark.parametrize(
    "hostile", [("evil", 0.0, True), (None, 0.0, True), ([1.0], 0.0, True), (1.0, "x", True)]
)
def test_an_answer_that_no_driver_gave_is_wrong_and_raises_nothing(hostile):
    assert not Sampled().compare(law(sample), hostile)
