"""Every benchmark can be run by its name."""

import importlib
import pkgutil

import pytest

import benchmarks
from benchmarks.__main__ import MODULES, main


def modules_with_main() -> set[str]:
    """Return the modules and packages that define a benchmark, two levels deep."""
    found = set()
    for folder in pkgutil.iter_modules(benchmarks.__path__, "benchmarks."):
        if folder.name == "benchmarks.__main__":
            continue
        package = importlib.import_module(folder.name)
        names = [folder.name]
        if not hasattr(package, "main") and folder.ispkg:
            names += [each.name for each in pkgutil.iter_modules(package.__path__, f"{folder.name}.")]
        found |= {name for name in names if hasattr(importlib.import_module(name), "main")}
    return found


def test_each_benchmark_has_a_name_and_each_name_is_a_benchmark():
    assert set(MODULES.values()) == modules_with_main()


def test_a_name_that_is_none_is_refused(capsys):
    with pytest.raises(SystemExit):
        main(["association", "asociation"])
    assert "there is no benchmark asociation" in capsys.readouterr().err
