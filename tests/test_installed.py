"""The package as others install it: from built wheels, outside the repository, at the oldest declared versions."""

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import zipfile
from pathlib import Path

import matplotlib.image
import pytest

from tests.paths import PROJECT
from tests.toy.course import lay_out_first_lessons

pytestmark = pytest.mark.slow

OLDEST_PYTHON = "3.11"
LESSON = "01_hsl_filtering"
# What a package index shows of the package has an example: it is run.
EXAMPLE = """
import importlib.metadata, re
page = importlib.metadata.metadata("nao-course").get_payload()
exec(re.search("```python\\n(.*?)```", page, re.DOTALL)[1])
"""
RUN_ALL_EXAMPLES = """
import doctest, importlib, pkgutil
import nao_course
names = [each.name for each in pkgutil.walk_packages(nao_course.__path__, "nao_course.")]
modules = [importlib.import_module(name) for name in names]
results = [doctest.testmod(each, optionflags=doctest.NORMALIZE_WHITESPACE) for each in modules]
print(sum(each.attempted for each in results), "examples of", nao_course.__file__)
raise SystemExit(sum(each.failed for each in results) > 0)
"""
READ_A_GRAPH = """
import sys
from nao_course.datasets import read_g2o
print(read_g2o(sys.argv[1]))
"""
WRITE_A_LESSONS_TEXT = """
import sys, nbformat
from nao_course.instructor.authoring import lesson_text
sys.stdout.write(lesson_text.write_lesson(nbformat.read(sys.argv[1], as_version=4)))
"""
VERSIONS = """
import importlib.metadata, json
found = importlib.metadata.distributions()
print(json.dumps({each.name.lower().replace("_", "-"): each.version for each in found}))
"""


class Environment:
    """A virtual environment, and an empty folder in which its programs are run."""

    def __init__(self, folder: Path, python: str) -> None:
        self.prefix, self.folder = folder / "environment", folder / "work"
        self.folder.mkdir(parents=True, exist_ok=True)
        subprocess.run([python, "-m", "venv", "--without-pip", str(self.prefix)], check=True)
        self.programs = self.prefix / ("Scripts" if sys.platform == "win32" else "bin")

    def run(self, program: str, *words: str) -> subprocess.CompletedProcess[str]:
        """Run a program of the environment, with nothing of the tests' environment in sight."""
        unset = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        more = {"MPLBACKEND": "Agg", "COLUMNS": "200"}
        command = [str(self.programs / program), *words]
        return subprocess.run(command, cwd=self.folder, env=unset | more, capture_output=True, text=True)

    def says(self, program: str, *words: str) -> str:
        """Run a program that must succeed, and return what it prints."""
        done = self.run(program, *words)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def install(self, *words: str | Path) -> subprocess.CompletedProcess[str]:
        """Install with uv from the package index that pip is set up for."""
        python = self.programs / "python"
        command = [sys.executable, "-m", "uv", "--no-config", "pip", "install", "--python", python, *words]
        return subprocess.run(
            [str(each) for each in command], env=index() | os.environ, capture_output=True, text=True
        )

    def installed(self) -> set[str]:
        """Every file of the environment, by its path in it."""
        return {path.relative_to(self.prefix).as_posix() for path in self.prefix.rglob("*") if path.is_file()}


def index() -> dict[str, str]:
    """Return pip's package index as uv wants it to be told."""
    listed = subprocess.run([sys.executable, "-m", "pip", "config", "list"], capture_output=True, text=True)
    found = re.search(r"\.index-url='(.+)'$", listed.stdout, re.MULTILINE)
    return {"UV_DEFAULT_INDEX": found[1]} if found else {}


