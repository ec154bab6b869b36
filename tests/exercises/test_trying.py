"""Demonstration cells never stop a notebook."""

import linecache
import sys
from unittest import mock

import cv2
import numpy as np
import pytest
import sympy
from IPython.core.interactiveshell import InteractiveShell

from nao_course.exercises import Case, call, try_out, trying
from tests.paths import PROJECT


def raising(error):
    def function():
        raise error

    return function


def test_an_error_is_named_and_escaped_and_what_could_not_be_made_is_said_again():
    table = try_out(raising(NotImplementedError), "Finish exercise 0.1.")
    assert repr(table) == "Finish exercise 0.1."
    assert repr(try_out(lambda: trying.made(table)[0], "Finish exercise 0.2.")) == "Finish exercise 0.1."
    assert try_out(lambda: trying.made([7])[0]) == 7
    message = try_out(raising(ValueError("<script>alert(1)</script>")))
    assert repr(message).startswith("ValueError: <script>")
    assert "<script>" not in message._repr_html_()
    with pytest.raises(KeyboardInterrupt):
        try_out(raising(KeyboardInterrupt))


def as_in_a_cell(source, number=3, **more):
    """What a cell defines."""
    file = f"<07_ekf_slam, cell {number}>"
    linecache.cache[file] = (len(source), None, source.splitlines(keepends=True), file)
    namespace = dict(more)
    exec(compile(source, file, "exec"), namespace)
    return namespace


def test_a_demonstration_or_one_call_that_never_ends_is_stopped_with_its_line(monkeypatch):
    monkeypatch.setattr(trying, "SECONDS", 0.3)
    update = as_in_a_cell("def update(state):\n    while True:\n        state += 1")["update"]
    said = repr(try_out(as_in_a_cell("show = lambda: [update(0)]", 4, update=update)["show"]))
    assert said.startswith("Time is up: one call of update() was not done after 0.3 s, and was stopped in ")
    assert "Is there a loop that never ends?" in said
    assert said.endswith("Correct it, run its cell and its check, then run this cell again.")
    monkeypatch.setattr(trying, "DISPLAY_SECONDS", 0.2)
    said = repr(try_out(as_in_a_cell("def demonstrate():\n    while True:\n        pass")["demonstrate"]))
    assert said.startswith("Time is up: this was not done after 0.2 s, and was stopped in line ")


def test_a_demonstration_of_many_short_calls_may_take_its_time():
    watch = trying._LongCall(0.0)  # a call that is seen twice is too long
    looks = []

    def look():
        looks.append(watch(sys._getframe()))

    short = as_in_a_cell("def short(times):\n    for _ in range(times):\n        look()", look=look)["short"]
    source = "def helper():\n    look()\n    look()\n    short(1)\n    short(1)\n    short(2)\n"
    source += "def demonstrate():\n    look()\n    look()\n    helper()"
    assert try_out(as_in_a_cell(source, 4, look=look, short=short)["demonstrate"]) is None
    assert looks == [*[False] * 7, True]
    assert watch.name == "short"
    assert try_out(lambda: watch(sys._getframe().f_back)) is False  # in try_out itself nothing is called yet


def test_an_unknown_name_comes_with_its_line_and_one_of_the_courses_with_its_import():
    def slip():
        value = value + 1  # noqa: F821, F841

    assert "'field' is not defined in this notebook yet (line " in repr(try_out(lambda: field))  # noqa: F821
    assert repr(try_out(slip)).startswith("UnboundLocalError")

    def typed():
        return thresh  # noqa: F821

    assert "'thresh' is not defined in this notebook yet (line " in repr(try_out(typed))
    assert "return thresh" in repr(try_out(typed))
    assert repr(try_out(lambda: progress())).endswith("from nao_course.student import progress")  # noqa: F821


def by_the_set_up_cell(shell):
    trying.explain_unknown_names()


def by_the_start_of_the_kernel(shell):
    """As IPython runs the file: in the notebook's own namespace."""
    shell.safe_execfile(PROJECT / "nao_course" / "lab" / "startup.py", shell.user_ns, raise_exceptions=True)
    assert not [name for name in shell.user_ns if "explain" in name or name == "show"]


@pytest.mark.parametrize("installed", [by_the_set_up_cell, by_the_start_of_the_kernel])
def test_in_jupyter_each_unknown_name_gets_its_sentence_and_no_long_traceback(capsys, installed):
    shell = InteractiveShell()
    try:
        with mock.patch.object(trying.sys.modules["IPython"], "get_ipython", return_value=shell):
            installed(shell)
            result = shell.run_cell("try_out(lambda: 1)")
            assert isinstance(result.error_in_exec, NameError)
            said = capsys.readouterr().out
            assert "name 'try_out' is not defined" in said and "Traceback (most" not in said
            assert "'try_out' is not defined in this notebook yet" in said and "Run All Above" in said
            for source in ("1 / 0", "def slip():\n    value = value + 1\nslip()"):
                shell.run_cell(source)
                said = capsys.readouterr().out
                assert "Traceback" in said and "is not defined in this notebook" not in said
    finally:
        InteractiveShell.clear_instance()


