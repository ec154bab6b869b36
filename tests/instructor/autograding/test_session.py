"""A session has its assignments prepared in a process that ends, and is not opened in a sandbox that is too weak."""

import multiprocessing
import subprocess
import sys
import time

import psutil
import pytest

from nao_course.instructor.autograding import session as module
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.session import Machines, open_session, prepare_in_background
from nao_course.instructor.sandbox.layers import Layer, Sandbox
from tests.toy import chain


def test_assignments_are_prepared_as_here_in_a_process_that_ends(tmp_path):
    course = chain.make_course(tmp_path)
    before = set(multiprocessing.active_children())
    begun = prepare_in_background(course, [chain.LESSON], chain.SECRET)
    assert set(multiprocessing.active_children()) > before
    assert begun[chain.LESSON].result(timeout=300).hash == prepare(course, "90", chain.SECRET).hash
    while set(multiprocessing.active_children()) - before:  # it ends by itself
        time.sleep(0.05)


def test_what_fails_while_an_assignment_is_prepared_is_raised_where_it_is_wanted(tmp_path):
    course = chain.make_course(tmp_path)
    (course.solutions / f"{chain.LESSON}.ipynb").unlink()
    begun = prepare_in_background(course, [chain.LESSON], chain.SECRET)
    with pytest.raises(FileNotFoundError, match="nao-course build"):
        begun[chain.LESSON].result(timeout=300)


def test_a_weak_sandbox_is_told_and_refused_where_more_is_required(tmp_path, monkeypatch):
    weak = Sandbox((Layer("landlock", False, "not today"),))
    monkeypatch.setattr(module, "probe", lambda: weak)
    monkeypatch.setattr(module, "prepare_in_background", lambda *_: {})
    monkeypatch.setattr(module.WarmServer, "__enter__", lambda self: sys.exit("it must not start"))
    said = []
    course = chain.make_course(tmp_path)
    with (
        pytest.raises(ValueError, match=r"'landlock' is required.*not today"),
        open_session(course, [], chain.SECRET, Machines(require_sandbox="landlock"), said.append),
    ):
        pass
    assert said == [str(weak)]


PREPARES = """
import sys, time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from nao_course.instructor.autograding.session import _end_with_the_grader
if __name__ == "__main__":
    pool = ProcessPoolExecutor(1, get_context("spawn"), _end_with_the_grader)
    print(pool.submit(os.getpid).result(), flush=True)
    pool.submit(time.sleep, 1000)
    time.sleep(1000)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_what_prepares_an_assignment_ends_when_the_grader_is_killed(tmp_path):
    script = tmp_path / "prepares.py"
    script.write_text(f"import os\n{PREPARES}")
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as grader:
        process = psutil.Process(int(grader.stdout.readline()))
        grader.kill()
    process.wait(timeout=300)
