"""A course.toml is understood, or the message names the key and what is allowed."""

import os
import shutil
import subprocess
import sys
from datetime import datetime
from pathlib import Path

import pytest

from nao_course.instructor.authoring.course import LessonError, load_course
from nao_course.instructor.authoring.course_file import CourseFileError, read_course_file
from tests.paths import PROJECT

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


SETTINGS = """lessons = ["00", "01", "04"]
[deadlines]
01 = 2026-11-20T23:59:00+01:00
11 = 2027-01-20T23:59:00+01:00
[late]
per_day = 0.1
grace_hours = 2
most = 0.5
[extensions."ada@uni.example"]
04 = 2026-12-27T23:59:00+01:00
[points]
"""
READERS = ["website", "instructor/authoring/test_course.py", "lessons/test_built.py", "test_images.py"]


@pytest.mark.slow
def test_the_settings_of_a_term_leave_the_courses_own_tests_green(tmp_path):
    """The first step of a term is `make test`, with the course.toml of the term."""
    for folder in (
        "nao_course",
        "solutions",
        "notebooks",
        "tests",
        "docs",
        "images",
        "website",
        "web",
        "deploy",
    ):
        ignored = shutil.ignore_patterns("__pycache__", "node_modules")
        shutil.copytree(PROJECT / folder, tmp_path / folder, ignore=ignored)
    for file in filter(Path.is_file, PROJECT.iterdir()):
        shutil.copy(file, tmp_path)
    settings = (PROJECT / "course.toml").read_text(encoding="utf-8")
    (tmp_path / "course.toml").write_text(settings.replace("[points]\n", SETTINGS), encoding="utf-8")
    tests = [f"tests/{each}" for each in READERS]
    options = ["-q", "-m", "not slow and not browser", "-p", "no:cacheprovider", "-p", "no:nbval"]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "-m", "pytest", *options, *tests]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:]
