"""What packages and modules say of themselves: their public names, some of which are imported only when they are used.

A check that needs one function of a lesson then does not load the lesson's panels, which take seconds.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from nao_course._internal.renamed_names import RENAMED

__all__ = ["import_as_typed", "import_when_asked", "list_public"]


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


def import_as_typed(package: str, file: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a package that imports at first use what its file imports for type checkers only.

    `file` is the package's ``__file__``; it has an ``if TYPE_CHECKING:`` block of ``from module import names``.
    """
    blocks = (each for each in ast.parse(Path(file).read_bytes()).body if isinstance(each, ast.If))
    imports = [each for block in blocks for each in block.body if isinstance(each, ast.ImportFrom)]
    names = {str(each.module): [name.name for name in each.names] for each in imports}
    look_up = import_when_asked(package, names)[1]

    def keep(name: str) -> Any:
        value = look_up(name)
        setattr(sys.modules[package], name, value)
        return value

    return keep
