"""The autograder for Gradescope: a zip of one lesson, and there the same grader as here."""

import json
import os
import re
import shutil
import stat
import subprocess
import sys
import tomllib
import zipfile
from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from nao_course.instructor.authoring.course import Course, LessonError, load_course
from nao_course.instructor.commands import gradescope
from nao_course.instructor.sandbox import layers as sandbox
from tests.paths import PROJECT

LESSON = "01_hsl_filtering"
posix = pytest.mark.skipif(sys.platform == "win32", reason="Gradescope's images are Linux: a shell script")


@pytest.fixture(scope="module")
def course():
    return load_course(PROJECT)


@pytest.fixture(scope="module")
def archive(course, tmp_path_factory):
    folder = tmp_path_factory.mktemp("zip")
    return gradescope.write_autograder(course, "00", b"0123456789abcdef", folder)


def test_the_zip_has_its_two_files_at_its_root_and_one_lesson(archive):
    packed = zipfile.ZipFile(archive)
    names = packed.namelist()
    assert {"setup.sh", "run_autograder", gradescope.LOCK, "course.toml", "secret"} <= set(names)
    notebooks = [name for name in names if re.match(r"(solutions|notebooks)/.*ipynb", name)]
    assert notebooks == [f"{folder}/00_meet_the_nao.ipynb" for folder in ("notebooks", "solutions")]
    assert "nao_course/instructor/autograding/grader.py" in names
    others = r"tests/|\.git|__pycache__|01_hsl_filtering\.(py|md|ipynb)"
    assert not [name for name in names if re.search(others, name)]
    # Whatever the library reads when it is imported is in the zip: scripts and style sheets, too.
    paths = [path for path in (PROJECT / "nao_course").rglob("*") if path.is_file() and path.suffix != ".md"]
    wanted = {path.relative_to(PROJECT).as_posix() for path in paths if "__pycache__" not in path.parts}
    assert wanted - set(names) == set()
    for name, mode in {"setup.sh": 0o755, "run_autograder": 0o755, "secret": 0o600}.items():
        assert stat.S_IMODE(packed.getinfo(name).external_attr >> 16) == mode
    run = packed.read("run_autograder").decode()
    assert run.startswith("#!") and "/autograder" in run and "00_meet_the_nao" in run


def test_the_zip_does_not_hold_the_instructors_secret_and_is_the_same_each_time(course, archive, tmp_path):
    assert b"0123456789abcdef" not in zipfile.ZipFile(archive).read("secret")
    again = gradescope.write_autograder(course, "00", b"0123456789abcdef", tmp_path)
    assert again.read_bytes() == archive.read_bytes()
    other = gradescope.write_autograder(course, "00", b"another secret, long", tmp_path / "other")
    assert other.read_bytes() != archive.read_bytes()


def test_where_nothing_hides_the_solution_nothing_is_graded(tmp_path, course, monkeypatch):
    monkeypatch.setattr(gradescope, "probe", lambda: sandbox.Sandbox((sandbox.Layer("limits", True),)))
    with pytest.raises(RuntimeError, match="a submission could read the solution.*landlock"):
        gradescope.grade_submission(tmp_path, course, "00_meet_the_nao")
    assert not (tmp_path / "results").exists()
    shutil.copytree(PROJECT / "solutions", tmp_path / "solutions")
    with pytest.raises(LessonError, match="there is no course.toml.*run `nao-course build` first"):
        gradescope.write_autograder(Course(tmp_path, "t", "1"), "00", b"x" * 16, tmp_path)


@posix
def test_its_scripts_are_bash(archive, tmp_path):
    bash = shutil.which("bash") or pytest.skip("no bash")
    for name in ("setup.sh", "run_autograder"):
        (tmp_path / name).write_bytes(zipfile.ZipFile(archive).read(name))
        assert subprocess.run([bash, "-n", tmp_path / name], capture_output=True).returncode == 0


@pytest.mark.slow
def test_what_its_script_installs_is_the_whole_library(archive, tmp_path):
    packed = zipfile.ZipFile(archive)
    packed.extractall(tmp_path / "source")
    last = packed.read("setup.sh").decode().splitlines()[-1]
    for folder in re.findall(r'"\$root/(source[^"]*)"', last):
        command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path / "dist")]
        subprocess.run(command, cwd=tmp_path / folder, check=True, capture_output=True)
    installed = {name for each in (tmp_path / "dist").iterdir() for name in zipfile.ZipFile(each).namelist()}
    library = {
        name for name in packed.namelist() if re.match(r"nao_course/.*\.(py|bin|js|json|css|npz|txt)$", name)
    }
    assert len(library) > 100 and library - installed == set()


def laid_out(archive, root, submission):
    """A folder as Gradescope lays it out."""
    zipfile.ZipFile(archive).extractall(root / "source")
    shutil.copy(root / "source" / "run_autograder", root / "run_autograder")
    (root / "submission").mkdir()
    for name, content in submission.items():
        (root / "submission" / name).write_bytes(content)
    return root


