"""Whatever a student's code does, its caller gets an outcome in time, and nothing of it stays."""

import contextlib
import json
import os
import sys
import time
import tracemalloc
from dataclasses import replace

import numpy as np
import psutil
import pytest

from nao_course.codec import encode
from nao_course.exercises import Case
from nao_course.exercises.comparisons.jacobians import evaluated
from nao_course.exercises.running import Outcome
from nao_course.instructor.sandbox import worker as module
from nao_course.instructor.sandbox.protocol import USED_UP, Allowance
from nao_course.instructor.sandbox.worker import Worker
from tests.toy import toy

posix = pytest.mark.skipif(sys.platform == "win32", reason="signals and forks")

STUDENT = """
import ctypes, os, signal, sys, threading, time
import numpy as np
from nao_course.codec import encode
from nao_course.exercises import Outcome, running

def double(x): return 2 * x
def unwritten(x): raise NotImplementedError()
def fails(x): return 1 / 0
def loops(x):
    while True:
        try:
            while True: pass
        except BaseException: pass
def sleeps(x): time.sleep(1000)
def stops(x): os.kill(os.getpid(), signal.SIGSTOP)
def stops_later(x): threading.Timer(0.1, stops, (x,)).start()
def leaves(x): sys.exit(3)
def leaves_hard(x): os._exit(4)
def kills_itself(x): os.kill(os.getpid(), signal.SIGKILL)
def real_time_signal(x): os.kill(os.getpid(), 40)
def interrupts(x): raise KeyboardInterrupt
def crashes(x): ctypes.string_at(0)
def prints(x):
    print("y" * 10_000_000)
    os.system("echo to the descriptor")
    os.write(1, b"NAO1 noise")
    print("late", file=sys.stderr)
    return x
def says(x):
    print("hello", x)
    return x
class Liar:
    def __eq__(self, other): return True
class Mine(np.ndarray):
    def __eq__(self, other): return np.True_
def gives_function(x): return lambda: x
def gives_liar(x): return Liar()
def gives_mine(x): return np.zeros(3).view(Mine)
def gives_much(x): return np.broadcast_to(0.0, (2**27,))
def gives_many(x): return [None] * 10**6
def changes(values):
    values[0] = 5
    return values.sum()
def forks(x):
    os.fork()
    return x
def forks_a_loop(x):
    child = os.fork()
    while child == 0: time.sleep(1)
    return child
def starts_threads(x):
    for _ in range(5): threading.Thread(target=time.sleep, args=(1000,)).start()
    return x
class Raises(Exception):
    def __str__(self): raise self
def raises_oddly(x): raise Raises
def channel(): return [int(name) for name in os.listdir("/proc/self/fd") if int(name) > 2]
def writes(data):
    for each in range(3, 20):
        try: os.write(each, data)
        except OSError: pass
def noise(x): writes(b"noise" * 100)
def early_answer(x): writes(encode((99, Outcome("value", 1.0))))
def closes(x):
    os.closerange(0, 100)
    time.sleep(1000)
def odd_outcome(x):
    import __main__
    for each in (__main__, sys.modules.get("nao_course.instructor.sandbox.worker_process")):
        if each: each.encoded = lambda outcome, *more: running.encoded(Outcome("right", 5), *more)
def environment(): return sorted(os.environ)
def threads():
    import cv2
    return cv2.getNumThreads()
def many_words(x): return {"text": "é", "n": (1, None)}
"""
ONE = Case((3.0,))
AMPLE = 120.0  # seconds for a call that has to succeed, however busy the machine


@pytest.fixture(scope="module")
def notebook(tmp_path_factory):
    return toy.write(tmp_path_factory.mktemp("student") / "own.ipynb", STUDENT)


@pytest.fixture(scope="module", params=["own process", "warm server"])
def server(request):
    """The two ways to start a worker: all laws hold for both."""
    if request.param == "own process":
        return None
    if not sys.platform.startswith("linux"):
        pytest.skip("the warm server forks on Linux alone")
    return request.getfixturevalue("warm_server")


# A process of its own takes long to start: what needs many is tried in both ways by the slow tests only.
both_ways_slowly = pytest.mark.parametrize(
    "server", [pytest.param("own process", marks=pytest.mark.slow), "warm server"], indirect=True
)


@pytest.fixture(scope="module")
def running(notebook, server):
    with Worker(notebook, seconds=AMPLE, server=server) as worker:
        yield worker


