"""Every benchmark can be run by its name."""

import importlib

import pytest

from benchmarks import RESULTS
from benchmarks.__main__ import MODULES, main


def test_a_benchmark_can_be_imported_every_result_is_of_one_and_another_name_is_refused(capsys):
    assert all(callable(importlib.import_module(module).main) for module in MODULES.values())
    assert {path.stem for path in RESULTS.glob("*.json")} <= {*MODULES}
    with pytest.raises(SystemExit):
        main(["association", "asociation"])
    assert "there is no benchmark asociation" in capsys.readouterr().err
