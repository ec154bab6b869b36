"""Every benchmark can be run by its name."""

import importlib

import pytest

from benchmarks import RESULTS
from benchmarks.__main__ import MODULES, main


@pytest.mark.parametrize("name", MODULES)
def test_a_benchmark_can_be_imported(name):
    assert callable(importlib.import_module(MODULES[name]).main)


def test_every_result_is_of_a_benchmark_and_another_name_is_refused(capsys):
    assert {path.stem for path in RESULTS.glob("*.json")} <= {*MODULES}
    with pytest.raises(SystemExit):
        main(["association", "asociation"])
    assert "there is no benchmark asociation" in capsys.readouterr().err
