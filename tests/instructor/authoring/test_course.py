"""Which folder is a course, and which of its lessons a word means."""

import pytest

from nao_course.instructor.authoring.course import LessonError
from tests.toy.course import run


def test_outside_a_course_build_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("build")
    assert result.exit_code == 1 and "no course.toml in this folder or above" in result.output
    (tmp_path / "course.toml").write_text('title = "x"\n')
    assert 'course.toml: version is missing; it must be a text, such as "1.0"' in run("build").output


@pytest.mark.parametrize("word", ["1", "01", "01_toy"])
def test_a_number_or_a_name_means_a_lesson_and_another_word_is_said(course, word):
    assert course.names([word]) == course.names() == ["01_toy"]
    for word in ["", "0", "001", "toy", "01_to", "x" * 300]:
        with pytest.raises(LessonError, match="there is no lesson"):
            course.names(["01", word])