@pytest.fixture
def disturbed(notebook, server):
    with Worker(notebook, seconds=AMPLE, allowance=Allowance(10 * AMPLE), server=server) as worker:
        worker.call("double", ONE)
        yield worker
        worker.seconds = AMPLE
        assert worker.call("double", ONE).value == 6.0  # whatever came before, the next call has its answer
        assert worker.call("says", ONE).output == "hello 3.0\n"


def eventually(true):
    """Whether something becomes so; long before the guard ends."""
    end = time.monotonic() + AMPLE
    while not (so := true()) and time.monotonic() < end:
        time.sleep(0.01)
    return so


def stopped(process):
    with contextlib.suppress(psutil.NoSuchProcess):
        return process.status() == psutil.STATUS_STOPPED
    return False


def test_an_outcome_says_what_came_of_a_call_and_an_answer_is_plain_when_it_arrives(running):
    for name, status, text in (
        ("double", "value", ""),
        ("unwritten", "not attempted", ""),
        ("fails", "raised", "ZeroDivisionError: division by zero"),
        ("leaves", "raised", "SystemExit: 3"),
        ("interrupts", "interrupted", ""),
        ("raises_oddly", "raised", "Raises"),
        ("no_such_name", "not found", ""),
        (
            "gives_function",
            "unsendable",
            "a value of type function cannot be sent; call this function with its arguments",
        ),
        ("gives_liar", "unsendable", "a value of type Liar cannot be sent"),
        ("gives_much", "unsendable", "a value larger than"),
        ("gives_many", "unsendable", "more than 200000 values"),
    ):
        outcome = running.call(name, ONE)
        assert outcome.status == status and text in outcome.text, name
    assert type(running.call("gives_mine", ONE).value) is np.ndarray
    assert running.call("many_words", ONE).value == {"text": "é", "n": (1, None)}
    assert running.call("fails", ONE).line.endswith("return 1 / 0")
    case = Case((np.zeros(3),))
    assert running.call("changes", case).changed and not running.call("double", case).changed
    assert case.args[0].sum() == 0


@posix
@pytest.mark.parametrize(
    ("name", "status", "text"),
    [
        ("loops", "timed out", "no answer within 0.5 s"),
        *(("sleeps", "timed out", ""), ("stops", "timed out", ""), ("closes", "died", "")),
        *((name, "died", "could not be read") for name in ("noise", "early_answer", "odd_outcome")),
        *(("leaves_hard", "died", "ended itself with status"), ("kills_itself", "died", "ended by signal 9")),
        *(("real_time_signal", "died", "ended by signal 40"), ("crashes", "died", "ended by signal 11")),
    ],
)
@both_ways_slowly
def test_whatever_kills_the_process_costs_that_call_alone(disturbed, name, status, text):
    disturbed.seconds = 0.5 if status == "timed out" else AMPLE
    outcome = disturbed.call(name, ONE)
    assert outcome.status == status and text in outcome.text


@posix
def test_what_a_call_leaves_behind_or_does_not_read_does_not_disturb_the_next(disturbed):
    for name in ("prints", "forks", "starts_threads"):
        for _ in range(3):
            assert disturbed.call(name, ONE).value == 3.0
    disturbed.call("stops_later", ONE)
    assert eventually(lambda: any(map(stopped, psutil.Process().children(recursive=True))))
    disturbed.seconds = 0.5
    assert disturbed.call("double", Case((np.zeros(10**6),))).status == "timed out"


def test_commands_of_ipython_the_released_set_up_cell_and_helpers_work(tmp_path, server):
    (tmp_path / "colorsys.py").write_text("raise RuntimeError('it must not stand before Python's own')")
    (tmp_path / "my_helper.py").write_text("def twice(x): return 2 * x")
    path = toy.write(
        tmp_path / "own.ipynb",
        "%%time\nfrom my_helper import twice\n!ls",
        "def hue(): return colorsys.rgb_to_hls(1, 0, 0)[0]",
        "from sympy import Matrix, symbols\nx = symbols('x')",
        "class Model:\n    def __new__(cls): return Matrix([x**2]), Matrix([2 * x])",
    )
    helpers = [tmp_path / "colorsys.py", tmp_path / "my_helper.py"]
    with Worker(path, setup="import colorsys\ncolorsys = 5", server=server, helpers=helpers) as worker:
        assert worker.call("twice", ONE).value == 6.0
        assert worker.call("hue", Case(())).value == 0.0
        found = worker.call("Model", Case((["x"], ["x"])), "jacobian").value
    assert evaluated(found, {"x": np.arange(3.0)}, ["x"])["jacobian"].ravel().tolist() == [0, 2, 4]
    with Worker(path, server=server) as worker:
        assert worker.call("hue", Case(())).text.startswith("NameError")


