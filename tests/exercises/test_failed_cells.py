"""After a cell that did not run, nobody is told about the function that it was to replace."""

import time
from unittest import mock

import pytest
from IPython.core.interactiveshell import InteractiveShell

from nao_course.exercises import failed_cells
from nao_course.exercises.failed_cells import FailedCells, where_reused


@pytest.fixture
def shell():
    shell = InteractiveShell()
    yield shell
    InteractiveShell.clear_instance()


@pytest.fixture
def cells(shell):
    cells = FailedCells()
    with mock.patch.object(failed_cells.sys.modules["IPython"], "get_ipython", return_value=shell):
        cells.watch()
        cells.watch()  # the set-up cell was run again
    return cells


def test_a_definition_with_a_syntax_error_or_below_an_error_is_named_until_it_runs(shell, cells, capsys):
    shell.run_cell("def double(x):\n    return x")
    assert cells.why_old("double") == ""
    shell.run_cell("def double(x):\n    return 2 *")
    said = "The cell that defines double did not run: SyntaxError, line 2: invalid syntax."
    assert cells.why_old("double") == said
    shell.run_cell("other = 1")
    assert cells.why_old("double")
    shell.run_cell("def double(x):\n    return 2 * x")
    assert cells.why_old("double") == ""
    shell.run_cell("def double(x):\n    return x")
    shell.run_cell("1 / 0\ndef double(x):\n    return 2 * x")
    assert "ZeroDivisionError: division by zero" in cells.why_old("double")
    shell.run_cell("def double(x):\n    return 2 * x\n1 / 0")
    assert cells.why_old("double") == ""


def test_a_corrected_cell_that_also_checks_its_function_or_class_is_not_out_of_date(shell, cells, capsys):
    """The check runs before the cell has ended, so the cell's own definition has to count already."""
    shell.user_ns["why_old"] = cells.why_old
    shell.run_cell("def double(x):\n    return 2 *")
    shell.run_cell("def double(x):\n    return 2 * x\nsaid = why_old('double')")
    assert shell.user_ns["said"] == ""
    shell.run_cell("def double(x):\n    return 3 *")
    shell.run_cell("said = why_old('double')\ndef double(x):\n    return 2 * x")
    assert shell.user_ns["said"].startswith("The cell that defines double did not run")
    shell.run_cell("class Filter:\n    def update(self):\n        return (")
    assert cells.why_old("Filter") and not cells.why_old("update")
    cells = FailedCells()
    cells.watch()
    assert cells.why_old("double") == ""


def test_the_cell_that_gives_a_name_to_a_value_is_named_in_one_pass():
    for source, does in [
        *(("T = 3", True), ("mean, T= 1, 2", True), ("for T in range(3):\n    pass", True)),
        ("for i, T in pairs:\n    pass", True),
        *(("T == 3", False), ("T_2 = T", False), ("format = T", False), ("main, T.index(3)", False)),
    ]:
        told = where_reused(["Error; the notebook's name T is of type int"], ["T_2 = 1", source, "print(T)"])
        assert told == ["Code cell 2 gives the name T to that value."] * does
    began = time.process_time()
    assert where_reused(["the notebook's name T is of type int"], ["T," * 200_000, "T = 3, T, " * 50_000])
    assert time.process_time() - began < 5.0
