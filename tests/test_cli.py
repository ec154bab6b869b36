"""The command line: what it makes of right and broken lessons, in a small course of its own."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from typer.testing import CliRunner

from nao_course import cli
from nao_course.exercises.exercise import ANSWER_HERE
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.release import release_problems
from tests.paths import PROJECT

TEXT = """
# A toy

```{code-cell} ipython3
:role: setup

from nao_course.exercises import lesson

check, hint = lesson("01_toy")
```

+++ {"slideshow": {"slide_type": "slide"}}

Words with $x^2$ and `code`.

```{code-cell} ipython3
:exercise: double

def double(value: float) -> float:
    \"\"\"Double a number. Example: double(2.0) is 4.0.\"\"\"
    ### BEGIN SOLUTION
    return 2.0 * value
    ### END SOLUTION
```

```{code-cell} ipython3
:check: double

check("double", double)
```

```{raw-cell}
:format: html

<b>raw</b>
```

```{code-cell} ipython3
:role: display
:tags: [wide]

print("shown")
```
"""
PLAN = """from nao_course.exercises import Case, Exercise, LessonPlan, Mistake

DOUBLE = Exercise(
    name="double",
    points=1,
    public=lambda: [Case((2.0,)), Case((0.0,)), Case((-1.5,))],
    hidden=lambda rng: [Case((float(value),)) for value in rng.uniform(-10, 10, 6)],
    hints=("Look.", "Nearly."),
    mistakes=[
        Mistake("not doubled", lambda value: value, "It is what went in."),
        Mistake("squared", lambda value: value**2, "Doubling is not squaring."),
        Mistake("sign lost", lambda value: abs(2 * value), "A negative number stays negative."),
    ],
    alternatives={
        "a sum": lambda value: value + value,
        "sum": lambda value: sum([value, value]),
        "a shift": lambda value: value - -value,
    },
)
PLAN = LessonPlan(exercises=[DOUBLE])
"""


@pytest.fixture
def course(tmp_path, monkeypatch):
    """A course with one small lesson, in the working folder."""
    shutil.copytree(PROJECT / "nao_course", tmp_path / "nao_course", ignore=shutil.ignore_patterns("*.bin"))
    (tmp_path / "solutions" / "exercises").mkdir(parents=True)
    (tmp_path / "solutions" / "01_toy.md").write_text(lesson_text.HEADER + TEXT)
    (tmp_path / "solutions" / "exercises" / "01_toy.py").write_text(PLAN)
    (tmp_path / "course.toml").write_text('title = "Toy"\nversion = "1"\n[points]\n')
    monkeypatch.chdir(tmp_path)
    return load_course()


def run(*words):
    return CliRunner().invoke(cli.app, list(words))


@pytest.fixture(autouse=True)
def _wide(monkeypatch):
    monkeypatch.setattr(cli.console, "width", 200)


def contents(root):
    return {
        path: path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts
    }


def write(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.fixture
def built(course):
    result = run("build")
    assert result.exit_code == 0, result.output
    return course


# --- build ---


def test_build_writes_all_that_is_made_of_a_lesson_and_then_nothing(course):
    assert sorted(run("build").output.split("\n")[:-1])[-3:] == [
        "wrote nao_course/exercises/checks/01_toy.bin",
        "wrote notebooks/01_toy.ipynb",
        "wrote solutions/01_toy.ipynb",
    ]
    before = contents(course.root)
    assert "Nothing has changed." in run("build", "01").output
    assert contents(course.root) == before


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


def with_a_written_question(course):
    write(
        course.text("01_toy"),
        "```{raw-cell}",
        '+++ {"written": "say_why"}\n\nBecause two times one is two.\n\n```{raw-cell}',
    )
    plan = course.solutions / "exercises" / "01_toy.py"
    text = plan.read_text().replace("import Case, Exercise,", "import Written, Case, Exercise,")
    written = 'Written("say_why", 2, "Why is it two?", "one point for each two")'
    plan.write_text(
        text.replace(
            "PLAN = LessonPlan(exercises=[DOUBLE])", f"PLAN = LessonPlan([DOUBLE], written=[{written}])"
        )
    )


def test_a_written_question_is_a_text_cell_that_a_person_marks(course):
    with_a_written_question(course)
    assert run("build").exit_code == 0
    notebook = nbformat.read("notebooks/01_toy.ipynb", as_version=4)
    ((_, cell),) = lesson_text.written_cells(notebook)
    assert cell.source == ANSWER_HERE and "two times one" not in nbformat.writes(notebook)
    assert dict(cell.metadata.nbgrader) | {"checksum": ""} == {
        "schema_version": 3,
        "task": False,
        "cell_type": "markdown",
        "checksum": "",
        "grade": True,
        "solution": True,
        "locked": False,
        "grade_id": "say_why",
        "points": 2.0,
    }
    solved = nbformat.read("solutions/01_toy.ipynb", as_version=4)
    assert lesson_text.written_cells(solved)[0][1].source == "Because two times one is two."
    assert lesson_text.write_lesson(solved) == course.text("01_toy").read_text()
    write(course.text("01_toy"), '"say_why"', '"say_how"')
    assert "begin with +++" in run("build").output


def test_an_instructors_answer_in_a_release_is_refused(course):
    with_a_written_question(course)
    assert run("build").exit_code == 0
    there = Path("notebooks/01_toy.ipynb")
    files = {"release/notebooks/01_toy.ipynb": there.read_bytes()}
    assert release_problems(course, files) == []
    leaking = there.read_text().replace(ANSWER_HERE, "Because two times one is two.")
    assert any(
        "a written answer is in it" in each
        for each in release_problems(course, {"release/notebooks/01_toy.ipynb": leaking.encode()})
    )


def test_points_of_the_course_file_count(course):
    write(course.root / "course.toml", "[points]", "[points]\ndouble = 2.5")
    assert run("build").exit_code == 0
    assert '"points": 2.5' in Path("notebooks/01_toy.ipynb").read_text()
    write(course.root / "course.toml", "double = 2.5", "treble = 1")
    assert "points for treble, which no lesson declares" in run("build").output


MARK = "### BEGIN SOLUTION"
BROKEN = {
    "a cell without options": (
        TEXT,
        ":role: display\n",
        "",
        r"01_toy.md, cell 7 \('print.*needs one of :exercise:",
    ),
    "an unknown role": (TEXT, ":role: display", ":role: dsplay", r"cell 7 .*no role 'dsplay'"),
    "no Python": (TEXT, 'print("shown")', "print(", r"01_toy.md, cell 7 .*line 1 is not Python"),
    "a solution without an end": (TEXT, "    ### END SOLUTION\n", "", r"cell 4 .*take turns"),
    "no solution": (
        TEXT,
        f"    {MARK}\n    return 2.0 * value\n    ### END SOLUTION",
        "    return 2.0 * value",
        r"cell 4 .*needs its sol",
    ),
    "another function": (
        TEXT,
        "def double(",
        "def twice(",
        r"cell 4 .*defines no function or class of that name",
    ),
    "a check that is edited": (
        TEXT,
        'check("double", double)',
        'check("double", print)',
        r"cell 5 .*is exactly: check",
    ),
    "an undeclared check": (
        TEXT,
        ":check: double",
        ":check: treble",
        r"cell 5 .*check treble is not declared",
    ),
    "no cell for an exercise": (
        TEXT,
        ":exercise: double",
        ":role: display",
        r"exercise double is declared but no cell",
    ),
    "a name in two cells": (
        TEXT,
        'print("shown")\n```\n',
        'print("shown")\n```\n\n```{code-cell} ipython3\n:check: double\n\ncheck("double", double)\n```\n',
        "2 cells say :check: double",
    ),
    "another lesson's set-up": (TEXT, 'lesson("01_toy")', 'lesson("02_toy")', r"cell 2 .*the set-up says"),
    "a header with more": (TEXT, "# A toy", "# A toy", "the header's 'author' would be lost"),
    "an exception": (TEXT, 'print("shown")', "1 / 0", r"01_toy.md, cell 7 .*ZeroDivisionError"),
    "a warning": (TEXT, 'print("shown")', 'import warnings\nwarnings.warn("old")', r"cell 7 .*it warns"),
    "an address": (TEXT, 'print("shown")', "object()", r"cell 7 .*shows an address"),
    "a path of this machine": (
        TEXT,
        'print("shown")',
        "import sys\nsys.prefix",
        r"cell 7 .*path of this machine",
    ),
    "a picture that is missing": (
        TEXT,
        "Words",
        "![a](images/a.png) Words",
        r"cell 3 .*images/a.png does not exist",
    ),
    "a wrong solution": (TEXT, "2.0 * value", "value**2.0", "alternative 'a sum' is not right"),
    "no cases": (
        PLAN,
        "[Case((2.0,)), Case((0.0,)), Case((-1.5,))]",
        "[]",
        r"exercises/01_toy.py, 01_toy.md, cell 4 .*double: no public cases",
    ),
    "a mistake that no case tells": (
        PLAN,
        "Case((0.0,)), Case((-1.5,))",
        "Case((0.0,))",
        "mistake 'squared': no public case tells",
    ),
    "a name used twice": (PLAN, "[DOUBLE]", "[DOUBLE, DOUBLE]", "double: the name is used twice"),
    "a declaration that does not run": (PLAN, "points=1,", "points=1, colour=2,", "01_toy.py: TypeError"),
}


@pytest.mark.parametrize("what", BROKEN)
def test_what_is_broken_is_said_with_its_place_and_nothing_is_written(course, what):
    source, old, new, said = BROKEN[what]
    path = course.text("01_toy") if source is TEXT else course.solutions / "exercises" / "01_toy.py"
    write(path, old, new)
    if what == "a header with more":
        write(path, "kernelspec:", "author: me\nkernelspec:")
    before = contents(course.root)
    result = run("build")
    assert result.exit_code == 1
    assert re.search(said, result.output), result.output
    assert "Traceback" not in result.output
    assert contents(course.root) == before


def test_a_name_of_another_lesson_is_refused(course):
    for suffix, folder in ((".md", course.solutions), (".py", course.solutions / "exercises")):
        text = (folder / f"01_toy{suffix}").read_text()
        (folder / f"02_toy{suffix}").write_text(text.replace("01_toy", "02_toy"))
    result = run("build")
    assert (
        result.exit_code == 1
        and "exercises/02_toy.py" in result.output
        and "double: the name is used twice" in result.output
    )


def test_a_lesson_that_is_taken_out_takes_what_was_made_of_it_along(built):
    built.text("01_toy").unlink()
    assert "took away notebooks/01_toy.ipynb" in run("build").output
    assert not list(built.root.glob("**/01_toy.ipynb")) + list(built.root.glob("**/01_toy.bin"))


def test_the_pictures_of_a_lesson_go_with_its_student_copy(course):
    (course.solutions / "images").mkdir()
    (course.solutions / "images" / "a.png").write_bytes(b"png")
    write(course.text("01_toy"), "Words", "![a post](images/a.png) Words")
    assert run("build").exit_code == 0
    assert Path("notebooks/images/a.png").read_bytes() == b"png"


# --- from the notebook back into the text ---


def edit(change):
    path = Path("solutions/01_toy.ipynb")
    notebook = nbformat.read(path, as_version=4)
    change(notebook.cells)
    nbformat.write(notebook, path)


def as_jupyterlab_does(cells):
    """Edit words and code, move and add cells, run, fold: what happens in JupyterLab."""
    cells[2].source = "Other **words**.\n\n- a\n- b\n\n```python\nnot_a_cell()\n```\n\n(eq-1)=\n$$ x = 1 $$"
    cells[3].source = cells[3].source.replace("2.0 * value", "value + value  # clearer")
    cells[6].execution_count, cells[6].outputs = 9, [nbformat.v4.new_output("stream", text="other")]
    cells[6].metadata["collapsed"] = True
    cells[6].metadata["execution"] = {"iopub.status.busy": "now"}
    cells.append(nbformat.v4.new_code_cell("%matplotlib inline\nprint('new')", metadata={"tags": ["new"]}))
    cells.append(nbformat.v4.new_markdown_cell("Also new.", metadata={"slideshow": {"slide_type": "notes"}}))
    cells.append(nbformat.v4.new_raw_cell("<i>raw</i>"))
    cells.append(nbformat.v4.new_code_cell(""))
    cells.insert(2, cells.pop(6))


def test_a_notebook_edited_in_jupyterlab_comes_back_into_the_text_with_nothing_lost(built):
    edit(as_jupyterlab_does)
    edited = nbformat.read("solutions/01_toy.ipynb", as_version=4).cells[:-1]  # an empty cell is nothing
    result = run("build", "--from-notebook", "01")
    assert result.exit_code == 0, result.output
    assert "wrote solutions/01_toy.md" in result.output
    again = lesson_text.read_lesson(built.text("01_toy"))
    assert [(cell.cell_type, cell.source) for cell in again.cells] == [
        (cell.cell_type, cell.source) for cell in edited
    ]
    text = built.text("01_toy").read_text()
    assert ":role: display\n:tags: [new]" in text and ":exercise: double" in text and "collapsed" not in text
    assert '+++ {"slideshow": {"slide_type": "notes"}}' in text and "```{raw-cell}\n:format: html" in text
    assert "clearer" not in Path("notebooks/01_toy.ipynb").read_text()
    assert "Nothing has changed." in run("build").output


def test_only_what_was_edited_differs_in_the_text(built):
    before = built.text("01_toy").read_text()
    edit(lambda cells: cells[2].update(source="Changed."))
    assert run("build", "--from-notebook", "01").exit_code == 0
    assert built.text("01_toy").read_text() == before.replace("Words with $x^2$ and `code`.", "Changed.")


def test_when_both_were_edited_nothing_is_written(built):
    edit(as_jupyterlab_does)
    write(built.text("01_toy"), "Words", "My words")
    before = contents(built.root)
    result = run("build", "--from-notebook", "01")
    assert (
        result.exit_code == 1 and "were both edited since the last build; nothing is written" in result.output
    )
    assert contents(built.root) == before


def test_an_edited_notebook_is_not_built_over(built):
    edit(as_jupyterlab_does)
    before = contents(built.root)
    result = run("build")
    assert result.exit_code == 1 and "--from-notebook 01" in result.output
    assert contents(built.root) == before


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda cells: None, "there is nothing to bring back"),
        (
            lambda cells: cells[2].update(attachments={"a.png": {"image/png": ""}}),
            r"cell 3.*a picture was pasted",
        ),
        (
            lambda cells: cells[2].update(source="one\n\n+++\n\ntwo"),
            r"cell 3.*MyST would read it as another cell",
        ),
        (
            lambda cells: cells[2].metadata.update(nbgrader={"grade": True}),
            r"cell 3.*a graded text cell is a written answer",
        ),
        (lambda cells: cells[3].update(source="def double(value):"), r"cell 4.*is not Python"),
        (lambda cells: cells[4].metadata.nbgrader.update(points=7), "the points of double were changed"),
    ],
    ids=["nothing", "attachment", "a break", "a graded text", "broken code", "points"],
)
def test_what_text_cannot_hold_is_refused(built, change, said):
    edit(change)
    before = contents(built.root)
    result = run("build", "--from-notebook", "01")
    assert result.exit_code == 1 and re.search(said, result.output), result.output
    assert contents(built.root) == before


# --- check, submit, new, release ---


def test_check_says_in_a_table_what_is_right_and_what_is_not():
    blank, solved = (
        str(PROJECT / folder / "01_hsl_filtering.ipynb") for folder in ("notebooks", "solutions")
    )
    result = run("check", solved)
    assert result.exit_code == 0 and result.output.count("✔ passes") == 6
    assert result.output.count("● written") == 1
    result = run("check", blank)
    assert result.exit_code == 1 and result.output.count("○ not attempted") == 6
    assert result.output.count("○ nothing written") == 1


def test_check_names_what_went_wrong(tmp_path):
    path = tmp_path / "00_meet_the_nao.ipynb"
    notebook = nbformat.read(PROJECT / "notebooks" / path.name, as_version=4)
    (cell,) = (cell for _, cell in lesson_text.code_cells(notebook, "exercise"))
    cell.source = "def to_radians(angle_deg):\n    return angle_deg"
    nbformat.write(notebook, path)
    result = run("check", str(path))
    assert result.exit_code == 1 and "✘ wrong" in result.output and "still in degrees" in result.output
    cell.source = "def to_radians(angle_deg:"
    nbformat.write(notebook, path)
    assert "SyntaxError" in run("check", str(path)).output
    path.write_text("{")
    result = run("check", str(path))
    assert result.exit_code == 1 and "not a notebook" in result.output
    assert "there is no file" in run("check", str(tmp_path / "x.ipynb")).output
    shutil.copy(path, tmp_path / "x.ipynb")
    assert "there is no lesson 'x'" in run("check", str(tmp_path / "x.ipynb")).output
    assert "is no folder" in run("submit", str(path), "--out", str(tmp_path)).output


def test_submit_says_where_the_zip_is_and_what_the_receipt_is(tmp_path):
    result = run("submit", str(PROJECT / "notebooks"), "--out", str(tmp_path))
    (made,) = tmp_path.iterdir()
    assert result.exit_code == 0 and made.name in result.output and "Your receipt is in it" in result.output
    assert "01_hsl_filtering: 0 of 6 exercises pass their public checks; not yet: rgb_to_hsl" in result.output
    assert "1.W1 (nothing written)" in result.output
    hand_in, state = (result.output.index(words) for words in ("Hand in ", "pass their public checks"))
    assert hand_in < state, "a student's code that never ends keeps nobody from handing in"
    result = run("submit", str(PROJECT / "solutions"), "--out", str(tmp_path / "solved"))
    assert "01_hsl_filtering: 6 of 6 exercises pass their public checks.\n" in result.output


def test_a_new_lesson_and_a_new_exercise_build_and_cannot_be_released_unfinished(built):
    assert run("new", "lesson", "07", "ekf_slam").exit_code == 0
    for name in ("predict_it", "update_it"):
        result = run("new", "exercise", "07", name)
        assert result.exit_code == 0, result.output
    assert run("new", "exercise", "01", "treble").exit_code == 0
    result = run("build")
    assert result.exit_code == 0, result.output
    shown = Path("notebooks/07_ekf_slam.ipynb").read_text()
    assert shown.index("predict_it") < shown.index("update_it") < shown.index("References")
    for name in ("LICENSE", "Makefile", "pyproject.toml", "requirements.lock", "docs/for_students.md"):
        (built.root / name).parent.mkdir(exist_ok=True)
        shutil.copy(PROJECT / name, built.root / name)
    result = run("release", "--out", "dist")
    assert result.exit_code == 1 and "07_ekf_slam.ipynb says TODO" in result.output
    assert not Path("dist").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("lesson", "01", "again"), "lesson 01 is there already: 01_toy"),
        (("lesson", "7", "ekf"), "a lesson is two digits and a name"),
        (("exercise", "01", "double"), "lesson 01_toy has an exercise double already"),
        (("exercise", "01", "Double"), "an exercise is named like a function"),
        (("exercise", "05", "x"), "there is no lesson 05"),
    ],
)
def test_a_scaffold_that_cannot_be_is_refused(course, words, said):
    before = contents(course.root)
    result = run("new", *words)
    assert result.exit_code == 1 and said in result.output
    assert contents(course.root) == before


def test_outside_a_course_build_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("build")
    assert result.exit_code == 1 and "no course.toml in this folder or above" in result.output
    (tmp_path / "course.toml").write_text('title = "x"\n')
    assert "course.toml: KeyError: 'version'" in run("build").output
    (tmp_path / "course.toml").write_text('title = "x"\nversion = "1"\ncolour = 3\n')
    assert "['colour'] is not understood" in run("build").output


STUDENTS_PYTHON = """
import sys
for name in ("jupytext", "nbgrader", "nbclient", "IPython", "cosmic_ray"):
    sys.modules[name] = None  # as if it were not installed
