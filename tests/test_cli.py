"""The command line: what it says to students, what it needs, and that the documentation can be followed."""

import io
import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import nbformat
import pytest
import typer

from nao_course import cli
from nao_course._internal.single_threaded import SINGLE_THREADED
from nao_course.exercises.answered import BLANK
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.collecting.submissions import gather
from nao_course.student import progress
from tests.paths import PROJECT
from tests.toy.course import lay_out_first_lessons, run


@pytest.fixture(autouse=True)
def _wide(monkeypatch):
    monkeypatch.setattr(cli.console, "width", 200)


def two_lessons(folder, of):
    """Copy two lessons into a folder: of all that lie there, `check` and `submit` say the sum."""
    folder.mkdir()
    for name in ("00_meet_the_nao", "01_hsl_filtering"):
        shutil.copy(PROJECT / of / f"{name}.ipynb", folder)
    return folder


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    return two_lessons(tmp_path_factory.mktemp("solved") / "notebooks", of="solutions")


@pytest.fixture(scope="module")
def blank(tmp_path_factory):
    return two_lessons(tmp_path_factory.mktemp("blank") / "notebooks", of="notebooks")


def test_check_says_in_a_table_what_is_right_and_what_is_not(solved, blank):
    result = run("check", str(solved / "01_hsl_filtering.ipynb"))
    assert result.exit_code == 0 and result.output.count("✔ passes") == 6
    assert result.output.count("● written") == 1
    result = run("check", str(blank / "01_hsl_filtering.ipynb"))
    assert result.exit_code == 1 and result.output.count("○ not attempted") == 6
    assert result.output.count("○ nothing written") == 1


@pytest.fixture(params=["ascii", "cp1252", "cp850"])
def output(request, monkeypatch):
    """A function that runs a command whose output has an encoding without most signs."""

    def run_here(*words):
        stream = io.TextIOWrapper(io.BytesIO(), encoding=request.param)
        monkeypatch.setattr(sys, "stdout", stream)
        monkeypatch.setattr(sys, "stderr", stream)
        with pytest.raises(SystemExit) as end:
            cli.app([str(word) for word in words])
        stream.flush()
        return end.value.code, stream.buffer.getvalue().decode(request.param)

    return run_here


def commands_of(group, *words):
    """Return the words of all commands and groups of commands."""
    yield list(words)
    for name, each in getattr(group, "commands", {}).items():
        yield from commands_of(each, *words, name)


@pytest.mark.parametrize("words", list(commands_of(typer.main.get_command(cli.app))), ids=" ".join)
def test_each_commands_help_reaches_an_output_of_any_encoding(output, words):
    code, said = output(*words, "--help")
    assert code == 0 and "--help" in said and "\\u" not in said


def test_results_and_errors_reach_an_output_of_any_encoding_with_the_same_status(output, blank, tmp_path):
    code, said = output("check", blank / "01_hsl_filtering.ipynb")
    assert code == 1 and said.count("o not attempted") == 6 and "\\u" not in said
    code, said = output("check", tmp_path / "Łukasz \udce9 ✔.ipynb")
    assert code == 1 and "\\u0141ukasz \\udce9 +.ipynb" in said.replace("\n", " ")


def test_check_names_what_went_wrong(tmp_path):
    path = tmp_path / "00_meet_the_nao.ipynb"
    notebook = nbformat.read(PROJECT / "notebooks" / path.name, as_version=4)
    (cell,) = (cell for _, cell in lesson_text.code_cells(notebook, "exercise"))
    cell.source = "def to_radians(angle_deg):\n    return angle_deg"
    nbformat.write(notebook, path)
    result = run("check", str(path))
    assert result.exit_code == 1 and "✘ wrong" in result.output
    assert "as it was given, in degrees" in " ".join(result.output.split())
    cell.source = "def to_radians(angle_deg:"
    nbformat.write(notebook, path)
    assert "SyntaxError" in run("check", str(path)).output
    path.write_text("{")
    result = run("check", str(path))
    assert result.exit_code == 1 and "not a notebook" in result.output
    assert "there is no file" in run("check", str(tmp_path / "x.ipynb")).output
    shutil.copy(path, tmp_path / "x.ipynb")
    assert "there is no lesson 'x'" in run("check", str(tmp_path / "x.ipynb")).output
    assert "is not a folder" in run("submit", str(path), "--out", str(tmp_path)).output


