"""Numbers of the students' own worlds: computed with the solution, kept, and computed again when it changes."""

import json
import pickle
import unicodedata
from dataclasses import replace

import pytest

from nao_course._internal.tables import TableError
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.plans import PlanError
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.commands.personal_numbers import PersonalNumbers, read_worlds
from tests.pages import answer, result
from tests.toy.course import lay_out, run, with_a_written_question, write

NUMBERS = """
def numbers(world, double):
    return {"twice the seed": double(float(world.seed("toy") % 100))}

PLAN ="""


@pytest.fixture
def asking(tmp_path, monkeypatch):
    """A built course with a question that asks for a number."""
    course = load_course(lay_out(tmp_path))
    monkeypatch.chdir(tmp_path)
    with_a_written_question(course)
    plan = course.solutions / "exercises" / "01_toy.py"
    write(plan, "PLAN =", NUMBERS)
    write(plan, '"one point for each two")', '"one point for each two", numbers=numbers)')
    assert run("build", "--no-execute").exit_code == 0
    return course


def test_each_student_has_own_numbers_which_are_kept(asking, tmp_path):
    path = tmp_path / "marking" / "numbers.json"
    numbers = PersonalNumbers(asking, path)
    numbers.compute([])
    assert not path.exists()
    found = {name: numbers("01_toy", "say_why", name) for name in ("ada", "bob", "")}
    values = [of["twice the seed"] for of in found.values()]
    assert len(set(values)) == 3 and all(value % 2 == 0 for value in values)
    given = (result(name, answer(name="say_why", text=text)) for name, text in (("ada", "2"), ("cyd", " ")))
    numbers.compute(replace(each, lesson="01_toy") for each in given)
    kept = json.loads(path.read_text())
    path.write_text(json.dumps({key: {"twice the seed": -1.0} for key in kept}))
    again = PersonalNumbers(asking, path)
    assert again("01_toy", "say_why", "ada") == {"twice the seed": -1.0}
    write(asking.text("01_toy"), "return 2.0 * value", "return value + value")
    assert run("build", "--no-execute").exit_code == 0
    assert PersonalNumbers(asking, path)("01_toy", "say_why", "ada") == found["ada"]


def test_other_questions_have_none_and_an_assignment_has_no_code_of_the_question(asking, tmp_path):
    path = tmp_path / "numbers.json"
    path.write_bytes(b"{")
    numbers = PersonalNumbers(asking, path)
    assert not numbers.needs("01_toy", "other") and numbers("01_toy", "other", "ada") == {}
    assert not numbers.needs("99_gone", "say_why") and numbers("99_gone", "say_why", "ada") == {}
    numbers.compute([result("ada", answer(name="other"))])
    assert path.read_bytes() == b"{"
    assignment = prepare(asking, "01_toy", b"0123456789abcdef")
    (question,) = pickle.loads(pickle.dumps(assignment)).written
    assert question.name == "say_why" and question.numbers is None


def test_a_function_that_the_solution_does_not_define_is_named(asking, tmp_path):
    write(
        asking.solutions / "exercises" / "01_toy.py",
        "def numbers(world, double)",
        "def numbers(world, triple)",
    )
    write(asking.solutions / "exercises" / "01_toy.py", "double(float(world", "triple(float(world")
    with pytest.raises(PlanError, match="numbers needs triple, which the solution does not define"):
        PersonalNumbers(asking, tmp_path / "numbers.json")("01_toy", "say_why", "ada")


def test_the_names_in_the_copies_may_differ_from_the_gradebook(asking, tmp_path):
    path = tmp_path / "worlds.csv"
    decomposed, composed = (unicodedata.normalize(form, "José Núñez_17") for form in ("NFD", "NFC"))
    path.write_text(f'student,world\n"{decomposed} ",ada\n', encoding="utf-8")
    numbers = PersonalNumbers(asking, tmp_path / "numbers.json", read_worlds(path))
    assert numbers("01_toy", "say_why", composed) == numbers("01_toy", "say_why", "ada")
    path.write_text("name\nada\n", encoding="utf-8")
    with pytest.raises(TableError):
        read_worlds(path)
