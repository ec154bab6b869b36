"""The warm server's workers are bounded, leave nothing behind, and outlive its death as work to be done again."""

import contextlib
import gc
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from nao_course.exercises import Case
from nao_course.instructor.sandbox import warm_server as module
from nao_course.instructor.sandbox.confinement import Bounds
from nao_course.instructor.sandbox.layers import NAMESPACES, Layer, Sandbox, SandboxError, probe
from nao_course.instructor.sandbox.protocol import EarlierNotebook, ServerEnded
from nao_course.instructor.sandbox.warm_server import WarmServer
from nao_course.instructor.sandbox.worker import Worker
from tests.paths import PROJECT
from tests.sandboxed import attacker, attempt, need, only, quickly
from tests.toy import toy

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="it forks on Linux alone")

BOUNDS = Bounds(memory=512 * 2**20, processes=40, scratch=64 * 2**20)
AMPLE = 120.0  # seconds for a call that has to succeed, however busy the machine


def cold(sandbox):
    """A server that has imported nothing: it starts at once."""
    return WarmServer(sandbox, BOUNDS, warm=False)


def patient(notebook, server):
    """A worker whose calls have all the time that they need."""
    return Worker(notebook, seconds=AMPLE, server=server)


@pytest.fixture(scope="module")
def notebook(tmp_path_factory):
    return attacker(tmp_path_factory.mktemp("attacker"))


@pytest.fixture
def fresh():
    """Return a server of one test, which may be ended."""
    need(*NAMESPACES)
    with cold(probe()) as server:
        yield server


@pytest.fixture(scope="module")
def server():
    need(*NAMESPACES)
    with cold(probe()) as server:
        yield server


@pytest.fixture
def worker(notebook, server):
    with patient(notebook, server) as worker:
        yield worker


def stat(process: int) -> list[str]:
    """Return the state of a process, its parent and what follows in /proc; an empty list if it has ended."""
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return []


def processes() -> list[int]:
    return [int(name) for name in os.listdir("/proc") if name.isdigit()]


def descendants(process: int) -> set[int]:
    """All processes below one, in whatever namespace."""
    parents = {each: int(found[1]) for each in processes() if (found := stat(each))}
    found = {process}
    while more := {child for child, parent in parents.items() if parent in found} - found:
        found |= more
    return found - {process}


def child_of(process: int) -> int:
    """The child of a process that has one; its number may be smaller, because numbers begin again at 1."""
    return next(each for each in descendants(process) if int(stat(each)[1]) == process)


def ended(process: int) -> bool:
    """Whether a process has ended; it may still have to be waited for."""
    return (stat(process) or "X")[0] in "ZX"


def servers_family(server: WarmServer) -> set[int]:
    """The server and all that was ever forked from it, whoever its parent is now."""
    line = Path(f"/proc/{server.process}/cmdline").read_bytes()
    family = set()
    for process in processes():
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            if Path(f"/proc/{process}/cmdline").read_bytes() == line and not ended(process):
                family.add(process)
    return family


@pytest.fixture(autouse=True)
def temporary(tmp_path, monkeypatch):
    """A folder for temporary files that no other process uses."""
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))


def state() -> tuple[object, ...]:
    """What a submission may not change: mounts, temporary files, descriptors."""
    gc.collect()
    temporary = sorted(os.listdir(tempfile.gettempdir()))
    return Path("/proc/self/mounts").read_text(), temporary, len(os.listdir("/proc/self/fd"))


def eventually(true):
    until = time.monotonic() + AMPLE
    while not (so := true()) and time.monotonic() < until:
        time.sleep(0.01)
    return so


BOMBS = {
    "fork bomb": """
def bomb():
    while True:
        try: os.fork()
        except OSError: time.sleep(0.01)
bomb()
""",
    "children in sessions of their own": """
started = 0
for _ in range(60):
    try:
        if os.fork() == 0:
            libc.setsid()
            os.fork()
            time.sleep(1000)
        started += 1
    except BlockingIOError:
        break
started
""",
    "threads without end": """
while True:
    try: threading.Thread(target=time.sleep, args=(1000,)).start()
    except RuntimeError: break
threading.active_count()
""",
    "a child that wakes up later": """
for _ in range(5):
    if os.fork() == 0:
        libc.setsid()
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        time.sleep(3)
        os.kill(-1, 9)
1
""",
}


