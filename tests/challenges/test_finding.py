"""Which challenge a word means."""

from __future__ import annotations

import pytest

from nao_course.challenges import challenge, finding


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
