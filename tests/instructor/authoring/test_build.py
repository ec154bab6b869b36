"""What is made of right and broken lessons, in a small course."""

import re
from dataclasses import replace
from pathlib import Path

import nbformat
import numpy as np
import pytest

from nao_course.exercises.checking import grade_public, pack, unpack
from nao_course.exercises.exercise import ANSWER_HERE
from nao_course.instructor.authoring import build, lesson_text, proofs
from nao_course.instructor.authoring.course import LessonError
from nao_course.instructor.authoring.perturbation import perturbed
from tests.instructor.authoring.conftest import PICTURE
from tests.paths import PROJECT
from tests.toy.course import PLAN, contents, run, with_a_written_question, write


@pytest.mark.slow
def test_build_writes_all_that_is_made_of_a_lesson_and_then_nothing(course, kernel):
    assert sorted(run("build").output.split("\n")[:-1])[-5:] == [
        "wrote nao_course/exercises/checks/01_toy.bin",
        "wrote nao_course/exercises/outlines/01_toy.json",
        "wrote notebooks/01_toy.ipynb",
        "wrote solutions/01_toy.ipynb",
        "wrote solutions/proofs.json",
    ]
    before = contents(course.root)
    assert "Nothing has changed." in run("build", "01").output
    assert contents(course.root) == before
    assert "shown" in Path("solutions/01_toy.ipynb").read_text().split('"outputs"')[-1]


def test_what_another_processor_built_stays_as_it_is_and_a_change_is_written(built):
    """The other processor is one that computes with perturbed inputs."""
    checks = built.check_data("01_toy")
    ours, lesson = checks.read_bytes(), unpack(checks.read_bytes())
    theirs = pack(perturbed(lesson, np.random.default_rng(1)))
    checks.write_bytes(theirs)
    assert theirs != ours
    assert run("build").output.split() == ["wrote", "solutions/proofs.json"]  # it vouches for theirs
    assert checks.read_bytes() == theirs and "Nothing has changed." in run("build").output
    other = replace(lesson.exercises[0], hints=["other", "hints"])
    checks.write_bytes(pack(replace(lesson, exercises=[other])))
    assert "wrote nao_course/exercises/checks/01_toy.bin" in run("build").output
    assert checks.read_bytes() == ours


def test_a_student_copy_has_nbgraders_metadata_and_no_solution(built):
    notebook = nbformat.read("notebooks/01_toy.ipynb", as_version=4)
    exercise, check = (cell for _, cell in lesson_text.code_cells(notebook, "exercise", "check"))
    assert exercise.source.endswith('4.0."""\n    raise NotImplementedError')
    assert (exercise.id, check.id) == ("lesson01-double", "lesson01-check_double")
    wanted = {"schema_version": 3, "task": False, "cell_type": "code"}
    solution = {"grade": False, "solution": True, "locked": False, "grade_id": "double"}
    graded = {"grade": True, "solution": False, "locked": True, "grade_id": "check_double", "points": 1.0}
    for cell, more in ((exercise, solution), (check, graded)):
        metadata = dict(cell.metadata.nbgrader)
        assert metadata.pop("checksum")
        assert metadata == wanted | more
    assert check.metadata.nao_course == {"role": "check"}
    assert check.metadata.editable is False


@pytest.mark.parametrize(
    ("source", "protected"),
    [
        *(("my_nao()", True), ('my_nao(upto="01")', True), ("panel = ControlPanel(nao)\npanel", True)),
        *(("lessons.FilmPanel(predict)", True), ('show_film("08_graph_slam")', True)),
        *(("panel = ControlPanel(nao)", False), ("panel.summary()", False)),
        *(("draw_map(ControlPanel)", False), ("# nothing yet", False)),
    ],
)
def test_a_cell_that_shows_a_panel_cannot_be_deleted_from_a_student_copy(course, source, protected):
    write(course.text("01_toy"), 'print("shown")', source)
    solved = lesson_text.read_lesson(course.text("01_toy"))
    *_, (_, shown) = lesson_text.code_cells(build.student_copy(solved))
    assert shown.source == source and shown.metadata.get("deletable", True) is not protected
    assert "deletable" not in solved.cells[-1].metadata