def build(kind: str, project: Path, folder: Path) -> Path:
    """Build a wheel or a source archive."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(folder)]
    subprocess.run(command, cwd=project, check=True, capture_output=True)
    (made,) = folder.iterdir()
    return made


@pytest.fixture(scope="module")
def wheels(tmp_path_factory) -> tuple[Path, Path]:
    """The students' wheel and the instructor's."""
    projects = PROJECT, PROJECT / "nao_course" / "instructor"
    first, second = (build("wheel", each, tmp_path_factory.mktemp("wheel")) for each in projects)
    return first, second


def assert_the_example_draws(environment: Environment) -> None:
    environment.says("python", "-c", EXAMPLE)
    assert matplotlib.image.imread(environment.folder / "nao.png").std() > 0.05, "an empty figure"


def files_of(archive: Path) -> set[str]:
    """Names of the files in a wheel or a source archive, without the folder that a source archive packs them in."""
    if archive.suffix == ".whl":
        return set(zipfile.ZipFile(archive).namelist())
    with tarfile.open(archive) as opened:
        return {name.partition("/")[2] for name in opened.getnames()}


def test_the_wheels_and_the_source_archive_hold_the_library_and_no_solutions(wheels, tmp_path):
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "nao_course"]
    listed = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip(f"not a git checkout: {listed.stderr}")
    library = {name for name in listed.stdout.splitlines() if (PROJECT / name).is_file()}
    instructors = {name for name in library if name.startswith("nao_course/instructor/")}
    assert len(instructors) > 50
    for archive, held in (
        (wheels[0], library - instructors),
        (wheels[1], instructors - {"nao_course/instructor/pyproject.toml"}),
        (build("sdist", PROJECT, tmp_path), library - instructors),
    ):
        beside = {name for name in files_of(archive) - held if ".dist-info/" not in name}
        assert held - files_of(archive) == set()
        assert beside <= {".gitignore", "LICENSE", "PKG-INFO", "pyproject.toml"}


def test_a_students_wheel_is_the_package_alone_and_works_in_an_empty_folder(wheels, tmp_path):
    """Its dependencies are those of this environment: nothing is downloaded."""
    environment = Environment(tmp_path, sys.executable)
    before = environment.installed()
    done = environment.install("--offline", "--no-deps", wheels[0])
    assert done.returncode == 0, done.stderr
    (package,) = environment.prefix.rglob("nao_course")
    site = package.parent.relative_to(environment.prefix).as_posix()
    beside = {name for name in environment.installed() - before if not name.startswith(f"{site}/nao_course")}
    assert {Path(name).name for name in beside} <= {"nao-course", "nao-course.exe", ".lock"}
    assert not (package / "instructor").exists()

    (package.parent / "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    assert_the_example_draws(environment)
    help_ = environment.says("nao-course", "--help")
    assert " submit " in help_ and " grade " not in help_
    refused = environment.run("nao-course", "grade", "submissions", "--out", "grades")
    assert refused.returncode == 1 and "pip install 'nao-course[instructor]'" in refused.stderr
    refused = environment.run("nao-course", "renew")
    assert refused.returncode == 1 and "there is no folder release/notebooks" in refused.stderr


def declared() -> list[str]:
    """What the package with all that is not for measuring or pages depends on, as the wheels declare it."""
    package, instructor = (
        tomllib.loads((PROJECT / name).read_text(encoding="utf-8"))["project"]
        for name in ("pyproject.toml", "nao_course/instructor/pyproject.toml")
    )
    extras = [each for name in ("lab", "scale") for each in package["optional-dependencies"][name]]
    return [*package["dependencies"], *extras, *instructor["dependencies"]]


def without_zeros(version: str) -> str:
    return re.sub(r"(\.0)+$", "", version)


def oldest_python() -> str:
    """Return an interpreter of the oldest version that is supported."""
    if ".".join(map(str, sys.version_info[:2])) == OLDEST_PYTHON:
        return sys.executable
    if found := shutil.which(f"python{OLDEST_PYTHON}"):
        return found
    pytest.skip(f"no Python {OLDEST_PYTHON} on this machine")


def test_the_wheels_work_with_the_oldest_versions_that_they_declare(wheels, tmp_path):
    environment = Environment(tmp_path, oldest_python())
    students, instructors = wheels
    both = f"{students}[lab,scale]", instructors
    done = environment.install("--resolution", "lowest-direct", *both, *declared())
    if re.search("Failed to fetch|error sending request|dns error|network", done.stderr):
        reason = f"no package index can be reached: {done.stderr}"
        if os.environ.get("NAO_COURSE_REQUIRE_INDEX") == "1":
            pytest.fail(f"NAO_COURSE_REQUIRE_INDEX=1, but {reason}")
        pytest.skip(reason)
    assert done.returncode == 0, done.stderr
    versions = json.loads(environment.says("python", "-c", VERSIONS))
    floors = dict(re.findall(r"^([\w-]+)>=([\d.]+)", "\n".join(declared()), re.MULTILINE))
    there = floors.keys() & versions.keys()  # one of them is for Linux only
    assert len(there) > 10
    assert {name: without_zeros(versions[name]) for name in there} == {
        name: without_zeros(floors[name]) for name in there
    }

    count, _, of = environment.says("python", "-c", RUN_ALL_EXAMPLES).partition(" examples of ")
    assert int(count) > 50 and of.startswith(str(environment.prefix))
    for command in ("--help", "submit --help", "grade --help"):
        environment.says("nao-course", *command.split())
    assert_the_example_draws(environment)
    graph = environment.folder / "graph.g2o"
    graph.write_text("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n")
    assert "Graph" in environment.says("python", "-c", READ_A_GRAPH, str(graph))
    shutil.copy(PROJECT / "solutions" / f"{LESSON}.ipynb", environment.folder)
    assert environment.says("nao-course", "check", LESSON).count("✔ passes") == 6

    text = (PROJECT / "solutions" / f"{LESSON}.md").read_text(encoding="utf-8")
    assert environment.says("python", "-c", WRITE_A_LESSONS_TEXT, f"{LESSON}.ipynb") == text
    lay_out_first_lessons(environment.folder)
    student_copy = environment.folder / "notebooks" / f"{LESSON}.ipynb"
    student_copy.unlink()
    environment.says("nao-course", "build", LESSON, "--no-execute")
    assert student_copy.read_bytes() == (PROJECT / "notebooks" / student_copy.name).read_bytes()
    shutil.rmtree(environment.prefix)  # some hundred megabytes
