"""A run's temporary folder goes with it, and that of a killed run with the next one."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from nao_course.instructor.autograding.scratch import scratch_folder

KILLED = """
import sys, time
from nao_course.instructor.autograding.scratch import scratch_folder
with scratch_folder() as folder:
    (folder / "submission").write_text("x")
    print(folder, flush=True)
    time.sleep(3600)
"""


@pytest.fixture
def usual(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    return tmp_path


def test_everything_temporary_lies_in_it_and_goes_with_it(usual):
    with scratch_folder() as folder:
        assert folder.parent == usual
        assert Path(tempfile.mkdtemp()).parent == folder
    assert list(usual.iterdir()) == []
    assert Path(tempfile.mkdtemp()).parent == usual


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not tell whether a process is gone")
def test_what_a_killed_run_left_goes_with_the_next_and_what_others_use_stays(usual):
    other = usual / f"nao_course_run_{os.getpid()}_abc"
    strange = usual / "nao_course_run_99999999_abc.txt"
    other.mkdir()
    strange.mkdir()
    run = subprocess.Popen([sys.executable, "-c", KILLED], stdout=subprocess.PIPE, text=True)
    left = Path(run.stdout.readline().strip())
    with scratch_folder():
        assert left.is_dir()  # its run is still there
    run.send_signal(signal.SIGKILL)
    run.wait()
    run.stdout.close()
    assert left.is_dir()
    with scratch_folder() as folder:
        assert {path.name for path in usual.iterdir()} == {other.name, strange.name, folder.name}
