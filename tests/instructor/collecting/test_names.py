"""Whose a file is and of which lesson, whatever a browser, a platform or a student made of its name."""

import pytest

from nao_course.exercises.running import alarm
from nao_course.instructor.collecting.names import LONGEST_NAME, clean_name, lesson_of, name_file, safe_name

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
    ],
)
def test_a_lesson_is_known_by_its_name_whatever_a_browser_added(name):
    assert lesson_of(name, LESSONS) == "01_hsl_filtering"


@pytest.mark.parametrize(
    "name", ["homework.ipynb", "101_hsl_filtering.ipynb", "01_hsl_filtering_old_stuff.ipynb", "01.ipynb", ""]
)
def test_a_file_that_is_named_after_no_lesson_is_of_none(name):
    assert lesson_of(name, LESSONS) == ""


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


@pytest.mark.parametrize(
    ("parts", "student", "file"),
    [
        (("ada", "deep", "01_hsl_filtering.ipynb"), "ada", "01_hsl_filtering.ipynb"),
        (("ada_01_hsl_filtering.ipynb",), "ada", "01_hsl_filtering.ipynb"),
        (("Ada L_12_assignsubmission_file_", "x.ipynb"), "Ada L_12", "x.ipynb"),
        (("Ada L_12_assignsubmission_file_x.ipynb",), "Ada L_12", "x.ipynb"),
        (("lada_LATE_12_34_x-2.ipynb",), "lada_12", "x.ipynb"),
        (("cc_123456\u00a0_22_01_hsl_filtering.ipynb",), "cc_123456", "01_hsl_filtering.ipynb"),
        (("mueller_123456_01_hsl_filtering.ipynb",), "mueller_123456", "01_hsl_filtering.ipynb"),
        (("team_7_01_hsl_filtering.ipynb",), "team_7", "01_hsl_filtering.ipynb"),
        (("team_7_01_01_hsl_filtering.ipynb",), "team_7", "01_hsl_filtering.ipynb"),
        (("submission-20260301-120000.zip",), "submission-20260301-120000", "submission-20260301-120000.zip"),
    ],
)
def test_each_platform_says_whose_file_it_is(parts, student, file):
    named = name_file(parts, LESSONS)
    assert (named.student, named.file) == (student, file)


def test_a_file_that_its_student_named_like_one_of_moodles_passes_for_nobodys():
    theirs = "Eve_99_assignsubmission_file_Ada Lovelace_12_assignsubmission_file_01_hsl_filtering.ipynb"
    assert name_file((theirs,), LESSONS) is None
    inside = name_file(("Eve_99_assignsubmission_file_", theirs), LESSONS)
    assert (inside.student, inside.file) == ("Eve_99", theirs)


def test_no_student_of_canvas_passes_for_another_by_a_number_before_the_lesson():
    named = name_file(("eve_99_789_x_1234567" + "01_hsl_filtering.ipynb",), LESSONS)
    assert named.student == "eve_99" and lesson_of(named.file, LESSONS) == ""
    assert name_file(("ada01_hsl_filtering.ipynb",), LESSONS).student == "ada"


def test_a_file_without_a_student_is_nobodys():
    assert name_file(("01_hsl_filtering.ipynb",), LESSONS) is None


def test_canvas_says_which_of_two_is_the_later_one():
    first, again = (name_file((f"ada_12_34_x{copy}.ipynb",), LESSONS) for copy in ("", "-1"))
    assert first.order < again.order


LONG = 60_000
PIECES = [
    "1",
    "a",
    "_",
    "-",
    " ",
    ".",
    "(1)",
    "_1",
    "-1",
    " copy",
    "-0a",
    "\n",
    "01_hsl_filtering",
    "_assignsubmission_",
]


@pytest.mark.parametrize("piece", PIECES)
@pytest.mark.parametrize(
    "before", ["", "01_hsl_filtering", "x_1_2_01_hsl_filtering", "Ada_1_assignsubmission_file_"]
)
def test_names_of_any_length_are_read_in_one_pass(piece, before):
    for name in (before + piece * (LONG // len(piece)) + "x.ipynb", before + piece * 60 + "x.ipynb"):
        with alarm(120.0):
            name_file((name,), LESSONS)
            name_file((name, name), LESSONS)
            lesson_of(name, LESSONS)
        assert len(safe_name(name)) <= 60 and len(clean_name(name)) <= LONGEST_NAME
