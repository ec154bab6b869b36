"""Which lessons a word means."""

import pytest

from nao_course.exercises.lesson_names import meant, number_of

LESSONS = ["00_meet_the_nao", "01_hsl_filtering", "12_all_of_it"]


@pytest.mark.parametrize("lesson", LESSONS)
def test_a_lesson_is_meant_by_its_number_with_or_without_a_zero_and_by_its_name(lesson):
    number = number_of(lesson)
    assert meant(lesson, LESSONS) == meant(number, LESSONS) == meant(str(int(number)), LESSONS) == [lesson]


@pytest.mark.parametrize(
    "word", ["", "2", "000", "0012", "hsl_filtering", "01_hsl", "01_HSL_FILTERING", "\u0660\u0661"]
)
def test_another_word_means_none(word):
    assert meant(word, LESSONS) == []
    assert meant("1", ["01_a", "01_b", "02_c"]) == ["01_a", "01_b"]
