"""The boards' rows are what their entries score: recorded numbers, computed again in a few cases."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.challenges import ENTRIES, margin
from nao_course.challenges.finding import declared
from nao_course.challenges.running import run

CHALLENGES = declared()
ROWS = [(lesson, name) for lesson, entries in ENTRIES.items() for name in entries]
AGAIN = 2  # cases; a new room takes a second


def test_every_challenge_has_a_row_for_each_entry():
    assert list(CHALLENGES) == list(ENTRIES)
    for lesson, challenge in CHALLENGES.items():
        assert [row.name for row in challenge.rows] == list(ENTRIES[lesson])


@pytest.mark.parametrize(("lesson", "name"), ROWS)
def test_a_recorded_row_is_what_its_entry_scores(lesson, name):
    challenge = CHALLENGES[lesson]
    recorded = next(row for row in challenge.rows if row.name == name)
    came = run(replace(challenge, seeds=challenge.seeds[:AGAIN], make=challenge.scene), ENTRIES[lesson][name])
    assert [each.score for each in came.results] == pytest.approx(recorded.cases[:AGAIN], abs=2e-3)
    assert recorded.score == pytest.approx(np.mean(recorded.cases), abs=1e-3)


def test_a_better_rule_beats_the_others_by_a_margin_that_is_not_luck():
    cases = {row.name: row.cases for row in CHALLENGES["01_hsl_filtering"].rows}
    for other in ("the paper's rule", "the reference"):
        mean, low, high = margin(cases["a better rule"], cases[other])
        assert 0.05 < low < mean < high
    assert margin([0.5, 0.7], [0.5, 0.7]) == (0.0, 0.0, 0.0)


PLAIN = np.full((48, 64, 3), (60, 160, 60), dtype=np.uint8)
FINDERS = [(lesson, name) for lesson, name in ROWS if lesson[:2] in ("02", "03") and name != "nothing"]


@pytest.mark.parametrize(("lesson", "name"), FINDERS)
def test_a_detector_finds_no_point_where_nothing_is_and_refuses_what_is_no_picture(lesson, name):
    find = ENTRIES[lesson][name]
    for picture in (PLAIN, PLAIN * 0, PLAIN * 0 + 255, PLAIN[:1, :1], PLAIN[:5, :7], PLAIN[:0], PLAIN[:, :0]):
        assert np.shape(find(picture)) == (0, 2)
    others = PLAIN[..., 0], PLAIN / 255, PLAIN.astype(int), np.dstack([PLAIN, PLAIN[..., :1]]), [[1, 2]]
    for other in others:
        with pytest.raises(ValueError, match=r"must be RGB, uint8 \(H, W, 3\)"):
            find(other)


@pytest.mark.parametrize("name", ["the paper's rule", "the reference", "a better rule"])
def test_a_colour_filter_has_no_label_for_no_pixel_and_refuses_what_is_no_picture(name):
    label = ENTRIES["01_hsl_filtering"][name]
    assert label(PLAIN[:0]).shape == (0, 64)
    with pytest.raises(ValueError, match="must be RGB"):
        label(PLAIN[..., 0])
