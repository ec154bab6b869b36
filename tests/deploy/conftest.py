"""What the tests of the hub's programs share."""

import sys
from importlib import import_module

import pytest

from tests.paths import PROJECT


@pytest.fixture
def hub_program(monkeypatch):
    """Return a function that imports a program of the hub by its name, for one test."""
    monkeypatch.syspath_prepend(str(PROJECT / "deploy" / "hub"))
    before = set(sys.modules)
    yield import_module
    for name in set(sys.modules) - before:
        if (PROJECT / "deploy" / "hub" / f"{name}.py").exists():
            sys.modules.pop(name)
