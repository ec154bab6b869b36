"""A course.toml is understood, or the message names the key and what is allowed."""

from datetime import datetime

import pytest

from nao_course.instructor.authoring.course import LessonError, load_course
from nao_course.instructor.authoring.course_file import CourseFileError, read_course_file

START = 'title = "Robots"\nversion = "1.0"\n'


@pytest.fixture
def read(tmp_path):
    (tmp_path / "solutions").mkdir()
    (tmp_path / "solutions" / "01_toy.md").touch()

    def read(text, start=START):
        (tmp_path / "course.toml").write_text(start + text, encoding="utf-8")
        return read_course_file(tmp_path)

    return read


def test_deadlines_are_known_by_the_lessons_whole_names_and_a_short_file_has_none(read):
    file = read("")
    assert (file.title, file.version, file.lessons, file.points) == ("Robots", "1.0", (), {})
    assert file.late_policy.deadlines == {} and file.late_policy.per_day == 0
    policy = read(
        "[deadlines]\n01 = 2026-11-20T23:59:00+01:00\n[late]\nper_day = 0.1\ngrace_hours = 2\nmost = 0.5\n"
        '[extensions."Jose\u0301 Lovelace_1234567"]\n1 = 2026-11-27T23:59:00+01:00\n'
    ).late_policy
    due, later = (datetime.fromisoformat(f"2026-11-{day}T23:59+01:00") for day in (20, 27))
    assert policy.deadlines == {"01_toy": due}
    assert policy.extensions == {"Jos\u00e9 Lovelace_1234567": {"01_toy": later}}
    assert (policy.per_day, policy.grace_hours, policy.most) == (0.1, 2, 0.5)


def test_what_is_wrong_is_said_with_its_key_and_what_is_allowed(read, tmp_path):
    for text, said in [
        ("colour = 3", "colour is not understood; there are title, version, lessons, points, deadlines"),
        ("lessons = [1]", "lessons must be a list of numbers"),
        ("points = 3", "points must be a table, got '3'"),
        *((f"[points]\nx = {each}", "points.x must be a number, 0") for each in ("'1'", -1, "nan", "true")),
        ("[deadlines]\n01 = 2026-11-20T23:59:00", "deadlines.01 must be a time with its offset from UTC"),
        ("[deadlines]\n01 = 2026-11-20", "deadlines.01 must be a time with its offset from UTC"),
        ("[deadlines]\n07 = 2026-11-20T23:59:00Z", "deadlines: there is no lesson '07'; there are 01_toy"),
        ("[extensions]\nada = 2026-11-20T23:59:00Z", "extensions.ada must be a table"),
        ("[extensions.ada]\n01 = 5", "extensions.ada.01 must be a time with its offset"),
        ("[extensions.ada]\n02 = 5", "extensions.ada: there is no lesson '02'"),
        ("[late]\nper_day = 10", "late.per_day must be a number from 0 to 1, got '10'"),
        ("[late]\nper_hour = 1", "late.per_hour is not understood; there are per_day, grace_hours, most"),
        ("[late]\ngrace_hours = -1", "late.grace_hours must be a number from 0 to 8784"),
        ("[late", "it is not TOML"),
    ]:
        with pytest.raises(CourseFileError) as caught:
            read(text)
        assert str(caught.value).startswith("course.toml: ") and said in str(caught.value)
    for title, said in (("", "title is missing; it must be a text"), ("title = 1", "title must be a text")):
        with pytest.raises(CourseFileError, match=said):
            read('\nversion = "1"', start=title)
    with pytest.raises(LessonError, match="title must be a text"):
        load_course(tmp_path)