@pytest.mark.parametrize("bomb", quickly(BOMBS, "children in sessions of their own"))
def test_processes_and_threads_are_bounded_and_end_with_the_worker(notebook, server, bomb):
    before, known = state(), servers_family(server)
    most = 0
    with Worker(notebook, seconds=3.0, server=server) as worker:
        attempt(worker, "1")
        caller = threading.Thread(target=attempt, args=(worker, BOMBS[bomb].strip()))
        caller.start()
        while caller.is_alive():
            most = max(most, len(servers_family(server)))
            time.sleep(0.05)
        # The kernel counts without a lock: forks at once overshoot
        assert most <= 1.5 * BOUNDS.processes + len(known)
    assert servers_family(server) == known
    assert state() == before
    with patient(notebook, server) as worker:
        assert attempt(worker, "2").value == "2"


def test_one_workers_processes_are_not_counted_against_another(notebook, server):
    with patient(notebook, server) as greedy, patient(notebook, server) as honest:
        assert int(attempt(greedy, BOMBS["threads without end"]).value) > 20
        assert attempt(honest, "t = threading.Thread(target=print)\nt.start()").value == "None"


HOGS = {
    "one process": "bytearray(2**30)",
    "many pieces": "[bytearray(2**24) for _ in range(200)]",
    "touched arrays": "import numpy as np\n[np.ones(2**22) for _ in range(100)]",
}


@pytest.mark.parametrize("hog", quickly(HOGS, "one process"))
def test_a_process_that_wants_too_much_memory_gets_an_error(worker, hog):
    outcome = attempt(worker, HOGS[hog])
    assert outcome.status == "raised"
    assert outcome.text.startswith(("MemoryError", "_ArrayMemoryError"))
    assert attempt(worker, "1").value == "1"


ALL_OF_IT = """
held = []
for k in (26, 20, 13, 9, 5, 30):
    try:
        while True: held.append(bytearray(2**k))
    except MemoryError:
        if k == 30: raise
"""
HOARD = "held = []\nfor _ in iter(int, 1): held.append(bytearray(2**26))\n"
LARGE = "def large(): return len(bytearray(256 * 2**20))"


@pytest.mark.slow
@pytest.mark.parametrize("hoard", [HOARD, ALL_OF_IT])
@pytest.mark.parametrize("whose", ["its own", "an earlier lesson's"])
def test_a_statement_that_takes_all_memory_leaves_some_to_the_rest_of_the_notebook(
    tmp_path, server, whose, hoard
):
    own = hoard + LARGE if whose == "its own" else LARGE
    notebook = toy.write(tmp_path / "02_own.ipynb", own)
    earlier = toy.write(tmp_path / "01_before.ipynb", hoard)
    before = [EarlierNotebook("01_before", earlier.read_bytes())]
    with Worker(notebook, seconds=AMPLE, server=server, earlier=before * (whose != "its own")) as worker:
        assert worker.call("large", Case(())).value == 256 * 2**20
        assert worker.deaths == 0
        reasons = [each.reason for each in worker.definitions.skipped]
    assert [reason.split(":")[0] for reason in reasons] == (["MemoryError"] if whose == "its own" else [])


def test_processes_that_want_too_much_memory_together_are_ended(worker):
    source = """
for _ in range(8):
    if os.fork() == 0:
        block = bytearray(300 * 2**20)
        for at in range(0, len(block), 4096): block[at] = 1
        time.sleep(1000)
time.sleep(1000)
"""
    outcome = attempt(worker, source + "1")
    assert outcome.status == "died"
    assert outcome.text == "the process and its children used more than 512 MB of memory"


FILES = {
    "one large file": "open('large', 'wb').truncate(10 * 2**30)",
    "a file that is written": "f = open('large', 'wb')\n[f.write(bytes(2**20)) for _ in range(10240)]",
    "many files": "[open(f'file{k}', 'wb').write(bytes(2**20)) for k in range(1000)]",
    "many empty files": "[open(f'file{k}', 'wb').close() for k in range(100_000)]",
    "many open files": "[open('/dev/null') for k in range(10_000)]",
}


@pytest.mark.parametrize("kind", FILES)
def test_files_are_bounded_and_go_with_the_worker(notebook, server, kind):
    free = os.statvfs(tempfile.gettempdir()).f_bavail
    with patient(notebook, server) as worker:
        outcome = attempt(worker, FILES[kind])
        assert outcome.status == "raised"
        assert outcome.text.startswith("OSError"), outcome
        used = attempt(worker, "os.statvfs('/scratch').f_blocks * os.statvfs('/scratch').f_frsize").value
        assert int(used) == BOUNDS.scratch
    assert os.statvfs(tempfile.gettempdir()).f_bavail > free - 50_000  # blocks; other processes write, too


def test_a_notebook_that_is_too_large_is_refused_before_it_is_read(tmp_path, server):
    path = tmp_path / "large.ipynb"
    with path.open("wb") as file:
        file.truncate(200 * 2**20)
    with Worker(path, server=server) as worker:
        assert worker.call("f", Case(())).text == "large.ipynb: larger than 50 MB"
    path.write_text('{"cells": ' + "[" * 10**6)
    with Worker(path, server=server) as worker:
        assert "not a notebook" in worker.call("f", Case(())).text


