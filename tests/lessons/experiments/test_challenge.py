"""The challenge of lesson 10: what is scored, and what is said of wrong answers."""

import numpy as np
import pytest

from nao_course.lessons.experiments.challenge import Room, interval_score, judge

PICTURE = np.zeros((240, 320, 3), dtype=np.uint8)
ROOM = Room("lab 1", ((PICTURE, np.array([(50.0, 90.0), (200.0, 80.0)])), (PICTURE, np.zeros((0, 2)))))
NONE = np.zeros((0, 2))


def test_the_cost_is_the_mean_and_a_right_interval_costs_a_quarter_of_its_width():
    scored = judge(([[(50, 90)], NONE], -1.0, 1.0), ROOM)
    assert scored.columns["mean cost"] == pytest.approx((-1.333 + 1) / 2)
    assert scored.score == pytest.approx(scored.columns["mean cost"] + 0.5)
    assert scored.columns["inside"] == 100.0 and scored.columns["false"] == 0.0


def test_a_wrong_interval_costs_ten_times_its_distance_and_none_costs_less_than_that_of_80_percent(rng):
    assert interval_score(0.0, 1.0, 1.5) == interval_score(0.0, 1.0, -0.5) == pytest.approx(6.0)
    scored = judge(([NONE, NONE], 2.0, 3.0), ROOM)
    assert scored.columns["mean cost"] == 1.0 and scored.score == pytest.approx(1.0 + (1.0 + 10.0) / 4)
    values = rng.normal(0, 1, 4000)
    means = [np.mean([interval_score(-half, half, value) for value in values]) for half in (1.28, 0.9, 1.8)]
    assert min(means) == means[0]


def test_what_is_no_claim_is_said():
    for answer in (
        [NONE, NONE],
        ([NONE], 0.0, 1.0),
        ([NONE, NONE], 1.0, 0.0),
        ([NONE, NONE], np.nan, 1.0),
        ([NONE, 3], 0, 1),
    ):
        with pytest.raises((TypeError, ValueError)):
            judge(answer, ROOM)
