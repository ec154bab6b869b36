"""Every benchmark can be run by its name."""

import importlib

import pytest

from benchmarks import RESULTS
from benchmarks.__main__ import MODULES, main

SMALLER = {"grading_beside", "grading_large", "grading_many"}  # results of parts of the benchmark `grading`


@pytest.mark.parametrize("name", MODULES)
def test_a_benchmark_can_be_imported(name):
    assert callable(importlib.import_module(MODULES[name]).main)


def test_every_result_is_of_a_benchmark():
    assert {path.stem for path in RESULTS.glob("*.json")} - SMALLER <= {*MODULES}


def test_a_name_that_is_none_is_refused(capsys):
    with pytest.raises(SystemExit):
        main(["association", "asociation"])
    assert "there is no benchmark asociation" in capsys.readouterr().err