def test_check_ends_with_the_sum_that_progress_gives_and_alone_shows_all_lessons(solved, monkeypatch):
    last = run("check", str(solved / "01_hsl_filtering.ipynb")).output.splitlines()[-1]
    total = progress(solved).total("01_hsl_filtering")
    assert last == total and total.startswith("01_hsl_filtering: 13 of 13 points pass their public checks")
    monkeypatch.chdir(solved.parent)
    result = run("check")
    assert result.exit_code == 0 and result.output.strip() == repr(progress(solved))


@pytest.mark.parametrize("word", ["0", "00", "00_meet_the_nao"])
def test_check_takes_the_number_of_a_lesson(word, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("notebooks").mkdir()
    shutil.copy(PROJECT / "solutions" / "00_meet_the_nao.ipynb", "notebooks")
    result = run("check", word)
    assert result.exit_code == 0 and "✔ passes" in result.output
    shutil.move("notebooks/00_meet_the_nao.ipynb", ".")
    shutil.rmtree("notebooks")  # with what was seen of them
    assert run("check", word).exit_code == 0
    result = run("check", "07")
    assert result.exit_code == 1 and "there is no file 07; lessons here: 00_meet_the_nao" in result.output


def test_submit_says_where_the_zip_is_and_what_the_receipt_is(solved, blank, tmp_path):
    result = run("submit", str(blank), "--out", str(tmp_path))
    (made,) = tmp_path.iterdir()
    assert result.exit_code == 0
    assert made.name in result.output and "It contains your receipt" in result.output
    assert "01_hsl_filtering: 0 of 6 exercises pass their public checks; not yet: rgb_to_hsl" in result.output
    assert "1.W1 (nothing written)" in result.output
    hand_in, state = (result.output.index(words) for words in ("hand in ", "pass their public checks"))
    assert hand_in < state, "a student's code that never ends keeps nobody from handing in"
    result = run("submit", str(solved), "--out", str(tmp_path / "solved"))
    assert "01_hsl_filtering: 6 of 6 exercises pass their public checks.\n" in result.output


COPIES = ("{} (1)", "{}-Copy1", "Kopie von {}", "{}_v2", "{}_ada")


@pytest.mark.parametrize("name", COPIES)
def test_check_and_submit_take_every_copy_that_the_grader_takes(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lesson, mine = "01_hsl_filtering", f"{name.format('01_hsl_filtering')}.ipynb"
    shutil.copy(PROJECT / "solutions" / f"{lesson}.ipynb", mine)
    total = run("check", mine).output.splitlines()[-1]
    assert run("check", "1").exit_code == run("check", mine).exit_code == 0 and f"{lesson}: 13 of 13" in total
    result = run("submit", "--out", "out")
    assert f"{lesson}: 6 of 6 exercises pass" in result.output and " notebooks here" not in result.output
    (packed,) = Path("out").iterdir()
    with zipfile.ZipFile(packed) as archive:
        assert archive.namelist() == [mine, "receipt.json"]
    if name == "{}_ada":  # words behind the name count after the lesson's own name
        return
    shutil.copy(PROJECT / "notebooks" / f"{lesson}.ipynb", f"{lesson}.ipynb")
    for words in (["check", f"{lesson}.ipynb"], ["check", "1"], ["submit"]):
        result = run(*words)
        assert result.exit_code == int(words[-1].endswith("ipynb"))
        assert f"newest one with answers: {mine}." in result.output
        assert f"{lesson}.ipynb does not count: {BLANK}." in result.output
    shutil.copytree(tmp_path / "out", tmp_path / "in" / "ada")
    (counts,) = gather(tmp_path / "in", tmp_path / "scratch", [lesson]).submissions
    assert counts.file.endswith(mine)


def test_renew_says_what_it_did_and_outside_of_a_release_what_it_looked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("renew")
    assert result.exit_code == 1 and "there is no folder release/notebooks" in result.output
    assert "in which the course's zip was unpacked" in result.output
    shutil.copytree(PROJECT / "notebooks", "release/notebooks")
    assert "00_meet_the_nao.ipynb: as released" in run("renew").output
    assert run("renew").output == "Your notebooks are up to date.\n"


STUDENTS_PYTHON = """
import json, sys
for name in ("jupytext", "nbgrader", "nbclient", "jupyterlab", "cosmic_ray"):  # IPython comes with ipywidgets
    sys.modules[name] = None  # as if it were not installed
from typer.testing import CliRunner
from nao_course.cli import app
ended = [CliRunner().invoke(app, words) for words in json.loads(sys.argv[1])]
print(json.dumps([[each.exit_code, each.output] for each in ended]))
"""


def run_as_student(folder, library, *commands):
    """Run commands in one process that has only what a student's machine has; say how each of them ended."""
    environment = {**os.environ, "PYTHONPATH": str(library), "COLUMNS": "200"}
    command = [sys.executable, "-c", STUDENTS_PYTHON, json.dumps(commands)]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.slow
def test_a_students_side_needs_the_core_alone_and_the_instructors_says_what_it_misses(tmp_path):
    notebook = "00_meet_the_nao.ipynb"
    (tmp_path / "notebooks").mkdir()
    shutil.copy(PROJECT / "solutions" / notebook, tmp_path / "notebooks")
    commands = (("check", f"notebooks/{notebook}"), ("submit",), ("build",))
    *students, (status, said) = run_as_student(tmp_path, PROJECT, *commands)
    assert [code for code, _ in students] == [0, 0], students
    assert status == 1 and "This command is for instructors and needs nbgrader" in said


def test_a_students_copy_says_that_it_has_no_instructors_side(tmp_path):
    ignored = shutil.ignore_patterns("instructor", "__pycache__")
    shutil.copytree(PROJECT / "nao_course", tmp_path / "nao_course", ignore=ignored)
    ((status, said), (_, help_)) = run_as_student(tmp_path, tmp_path, ("release", "--out", "x"), ("--help",))
    assert status == 1 and "needs nao_course.instructor, which is not installed" in said
    assert " submit " in help_ and " regrade " not in help_


HEAVY = {*("scipy", "sympy", "matplotlib", "cv2", "IPython", "ipywidgets")}
HEAVY |= {*("jupytext", "nbgrader", "nbclient", "nbformat")}


@pytest.mark.parametrize("module", ["nao_course.cli", "nao_course.instructor.commands.grading"])
def test_the_command_line_and_grading_start_without_what_only_some_commands_need(module):
    code = f"import sys, {module}\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=True)
    assert not HEAVY & set(done.stdout.split())


@pytest.mark.skipif(sys.platform != "linux", reason="counts the threads in /proc")
def test_a_command_has_one_thread_for_its_matrices_unless_more_are_asked_for():
    """With as many as there are processors, the proof of a lesson stalls on a busy machine."""
    unset = {name: value for name, value in os.environ.items() if name not in SINGLE_THREADED}
    say = "print(os.environ['OMP_NUM_THREADS'], len(os.listdir('/proc/self/task')))"
    code = f"import os, nao_course.cli, numpy, cv2\n{say}"
    alone, told = (
        subprocess.run([sys.executable, "-c", code], env=unset | more, capture_output=True, text=True).stdout
        for more in ({}, {"OMP_NUM_THREADS": "2"})
    )
    assert alone.split() == ["1", "1"] and told.split()[0] == "2"


@pytest.mark.slow
@pytest.mark.parametrize("page", ["write_a_lesson", "write_an_exercise"])
def test_the_documentation_can_be_followed_word_for_word(page, tmp_path, monkeypatch):
    """Run the commands of a page in a copy of the course, but for those that stand for any lesson, NN."""
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    lessons = lay_out_first_lessons(tmp_path)
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
    if page == "write_a_lesson":
        assert lessons == sorted(path.stem for path in (tmp_path / "notebooks").glob("*.ipynb"))
