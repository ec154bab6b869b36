"""What students get and give back: no secret in the zip, no work lost to a newer one, a receipt."""

import hashlib
import json
import os
import shutil
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import nbformat
import pytest

from nao_course import homework
from nao_course.instructor.authoring import build as building
from nao_course.instructor.authoring import lesson_text as lessons
from nao_course.instructor.authoring import release
from nao_course.instructor.authoring.leaks import SMALLEST, fingerprints
from nao_course.instructor.authoring.lesson_text import LessonError
from tests.paths import PROJECT

COURSE = building.load_course(PROJECT)
NOTEBOOK = "release/notebooks/01_hsl_filtering.ipynb"


@pytest.fixture(scope="module")
def files():
    return release.contents(COURSE, COURSE.names())


def notebook_with(files, source, kind="code"):
    notebook = nbformat.reads(files[NOTEBOOK].decode(), as_version=4)
    made = {"code": nbformat.v4.new_code_cell, "markdown": nbformat.v4.new_markdown_cell}[kind](source)
    notebook.cells.insert(5, made)
    return {**files, NOTEBOOK: nbformat.writes(notebook).encode()}


# --- what is in the zip ---


def test_the_zip_has_what_make_lab_needs_and_nothing_of_the_instructors(files):
    assert {"Makefile", "pyproject.toml", "requirements.lock", "LICENSE", "README.md"} <= files.keys()
    assert {"nao_course/cli.py", "nao_course/homework.py", "nao_course/geometry.py", NOTEBOOK} <= files.keys()
    assert "nao_course/lessons/hsl_filtering/panel.py" in files
    parts = {part for name in files for part in Path(name).parts}
    assert not parts & {"instructor", "solutions", "tests", "benchmarks", "__pycache__", "course.toml"}
    assert not [name for name in files if name.startswith("notebooks/")], "students work there"


def test_a_release_says_its_version_in_a_file_and_in_each_notebook(files):
    stamp = json.loads(files["release/release.json"])
    assert (stamp["version"], stamp["title"]) == (COURSE.version, COURSE.title)
    for name in COURSE.names():
        content = files[f"release/notebooks/{name}.ipynb"]
        assert json.loads(content)["metadata"]["nao_course"] == {"lesson": name, "version": COURSE.version}
        assert stamp["lessons"][name] == hashlib.sha256(content).hexdigest()


def test_two_releases_of_one_course_are_the_same_bytes(tmp_path):
    first, second = (release.make_release(COURSE, tmp_path / each) for each in ("a", "b"))
    assert first.read_bytes() == second.read_bytes()
    assert all(name.startswith("nao-course/") for name in zipfile.ZipFile(first).namelist())


def test_only_the_chosen_lessons_are_released():
    course = replace(COURSE, chosen=("00",))
    chosen = release.contents(course, course.names(course.chosen))
    assert [name for name in chosen if name.endswith((".ipynb", ".bin"))] == [
        "nao_course/exercises/checks/00_meet_the_nao.bin",
        "release/notebooks/00_meet_the_nao.ipynb",
    ]


def test_a_lesson_that_is_not_built_is_not_released(tmp_path):
    course = replace(COURSE, version="another")
    with pytest.raises(LessonError, match="00_meet_the_nao.ipynb.*run `nao-course build` first"):
        release.make_release(course, tmp_path)
    assert not list(tmp_path.iterdir())


# --- secrets ---


def test_nothing_in_the_release_is_a_secret(files):
    assert release.release_problems(COURSE, files) == []


def secret_pieces():
    """A piece of each kind of secret: lines of a solution, of a mistake or alternative, and of hidden cases."""
    notebook = building.read_notebook(COURSE.solutions / "01_hsl_filtering.ipynb")
    cell = next(cell for cell in notebook.cells if "def rgb_to_hsl" in cell.source)
    solution = cell.source.split("### BEGIN SOLUTION\n")[1].split("    ### END SOLUTION")[0]
    declared = (COURSE.solutions / "exercises" / "01_hsl_filtering.py").read_text(encoding="utf-8")
    helper = declared[declared.index("def picture(") : declared.index("def primaries(")]
    mistake = declared[declared.index("def _hsl(") : declared.index("def _overflow(")]
    return {
        "solution": f"def f(picture):\n{solution}",
        "hidden": helper,
        "mistake": mistake,
        "hidden under other names": helper.replace("rng", "r")
        .replace("colours", "c")
        .replace("kinds", "which"),
        "solution under other names": f"def g(p):\n{solution}".replace("picture", "p").replace(
            "spread", "width"
        ),
        "solution with comments": f'def f(picture):\n    "Mine."\n    # well\n{solution}',
    }