def run_there(root):
    bash = shutil.which("bash") or pytest.skip("no bash")
    environment = os.environ | {"NAO_COURSE_AUTOGRADER": str(root), "NAO_COURSE_PYTHON": sys.executable}
    environment["PYTHONPATH"] = str(root / "source")  # there it is installed; here another copy is
    words = [bash, root / "run_autograder"]
    done = subprocess.run(words, cwd=root, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads((root / "results" / "results.json").read_text(encoding="utf-8"))


@posix
@pytest.mark.slow
def test_gradescope_gets_all_points_for_the_solution_and_none_for_a_blank_notebook(course, tmp_path):
    archive = gradescope.write_autograder(course, "01", b"0123456789abcdef", tmp_path)
    for folder, whole in (("solutions", True), ("notebooks", False)):
        notebook = (PROJECT / folder / f"{LESSON}.ipynb").read_bytes()
        root = laid_out(archive, tmp_path / folder, {f"{LESSON}.ipynb": notebook})
        made = run_there(root)
        graded = [each for each in made["tests"] if ".W" not in each["number"]]
        assert made["score"] == (sum(each["max_score"] for each in graded) if whole else 0)
        assert graded and {each["status"] for each in graded} == {"passed" if whole else "failed"}
        assert stat.S_IMODE((root / "source" / "solutions").stat().st_mode) & 0o077 == 0


@posix
@pytest.mark.slow
def test_gradescope_is_told_what_is_missing_and_what_cannot_be_graded(archive, tmp_path):
    made = run_there(laid_out(archive, tmp_path / "a", {"essay.txt": b"words"}))
    assert made["score"] == 0 and "There is no 00_meet_the_nao.ipynb" in made["output"]
    assert "essay.txt" in made["output"]
    made = run_there(laid_out(archive, tmp_path / "b", {"00_meet_the_nao.ipynb": b"{]"}))
    assert made["score"] == 0 and made["output"].startswith("Refused: ")


@posix
@pytest.mark.slow
def test_a_submission_cannot_read_the_solution_that_lies_beside_it_there(archive, tmp_path):
    if sandbox.probe().level == "process":
        pytest.skip("the sandbox of this machine cannot close folders")
    root = tmp_path / "autograder"
    spy = f"""
def to_radians(degrees):
    texts = []
    for name in ("source/secret", "source/solutions/exercises/00_meet_the_nao.py", "submission/00_meet_the_nao.ipynb"):
        try:
            texts.append(open({str(root)!r} + "/" + name).read()[:20])
        except OSError as error:
            texts.append(type(error).__name__)
    raise ValueError("I read " + "; ".join(texts))
"""
    notebook = json.loads((PROJECT / "notebooks" / "00_meet_the_nao.ipynb").read_text(encoding="utf-8"))
    cells = [cell for cell in notebook["cells"] if "def to_radians" in "".join(cell["source"])]
    cells[0]["source"] = spy
    laid_out(archive, root, {"00_meet_the_nao.ipynb": json.dumps(notebook).encode()})
    made = run_there(root)
    said = next(each["output"] for each in made["tests"] if each["name"] == "to_radians")
    assert re.search(r"I read (\w+Error; ){2}\w+Error", said), said


def test_where_the_grader_itself_fails_there_is_no_score(tmp_path, course, monkeypatch):
    (tmp_path / "submission").mkdir()
    (tmp_path / "submission" / "00_meet_the_nao.ipynb").write_bytes(b"{}")
    write = tmp_path / "results"
    write.mkdir()
    (write / "results.json").write_text("{}")
    failed = SimpleNamespace(grade=lambda *_: SimpleNamespace(failed=["the grader failed"]))
    monkeypatch.setattr(gradescope, "open_session", lambda *_, **__: nullcontext(failed))
    monkeypatch.setattr(gradescope, "probe", lambda: sandbox.Sandbox((sandbox.Layer("landlock", True),)))
    with pytest.raises(RuntimeError, match="the grader failed"):
        gradescope.grade_submission(tmp_path, course, "00_meet_the_nao")
    assert list(write.iterdir()) == []


def test_extensions_name_students_and_do_not_go_to_gradescope():
    text = 'title = "x"\n[late]\nper_day = 0.1\n [extensions."Ada [1]"]\n01 = 2026-11-27T00:00:00Z\n[points]\na = 2\n'
    left = gradescope.without_extensions(text)
    assert "Ada" not in left
    assert tomllib.loads(left) == {"title": "x", "late": {"per_day": 0.1}, "points": {"a": 2}}
    assert gradescope.without_extensions('title = "x"\n') == 'title = "x"\n'
    with pytest.raises(LessonError, match="so that they can be left out"):
        gradescope.without_extensions("extensions.Ada.01 = 2026-11-27T00:00:00Z\n")
