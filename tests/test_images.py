"""Every picture that README, docs or lessons show is there, is made by images/make.py, and is told in words, once."""

import re
import tomllib
from itertools import chain
from pathlib import Path

import pytest

from images.make import PICTURES
from nao_course.instructor.authoring.course import load_course
from tests.paths import PROJECT

DRAFTS = load_course(PROJECT).drafts()  # their figures and words are still to come
PAGES = [
    PROJECT / "README.md",
    *sorted(
        path
        for path in chain(*(PROJECT.glob(f"{folder}/*.md") for folder in ("docs", "solutions")))
        if path.stem not in DRAFTS
    ),
]
ALT_TEXTS = tomllib.loads((PROJECT / "images" / "alt_texts.toml").read_text(encoding="utf-8"))


def uses(path: Path) -> list[tuple[str, Path]]:
    """Alt text and file of each picture that a page shows; a sheet to print that it links to has no text."""
    text = re.sub(r"`[^`\n]+`", "", path.read_text(encoding="utf-8"))  # code shows how a picture is written
    found = re.findall(r"!\[([^\]]*)\]\(([^)\s]+)\)|(?<!!)\[[^\]]*\]\((images/[^)\s]+)\)", text)
    return [(alt, (path.parent / (shown or linked)).resolve()) for alt, shown, linked in found]


def pictures() -> set[Path]:
    """All files of images/ and solutions/images/ but the scripts and words."""
    there = chain(*(PROJECT.glob(f"{folder}/*.*") for folder in ("images", "solutions/images")))
    drawn = {f"{name[:2]}_payoff" for name in DRAFTS}
    return {path for path in there if path.suffix not in {".py", ".toml"} and path.stem not in drawn}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_says_of_each_picture_what_the_alt_texts_say(page):
    shown = [(alt, path.name) for alt, path in uses(page) if path.suffix != ".pdf"]
    assert shown == [(ALT_TEXTS.get(name), name) for _, name in shown]


def test_every_picture_is_shown_and_every_one_that_is_shown_is_there():
    shown = {path for page in PAGES for _, path in uses(page)}
    assert shown == pictures()
    assert {path.name for path in shown if path.suffix != ".pdf"} == {*ALT_TEXTS}
    assert [name for name, alt in ALT_TEXTS.items() if len(alt) < 40] == []


def test_the_script_makes_every_picture_and_no_other():
    assert {path.stem for path in pictures()} == {*PICTURES} - {f"{name[:2]}_payoff" for name in DRAFTS}


def test_student_copies_come_with_the_pictures_of_the_solutions():
    copies = {path.name: path.read_bytes() for path in (PROJECT / "notebooks" / "images").iterdir()}
    assert copies == {path.name: path.read_bytes() for path in (PROJECT / "solutions" / "images").iterdir()}
