"""Every picture that README, docs or lessons show is there, is made by images/make.py, and is told in words, once."""

import re
from itertools import chain
from pathlib import Path

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


def test_every_picture_is_told_in_words_which_are_the_same_on_every_page():
    words = {}
    for alt, path in chain(*map(uses, PAGES)):
        if path.suffix != ".pdf":
            assert len(alt) >= 40 and words.setdefault(path.name, alt) == alt, path.name


def test_every_picture_is_shown_made_by_the_script_and_in_the_student_copies():
    assert {path for page in PAGES for _, path in uses(page)} == pictures()
    assert {path.stem for path in pictures()} == {*PICTURES} - {f"{name[:2]}_payoff" for name in DRAFTS}
    copies = {path.name: path.read_bytes() for path in (PROJECT / "notebooks" / "images").iterdir()}
    assert copies == {path.name: path.read_bytes() for path in (PROJECT / "solutions" / "images").iterdir()}