def test_the_beginning_of_what_is_printed_is_kept(running):
    assert running.call("says", ONE).output == "hello 3.0\n"
    output = running.call("prints", ONE).output
    assert set(output) == {"y"} and len(output) == module.MOST_OUTPUT
    assert running.call("double", ONE).output == ""


def test_what_is_expected_is_never_sent(running, monkeypatch):
    sent, ask = [], module.Channel.ask
    noted = lambda self, frame, s: sent.append(frame) or ask(self, frame, s)  # noqa: E731
    monkeypatch.setattr(module.Channel, "ask", noted)
    case = replace(ONE, name="a telling name", expected=np.full(3, 987.125))
    assert running.call("double", case).value == 6.0
    (frame,) = sent
    assert encode(case.expected)[-24:] not in frame and b"telling" not in frame


@pytest.mark.parametrize(("first", "processes"), [("x = 1", 1), ("import os\nx = os._exit(5)", 3)])
def test_statements_are_announced_after_one_has_ended_a_process(
    tmp_path, server, monkeypatch, first, processes
):
    said = []
    receive = module.Channel.receive
    monkeypatch.setattr(module.Channel, "receive", lambda self: said.append(receive(self)) or said[-1])
    path = toy.write(tmp_path / "own.ipynb", first, "def f(x): return x")
    with Worker(path, server=server) as worker:
        assert worker.call("f", ONE).status == "value"
    assert said.count("ready") == processes
    assert any(each[:1] == ("at",) for each in said) == (processes > 1)


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="asks /proc")
def test_the_environment_is_scrubbed_and_nothing_is_open(monkeypatch, notebook, server, running, tmp_path):
    monkeypatch.setenv("A_SECRET", "1")
    with Worker(notebook, server=server) as worker:
        names = worker.call("environment", Case(())).value
        assert "A_SECRET" not in names and {"OMP_NUM_THREADS", "MPLBACKEND"} <= set(names)
        assert worker.call("threads", Case(())).value == 1
    with (tmp_path / "secret").open("w") as secret:
        os.set_inheritable(secret.fileno(), True)
        assert len(running.call("channel", Case(())).value) <= 4  # two pipes, /proc itself, the null device


def gone(process):
    """Whether a process has ended; one that nobody has waited for yet has, too."""
    with contextlib.suppress(psutil.NoSuchProcess):
        return psutil.Process(process).status() == psutil.STATUS_ZOMBIE
    return True


@posix
def test_no_process_is_left(notebook):
    with Worker(notebook, seconds=AMPLE) as worker:
        first = worker.call("forks_a_loop", ONE).value
        worker.seconds = 0.5
        worker.call("leaves_hard", ONE)  # the leader is gone, its child is not, and holds the pipes
        worker.seconds = AMPLE
        second = worker.call("forks_a_loop", ONE).value
        assert eventually(lambda: gone(first))
        assert not gone(second)
    assert eventually(lambda: gone(second))


@both_ways_slowly
def test_statements_that_never_end_or_end_the_process_cost_themselves_alone(tmp_path, server):
    ends = ["import time\nz = time.sleep(1000)", "import os\nz = os._exit(5)"]
    path = toy.write(tmp_path / "own.ipynb", "def before(x): return x", *ends, "def after(x): return x + 1")
    with Worker(path, seconds=2.0, server=server) as worker:
        assert worker.call("before", ONE).value == 3.0
        assert worker.call("after", ONE).value == 4.0
        assert worker.definitions.names == ("before", "after")
        reasons = {(each.cell, each.line): each.reason for each in worker.definitions.skipped}
    assert reasons == {(2, 2): "no answer within 2 s", (3, 2): "the process ended itself with status 5"}


@both_ways_slowly
def test_a_notebook_that_only_ends_is_given_up(tmp_path, server, monkeypatch):
    path = toy.write(tmp_path / "own.ipynb", *["import os\nx = os._exit(5)"] * 10, "def f(x): return x")
    with Worker(path, seconds=AMPLE, server=server) as worker:
        assert worker.call("f", ONE).status == "died"
        monkeypatch.setattr(Worker, "_start", None)  # it is not tried again
        assert worker.call("f", ONE).status == "died"
        assert worker.definitions.names == () and "status 5" in worker.definitions.skipped[0].reason


