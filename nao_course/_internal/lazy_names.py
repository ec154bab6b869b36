"""Packages that import the modules of their names only when a name is used.

A check that needs one function of a lesson then does not load the lesson's panels, which take seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

from nao_course._internal.renamed_names import RENAMED

__all__ = ["import_when_asked"]


def import_when_asked(package: str, names: Mapping[str, Sequence[str]]) -> Callable[[str], Any]:
    """Return a ``__getattr__`` for a package that imports each name from its module at first use.

    `names` are the public names of each module. An unknown name raises an AttributeError, and a name of an older
    release an ImportError with the new name: `from package import name` would hide the message of an AttributeError.
    """
    module_of = {name: module for module, each in names.items() for name in each}

    def look_up(name: str) -> Any:
        if name in module_of:
            return getattr(import_module(f"{package}.{module_of[name]}"), name)
        if name in RENAMED:
            raise ImportError(
                f"{name} is now called {RENAMED[name]}: change the name in your notebook, "
                "or run `nao-course renew`, which changes it for you"
            )
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return look_up
