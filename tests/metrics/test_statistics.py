"""Confidence intervals: a bootstrap of a mean, and Wilson's of a proportion."""

import numpy as np
import pytest

from nao_course.metrics import mean_interval, wilson_interval


def test_wilsons_interval_is_his():
    assert wilson_interval(7, 10) == pytest.approx((0.3968, 0.8922), abs=1e-4)
    low, high = wilson_interval(12, 12)
    assert 0.75 < low < 0.76 and high == pytest.approx(1.0)
    assert wilson_interval(0, 0) == (0.0, 1.0)


def test_the_interval_of_a_mean_holds_it_as_often_as_it_says(rng):
    assert mean_interval([3.0] * 5) == (3.0, 3.0) and np.isnan(mean_interval([])).all()
    held = [low <= 0.0 <= high for low, high in (mean_interval(rng.normal(0, 2, 40)) for _ in range(200))]
    assert 0.88 < np.mean(held) < 0.99
    low, high = mean_interval(np.arange(30.0), 0.5)
    assert mean_interval(np.arange(30.0))[0] < low < 14.5 < high < mean_interval(np.arange(30.0))[1]
