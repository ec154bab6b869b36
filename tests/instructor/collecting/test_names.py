"""Whose a file is and of which lesson, whatever a browser, a platform or a student made of its name."""

from nao_course.exercises.lesson_names import lesson_and_more, lesson_of
from nao_course.instructor.collecting.names import LONGEST_NAME, clean_name, safe_name

LESSONS = ["00_meet_the_nao", "01_hsl_filtering", "02_goal_posts"]
NAMED = "{}; {} (1); {}(12); {}\u00a0(1); 01\u00a0hsl\u2009filtering; {}-2; {} (1) ; {}_copy; {}-Copy1"
NAMED += "; 01-hsl-filtering; 01 hsl filtering v2; ada_{}; Copy of {}; Kopie von Kopie von {} (2); {}_final (1)-Copy2"


def test_a_lesson_is_known_by_its_name_whatever_a_browser_added():
    names = [f"{each.format('01_hsl_filtering')}.ipynb" for each in NAMED.split("; ")]
    assert [
        each for each in (*names, "01_HSL_Filtering.IPYNB") if lesson_of(each, LESSONS) != LESSONS[1]
    ] == []


def test_a_file_that_is_named_after_no_lesson_is_of_none():
    for name in ("homework.ipynb", "101_hsl_filtering.ipynb", "01_hsl_filteringada.ipynb", "01.ipynb", ""):
        assert lesson_of(name, LESSONS) == "" and lesson_and_more(name, LESSONS)[1] == ""
    for more in ("vera", "old_stuff"):
        name = f"01_hsl_filtering_{more}.ipynb"
        assert lesson_of(name, LESSONS) == "" and lesson_and_more(name, LESSONS)[1] == more


HOSTILE = ["<script>alert(1)</script>", "ada\x1b[31m", "ada\n\r\t", "a" * 500, "a" * 499 + "b", "..", ".", ""]
HOSTILE += ["con", "CON", "ada/../eve", "ada", "Ada", "ADA", "ada ", "ada.", "Müller", "Mu\u0308ller"]
HOSTILE += ["\udcff", "\u202eada", "=1+1", "nul.txt", safe_name("Ada"), safe_name("Müller").upper()]


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
