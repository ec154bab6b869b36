"""Small courses: one with a plan and a reference, and one that is built; whoever changes one has a copy."""

import shutil
from unittest import mock

import nbformat
import pytest

from nao_course import cli
from nao_course.instructor.authoring import build, lesson_text
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.plans import load_plan, reference
from nao_course.plotting import image_tag
from tests.toy import course as toy_course
from tests.toy import toy


@pytest.fixture(scope="session")
def solutions(tmp_path_factory):
    return toy.solutions(tmp_path_factory.mktemp("course") / "solutions")


@pytest.fixture(scope="session")
def plan(solutions):
    return load_plan(solutions / "exercises" / "90_toy.py")


@pytest.fixture(scope="session")
def right(solutions):
    return reference("90", solutions)


PICTURE = b"what the payoff drew"


def not_run(solved, root):
    """The lesson as if it had run, with nothing shown but its payoff."""
    notebook = nbformat.from_dict(solved)
    for _, cell in lesson_text.code_cells(notebook, "payoff"):
        shown = {"text/plain": "a figure", "text/html": image_tag(PICTURE, "a figure", "png")}
        cell.outputs = [nbformat.v4.new_output("display_data", shown)]
    return notebook


NO_KERNEL = mock.patch("nao_course.instructor.authoring.execute.execute", not_run)


@pytest.fixture
def kernel():
    """For a test whose lessons are run when they are built; all others build without running anything."""


@pytest.fixture(autouse=True)
def _quickly(request, monkeypatch):
    monkeypatch.setattr(cli.console, "width", 200)
    if "kernel" in request.fixturenames:
        yield
    else:
        with NO_KERNEL:
            yield


@pytest.fixture(scope="session")
def built_course(tmp_path_factory):
    root = toy_course.lay_out(tmp_path_factory.mktemp("built"))
    with NO_KERNEL:
        build.build(load_course(root)).write()
    return root


@pytest.fixture
def course(tmp_path, monkeypatch):
    """A course with one small lesson, in the working folder."""
    toy_course.lay_out(tmp_path)
    monkeypatch.chdir(tmp_path)
    return load_course()


@pytest.fixture
def built(built_course, tmp_path, monkeypatch):
    """The same, and built."""
    shutil.copytree(built_course, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return load_course()
