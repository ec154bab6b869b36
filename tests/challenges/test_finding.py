"""Which challenge a word means."""

from __future__ import annotations

import pytest

from nao_course.challenges import challenge, finding
from nao_course.challenges.finding import declared


@pytest.mark.parametrize("word", ["01_hsl_filtering", "01", "1", 1])
def test_a_number_or_a_name_finds_a_lessons_challenge(word):
    assert challenge(word).challenge.lesson == "01_hsl_filtering"


def test_what_is_no_lesson_with_a_challenge_is_said():
    with pytest.raises(
        ValueError, match="no challenge '99'; choose one of 00_meet_the_nao, 01_hsl_filtering"
    ):
        challenge("99")


def test_a_lesson_without_a_challenge_or_without_a_folder_has_none(monkeypatch):
    monkeypatch.setattr(finding, "lessons", lambda: ["01_hsl_filtering", "98_nowhere", "99_challenges"])
    for word in ("98", "99"):
        with pytest.raises(ValueError, match="there is no challenge"):
            challenge(word)


def test_every_challenge_stands_in_the_folder_of_its_lesson_and_has_rows_for_nothing_and_the_reference():
    for lesson, each in declared().items():
        assert each.judge.__module__.split(".")[2] == lesson.partition("_")[2]
        assert len(each.rows) >= 3 and any(row.name.startswith("the reference") for row in each.rows)
        names = {column.name for column in each.columns}
        assert all(len(row.cases) == len(each.seeds) and set(row.columns) == names for row in each.rows)
