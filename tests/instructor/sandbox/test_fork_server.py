"""What the warm server's process has imported is what students may import, and nothing of the instructors'."""

import sys

import pytest

from nao_course.exercises import running
from nao_course.instructor.sandbox import fork_server as module
from nao_course.instructor.sandbox.confinement import INSTRUCTORS, readable
from tests.paths import PROJECT

linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the server forks on Linux alone")


def test_every_module_that_students_may_import_is_imported_and_no_other():
    files = [path.relative_to(PROJECT).with_suffix("") for path in (PROJECT / "nao_course").rglob("*.py")]
    names = {".".join(path.parts).removesuffix(".__init__") for path in files}
    theirs = {name for name in names if name.split(".")[1:2] and name.split(".")[1] not in INSTRUCTORS}
    assert set(module.students_modules()) == theirs
    assert running.__name__ in theirs


def test_what_students_may_import_is_what_they_may_read_of_the_package():
    package = str(PROJECT / "nao_course")
    shown = {path.removeprefix(package + "/") for path in readable() if path.startswith(package)}
    assert "sim" in shown and "geometry.py" in shown
    assert not {"", "instructor", "cli.py"} & shown and package not in shown


@linux
def test_a_process_that_comes_from_one_of_some_is_known_as_such():
    parents = {5: 4, 4: 1, 7: 6, 6: 2}
    assert module._descends(5, {4}, parents) and module._descends(4, {4}, parents)
    assert not module._descends(7, {4}, parents) and not module._descends(4, {5}, parents)