def test_workers_see_nothing_of_each_other(notebook, server):
    with patient(notebook, server) as first, patient(notebook, server) as second:
        assert attempt(first, "open('mine', 'w').write('x')").value == "1"
        assert attempt(first, "sys.modules['numpy'].pi = 3\nsys.modules['numpy'].pi").value == "3"
        assert attempt(second, "os.listdir()").value == "['attacker.ipynb']"
        assert attempt(second, "sys.modules['numpy'].pi > 3.1").value == "True"
        assert attempt(second, "os.getpid(), os.getppid()").value == "(2, 0)"


def test_a_worker_holds_no_descriptor_but_its_channel_and_no_solution(worker):
    source = """
open_files = [f"/proc/self/fd/{name}" for name in os.listdir("/proc/self/fd")]
sorted(os.readlink(each).split(":")[0] for each in open_files if os.path.lexists(each))
"""
    value = attempt(worker, source).value
    assert value == "['/dev/null', '/dev/null', '/dev/null', 'socket']"
    value = attempt(worker, "[name for name in sys.modules if 'plans' in name or 'solution' in name]").value
    assert value == "[]"


def test_many_workers_at_once_and_one_after_the_other_leave_nothing(notebook, server):
    before, known = state(), descendants(server.process)

    def grade(number):
        with patient(notebook, server) as worker:
            return [attempt(worker, f"{number} + {k}").value for k in range(3)]

    with ThreadPoolExecutor(4) as threads:
        values = list(threads.map(grade, range(24)))
    assert values == [[str(number + k) for k in range(3)] for number in range(24)]
    assert descendants(server.process) == known
    assert state() == before


def test_a_worker_that_is_killed_costs_its_call_alone(worker, server):
    known = descendants(server.process)
    for which in (0, 1):  # the one that waits, and the student's
        assert attempt(worker, "1").value == "1"
        both = sorted(descendants(server.process) - known)
        assert len(both) == 2
        os.kill(both[which], signal.SIGKILL)
        assert eventually(lambda student=both[1]: ended(student))
        assert attempt(worker, "2").text == "the process was ended by signal 9 (Killed)"
        assert attempt(worker, "3").value == "3"
        worker.close()


def test_the_death_of_the_server_is_told_and_the_next_submission_has_a_new_one(notebook, fresh):
    with patient(notebook, fresh) as worker:
        for process in (lambda: fresh.process, lambda: child_of(fresh.process)):
            assert attempt(worker, "1").value == "1"
            below = descendants(fresh.process)
            os.kill(process(), signal.SIGKILL)
            assert eventually(lambda below=below: all(map(ended, below)))
            with pytest.raises(ServerEnded, match="died"):
                attempt(worker, "2")
            with patient(notebook, fresh) as another:
                assert attempt(another, "3").value == "3"
            assert attempt(worker, "4").value == "4"
    assert fresh.generation == 3
    with patient(notebook, fresh) as first, patient(notebook, fresh) as second:
        assert (attempt(first, "1").value, attempt(second, "1").value) == ("1", "1")
        below = descendants(fresh.process)
        os.kill(fresh.process, signal.SIGKILL)
        assert eventually(lambda: all(map(ended, below)))
        with pytest.raises(ServerEnded):
            attempt(first, "2")
        assert attempt(first, "3").value == "3"
        with pytest.raises(ServerEnded):
            attempt(second, "4")
        assert attempt(first, "5").value == "5"  # by the new server still
    assert fresh.generation == 4


def test_a_worker_ends_beside_another_one_when_what_makes_their_namespaces_was_killed(notebook, fresh):
    with patient(notebook, fresh) as first:
        assert attempt(first, "1").value == "1"
    assert eventually(lambda: len(descendants(fresh.process)) == 2)  # the worker has ended
    factory = child_of(child_of(fresh.process))
    with patient(notebook, fresh) as first, patient(notebook, fresh) as second:
        assert (attempt(first, "1").value, attempt(second, "1").value) == ("1", "1")
        os.kill(factory, signal.SIGKILL)
        assert eventually(lambda: ended(factory))
        first.close()
        assert attempt(second, "2").text == "the process was ended by signal 9 (Killed)"
        assert fresh.generation == 1, "the server answers, although it can make no namespace any more"


@pytest.mark.slow
def test_a_server_that_stops_answering_is_replaced(notebook, fresh, monkeypatch):
    monkeypatch.setattr(module, "_SECONDS_TO_REPLY", 1.0)
    with patient(notebook, fresh) as worker:
        os.kill(child_of(fresh.process), signal.SIGSTOP)
        with pytest.raises(ServerEnded):
            attempt(worker, "1")
        assert attempt(worker, "2").value == "2"


