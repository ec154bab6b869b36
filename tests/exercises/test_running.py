"""Drivers are found by their name, from wherever they are registered; what takes too long is stopped."""

import errno
import importlib
import linecache
import os
import signal
import sys
import threading
from types import FunctionType, ModuleType

import pytest

from nao_course.exercises import Case, call, register_driver, running
from nao_course.exercises.comparisons.jacobians import jacobian
from nao_course.exercises.running import find_driver


def test_a_driver_is_found_by_its_name_and_runs_with_the_students_function_first(monkeypatch):
    assert find_driver("jacobian") is jacobian
    for name in ("no_driver", "os:system", "nao_course.exercises.running:call"):
        with pytest.raises(ValueError, match=r"there is no driver .*'jacobian'.*'methods'"):
            find_driver(name)
    with pytest.raises(ValueError, match="a driver named 'jacobian' is registered already"):
        register_driver(FunctionType((lambda: None).__code__, {}, "jacobian"))
    monkeypatch.setattr("nao_course.exercises.running._DRIVERS", {})
    module = ModuleType("nao_course.a_lesson_of_this_test")
    monkeypatch.setitem(sys.modules, module.__name__, module)

    @register_driver
    def twice(function, value):
        return function(function(value))

    name = f"{module.__name__}:twice"
    assert find_driver(name) is twice
    assert call(lambda value: value + 1, Case((1,)), name).value == 3


def cell(source, name):
    """What a function looks like that was written in a cell, whose lines Python can show."""
    linecache.cache[name] = (len(source), None, source.splitlines(keepends=True), name)
    namespace = {}
    exec(compile(source, name, "exec"), namespace)
    return namespace["f"]


CELLS = ("<ipython-input-3-5f0c>", "<04_distance, cell 7>", "/tmp/ipykernel_71/2735462784.py")
MADE_AS_TEXT = {
    "lambdify": "import sympy\nx = sympy.Symbol('x')\ng = sympy.lambdify(x, 1 / x, 'math')\ndef f(v):\n    return g(v)",
    "exec": "space = {}\nexec('def g(v):\\n    return 1 / v', space)\n\ndef f(v):\n    return space['g'](v)",
    "a dataclass": "from dataclasses import dataclass\n@dataclass\nclass G:\n    a: int\n    b: int\n"
    "def f(v):\n    return G(v)",
    "a lambda in numpy": "import numpy as np\n\n\ndef f(v):\n    return np.vectorize(lambda x: 1 / int(x))([v])",
}


@pytest.mark.parametrize("name", CELLS)
@pytest.mark.parametrize("made", MADE_AS_TEXT)
def test_the_students_own_line_is_said_also_where_code_that_was_made_as_text_raises(made, name):
    source = MADE_AS_TEXT[made]
    outcome = call(cell(source, name), Case((0,)))
    number = len(source.splitlines())
    assert outcome.line == f"line {number}: {source.splitlines()[-1].strip()}"


def test_a_function_of_another_cell_that_raises_is_named():
    """Its line is said with the number in that cell, so the number alone would mislead."""
    inner = cell("def f(v):\n    return 1 / v", "<ipython-input-7-0123456789ab>")
    made = cell("def f(v):\n    return inner(v)", "<ipython-input-8-0123456789ab>")
    made.__globals__["inner"] = inner
    assert call(made, Case((0,))).text == "ZeroDivisionError: division by zero (inside f)"
    assert call(inner, Case((0,))).text == "ZeroDivisionError: division by zero"


@pytest.mark.parametrize(
    ("source", "named"),
    [
        ("T = 3\ndef f(v):\n    return T(v)", "; the notebook's name T is of type int"),
        ("def f(v):\n    return v(1)", "; the argument v is of type int"),
        ("T = 3\ndef f(v):\n    return T.size", "; the notebook's name T is of type int"),
        ("def f(v):\n    return len(v)", ""),  # nobody gave the name len to a value
    ],
)
def test_a_name_of_the_notebook_or_an_argument_whose_value_fails_is_said_and_no_builtin_is_blamed(
    source, named
):
    text = call(cell(source, CELLS[0]), Case((0,))).text
    assert text.partition("; ")[1:] == named.partition("; ")[1:]


needs_alarm = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no alarm clock")


def endless():
    while True:
        pass


@needs_alarm
def test_an_alarm_within_another_rings_no_later_and_leaves_the_outer_one_on():
    def inner_then_endless():
        with running.alarm(60.0):
            pass
        endless()

    with pytest.raises(running.TimeIsUp), running.alarm(0.05):
        inner_then_endless()
    with pytest.raises(running.TimeIsUp), running.alarm(0.05), running.alarm(60.0):
        endless()
    with running.alarm(60.0):
        with pytest.raises(running.TimeIsUp), running.alarm(0.05):
            endless()
        assert 0.0 < signal.getitimer(signal.ITIMER_REAL)[0] <= 60.0
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0


@needs_alarm
def test_an_alarm_rings_after_an_import_not_within_it_unless_that_never_ends(tmp_path, monkeypatch):
    """A compiled module that is begun and not ended can never be imported again: a lesson's first cell died of that."""
    (tmp_path / "slow_to_import.py").write_text("import time\ntime.sleep(0.2)\nENDED = True\n")
    monkeypatch.syspath_prepend(tmp_path)

    def import_and_go_on():
        importlib.import_module("slow_to_import")
        while True:
            pass

    with pytest.raises(running.TimeIsUp), running.alarm(0.05):
        import_and_go_on()
    assert sys.modules["slow_to_import"].ENDED
    (tmp_path / "never_imported.py").write_text("while True:\n    pass\n")
    monkeypatch.setattr("nao_course._internal.time_limits.IMPORTING", 0.1)
    with pytest.raises(running.TimeIsUp), running.alarm(0.05):
        importlib.import_module("never_imported")


def test_in_another_thread_too_a_case_that_never_ends_is_stopped():
    """There, and on Windows, no alarm clock rings."""
    found = []

    def check():
        found.extend(running.call_all(lambda: endless(), [Case(()), Case(())], seconds=0.05))

    thread = threading.Thread(target=check, daemon=True)
    thread.start()
    thread.join(30)  # where it is not stopped
    assert [outcome.status for outcome in found] == ["timed out"]


def test_used_up_disk_space_is_said_in_plain_words():
    for number in [errno.ENOSPC, errno.EFBIG, errno.EDQUOT]:

        def full(number=number):
            raise OSError(number, os.strerror(number), "big.npy")

        said = call(full, Case(())).text
        assert said == "OSError: the disk space that this code may use is used up"