def test_a_written_question_is_a_text_cell_that_a_person_marks(course):
    with_a_written_question(course)
    assert run("build").exit_code == 0
    notebook = nbformat.read("notebooks/01_toy.ipynb", as_version=4)
    ((_, cell),) = lesson_text.written_cells(notebook)
    assert cell.source == ANSWER_HERE and "two times one" not in nbformat.writes(notebook)
    wanted = {"schema_version": 3, "task": False, "cell_type": "markdown", "checksum": "", "points": 2.0}
    wanted |= {"grade": True, "solution": True, "locked": False, "grade_id": "say_why"}
    assert dict(cell.metadata.nbgrader) | {"checksum": ""} == wanted
    solved = nbformat.read("solutions/01_toy.ipynb", as_version=4)
    assert lesson_text.written_cells(solved)[0][1].source == "Because two times one is two."
    assert lesson_text.write_lesson(solved) == course.text("01_toy").read_text()
    write(course.text("01_toy"), '"say_why"', '"say_how"')
    assert "begin with +++" in run("build").output


@pytest.fixture
def runs(monkeypatch):
    """Return the names of the lessons that are run, in the order in which they are."""
    names = []

    def run_it(solved, root):
        names.append(solved.metadata.nao_course.lesson)
        return with_output(solved, f"run {len(names)}")

    with monkeypatch.context() as patched:  # undone before `_quickly` puts back what runs notebooks
        patched.setattr("nao_course.instructor.authoring.execute.execute", run_it)
        yield names


def with_output(solved, text):
    notebook = nbformat.from_dict(solved)
    notebook.cells[-1].outputs = [nbformat.v4.new_output("stream", text=text)]
    return notebook


def test_a_new_version_is_stamped_into_notebooks_without_running_them_again(course, runs):
    assert run("build").exit_code == 0 and runs == ["01_toy"]
    write(course.root / "course.toml", 'version = "1"', 'version = "2"')
    assert run("build").exit_code == 0 and runs == ["01_toy"]
    for folder in ("notebooks", "solutions"):
        assert nbformat.read(f"{folder}/01_toy.ipynb", as_version=4).metadata.nao_course.version == "2"
    assert nbformat.read("solutions/01_toy.ipynb", as_version=4).cells[-1].outputs[0].text == "run 1"
    assert run("build").exit_code == 0 and len(runs) == 2, "a build of the same version runs all"


CHANGES = {
    "the code": ("solutions/01_toy.md", 'print("shown")', 'print("more")'),
    "the words": ("solutions/01_toy.md", "Words", "Other words"),
    "the declaration's check data": ("solutions/exercises/01_toy.py", "Look.", "Look there."),
    "the library": ("nao_course/geometry.py", "import", "# changed\nimport"),
}


@pytest.mark.parametrize("changed", CHANGES)
def test_a_new_version_with_a_change_of_what_the_outputs_depend_on_is_run(course, runs, changed):
    assert run("build").exit_code == 0
    file, old, new = CHANGES[changed]
    (course.root / file).write_text((course.root / file).read_text().replace(old, new, 1))
    write(course.root / "course.toml", 'version = "1"', 'version = "2"')
    assert run("build").exit_code == 0 and len(runs) == 2


def test_a_lesson_that_was_built_without_being_run_is_run_with_a_new_version(course, runs):
    assert run("build").exit_code == 0 and run("build", "--no-execute").exit_code == 0
    write(course.root / "course.toml", 'version = "1"', 'version = "2"')
    assert run("build").exit_code == 0 and len(runs) == 2


def add_lessons(course, *numbers):
    """Copy the course's lesson, with other names."""
    for number in numbers:
        for path in (course.text("01_toy"), course.declaration("01_toy")):
            said = path.read_text().replace("01_toy", f"{number}_toy").replace("double", f"double_{number}")
            path.with_stem(f"{number}_toy").write_text(said)


def test_a_new_version_with_another_solution_of_an_earlier_lesson_runs_the_later_ones(course, runs):
    add_lessons(course, "02")
    assert run("build").exit_code == 0
    write(course.text("02_toy"), "return 2.0 * value", "return value + value")
    write(course.root / "course.toml", 'version = "1"', 'version = "2"')
    assert run("build").exit_code == 0 and sorted(runs) == ["01_toy", "02_toy", "02_toy"]
    write(course.text("01_toy"), "return 2.0 * value", "return value + value")
    write(course.root / "course.toml", 'version = "2"', 'version = "3"')
    assert run("build").exit_code == 0 and sorted(runs) == ["01_toy"] * 2 + ["02_toy"] * 3