def test_what_is_no_notebook_has_a_reason_and_is_no_burden_however_often_it_is_called(tmp_path, server):
    (tmp_path / "bad.ipynb").write_text("{")
    for name, reason in (("bad.ipynb", "not a notebook"), ("missing.ipynb", "no such file")):
        with Worker(tmp_path / name, seconds=AMPLE, server=server) as worker:
            outcome = worker.call("f", ONE)
            assert outcome.status == "not found" and reason in outcome.text
            assert reason in worker.definitions.skipped[0].reason
            tracemalloc.start()
            assert {worker.call("anything", ONE).status for _ in range(2000)} == {"not found"}
            assert tracemalloc.get_traced_memory()[0] < 2**17
            tracemalloc.stop()


def test_a_function_may_be_overridden_and_the_others_use_it(tmp_path, server):
    path = toy.write(tmp_path / "own.ipynb", "def f(x): return x\ndef g(x): return f(x) + 1")
    with Worker(path, {"f": "def f(x): return 10 * x"}, server=server) as worker:
        assert worker.call("g", ONE).value == 31.0
        worker.overrides = {"g": "def g(x):\n    return -f(x)"}
        assert worker.call("g", ONE).value == -3.0
        for source, status in (("def f(x, y=1 / 0): pass", "not found"), ("import os; os._exit(3)", "died")):
            worker.overrides = {"f": source}
            assert worker.call("f", ONE).status == status
        worker.overrides = {}
        assert worker.call("g", ONE).value == 4.0


def test_written_answers_and_the_stamp_are_read_in_the_worker(tmp_path, server):
    def cell(source, name="explain", **more):
        metadata = {"nbgrader": {"grade": True, "solution": True, "grade_id": name, **more}}
        return {"cell_type": "markdown", "metadata": metadata, "source": source}

    cells = [cell(["Because\n", "it is."]), cell("read only", solution=False), cell("And more.")]
    stamp = {"nao_course": {"lesson": "01_toy", "version": "1.2"}}
    path = tmp_path / "own.ipynb"
    path.write_text(json.dumps({"cells": [*cells, cell("x" * 10**6, "long")], "metadata": stamp}))
    with Worker(path, server=server) as worker:
        found = worker.definitions
    assert found.written["explain"] == "Because\nit is.\n\nAnd more."
    assert len(found.written["long"]) == 2**16
    assert (found.lesson, found.version) == ("01_toy", "1.2")


LENDING = """
import os
from nao_course.exercises import encode
def base(x): return -1.0
def user(x):
    return [base(x), base(x=x), base(2 * x)]
def asks_for_ever(x):
    while True: base(x)
def asks_oddly(x): return base(lambda: x)
def asks_for_another(x):
    for each in range(3, 20):
        try: os.write(each, encode(("ask", "secret", (1,), {})))
        except OSError: pass
    return x
"""


@pytest.fixture
def lending(tmp_path, server):
    path = toy.write(tmp_path / "own.ipynb", LENDING)
    with Worker(path, seconds=AMPLE, allowance=Allowance(10 * AMPLE), server=server) as worker:
        yield worker


def test_a_function_that_is_lent_answers_from_the_grader_until_it_is_taken_back(lending, monkeypatch):
    asked = []

    def answer(args, kwargs):
        asked.append((args, kwargs))
        return Outcome("value", 10.0 * sum(args) + sum(kwargs.values()))

    assert lending.call("user", ONE).value == [-1.0, -1.0, -1.0]
    lending.stand_in({"base": answer})
    assert lending.call("user", ONE).value == [30.0, 3.0, 60.0]
    assert asked == [((3.0,), {}), ((), {"x": 3.0}), ((6.0,), {})]
    lending.close()  # a process that had to be killed
    assert lending.call("user", ONE).value == [30.0, 3.0, 60.0]
    lending.stand_in({})
    assert lending.call("user", ONE).value == [-1.0, -1.0, -1.0]
    lending.stand_in({"base": lambda args, kwargs: Outcome("raised", text="ValueError: too small")})
    outcome = lending.call("user", ONE)
    assert outcome.status == "raised"
    assert outcome.text == "RuntimeError: base gives no answer to this: raised ValueError: too small"
    assert outcome.line.endswith("return [base(x), base(x=x), base(2 * x)]")
    assert lending.call("asks_oddly", ONE).text.startswith("CodecError")
    real, slept = time.monotonic, []
    monkeypatch.setattr(time, "monotonic", lambda: real() + sum(slept))
    later = lambda *_: (slept.append(2 * lending.allowance.seconds), Outcome("value", 1.0))[1]  # noqa: E731
    lending.stand_in({"base": later})
    assert lending.call("user", ONE).value == [1.0, 1.0, 1.0]


