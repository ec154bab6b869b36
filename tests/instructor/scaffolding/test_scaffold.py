"""A new lesson and a new exercise build at once, and cannot be released unfinished."""

import shutil
from pathlib import Path

import pytest

from tests.paths import PROJECT
from tests.toy.course import contents, run


def test_a_new_lesson_and_a_new_exercise_build_and_cannot_be_released_unfinished(built):
    assert run("new", "lesson", "07", "ekf_slam").exit_code == 0
    for name in ("predict_it", "update_it"):
        result = run("new", "exercise", "07", name)
        assert result.exit_code == 0, result.output
    assert run("new", "exercise", "01", "treble").exit_code == 0
    result = run("build")
    assert result.exit_code == 0, result.output
    shown = Path("notebooks/07_ekf_slam.ipynb").read_text()
    assert shown.index("predict_it") < shown.index("update_it") < shown.index("References")
    for name in ("LICENSE", "Makefile", "pyproject.toml", "requirements.lock", "docs/for_students.md"):
        (built.root / name).parent.mkdir(exist_ok=True)
        shutil.copy(PROJECT / name, built.root / name)
    result = run("release", "--out", "dist")
    assert result.exit_code == 1 and "07_ekf_slam.ipynb says TODO" in result.output
    assert not Path("dist").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("lesson", "01", "again"), "lesson 01 is there already: 01_toy"),
        (("lesson", "7", "ekf"), "a lesson is two digits and a name"),
        (("exercise", "01", "double"), "lesson 01_toy has an exercise double already"),
        (("exercise", "01", "Double"), "an exercise is named like a function"),
        (("exercise", "05", "x"), "there is no lesson 05"),
    ],
)
def test_a_scaffold_that_cannot_be_is_refused(course, words, said):
    before = contents(course.root)
    result = run("new", *words)
    assert result.exit_code == 1 and said in result.output
    assert contents(course.root) == before