def test_without_numbers_the_lessons_of_the_course_file_are_built(course, runs):
    add_lessons(course, "02", "03")
    write(course.root / "course.toml", "[points]", 'lessons = ["01", "03"]\n[points]')
    assert run("build").exit_code == 0
    assert sorted(path.name for path in Path("notebooks").iterdir()) == ["01_toy.ipynb", "03_toy.ipynb"]
    assert run("build", "02").exit_code == 0 and sorted(runs) == ["01_toy", "02_toy", "03_toy"]
    assert run("build").exit_code == 0 and Path("notebooks/02_toy.ipynb").is_file(), "it is not deleted"


def test_points_of_the_course_file_count(course):
    write(course.root / "course.toml", "[points]", "[points]\ndouble = 2.5")
    assert run("build").exit_code == 0
    assert '"points": 2.5' in Path("notebooks/01_toy.ipynb").read_text()
    write(course.root / "course.toml", "double = 2.5", "treble = 1")
    assert "points for treble, which no lesson declares" in run("build").output


SOLVED = "    ### BEGIN SOLUTION\n    return 2.0 * value\n    ### END SOLUTION"
CELL = "```{code-cell} ipython3"
CHECK = f'{CELL}\n:check: double\n\ncheck("double", double)\n```\n'
DECLARED = "exercises/01_toy.py, 01_toy.md, cell 4 .*"
IN_TEXT = {
    "a cell without options": (":role: display\n", "", "01_toy.md, cell 7 .'print.*needs one of :exercise:"),
    "an unknown role": (":role: display", ":role: dsplay", "cell 7 .*no role 'dsplay'"),
    "no Python": ('print("shown")', "print(", "01_toy.md, cell 7 .*line 1 is not Python"),
    "a solution without an end": ("    ### END SOLUTION\n", "", "cell 4 .*take turns"),
    "no solution": (SOLVED, "    return 2.0 * value", "cell 4 .*needs its sol"),
    "a solution outside an exercise": ('print("shown")', SOLVED, "cell 7 .*stands outside"),
    "another function": ("def double(", "def twice(", "cell 4 .*defines no function"),
    "a check that is edited": ('"double", double)', '"double", print)', "cell 5 .*is exactly: check"),
    "an undeclared check": (":check: double", ":check: treble", "cell 5 .*check treble is not declared"),
    "no cell": (":exercise: double", ":role: display", "exercise double is declared but no cell"),
    "a name in two cells": ('print("shown")\n```\n', f"print(1)\n```\n\n{CHECK}", "2 cells say :check: do"),
    "another lesson's set-up": ('lesson("01_toy")', 'lesson("02_toy")', "cell 2 .*the set-up says"),
    "a header with more": ("kernelspec:", "author: me\nkernelspec:", "the header's 'author' would be lost"),
    "a missing picture": ("Words", "![a](images/a.png) Words", "cell 3 .*images/a.png does not exist"),
    "a wrong solution": ("2.0 * value", "value**2.0", "alternative 'a sum' is not right"),
}
IN_PLAN = {
    "no cases": ("[Case((2.0,)), Case((0.0,)), Case((-1.5,))]", "[]", f"{DECLARED}double: no public cases"),
    "an untold mistake": ("Case((0.0,)), Case((-1.5,))", "Case((0.0,))", "'squared': no public case disting"),
    "a name used twice": ("[DOUBLE]", "[DOUBLE, DOUBLE]", "double: the name is used twice"),
    "what does not run": ("points=1,", "points=1, colour=2,", "01_toy.py: line 3: TypeError"),
    "stars of seven": ("points=1,", "points=1, stars=7,", "01_toy.py: double: stars must be 1, 2 or 3, got"),
    "no tuple": ("Case((2.0,))", "Case((2.0))", f"{DECLARED}public case 1: args must be"),
    "an error in hidden cases": ("(-10, 10, 6)", "(-10, 10, -6)", "its hidden cases: line 7: ValueError"),
}


@pytest.mark.parametrize("what", [*IN_TEXT, *IN_PLAN])
def test_what_is_broken_is_said_with_its_place_and_nothing_is_written(course, what):
    old, new, said = (IN_TEXT | IN_PLAN)[what]
    write(course.text("01_toy") if what in IN_TEXT else course.declaration("01_toy"), old, new)
    before = contents(course.root)
    result = run("build")
    assert result.exit_code == 1 and "Traceback" not in result.output
    assert re.search(said, result.output), result.output
    assert contents(course.root) == before