@pytest.mark.parametrize("piece", secret_pieces())
@pytest.mark.parametrize("where", ["module", "cell", "fence", "string"])
def test_a_planted_secret_is_found_wherever_it_stands(files, piece, where):
    source = secret_pieces()[piece]
    planted = {
        "module": files | {"nao_course/sim/extra.py": f"import numpy as np\n\n\n{source}".encode()},
        "cell": notebook_with(files, f"%matplotlib inline\n{source}"),
        "string": notebook_with(files, f"exec({source!r})"),
        "fence": notebook_with(files, f"Look:\n\n```python\n{source}\n```\n", "markdown"),
    }[where]
    problems = release.release_problems(COURSE, planted)
    place = "extra.py" if where == "module" else "cell 6"
    assert problems and all(place in problem for problem in problems)


def test_a_solution_that_was_left_in_is_found(files):
    problems = release.release_problems(COURSE, notebook_with(files, "### BEGIN SOLUTION\n### END SOLUTION"))
    assert [problem.split("says ")[1] for problem in problems] == ["### BEGIN SOLUTION", "### END SOLUTION"]
    assert "TODO" in release.release_problems(COURSE, notebook_with(files, "TODO", "markdown"))[0]


def test_a_fingerprint_sees_through_names_docstrings_wrapping_and_the_way_numbers_are_written():
    first = 'def f(a, b):\n    """One."""\n    c = a * 2 + np.sqrt(b ** 2 + 1)\n    return c'
    second = "def g(x, y):\n    return x * 2.0 + np.sqrt(y**2 + 1.0)  # two"
    third = "h = lambda u, v: u * 2 + np.sqrt(v ** 2 + 1)"
    marks = [{mark for mark, _ in fingerprints(source)} for source in (first, second, third)]
    assert marks[0] & marks[1] & marks[2]
    other = "def g(x, y):\n    return x * 2.0 + np.sqrt(x**2 + 1.0)"
    assert not marks[0] & {mark for mark, _ in fingerprints(other)}


def test_what_is_alike_by_accident_has_no_fingerprint():
    assert SMALLEST > 6
    for common in (
        "height, width = picture.shape[:2]",
        "return np.array(points)",
        "import numpy as np",
        "x = 1",
    ):
        assert list(fingerprints(common)) == []


# --- a newer release ---


@pytest.fixture
def unpacked(files, tmp_path):
    """A student's folder, in which the release was unpacked and the lessons were laid out once."""
    unpack(files, tmp_path)
    assert [str(each) for each in homework.renew(tmp_path)] == [
        f"{name}.ipynb: as released" for name in COURSE.names()
    ]
    return tmp_path


def unpack(files, folder):
    for name, content in files.items():
        if name.startswith("release/"):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)


def edit(path, change):
    notebook = nbformat.read(path, as_version=4)
    change(notebook.cells)
    nbformat.write(notebook, path)


def cell_with(cells, text):
    return next(cell for cell in cells if text in cell.source)


def newer(files):
    """A release in which lesson 01 has another first line, one more cell, and another text before exercise 1.2."""
    notebook = nbformat.reads(files[NOTEBOOK].decode(), as_version=4)
    notebook.cells[0].source += "\n\nNew in this release."
    notebook.cells.insert(2, nbformat.v4.new_markdown_cell("A new cell.", id="lesson01-999"))
    cell_with(notebook.cells, "def hue_mask").source += "\n    # a better stub"
    return {**files, NOTEBOOK: nbformat.writes(notebook).encode()}


def test_laying_out_again_changes_nothing(unpacked):
    mine = unpacked / "notebooks" / "01_hsl_filtering.ipynb"
    edit(mine, lambda cells: cells.pop(-1))
    before = mine.read_bytes()
    assert homework.renew(unpacked) == []
    assert mine.read_bytes() == before


