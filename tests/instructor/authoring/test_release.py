"""What students get: all that make lab needs, and nothing of an instructor's."""

import hashlib
import json
import os
import shutil
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import nbformat
import numpy as np
import pytest

from nao_course._internal.personal_world import personal_world
from nao_course.exercises.checking import pack, unpack
from nao_course.exercises.exercise import ANSWER_HERE
from nao_course.instructor.authoring import lesson_text, release
from nao_course.instructor.authoring.course import LessonError, load_course
from nao_course.instructor.authoring.perturbation import perturbed
from nao_course.instructor.authoring.release import nbgrader_config, release_problems
from nao_course.instructor.collecting.roster import Student
from nao_course.instructor.gradebook.journal import Journal
from tests.paths import PROJECT
from tests.toy.course import run, with_a_written_question

COURSE = load_course(PROJECT)
NOTEBOOK = "release/notebooks/01_hsl_filtering.ipynb"


@pytest.fixture(scope="module")
def files():
    return release.contents(COURSE, COURSE.names())


def test_the_zip_has_every_file_of_the_students_library_and_nothing_of_the_instructors(files):
    assert {
        "Makefile",
        "pyproject.toml",
        "requirements.lock",
        "LICENSE",
        "README.md",
        "AGENTS.md",
    } <= files.keys()
    assert {"nao_course/cli.py", "nao_course/homework.py", "nao_course/geometry.py", NOTEBOOK} <= files.keys()
    room = "nao_course/lessons/hsl_filtering"
    assert {f"{room}/panel.py", f"{room}/challenge.json"} <= files.keys(), "a board without rows says nothing"
    parts = {part for name in files for part in Path(name).parts}
    assert not parts & {"instructor", "solutions", "tests", "benchmarks", "__pycache__", "course.toml"}
    assert not [name for name in files if name.startswith("notebooks/")], "students work there"
    # A lesson's log that is left out is a traceback in the lesson's first cell.
    package = PROJECT / "nao_course"
    theirs = [
        path.relative_to(PROJECT).as_posix()
        for path in package.rglob("*")
        if path.is_file() and not {"instructor", "__pycache__"} & set(path.relative_to(package).parts)
    ]
    assert len(theirs) > 200 and [name for name in theirs if name not in files] == []


def test_a_release_says_its_version_in_each_notebook_and_has_only_the_chosen_lessons(files):
    stamp = json.loads(files["release/release.json"])
    assert (stamp["version"], stamp["title"]) == (COURSE.version, COURSE.title)
    for name in COURSE.names():
        content = files[f"release/notebooks/{name}.ipynb"]
        assert json.loads(content)["metadata"]["nao_course"] == {"lesson": name, "version": COURSE.version}
        assert stamp["lessons"][name] == hashlib.sha256(content).hexdigest()
    course = replace(COURSE, chosen=("00",))
    chosen = release.contents(course, course.names(course.chosen))
    made = [name for name in chosen if name.endswith((".ipynb", ".bin")) or "/outlines/" in name]
    folders = ("nao_course/exercises/checks", "nao_course/exercises/outlines", "release/notebooks")
    assert sorted(f"{Path(name).parent}" for name in made) == list(folders)
    assert {Path(name).stem for name in made} == {"00_meet_the_nao"}


def test_tools_with_language_models_are_asked_to_help_and_how_they_recognise_an_exercise(files):
    page = files["AGENTS.md"].decode()
    assert '`"nao_course": {"role": "exercise"}`' in page and '`"role": "written"`' in page
    assert "AGENTS.md" in json.loads(files["release/release.json"])["language models"]
    for name in COURSE.names():
        cells = json.loads(files[f"release/notebooks/{name}.ipynb"])["cells"]
        theirs = [cell for cell in cells if cell["metadata"].get("nbgrader", {}).get("solution")]
        for cell in theirs:
            is_words = ANSWER_HERE in "".join(cell["source"])
            assert cell["metadata"]["nao_course"] == {"role": "written" if is_words else "exercise"}
            assert is_words or "raise NotImplementedError" in "".join(cell["source"])
        assert theirs


BESIDE = (*release.AS_THEY_ARE, *release.PAGES.values())