def test_check_data_that_is_too_much_to_download_is_refused(course, monkeypatch):
    monkeypatch.setattr(proofs, "MOST_CHECK_DATA", 100)
    before = contents(course.root)
    result = run("build")
    assert result.exit_code == 1 and "its check data has 0.0 MB; 0.0001 MB is the most" in result.output
    assert "first of double" in result.output and contents(course.root) == before


def test_what_is_wrong_with_the_declarations_of_all_lessons_is_said_at_once(course):
    declared = course.declaration("01_toy")
    course.text("02_toy").write_text(course.text("01_toy").read_text().replace("01_toy", "02_toy"))
    course.declaration("02_toy").write_text(declared.read_text().replace("01_toy", "02_toy"))
    result = run("build")
    assert result.exit_code == 1 and "exercises/02_toy.py" in result.output
    assert "double: the name is used twice" in result.output
    text = declared.read_text().replace("points=1,", "points=-1,").replace('("Look.", "Nearly.")', '"Look."')
    declared.write_text(text)
    course.declaration("02_toy").write_text("PLAN = 3")
    said = run("build").output
    for problem in ("01_toy.py: double: points must", "01_toy.py: double: hints must", "02_toy.py: it must"):
        assert f"solutions/exercises/{problem}" in said


def test_pictures_and_files_that_a_lesson_links_to_go_with_its_student_copy(course):
    images = course.solutions / "images"
    images.mkdir()
    files = {"a.png": b"png", "sheet.pdf": b"%PDF"}
    for name, content in files.items():
        (images / name).write_bytes(content)
    words = "![a post](images/a.png) Print [the sheet](images/sheet.pdf), and read [more](docs/setup.md)."
    write(course.text("01_toy"), "Words", words)
    assert run("build").exit_code == 0
    assert {path.name: path.read_bytes() for path in Path("notebooks/images").iterdir()} == files


OPENING = "# A toy\n\n![what it shows](images/01_payoff.png)"
PAYOFF = """
```{code-cell} ipython3
:role: payoff

check.payoff(print, double=double)
```
"""


def with_a_payoff(course):
    write(course.text("01_toy"), "# A toy", OPENING)
    with course.text("01_toy").open("a") as text:
        text.write(PAYOFF)


def test_the_picture_that_a_lesson_opens_with_is_the_one_that_its_payoff_drew(course):
    with_a_payoff(course)
    assert run("build", "--no-execute").exit_code == 0
    with pytest.raises(LessonError, match=r"solutions/images/01_payoff.png does not exist"):
        build.build(course, solutions=False)  # it is built before it has ever run, but not released
    assert run("build").exit_code == 0
    for folder in ("notebooks", "solutions"):
        assert (course.root / folder / "images" / "01_payoff.png").read_bytes() == PICTURE
    assert "Nothing has changed." in run("build").output
    course.text("01_toy").unlink()
    assert "deleted notebooks/01_toy.ipynb" in run("build").output
    made = ("images/01_payoff.png", "01_toy.ipynb", "01_toy.bin")
    assert not [path for name in made for path in course.root.glob(f"**/{name}")]


def test_a_payoff_without_a_picture_or_that_the_lesson_does_not_open_with_is_refused(course):
    notebook = lesson_text.read_lesson(course.text("01_toy"), lesson_text.HEADER + OPENING + PAYOFF)
    with pytest.raises(LessonError, match="a payoff shows one picture, this one shows 0"):
        build.payoff_files(notebook)
    with_a_payoff(course)
    whole = course.text("01_toy").read_text()
    for old, new, said in (
        (OPENING, "# A toy", "does not open with its picture"),
        ("01_payoff.png", "01_payoff.jpeg", "does not open with its picture"),
        (PAYOFF, PAYOFF * 2, "only one cell may have :role: payoff"),
    ):
        course.text("01_toy").write_text(whole.replace(old, new))
        assert said in run("build").output


