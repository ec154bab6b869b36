"""The lessons are one course: what one says of another is so, and letters and colours mean the same in all of them."""

import ast
import colorsys
import re
from functools import cache
from urllib.parse import urlparse

import pytest

from nao_course.instructor.authoring import lesson_text
from nao_course.plotting.marks import TRUE
from nao_course.plotting.style import STYLES
from tests.lessons.every import COURSE, FINISHED, NAMES, each_lesson, public, solved

NUMBER = r"\d+\.\d+"
LIST = rf"{NUMBER}(?:(?:,|,? and|,? or| to) {NUMBER})*"


@cache
def words(name):
    """All that a lesson says, code too: messages of its cells name exercises."""
    return "\n\n".join(cell.source for cell in solved(name).cells)


def numbers(pattern, text):
    """The numbers in all lists that follow a word, as in "exercises 5.1, 5.4 and 5.5"."""
    return {
        number for found in re.findall(rf"{pattern} ({LIST})", text) for number in re.findall(NUMBER, found)
    }


@cache
def equations():
    return {tag for name in NAMES for tag in re.findall(rf"\\tag\{{({NUMBER})\}}", words(name))}


def messages(name):
    """Return the hints and messages of a lesson's exercises."""
    for exercise in public(name).exercises:
        yield from (*exercise.hints, *(mistake.message for mistake in exercise.mistakes))


@each_lesson
def test_each_lesson_that_is_named_is_one_of_the_course(name):
    named = re.findall(r"\blessons? (\d\d)(?:(?:, \d\d)*,? (?:and|to|or) (\d\d))?", words(name))
    there = {each[:2] for each in NAMES}
    following = f"{int(max(there)) + 1:02}"  # a course that grows may promise what comes next
    lost = {number for pair in named for number in pair if number} - there - {following}
    assert not lost, f"it names lessons that do not exist: {sorted(lost)}"


@pytest.mark.parametrize("name", FINISHED)
def test_what_comes_next_is_the_next_lesson(name):
    promised = re.findall(r"\*\*Next\*\*[^.]*?\blesson (\d\d)", words(name))
    following = f"{int(name[:2]) + 1:02}"
    if name == FINISHED[-1] and not promised:
        return
    assert promised == [following], (
        f"its ending says: **Next**, in lesson {following}, ...; it names {promised}"
    )


@each_lesson
def test_exercises_and_equations_are_quoted_by_numbers_that_they_have(name):
    declared = {exercise.number for each in NAMES for exercise in public(each).exercises}
    lost = numbers(r"[Ee]xercises?", words(name)) - declared
    assert not lost, f"it names exercises that do not exist: {sorted(lost)}"
    ours = re.sub(r"\b(?:paper|report)'s\b[^.;]*?(?:equations?|sections?)[^;\n]*", "", words(name))
    lost = numbers(r"[Ee]quations?", ours) - equations()
    assert not lost, f"it names equations that do not exist: {sorted(lost)}"
    for said in messages(name):  # of this lesson or an earlier one
        for number in numbers(r"[Ee]quations?", said):
            assert number in equations() and int(number.partition(".")[0]) <= int(name[:2])


@each_lesson
def test_links_of_a_lesson_lead_to_files_beside_it(name):
    prose = "\n".join(cell.source for cell in solved(name).cells if cell.cell_type == "markdown")
    prose = re.sub(r"`[^`]*`", "", prose)
    for link in re.findall(r"\]\(([^)\s]+)\)", prose):
        assert not urlparse(link).scheme, "a student may be without network"
        assert (COURSE.text(name).parent / link).is_file(), link


@each_lesson
def test_transposed_is_written_in_one_way_for_t_is_a_matrix_too_and_a_prime_is_after(name):
    assert not re.findall(r".{20}\^\{?T\b.*", words(name)), r"write \top"
    after = r"(?<![\w'])P' = "  # the covariance after a step
    primed = r"(?<![\w'\"])(?:[A-Zg]|J_\w)'(?= \w| [(+.-]|[,.])"
    assert not [said for said in messages(name) if re.search(primed, re.sub(after, "", said))]


def named(colour):
    """How a text calls a colour "#rrggbb"."""
    hue, lightness, _ = colorsys.rgb_to_hls(*(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)))
    if lightness < 0.15:
        return "black"
    circle = {"red": 0, "orange": 25, "yellow": 50, "green": 130, "blue": 210, "magenta": 335}
    return min(circle, key=lambda each: abs((360 * hue - circle[each] + 180) % 360 - 180))


def test_truth_odometry_and_estimate_have_the_colours_that_lessons_call_them_by():
    assert {key: named(style.colour) for key, style in STYLES.items()} == {
        "truth": "black",
        "odometry": "orange",
        "ekf": "blue",
        "graph": "magenta",
    }
    assert named(TRUE) == "black"


@each_lesson
def test_a_path_a_pose_or_an_ellipse_is_called_by_a_colour_of_the_course(name):
    colours = {named(style.colour) for style in STYLES.values()} | {"grey"}  # grey is what others do
    called = re.findall(
        r"\b(black|white|red|orange|yellow|green|blue|magenta|violet|purple) "
        r"(?:paths?|poses?|ellipses?|strokes?|triangles?|stars?)\b",
        words(name),
    )
    assert set(called) <= colours


def names_given(source):
    """Names that a cell defines or assigns on its top level, without the functions of earlier lessons."""
    tree = ast.parse(source)
    defined = {each.name for each in tree.body if isinstance(each, ast.FunctionDef | ast.ClassDef)}
    own = [each for each in tree.body if isinstance(each, ast.Assign) and "earlier(" not in ast.unparse(each)]
    return defined | {name.id for each in own for name in each.targets if isinstance(name, ast.Name)}


@each_lesson
def test_no_cell_takes_the_name_of_another_lessons_exercise(name):
    """`my_nao` would take the cell's function for the student's solution of that exercise."""
    others = {each.name for lesson in NAMES if lesson != name for each in public(lesson).exercises}
    code = [lesson_text.python(cell) for cell in solved(name).cells if cell.cell_type == "code"]
    assert set().union(*map(names_given, code)) & others == set()
