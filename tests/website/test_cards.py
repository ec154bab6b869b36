"""The first page's cards show a part of each lesson's opening figure."""

from dataclasses import replace

import pytest
from PIL import Image

from nao_course.instructor.authoring.course import load_course
from tests.paths import PROJECT
from website.cards import SIZE, cards
from website.lessons import read_lesson

DRAFTS = load_course(PROJECT).drafts()
LESSONS = [read_lesson(at) for at in sorted((PROJECT / "notebooks").glob("*.ipynb")) if at.stem not in DRAFTS]
COLOURED = 0.02  # of a card's pixels: a part that misses its figure is white


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "lessons").mkdir()
    (tmp_path / "lessons" / "images").symlink_to(PROJECT / "notebooks" / "images")
    return tmp_path / "cards"


def test_each_lesson_has_a_card_of_one_size_that_is_not_empty(folder):
    text = cards(LESSONS, folder)
    for lesson in LESSONS:
        assert f"![{lesson.about['card_shows']}](cards/{lesson.number}.webp)" in text
        with Image.open(folder / f"{lesson.number}.webp") as picture:
            assert picture.size == SIZE
            white = sum(picture.convert("L").histogram()[250:])
        assert white < (1 - COLOURED) * SIZE[0] * SIZE[1], lesson.name


def test_a_lesson_that_opens_with_no_figure_has_a_card_of_words(folder):
    text = cards([replace(LESSONS[0], picture="", about={})], folder)
    assert "![" not in text and f"**[00 {LESSONS[0].title}](lessons/{LESSONS[0].name}.ipynb)**" in text
    assert not list(folder.iterdir())


def test_a_part_outside_of_its_figure_is_refused(folder):
    outside = replace(LESSONS[0], about=LESSONS[0].about | {"card": [0.5, 0, 0.4, 1]})
    with pytest.raises(ValueError, match=r"00_payoff.png: the part \[0.5, 0, 0.4, 1\] of a card must be"):
        cards([outside], folder)