@pytest.fixture
def finished(built):
    """A built course with all that stands beside its lessons."""
    for name in BESIDE:
        (built.root / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(PROJECT / name, built.root / name)
    return built


@pytest.mark.slow
def test_two_releases_of_one_course_are_the_same_bytes(finished, tmp_path, monkeypatch):
    problems = release.release_problems(finished, release.contents(finished, finished.names()))
    monkeypatch.setattr(release, "release_problems", lambda course, files: problems)
    first, second = (release.make_release(finished, tmp_path / each) for each in ("a", "b"))
    assert first.read_bytes() == second.read_bytes()
    assert all(name.startswith("nao-course/") for name in zipfile.ZipFile(first).namelist())


def test_a_lesson_that_is_not_built_or_a_release_with_a_problem_is_not_made(finished, tmp_path, monkeypatch):
    with pytest.raises(LessonError, match="01_toy.ipynb.*run `nao-course build` first"):
        release.make_release(replace(finished, version="another"), tmp_path / "out")
    monkeypatch.setattr(release, "release_problems", lambda course, files: ["x.py holds a secret"])
    with pytest.raises(LessonError, match=r"x\.py holds a secret"):
        release.make_release(finished, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_course_that_was_built_on_another_processor_is_released_as_it_is(finished, tmp_path, monkeypatch):
    monkeypatch.setattr(release, "release_problems", lambda course, files: [])
    checks = finished.check_data("01_toy")
    theirs = pack(perturbed(unpack(checks.read_bytes()), np.random.default_rng(1)))
    assert theirs != checks.read_bytes()
    checks.write_bytes(theirs)
    with zipfile.ZipFile(release.make_release(finished, tmp_path / "out")) as made:
        assert made.read("nao-course/nao_course/exercises/checks/01_toy.bin") == theirs


@pytest.mark.slow
def test_an_instructors_answer_in_a_release_is_refused(course):
    with_a_written_question(course)
    assert run("build").exit_code == 0
    there = Path("notebooks/01_toy.ipynb").read_text()
    assert release_problems(course, {"release/notebooks/01_toy.ipynb": there.encode()}) == []
    leaking = there.replace(ANSWER_HERE, "Because two times one is two.").encode()
    found = release_problems(course, {"release/notebooks/01_toy.ipynb": leaking})
    assert any("your answer to say_why is in it" in each for each in found)


def test_each_student_gets_the_release_with_their_name_in_it(finished, tmp_path, monkeypatch):
    monkeypatch.setattr(release, "release_problems", lambda course, files: [])
    names = ["ada", "Łucja Nguyễn", "../evil"]
    common = zipfile.ZipFile(release.make_release(finished, tmp_path / "out", students=names))
    found = {}
    for path in (tmp_path / "out" / "students").iterdir():
        copy = zipfile.ZipFile(path)
        assert copy.testzip() is None
        (added,) = set(copy.namelist()) - set(common.namelist())
        assert len(copy.namelist()) == len(set(copy.namelist()))
        copy.extractall(tmp_path / path.stem)
        found[personal_world(tmp_path / path.stem / "nao-course" / "notebooks").student] = added
    assert found == dict.fromkeys(names, "nao-course/release/student.json")


def test_names_are_read_from_lines_and_from_a_table_and_what_cannot_be_used_is_refused(tmp_path):
    path = tmp_path / "names.txt"
    for text, names in {
        "\ufeffada\n\n  bob \n": ["ada", "bob"],
        'student,email\n"Lovelace, Ada",a@b\nbob,\n': ["Lovelace, Ada", "bob"],
        'Student,ID,Section\n"Lovelace, Ada",12,A\n': ["lovelaceada_12"],
        "Identifier,Full name\nParticipant 12,Ada Lovelace\n": ["Ada Lovelace"],
        "Identifier,Full name\nTN 12,Jan Novák\nTN 13,Ada\nTN 14,Jan Novák\n": [
            "Jan Novák_12",
            "Ada",
            "Jan Novák_14",
        ],
    }.items():
        path.write_text(text, encoding="utf-8")
        assert release.read_students(path) == names
    with Journal(tmp_path / "grades") as journal:
        journal.know([Student("ada", "Ada", "ada@uni.example"), Student("Łucja", listed=True)])
    assert release.read_students(tmp_path / "grades") == ["ada", "Łucja"]
    with pytest.raises(LessonError, match="there is no journal"):
        release.read_students(tmp_path)
    path = tmp_path / "names.txt"
    for content, message in (
        (b"", "contains no names"),
        (b"student\n\n", "contains no names"),
        (b"\xff\xfe\x00", "Save it as UTF-8"),
        (b"name,email\nada,a@b\n", "a column 'student'"),
        (b"Ada\nada\n", "'Ada' and 'ada'"),
    ):
        path.write_bytes(content)
        with pytest.raises(LessonError, match=message):
            release.read_students(path)
    with pytest.raises(LessonError, match="cannot read"):
        release.read_students(tmp_path / "nothing.txt")


NOISE = """

def {name}(*args, right={name}, **kwargs):
    print("what a right answer may write", file=sys.stderr)
    return right(*args, **kwargs)

import sys
"""


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Object of type <Submitted")  # nbgrader's own, from SQLAlchemy
# All are built in the same way. Lesson 07 rests on earlier lessons' functions.
@pytest.mark.parametrize("name", COURSE.names(["07"]))
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
        lesson_text.exercise_name(cell): cell.source
        for _, cell in lesson_text.code_cells(lesson_text.read_lesson(COURSE.text(name)), "exercise")
    }
    for _, cell in lesson_text.code_cells(solved, "exercise"):
        exercise = lesson_text.exercise_name(cell)
        cell.source = solutions[exercise] + NOISE.format(name=exercise)
    for _, cell in lesson_text.written_cells(solved):
        cell.source = "One pixel decides it."
    for student, notebook in (("blank", blank), ("solved", solved)):
        (tmp_path / "submitted" / student / name).mkdir(parents=True)
        nbformat.write(notebook, tmp_path / "submitted" / student / name / f"{name}.ipynb")
    (tmp_path / "source" / name).mkdir(parents=True)
    shutil.copy(COURSE.solutions / f"{name}.ipynb", tmp_path / "source" / name)

    config = Config()
    config.CourseDirectory.root = str(tmp_path)
    config.ExecutePreprocessor.timeout = 120
    exec(nbgrader_config(), {"get_config": lambda: config})
    api = NbGraderAPI(config=config)
    for result in (
        api.generate_assignment(name),
        api.autograde(name, "solved"),
        api.autograde(name, "blank"),
    ):
        assert result["success"], result["log"] + str(result["error"])
    made = nbformat.read(tmp_path / "release" / name / f"{name}.ipynb", as_version=4)
    assert [cell.source for cell in made.cells] == [cell.source for cell in blank.cells]
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
