"""What packages and modules say of themselves: their public names, some of which are imported only when they are used.

A check that needs one function of a lesson then does not load the lesson's panels, which take seconds.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

from nao_course._internal.renamed_names import RENAMED

__all__ = ["import_when_asked", "list_public"]


def list_public(module: str) -> Callable[[], list[str]]:
    """Return a ``__dir__`` that lists a module's ``__all__``, so that tab completion omits what the module imports."""
    return lambda: sys.modules[module].__all__


def import_when_asked(
    package: str, names: Mapping[str, Sequence[str]]
) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__all__``, ``__getattr__`` and ``__dir__`` of a package that imports each name at its first use.

    `names` are the public names by module, a module of the package or one of `nao_course` in full. An unknown name
    raises an AttributeError, and a name of an older release an ImportError with the new name: `from package import
    name` would hide the message of an AttributeError.
    """
    module_of = {name: module for module, each in names.items() for name in each}

    def look_up(name: str) -> Any:
        if name in module_of:
            module = module_of[name]
            whole = module if module.startswith("nao_course.") else f"{package}.{module}"
            return getattr(import_module(whole), name)
        if name in RENAMED:
            raise ImportError(
                f"{name} is now called {RENAMED[name]}: change the name in your notebook, "
                "or run `nao-course renew`, which changes it for you"
            )
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return sorted(module_of), look_up, list_public(package)
