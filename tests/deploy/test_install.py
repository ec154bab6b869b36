"""Releases lie beside each other on a server: an update touches nothing that runs, and there is a way back."""

import os
import shutil
import subprocess
import sys

import pytest

from tests.paths import PROJECT

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the hub's server has Linux")

# Stands for the Python of the system and of each environment: it makes what the real one would make, without a network.
PYTHON = """#!/bin/sh
case "$*" in
"-m venv "*) mkdir -p "$3/bin" "$3/lib"; cp "$0" "$3/bin/python" ;;
"-m zipfile "*) mkdir -p "$5/nao-course/release"; cp "$4" "$5/nao-course/release/lessons" ;;
"-m pip install --quiet --no-deps "*) test ! -e "${0%/bin/python}/../../../fails" ;;
"-m pip list"*) echo "nao-course 0.1.0" ;;
esac
"""


@pytest.fixture
def server(tmp_path):
    """A function that runs install.sh for a folder, with releases that only differ in a file."""
    python = tmp_path / "python"
    python.write_text(PYTHON)
    python.chmod(0o755)
    # Students can run this Python; the real program would not enter the tests' folder as "nobody".
    setpriv = tmp_path / "setpriv"
    setpriv.write_text("#!/bin/sh\n")
    setpriv.chmod(0o755)
    folder = tmp_path / "nao course"
    shutil.copy(PROJECT / "deploy" / "hub" / "install.sh", tmp_path)

    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PYTHON": str(python), "PATH": path}

    def run(words, fails=False):
        if words != "--back":
            (tmp_path / words).write_text(words)
        command = [
            "sh",
            str(tmp_path / "install.sh"),
            words if words == "--back" else str(tmp_path / words),
            str(folder),
        ]
        folder.mkdir(exist_ok=True)
        (folder / "fails").unlink(missing_ok=True)
        if fails:
            (folder / "fails").touch()
        return subprocess.run(command, env=environment, capture_output=True, text=True)

    run.folder = folder
    run.current = lambda: (folder / "current" / "release" / "lessons").read_text()
    return run


def test_a_newer_release_is_current_the_older_one_stays_and_back_exchanges_them(server):
    for version in ("0.1.0", "0.1.1"):
        done = server(f"nao-course-{version}.zip")
        assert done.returncode == 0, done.stderr
        assert server.current() == f"nao-course-{version}.zip"
    assert sorted(each.name for each in (server.folder / "versions").iterdir()) == ["0.1.0", "0.1.1"]
    assert (server.folder / "current").is_symlink() and os.readlink(
        server.folder / "current"
    ) == "versions/0.1.1"
    for version in ("0.1.0", "0.1.1", "0.1.0"):
        assert server("--back").stdout.strip().endswith(f"{version} is current again")
        assert server.current() == f"nao-course-{version}.zip"
    assert not list(server.folder.glob("*.new"))


def test_there_is_no_way_back_from_the_first_release(server):
    assert server("nao-course-0.1.0.zip").returncode == 0
    done = server("--back")
    assert done.returncode == 1 and "no release before" in done.stderr
    assert server.current() == "nao-course-0.1.0.zip"


def test_a_release_that_is_installed_is_not_replaced_and_half_of_one_does_not_stay(server):
    assert server("nao-course-0.1.0.zip").returncode == 0
    again = server("nao-course-0.1.0.zip")
    assert again.returncode == 1 and "exists" in again.stderr
    assert server("nao-course-0.1.1.zip", fails=True).returncode == 1
    assert server.current() == "nao-course-0.1.0.zip"
    assert [each.name for each in (server.folder / "versions").iterdir()] == ["0.1.0"]
    assert server("nao-course-0.1.1.zip").returncode == 0
    assert server.current() == "nao-course-0.1.1.zip"