@both_ways_slowly
def test_asking_for_ever_and_for_what_is_not_lent_gains_nothing(lending, monkeypatch):
    lending.stand_in({"base": lambda args, kwargs: Outcome("value", 1.0)})
    lending.definitions  # noqa: B018 - it loads
    monkeypatch.setattr(module, "MOST_ASKED", 500)
    assert "too often" in lending.call("asks_for_ever", ONE).text
    assert lending.call("asks_for_another", ONE).status == "died"
    lending.stand_in({})
    lending.seconds = 0.5
    assert lending.call("asks_for_ever", ONE).status == "timed out"


@both_ways_slowly
def test_a_submission_has_a_total_of_time(notebook, server):
    with Worker(notebook, seconds=AMPLE, server=server) as worker:
        worker.definitions  # noqa: B018 - it loads
        worker.seconds, worker.allowance.seconds = 0.4, worker.allowance.spent + 1.0
        assert worker.call("sleeps", ONE).text == "no answer within 0.4 s"
        assert worker.allowance.spent >= worker.allowance.seconds - 0.7
        worker.allowance.spent = worker.allowance.seconds
        assert worker.call("sleeps", ONE).text == USED_UP


def test_the_texts_of_an_answer_are_bounded_whoever_writes_them(tmp_path, server):
    source = """
import sys, __main__
from nao_course.exercises import Outcome, running
long = "x" * 10**6
false = Outcome("raised", None, long, long, False, long)
def lies(x):
    for each in (__main__, sys.modules.get("nao_course.instructor.sandbox.worker_process")):
        if each: each.encoded = lambda _, *more: running.encoded(false, *more)
"""
    path = toy.write(tmp_path / "own.ipynb", source, *["print(1)"] * 1500)
    with Worker(path, server=server) as worker:
        outcome = worker.call("lies", ONE)
        assert (len(outcome.text), len(outcome.line), len(outcome.output)) == (1000, 1000, 8192)
        assert len(worker.definitions.skipped) == 1000


PATCHES = [
    "json.dumps = json.loads = lambda *args, **kwargs: {}",
    "struct.Struct.pack = None",
    "registry._TYPES.clear()",
    "writing._Writer.node = lambda *args: {'l': [None] * 10**5}",
    "writing._Writer.array = lambda *args: {'a': '<f8', 'shape': [-1], 'b': -8}",
    "writing._Writer.array = lambda *args: {'a': '<f8', 'shape': [2**40, 2**40], 'b': 0}",
    "codec.encode = lambda *args: b'NAO1'",
    "builtins.len = lambda x: 0",
    "builtins.isinstance = lambda *args: True",
    "builtins.exec = builtins.compile = builtins.print = None",
    "np.asarray = np.frombuffer = np.ndarray = None",
    "os.write = os.read = lambda *args: b''",
    "ast.parse = gc.collect = gc.get_objects = None",
    "sys.modules.clear()",
    "sys.stdout = sys.stderr = None",
    "sys.settrace(lambda *args: 1 / 0)",
    "[each.clear() for each in gc.get_objects() if type(each) is dict and 'codec' in each]",
    "Outcome.__init__ = lambda *args, **kwargs: None",
    "sys.setrecursionlimit(50)",
    "threading.Thread(target=lambda: [os.write(each, b'x' * 10**6) for each in (3, 4, 5)]).start()",
]


@both_ways_slowly
@pytest.mark.parametrize("patch", PATCHES)
def test_what_a_student_puts_in_place_of_anything_costs_them_alone(tmp_path, server, patch):
    source = f"""
import ast, builtins, gc, json, os, struct, sys, threading
import numpy as np
from nao_course import codec
from nao_course.codec import registry, writing
from nao_course.exercises import Outcome
def f(x): return 2 * x
def g(x):
    {patch}
    return 3 * x
"""
    path = toy.write(tmp_path / "own.ipynb", source)
    with Worker(path, seconds=AMPLE, allowance=Allowance(10 * AMPLE), server=server) as worker:
        for _ in range(2):
            worker.definitions  # noqa: B018 - it loads
            worker.seconds = 0.5
            outcome = worker.call("g", ONE)
            worker.seconds = AMPLE
            assert outcome.status in ("value", "raised", "died", "timed out", "unsendable"), outcome
            assert type(outcome.value) in (float, type(None), list, dict, np.ndarray, int)
        worker.close()
        assert worker.call("f", ONE).value == 6.0