def test_numpys_complaint_gets_one_piece_of_advice_that_fits():
    for slip, advice in [
        (lambda: np.ones((2, 3)) @ np.ones((2, 3)), "is a .T missing"),
        (lambda: np.ones(4) - np.ones(2), "need the same shape"),
        (lambda: np.column_stack([np.ones(3), 1.0]), "Is one of them a single number"),
        (lambda: np.block([[np.eye(3), np.ones((2, 3))]]), "along the other axis"),
        (lambda: np.linalg.inv(np.eye(3)[[0, 1], [0, 1]]), "matrix[np.ix_(rows, columns)]"),
        (lambda: np.zeros(0)[0], "That array is empty"),
        (lambda: np.zeros(3)[3], "the last of n is n - 1"),
        (lambda: np.zeros(3)[0:1.6], "The limits of a slice must be whole numbers"),
        (lambda: np.zeros(3)[np.array([0.5])], "Indices must be whole numbers"),
        (lambda: np.ones(2) >= 1.0 & np.ones(2), "put each comparison in brackets"),
        (lambda: np.ones(2).__setitem__([True, False], np.zeros(2)), "write values[mask] there, too"),
        (lambda: np.array([[1, np.zeros(3)], [0, 1]]), "one number, such as v[2]"),
        (lambda: None - 1.0, "is None, perhaps the result"),
        (lambda: (lambda: 0).shape, "a function, not an array"),
        (lambda: 1.5 ^ 2, "A power is written **"),
        (lambda: (np.ones(2),).__getitem__((..., 0)), "Unpack it first"),
        (lambda: np.zeros(3) + np.zeros(2), "the position of a pose (x, y, theta) is pose[:2]"),
        (lambda: float(sympy.Symbol("x")), "SymPy symbols"),
        (lambda: np.sin(sympy.Symbol("x")), "use SymPy's sin"),
        (lambda: np.arctan2(sympy.Symbol("x"), 1), "use SymPy's atan2"),
        (lambda: cv2.Canny(np.zeros((3, 3)), 50, 150), "a picture of bytes"),
        (lambda: (lambda low, high: low)((340, 10)), "as in f(x, *limits)"),
    ]:
        with pytest.raises((IndexError, TypeError, AttributeError, ValueError, cv2.error)) as caught:
            slip()
        (said,) = trying.advice_on(f"{type(caught.value).__name__}: {caught.value}")
        assert advice in said
    for name in ("pi", "π"):
        (said,) = trying.advice_on(f"NameError: name {name!r} is not defined; the function's arguments are a")
        assert "np.pi" in said
    for line in ["clusters.remove(each)", "if point not in seen:", "if point in seen:"]:
        complaint = "ValueError: The truth value of an array with more than one element is ambiguous."
        assert "Build a new list" in trying.advice_on(complaint, line)[0]
        assert "True or False. Instead of" in trying.advice_on(complaint, "if low <= hue <= high:")[0]
    for line, advice in [("nis = nis(nu, S)", "another name"), ("nis += 1", "")]:
        complaint = (
            "UnboundLocalError: cannot access local variable 'nis' where it is not associated with a value"
        )
        assert advice in "".join(trying.advice_on(complaint, line)) and bool(advice) == ("(" in line)


WHOSE = {
    "np = 3\ndef f(x):\n    return np.zeros(3)": "the name np",
    "import numpy as np\nnp = np.zeros(3)\ndef f(x):\n    return np.sin(x)": "the name np",
    "max = 3\ndef f(x):\n    return x + max(x, 3)": "the name max",
    "def f(x):\n    return x.integers(0, 9)": "in the order of the function's first line",
    "def f(x):\n    y = 3\n    return y.shape": "",
    "y = 3\ndef f(x):\n    return y.shape": "the name y",
}


def test_the_advice_on_a_value_depends_on_whose_value_it_is(monkeypatch):
    for source, advice in WHOSE.items():
        name, space = "<01_whose, cell 3>", {}
        monkeypatch.setitem(linecache.cache, name, (len(source), None, source.splitlines(True), name))
        exec(compile(source, name, "exec"), space)
        outcome = call(space["f"], Case((3,)))
        assert advice in " ".join(trying.advice_on(outcome.text, outcome.line))