SECOND = """
# Another toy

```{code-cell} ipython3
:role: setup

from nao_course.exercises import lesson
from nao_course.student import earlier

check, hint = lesson("02_more")
double = earlier("01:double")
```

```{code-cell} ipython3
:exercise: quadruple

def quadruple(value: float) -> float:
    \"\"\"Double it twice. Example: quadruple(2.0) is 8.0.\"\"\"
    ### BEGIN SOLUTION
    return double(double(value))
    ### END SOLUTION
```

```{code-cell} ipython3
:check: quadruple

check("quadruple", quadruple)
```
"""


def add_a_second_lesson(course, uses='uses=["01:double"], '):
    """A lesson whose exercise, and its mistakes and alternatives, call a function of the first."""
    (course.solutions / "02_more.md").write_text(lesson_text.HEADER + SECOND)
    text = PLAN
    for old, new in {
        'name="double",': f'name="quadruple", {uses}', "DOUBLE": "QUADRUPLE", "value + value": "double(double(value))",
        "sum([value, value])": "4 * value", "value - -value": "double(value) + double(value)",
        "lambda value: value**2": "lambda value: double(value)", "abs(2 * value)": "abs(4 * value)",
    }.items():  # fmt: skip
        text = text.replace(old, new)
    head = 'from nao_course.student import earlier\n\ndouble = earlier("01:double")\n'
    (course.solutions / "exercises" / "02_more.py").write_text(head + text)


def test_a_lesson_that_uses_an_earlier_one_is_built_without_a_working_folder(course, tmp_path):
    add_a_second_lesson(course)
    assert run("build").exit_code == 0, run("build").output
    (exercise,) = unpack(Path("nao_course/exercises/checks/02_more.bin").read_bytes()).exercises
    assert {(each.use, each.given["value"], each.answer) for each in exercise.earlier} >= {
        ("01:double", 2.0, 4.0),
        ("01:double", 4.0, 8.0),
    }
    assert "Nothing has changed." in run("build", "02").output


@pytest.mark.slow
def test_a_lesson_that_uses_an_earlier_one_runs_with_its_solution(course, kernel):
    add_a_second_lesson(course)
    assert run("build").exit_code == 0
    assert re.search("the public check|all 3 public", Path("solutions/02_more.ipynb").read_text())


@pytest.mark.parametrize(
    ("uses", "message"),
    [
        ("03:double", "02_more: quadruple: it uses '03:double': there is no lesson '03'; there are"),
        ("01:halve", "02_more: quadruple: it uses '01:halve': lesson 01_toy has no exercise 'halve'"),
        ("02:quadruple", "it uses '02:quadruple': lesson 02_more does not come before 02_more"),
        ("quadruple", "it uses 'quadruple': quadruple does not come before it"),
        ("", "quadruple: it calls double of your lesson 01; add '01:double' to its `uses`"),
    ],
)
def test_what_is_used_has_to_be_there_before_and_declared(course, uses, message):
    add_a_second_lesson(course, f'uses=["{uses}"], ' if uses else "")
    result = run("build")
    assert result.exit_code == 1 and message in result.output
    assert not Path("notebooks").exists()


@pytest.fixture
def minimum(course):
    """Return a course whose lesson is declared as in the docs: with cases and a comparison, and nothing else."""
    docs = (PROJECT / "docs" / "write_an_exercise.md").read_text(encoding="utf-8")
    section = docs.split("## A minimum exercise")[1]
    course.declaration("01_toy").write_text(section.split("```python\n")[1].split("```")[0])
    return course


def test_the_docs_minimum_exercise_is_built_and_build_warns_of_few_mistakes_and_alternatives(minimum):
    result = run("build", "--no-execute")
    assert result.exit_code == 0 and "warning" not in result.output, result.output
    checks = unpack(minimum.check_data("01_toy").read_bytes())
    double = checks.exercises[0]
    assert (double.points, len(double.cases), double.mistakes) == (1, 2, [])
    assert grade_public(double, lambda value: value * 2)
    assert grade_public(double, abs).state == "wrong"
    plan = minimum.declaration("01_toy")
    plan.write_text(re.sub(r", waived=\{.*?\}", "", plan.read_text()))
    warning = "warning: solutions/exercises/01_toy.py: double: it has 0 mistakes and 0 alternatives"
    for _ in range(2):  # also where nothing has changed
        result = run("build", "--no-execute")
        assert result.exit_code == 0 and warning in result.output
    plan.write_text(plan.read_text().replace("points=1", "points=0"))
    assert "warning" not in run("build", "--no-execute").output, "an exercise for practice"
