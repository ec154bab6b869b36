"""What the rules look at: the lessons of a course, each file read once; and what earlier lessons' functions are."""

import re
from functools import cache
from importlib.metadata import version

import nbformat
import pytest

from nao_course.colours import GREEN, YELLOW, mean_lightness
from nao_course.exercises.checking import grade_public, read_public
from nao_course.exercises.earlier import resolved_by
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.plans import load_solution, solutions_beside
from tests.paths import PROJECT

COURSE = load_course(PROJECT)
NAMES = COURSE.names()
FINISHED = [name for name in NAMES if name not in COURSE.drafts()]

# Some numbers in texts are those of pictures, and differ a little with another OpenCV.
LOCKED_OPENCV = f"opencv-python-headless=={version('opencv-python-headless')} " in (
    PROJECT / "requirements.lock"
).read_text(encoding="utf-8")
quoted_with_the_locked_opencv = pytest.mark.skipif(
    not LOCKED_OPENCV, reason="this OpenCV is not the locked one"
)
each_lesson = pytest.mark.parametrize("name", NAMES)


@cache
def solved(name):
    return lesson_text.read_lesson(COURSE.text(name))


@cache
def student_copy(name):
    """The notebook that a student gets; a copy of it for who changes it."""
    return nbformat.read(PROJECT / "notebooks" / f"{name}.ipynb", as_version=4)


@cache
def executed(name):
    """The solution with its outputs; a copy of it for who changes it."""
    return nbformat.read(PROJECT / "solutions" / f"{name}.ipynb", as_version=4)


@cache
def reference(name):
    return load_solution(PROJECT / "solutions" / f"{name}.ipynb")


@cache
def public(name):
    return read_public(name)


@cache
def text(number):
    """Return the text of the lesson of a number, such as "06"."""
    return COURSE.text(*COURSE.names([number])).read_text(encoding="utf-8")


def own(number):
    """Return the solutions of the lesson of a number."""
    return reference(*COURSE.names([number]))


def label(picture, green=GREEN, yellow=YELLOW):
    """Return the labels of a picture by the solution of lesson 01."""
    white = own("01")["white_threshold"](mean_lightness(picture))
    return own("01")["color_labels"](picture, green, yellow, white)


def public_exercise(name, exercise):
    return next(each for each in public(name).exercises if each.name == exercise)


@cache
def graded(name, exercise):
    """What the public checks say of the solution."""
    return grade_public(public_exercise(name, exercise), reference(name)[exercise])


def blank(*given, **named):
    """Raise what an exercise raises that is not written."""
    raise NotImplementedError


def quotes(text, *numbers):
    """Assert that a text contains each of some numbers, written with their units."""
    missing = [each for each in numbers if not re.search(rf"(?<![\d.-]){re.escape(each)}(?!\d)", text)]
    assert not missing, f"the text does not say {missing}"


@cache
def waived(name):
    """Return the rules that a lesson's plan waives, with their reasons."""
    return COURSE.plan(name).waived


@pytest.fixture(autouse=True)
def waived_rules_are_skipped(request):
    """Skip a rule, by the number in its test's name, for a lesson that waives it."""
    name = request.node.callspec.params.get("name") if hasattr(request.node, "callspec") else None
    if name and (reason := waiver(request.node.originalname, waived(name))):
        pytest.skip(f"{name}: {reason}")


def waiver(test, rules):
    """Return why a test is skipped for a lesson that waives some rules; nothing if its rule is not one of them."""
    rule = re.match(r"test_rubric_(\d+)_", test)
    return f"rule {rule[1]} is waived, {rules[rule[1]]}" if rule and rule[1] in rules else ""


@pytest.fixture(autouse=True)
def earlier_functions_are_the_references(request):
    """In declarations, too, as while the course is built."""
    name = request.node.callspec.params.get("name") if hasattr(request.node, "callspec") else None
    if name is None:
        yield
        return
    with resolved_by(solutions_beside(PROJECT / "solutions" / f"{name}.ipynb")):
        yield