def test_the_server_ends_with_its_grader_however_that_ends(notebook):
    need(*NAMESPACES)
    code = f"""
import os, signal, sys
from pathlib import Path
from nao_course.exercises import Case
from nao_course.instructor.sandbox.layers import probe
from nao_course.instructor.sandbox.warm_server import WarmServer
from nao_course.instructor.sandbox.worker import Worker
server = WarmServer(probe(), warm=False).__enter__()
worker = Worker(Path({str(notebook)!r}), server=server)
worker.call("attempt", Case(("1",)))
print(server.process, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""
    grader = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, cwd=PROJECT)
    process = int(grader.stdout.readline())
    grader.wait()
    grader.stdout.close()
    assert eventually(lambda: not os.path.exists(f"/proc/{process}/fd") or not descendants(process))
    assert eventually(lambda: ended(process))


def test_closing_the_server_leaves_nothing(notebook):
    before = state()
    server = cold(probe())
    with server, patient(notebook, server) as worker:
        assert attempt(worker, "1").value == "1"
        below = descendants(server.process) | {server.process}
    assert not any(os.path.exists(f"/proc/{each}") for each in below)
    assert state() == before


def test_a_server_or_worker_that_cannot_be_confined_does_not_start(notebook, monkeypatch):
    need(*NAMESPACES)
    told = module.asdict
    monkeypatch.setattr(module, "asdict", lambda bounds: {"no such": 1})
    server = cold(probe())
    with pytest.raises(SandboxError, match=r"could not start: TypeError.*no such"):
        server.__enter__()
    assert server.process is None
    monkeypatch.setattr(module, "asdict", lambda bounds: told(bounds) | {"scratch": "no number"})
    refused = pytest.raises(SandboxError, match="could not be confined")
    with cold(probe()) as server, patient(notebook, server) as worker, refused:
        attempt(worker, "1")


@pytest.mark.parametrize("layers", [("landlock",), ()], ids=["landlock", "process"])
def test_without_namespaces_nothing_is_left_either(notebook, layers):
    before = state()
    with cold(only(*layers)) as server:
        known = servers_family(server)
        for bomb in ("children in sessions of their own", "a child that wakes up later"):
            with patient(notebook, server) as worker:
                source = BOMBS[bomb].replace("os.kill(-1, 9)", "1")
                assert int(attempt(worker, source).value) >= 1
                assert attempt(worker, "open('mine', 'w').write('x')").value == "1"
                assert len(servers_family(server)) > len(known) + 5
            assert servers_family(server) == known
    assert state() == before


@pytest.mark.slow
@pytest.mark.parametrize("missing", ["_try_namespace", "_try_all", "_try_seccomp"])
def test_a_machine_that_refuses_some_layers_still_grades_behind_the_others(notebook, missing):
    code = f"""
import json
from nao_course.instructor.sandbox import layers as sandbox
def refused(*_): raise OSError("refused here")
sandbox.{missing} = refused
print(json.dumps([[layer.name, layer.on, layer.detail] for layer in sandbox._trial()]))
"""
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, cwd=PROJECT, check=True)
    sandbox = Sandbox(tuple(Layer(*each) for each in json.loads(done.stdout)))
    assert any("refused here" in layer.detail for layer in sandbox.layers if not layer.on)
    assert sandbox.level != "full"
    look = "__import__('colorsys').rgb_to_hls(1, 0, 0)[0], len(os.listdir())"
    with cold(sandbox) as server, patient(notebook, server) as worker:
        assert attempt(worker, look).value == "(0.0, 1)"
        assert attempt(worker, "open('mine', 'w').write('x')").value == "1"


def test_where_nothing_can_be_forked_a_worker_is_a_process_with_limits(notebook, monkeypatch):
    monkeypatch.setattr(WarmServer, "forks", False)
    before = state()
    with cold(probe()) as server, patient(notebook, server) as worker:
        assert attempt(worker, "os.listdir()").value == "['attacker.ipynb']"
        assert attempt(worker, "open('large', 'wb').truncate(10 * 2**30)").status == "raised"
        assert attempt(worker, "1").value == "1"
        assert server.process is None
    assert state() == before


def test_a_worker_of_a_warm_server_has_what_lessons_use_before_its_first_statement(notebook, warm_server):
    wanted = ["numpy", "cv2", "scipy.optimize", "matplotlib.pyplot", "sympy", "nao_course.sim"]
    with Worker(notebook, seconds=AMPLE, server=warm_server) as worker:
        assert attempt(worker, "[name for name in args[0] if name not in sys.modules]", wanted).value == "[]"
        assert attempt(worker, "[name for name in sys.modules if 'authoring' in name]").value == "[]"