def test_an_untouched_notebook_is_replaced_even_when_it_was_run(unpacked, files):
    mine = unpacked / "notebooks" / "01_hsl_filtering.ipynb"

    def ran(cells):
        cell = cell_with(cells, "def hue_mask")
        cell.execution_count, cell.outputs = 7, [nbformat.v4.new_output("stream", text="x")]

    edit(mine, ran)
    unpack(newer(files), unpacked)
    assert [str(each) for each in homework.renew(unpacked)] == ["01_hsl_filtering.ipynb: as released"]
    assert mine.read_bytes() == newer(files)[NOTEBOOK]
    assert not (unpacked / "notebooks" / "kept").exists()


def test_a_newer_release_keeps_a_students_work(unpacked, files):
    mine = unpacked / "notebooks" / "01_hsl_filtering.ipynb"

    def work(cells):
        cell_with(cells, "def hue_mask").source = "def hue_mask(hue, low, high):\n    return hue > low"
        cell_with(cells, "**Predict:**").source += "\n\nI say 7 %."
        cells[0].source += "\n\nmy note"  # where the release has a new text, too
        place = cells.index(cell_with(cells, 'check("hue_mask"'))
        cells.insert(place + 1, nbformat.v4.new_code_cell('hint("hue_mask")'))
        cells.remove(cell_with(cells, "## References"))
        cell_with(cells, 'check("rgb_to_hsl"').source = "passed = True"

    edit(mine, work)
    as_it_was = mine.read_bytes()
    unpack(newer(files), unpacked)
    (renewal,) = homework.renew(unpacked)
    assert renewal.carried == 3
    assert renewal.lost == ("# HSL filtering",)
    assert (unpacked / renewal.kept).read_bytes() == as_it_was
    notebook = nbformat.read(mine, as_version=4)
    nbformat.validate(notebook)
    sources = [cell.source for cell in notebook.cells]
    assert "def hue_mask(hue, low, high):\n    return hue > low" in sources
    assert any(source.endswith("I say 7 %.") for source in sources)
    assert sources[sources.index('check("hue_mask", hue_mask)') + 1] == 'hint("hue_mask")'
    assert sources[0].endswith("New in this release.") and "A new cell." in sources
    assert 'check("rgb_to_hsl", rgb_to_hsl)' in sources and "passed = True" not in sources
    assert homework.renew(unpacked) == []


def test_work_survives_a_second_renewal_and_a_missing_memory_of_what_was_given(unpacked, files):
    mine = unpacked / "notebooks" / "01_hsl_filtering.ipynb"
    answer = "def hue_mask(hue, low, high):\n    return hue > low"

    def work(cells):
        cell_with(cells, "def hue_mask").source = answer

    edit(mine, work)
    for release_files in (newer(files), files):
        unpack(release_files, unpacked)
        (renewal,) = homework.renew(unpacked)
        assert renewal.carried == 1
    shutil.rmtree(unpacked / "notebooks" / ".given")
    (renewal,) = [each for each in homework.renew(unpacked) if each.kept]
    assert answer in [cell.source for cell in nbformat.read(mine, as_version=4).cells]
    assert len(list((unpacked / "notebooks" / "kept").iterdir())) == 3


def test_a_broken_notebook_is_kept_and_a_new_one_stands_in_its_place(unpacked, files):
    mine = unpacked / "notebooks" / "01_hsl_filtering.ipynb"
    mine.write_text("{ half of it")
    unpack(newer(files), unpacked)
    (renewal,) = homework.renew(unpacked)
    assert (unpacked / renewal.kept).read_text() == "{ half of it"
    nbformat.validate(nbformat.read(mine, as_version=4))


# --- handing in ---


