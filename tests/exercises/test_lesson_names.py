"""Which lessons a word means."""

from nao_course.exercises.lesson_names import meant, number_of

LESSONS = ["00_meet_the_nao", "01_hsl_filtering", "12_all_of_it"]


def test_a_lesson_is_meant_by_its_number_or_its_name_and_by_no_other_word():
    for lesson in LESSONS:
        n = number_of(lesson)
        assert meant(lesson, LESSONS) == meant(n, LESSONS) == meant(str(int(n)), LESSONS) == [lesson]
    for word in ["", "2", "000", "0012", "hsl_filtering", "01_hsl", "01_HSL_FILTERING", "\u0660\u0661"]:
        assert meant(word, LESSONS) == []
        assert meant("1", ["01_a", "01_b", "02_c"]) == ["01_a", "01_b"]
