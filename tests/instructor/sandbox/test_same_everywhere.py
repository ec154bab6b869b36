"""What a student's code computes does not depend on the worker, its surroundings or its earlier calls."""

import os
import sys

import pytest

from nao_course.exercises import Case
from nao_course.exercises.running import Outcome
from nao_course.instructor.sandbox.protocol import Allowance
from nao_course.instructor.sandbox.worker import Worker
from tests.toy import toy

posix = pytest.mark.skipif(sys.platform == "win32", reason="schedules and umasks")
AMPLE = 60.0
CHANCE = """
import locale, os, random, sys, time
import cv2
import numpy as np

def drawn():
    return [random.random(), np.random.rand(), np.random.default_rng().random(), cv2.randu(np.zeros(3), 0, 1).tolist()]

AT_FIRST = drawn()[:3]  # OpenCV's state is set for calls
LETTERS = "".join({"a", "b", "c", "d", "e", "f"})

def chance(x):
    depth, frame = 0, sys._getframe()
    while frame := frame.f_back:
        depth += 1
    around = [time.tzname, time.localtime(0)[:], locale.getlocale(), sys.getfilesystemencoding(), sys.flags.utf8_mode]
    mask = os.umask(0o77)
    os.umask(mask)
    return [AT_FIRST, LETTERS, drawn(), repr(around), mask, sys.getrecursionlimit() - depth, str({"x", "y", x})]

def disturbs(x):
    np.random.set_state(np.random.RandomState(3).get_state())
    random.seed(5)
    return drawn()
"""


def surroundings(monkeypatch, number):
    """Start what comes in other surroundings each time."""
    monkeypatch.setenv("PYTHONHASHSEED", str(number))
    monkeypatch.setenv("TZ", ["Asia/Tokyo", "America/Lima"][number % 2])
    monkeypatch.setenv("LC_ALL", ["C", "C.UTF-8"][number % 2])


@posix
def test_all_workers_compute_the_same_whatever_was_called_before(tmp_path, warm_server, monkeypatch):
    notebook, told = toy.write(tmp_path / "x.ipynb", CHANCE), []
    for number, server in enumerate([None, warm_server, None, warm_server]):
        surroundings(monkeypatch, number)
        before = os.umask([0o022, 0o077][number % 2])
        try:
            with Worker(notebook, seconds=AMPLE, server=server) as worker:
                for _ in range(number):
                    assert worker.call("disturbs", Case((1,))).status == "value"
                outcome = worker.call("chance", Case(("z",)))
        finally:
            os.umask(before)
        assert outcome.status == "value", outcome.text
        told.append(outcome)
    assert told[1:] == told[:-1]
    assert told[0].value[0] != told[0].value[2], "other numbers, though always the same ones"


@pytest.mark.slow
@posix
def test_a_call_that_waits_for_a_processor_has_its_time_left(tmp_path, warm_server, monkeypatch):
    """The clock of a worker stops where it waits; it runs where the worker computes or sleeps."""
    source = "import time\ndef waits(x): time.sleep(0.6)\ndef counts(x):\n    while time.process_time() < 1e4: pass"
    notebook = toy.write(tmp_path / "x.ipynb", source)
    with Worker(notebook, seconds=AMPLE, server=warm_server) as worker:
        worker.definitions  # noqa: B018 - it loads
        worker.loading, worker.allowance = Allowance(), Allowance()
        assert worker.call("counts", Case((1,)), seconds=0.2).status == "timed out"
        assert worker.call("waits", Case((1,)), seconds=0.2).status == "timed out"
        assert worker.allowance.total > 0.4 - 0.01
        worker.definitions  # noqa: B018 - it loads
        channel = worker._channel
        queued = iter([0.0, 0.7, *[0.0] * 100])  # s in the queue for a processor on a busy machine
        monkeypatch.setattr(channel, "waited_since", lambda: next(queued))
        assert worker.call("waits", Case((1,)), seconds=0.2) == Outcome("value")
        queued = iter([0.0, *[1e4] * 100])  # waiting without end is counted from nine times the limit on
        assert worker.call("counts", Case((1,)), seconds=0.1).status == "timed out"


@posix
def test_processes_that_a_worker_starts_come_last(tmp_path, warm_server):
    source = """
import os, time
def priority_of_a_child(lowest):
    child = os.fork()
    if child == 0:
        while os.getpriority(os.PRIO_PROCESS, 0) != lowest:
            time.sleep(0.01)
        os._exit(lowest)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
"""
    with Worker(toy.write(tmp_path / "x.ipynb", source), seconds=AMPLE, server=warm_server) as worker:
        assert worker.call("priority_of_a_child", Case((19,))).value == 19


@posix
def test_a_worker_that_never_stops_to_talk_costs_its_time_alone(tmp_path, warm_server):
    source = """
import __main__, gc
from nao_course.codec import encode
from nao_course.instructor.sandbox.worker_process import RequestLoop

def floods(x):
    loop = next(each for each in gc.get_objects() if isinstance(each, RequestLoop))
    frame = encode(("attempt", "x" * 10))
    while True:
        loop.say(frame)
"""
    with Worker(toy.write(tmp_path / "x.ipynb", source), seconds=AMPLE, server=warm_server) as worker:
        worker.definitions  # noqa: B018 - it loads
        outcome = worker.call("floods", Case((1,)), seconds=0.3)
        assert outcome.status == "timed out"
