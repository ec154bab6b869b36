"""``python -m website`` says what to run where a lesson is not built, and a phone's headings keep their order."""

import re
import shutil

import pytest

from tests.paths import PROJECT
from website import __main__ as module
from website.__main__ import main


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """Return the folder of a course whose only lesson is built; gathering its pages ends with a message."""
    for folder in ("solutions", "notebooks"):
        (tmp_path / folder).mkdir()
    (tmp_path / "solutions" / "exercises").mkdir()
    (tmp_path / "course.toml").write_text('title = "One lesson"\nversion = "1"\n')
    for file in (
        *("notebooks/00_meet_the_nao.ipynb", "solutions/00_meet_the_nao.ipynb"),
        *("solutions/00_meet_the_nao.md", "solutions/exercises/00_meet_the_nao.py"),
    ):
        shutil.copy(PROJECT / file, tmp_path / file)
    monkeypatch.setattr(module, "ROOT", tmp_path)
    monkeypatch.setattr(module, "BUILD", tmp_path / "build")
    monkeypatch.setattr(module, "gather", stop)
    return tmp_path


def stop(*_):
    raise ValueError("all lessons are built")


@pytest.mark.parametrize("edition", ["student", "instructor"])
def test_lessons_that_are_built_become_pages_and_another_names_the_command_that_builds_it(
    copy, edition, capsys
):
    assert main([edition]) == 1
    assert capsys.readouterr().err == "all lessons are built\n"
    file = "solutions/00_meet_the_nao.ipynb" if edition == "instructor" else "notebooks/00_meet_the_nao.ipynb"
    (copy / file).rename(copy / "kept")
    assert main(["student"]) == 1
    assert capsys.readouterr().err == f"there is no {file}: run `nao-course build 00`\n"
    (copy / "kept").rename(copy / file)
    text = copy / "solutions" / "00_meet_the_nao.md"
    text.write_text(text.read_text(encoding="utf-8") + "\nMore.\n", encoding="utf-8")
    assert main([edition, "00"]) == 1
    said = "00_meet_the_nao.md was edited since it was built: run `nao-course build 00`"
    assert said in capsys.readouterr().err


def test_on_a_phone_each_heading_is_larger_than_the_headings_below_it():
    rules = (PROJECT / "website" / "static" / "course.css").read_text(encoding="utf-8")
    phone = rules.split("@media (max-width: 46em)", 1)[1]
    sizes = dict(re.findall(r"article (h\d) \{ font-size: ([\d.]+)em; \}", phone))
    assert [*sizes] == ["h1", "h2", "h3", "h4", "h5"]
    assert sorted(sizes.values(), key=float, reverse=True) == [*sizes.values()]
    assert len({*sizes.values()}) == 5 and min(map(float, sizes.values())) > 1
