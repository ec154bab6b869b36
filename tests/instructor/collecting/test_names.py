"""Whose a file is and of which lesson, whatever a browser, a platform or a student made of its name."""

import pytest

from nao_course.exercises.lesson_names import lesson_and_more, lesson_of
from nao_course.instructor.collecting.names import LONGEST_NAME, clean_name, safe_name

LESSONS = ["00_meet_the_nao", "01_hsl_filtering", "02_goal_posts"]


@pytest.mark.parametrize(
    "name",
    [
        "01_hsl_filtering.ipynb",
        "01_hsl_filtering (1).ipynb",
        "01_hsl_filtering(12).ipynb",
        "01_hsl_filtering\u00a0(1).ipynb",
        "01\u00a0hsl\u2009filtering.ipynb",
        "01_hsl_filtering-2.ipynb",
        "01_hsl_filtering (1) .ipynb",
        "01_hsl_filtering_copy.ipynb",
        "01_hsl_filtering-Copy1.ipynb",
        "01_HSL_Filtering.IPYNB",
        "01-hsl-filtering.ipynb",
        "01 hsl filtering v2.ipynb",
        "ada_01_hsl_filtering.ipynb",
        "Copy of 01_hsl_filtering.ipynb",
        "Kopie von Kopie von 01_hsl_filtering (2).ipynb",
        "01_hsl_filtering_final (1)-Copy2.ipynb",
    ],
)
def test_a_lesson_is_known_by_its_name_whatever_a_browser_added(name):
    assert lesson_of(name, LESSONS) == "01_hsl_filtering"


@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("homework.ipynb", ""),
        ("101_hsl_filtering.ipynb", ""),
        ("01_hsl_filteringada.ipynb", ""),
        ("01_hsl_filtering_vera.ipynb", "vera"),
        ("01_hsl_filtering_old_stuff.ipynb", "old_stuff"),
        ("01.ipynb", ""),
        ("", ""),
    ],
)
def test_a_file_that_is_named_after_no_lesson_is_of_none(name, more):
    assert lesson_of(name, LESSONS) == "" and lesson_and_more(name, LESSONS)[1] == more


HOSTILE = [
    "<script>alert(1)</script>",
    "ada\x1b[31m",
    "ada\n\r\t",
    "a" * 500,
    "a" * 499 + "b",
    "..",
    ".",
    "",
    "con",
    "CON",
    "ada/../eve",
    "ada",
    "Ada",
    "ADA",
    "ada ",
    "ada.",
    "Müller",
    "Mu\u0308ller",
    "\u202eada",
    "=1+1",
    "nul.txt",
    safe_name("Ada"),
    safe_name("Müller").upper(),
    "\udcff",
]


def test_safe_names_are_safe_and_none_is_anothers():
    names = [safe_name(name) for name in HOSTILE]
    assert len({name.lower() for name in names}) == len(names)
    for name in names:
        assert name.isascii() and name[0].isalnum() and not set(name) & set('/\\<>:"|?* \n')
        assert len(name) <= 60 and not name.endswith(".")
        assert name.split(".")[0] not in ("con", "nul")


def test_students_names_hold_nothing_that_a_terminal_obeys():
    names = [clean_name(name) for name in HOSTILE]
    assert all(name.isprintable() and len(name) <= LONGEST_NAME for name in names)
    assert all(name.encode() is not None for name in names)
    assert clean_name("a" * 500) != clean_name("a" * 499 + "b")
    assert clean_name("Mu\u0308ller") == clean_name("Müller")  # one student, two file systems
    assert clean_name("ada\x1b") != clean_name("ada")
    assert [clean_name(name) for name in (" ", "\u3000", "")] == [r"\x20", r"\x3000", ""]