def test_a_submission_holds_the_notebooks_helpers_and_a_receipt(unpacked, tmp_path):
    folder = unpacked / "notebooks"
    (folder / "my_helpers.py").write_text("x = 1\n")
    (folder / "notes.ipynb").write_text("not of the course")
    receipt = homework.submit(folder, tmp_path / "out")
    with zipfile.ZipFile(receipt.path) as archive:
        names = set(archive.namelist())
        kept = json.loads(archive.read("receipt.json"))
        content = archive.read("my_helpers.py")
    assert names == {"00_meet_the_nao.ipynb", "01_hsl_filtering.ipynb", "my_helpers.py", "receipt.json"} | {
        f"{name}.ipynb" for name in COURSE.names()
    }
    assert kept["files"]["my_helpers.py"] == hashlib.sha256(content).hexdigest()
    assert kept["versions"]["release"] == COURSE.version
    told = {key: kept[key] for key in ("time", "files", "versions")}
    assert (
        kept["code"] == receipt.code == hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()
    )


def test_what_cannot_be_handed_in_is_said(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"no lesson's notebook \(such as 01_hsl_filtering.ipynb\)"):
        homework.submit(tmp_path, tmp_path)
    (tmp_path / "01_hsl_filtering.ipynb").write_text("{}")
    with pytest.raises(ValueError, match="01_hsl_filtering.ipynb is not a notebook"):
        homework.submit(tmp_path, tmp_path)
    shutil.copy(PROJECT / "notebooks" / "01_hsl_filtering.ipynb", tmp_path)
    monkeypatch.setattr(homework, "MOST_BYTES", 1000)
    with pytest.raises(ValueError, match="Clear Outputs of All Cells"):
        homework.submit(tmp_path, tmp_path)


# --- nbgrader ---


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Object of type <Submitted")  # nbgrader's own, from SQLAlchemy
@pytest.mark.parametrize("name", COURSE.names())
def test_nbgrader_makes_validates_and_grades_the_release(name, files, tmp_path, monkeypatch):
    """The executed solution is nbgrader's source; a solved and a blank copy of the release are handed in."""
    from nbgrader.apps import NbGraderAPI
    from nbgrader.validator import Validator
    from traitlets.config import Config

    monkeypatch.setenv("PYTHONPATH", str(PROJECT))
    beside_python = str(Path(sys.executable).parent)  # nbgrader looks for its alembic on the path
    monkeypatch.setenv("PATH", os.pathsep.join([beside_python, os.environ["PATH"]]))
    monkeypatch.chdir(tmp_path)
    blank = nbformat.reads(files[f"release/notebooks/{name}.ipynb"].decode(), as_version=4)
    solved = nbformat.from_dict(blank)
    solutions = {
        lessons.exercise_name(cell): cell.source
        for _, cell in lessons.code_cells(lessons.read_lesson(COURSE.text(name)), "exercise")
    }
    for _, cell in lessons.code_cells(solved, "exercise"):
        cell.source = solutions[lessons.exercise_name(cell)]
    for _, cell in lessons.written_cells(solved):
        cell.source = "One pixel decides it."
    for student, notebook in (("blank", blank), ("solved", solved)):
        (tmp_path / "submitted" / student / name).mkdir(parents=True)
        nbformat.write(notebook, tmp_path / "submitted" / student / name / f"{name}.ipynb")
    (tmp_path / "source" / name).mkdir(parents=True)
    shutil.copy(COURSE.solutions / f"{name}.ipynb", tmp_path / "source" / name)

    config = Config()
    config.CourseDirectory.root = str(tmp_path)
    config.ExecutePreprocessor.timeout = 120
    api = NbGraderAPI(config=config)
    for result in (
        api.generate_assignment(name),
        api.autograde(name, "solved"),
        api.autograde(name, "blank"),
    ):
        assert result["success"], result["log"] + str(result["error"])
    assert (tmp_path / "release" / name / f"{name}.ipynb").is_file()
    plan = COURSE.plan(name)
    points = sum(exercise.points for exercise in plan.exercises)
    with api.gradebook as gradebook:
        scores = {student: gradebook.find_submission(name, student).score for student in ("solved", "blank")}
        assert gradebook.find_assignment(name).max_score == sum(plan.points.values())
    assert scores == {"solved": points, "blank": 0}

    submitted = tmp_path / "submitted"
    found = Validator().validate(str(submitted / "solved" / name / f"{name}.ipynb"))
    assert not set(found) & {"failed", "changed", "type_changed"}, found
    found = Validator().validate(str(submitted / "blank" / name / f"{name}.ipynb"))
    assert len(found["failed"]) == len(COURSE.plan(name).points)