from nao_course.cli import app
app(sys.argv[1:])
"""


def test_a_students_side_needs_the_core_alone_and_the_instructors_says_what_it_misses(tmp_path):
    def run_as_student(*words, here=PROJECT):
        environment = {**os.environ, "PYTHONPATH": str(here), "COLUMNS": "200"}
        command = [sys.executable, "-c", STUDENTS_PYTHON, *words]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)

    notebook = str(PROJECT / "solutions" / "01_hsl_filtering.ipynb")
    assert run_as_student("check", notebook).returncode == 0
    assert run_as_student("submit", str(PROJECT / "notebooks")).returncode == 0
    assert run_as_student("renew").returncode == 0
    refused = run_as_student("build")
    assert refused.returncode == 1 and "not available here: it needs" in refused.stderr
    shutil.copytree(
        PROJECT / "nao_course", tmp_path / "nao_course", ignore=shutil.ignore_patterns("instructor")
    )
    refused = run_as_student("release", "--out", "x", here=tmp_path)
    assert refused.returncode == 1 and "the instructor's side" in refused.stderr


# --- what the documentation says ---


@pytest.mark.slow
@pytest.mark.parametrize("page", ["write_a_lesson", "write_an_exercise"])
def test_the_documentation_can_be_followed_word_for_word(page, tmp_path, monkeypatch):
    """Run the commands of a page in a copy of the course, but for those that stand for any lesson, NN."""
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    shutil.copytree(PROJECT / "nao_course", tmp_path / "nao_course")
    shutil.copytree(PROJECT / "solutions", tmp_path / "solutions")
    shutil.copytree(PROJECT / "notebooks", tmp_path / "notebooks")
    shutil.copy(PROJECT / "course.toml", tmp_path)
    monkeypatch.chdir(tmp_path)
    text = (PROJECT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```\n((?:(?:nao-course|rm) .*\n)+)```", text, re.MULTILINE)
    commands = [line.split() for block in blocks for line in block.splitlines() if " NN" not in line]
    assert len(commands) >= 3
    for program, *words in commands:
        if program == "rm":
            for word in words:
                Path(word).unlink()
        else:
            assert program == "nao-course"
            command = [sys.executable, "-m", "nao_course.cli", *words]
            done = subprocess.run(command, env=environment, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
    there = contents(tmp_path / "notebooks").keys()
    if page == "write_a_lesson":
        assert {path.name for path in there} == {
            path.name for path in (PROJECT / "notebooks").glob("*.ipynb")
        }
