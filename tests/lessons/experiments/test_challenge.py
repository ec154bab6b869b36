"""The challenge of lesson 10: what is scored, and what is said of wrong answers."""

import numpy as np
import pytest

from benchmarks.challenges import margin
from nao_course.challenges import CaseResult, Run
from nao_course.lessons.experiments.challenge import CHALLENGE, ROOMS, Room, interval_score, judge
from tests.lessons.experiments.own import TEXT

PICTURE = np.zeros((240, 320, 3), dtype=np.uint8)
ROOM = Room("lab 1", ((PICTURE, np.array([(50.0, 90.0), (200.0, 80.0)])), (PICTURE, np.zeros((0, 2)))))
NONE = np.zeros((0, 2))


def test_the_cost_is_the_mean_and_a_right_interval_costs_a_quarter_of_its_width():
    scored = judge(([[(50, 90)], NONE], -1.0, 1.0), ROOM)
    assert scored.columns["mean cost"] == pytest.approx((-1.333 + 1) / 2)
    assert scored.score == pytest.approx(scored.columns["mean cost"] + 0.5)
    assert scored.columns["inside"] == 100.0 and scored.columns["false"] == 0.0


def test_a_wrong_interval_costs_ten_times_its_distance():
    assert interval_score(0.0, 1.0, 1.5) == interval_score(0.0, 1.0, -0.5) == pytest.approx(6.0)
    scored = judge(([NONE, NONE], 2.0, 3.0), ROOM)
    assert scored.columns["mean cost"] == 1.0 and scored.score == pytest.approx(1.0 + (1.0 + 10.0) / 4)


def test_no_other_interval_than_that_of_80_percent_costs_less(rng):
    values = rng.normal(0, 1, 4000)

    def mean_score(half):
        return np.mean([interval_score(-half, half, value) for value in values])

    assert mean_score(1.28) < min(mean_score(0.9), mean_score(1.8))


@pytest.mark.parametrize(
    "answer",
    [
        None,
        [NONE, NONE],
        ([NONE], 0.0, 1.0),
        ([NONE, NONE], 1.0, 0.0),
        ([NONE, NONE], np.nan, 1.0),
        ([NONE, 3], 0, 1),
    ],
)
def test_what_is_no_claim_is_said(answer):
    with pytest.raises((TypeError, ValueError)):
        judge(answer, ROOM)


def test_every_room_has_a_name_and_nothing_is_worth_less_than_a_failing_entry():
    names = [CHALLENGE.name_of(seed) for seed in CHALLENGE.seeds]
    assert len(set(names)) == len(names) == sum(map(len, ROOMS.values())) and names[0] == "lab 1"
    nothing = next(row for row in CHALLENGE.rows if row.name == "nothing")
    assert max(nothing.cases) < CHALLENGE.nothing


def test_the_figure_says_which_rooms_are_outside():
    answers = (([NONE, NONE], 0.0, 2.0), ([NONE, NONE], 2.0, 3.0))
    scored = [judge(each, ROOM) for each in answers]
    results = tuple(
        CaseResult(i, f"lab {i}", each.score, each.columns, each.kept) for i, each in enumerate(scored)
    )
    assert "Mean cost of 2 rooms" in CHALLENGE.figure(Run(CHALLENGE, results)).alt


def test_the_text_says_what_the_board_says():
    rows = {row.name: row for row in CHALLENGE.rows}
    own, nothing, better = (rows[name] for name in ("the reference", "nothing", "a better detector"))
    assert f"scores {own.score:.2f}; reporting nothing scores {nothing.score:.2f}" in TEXT
    mean, low, high = margin(own.cases, better.cases)
    assert (
        f"scores {better.score:.2f}, which is better than the reference by {mean:.2f} "
        f"(95 % interval {low:.2f} to {high:.2f})" in TEXT
    )
