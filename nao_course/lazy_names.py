"""A package whose names are imported when they are asked for: what a check needs of a lesson loads no panel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

__all__ = ["import_when_asked"]


def import_when_asked(package: str, names: Mapping[str, Sequence[str]]) -> Callable[[str], Any]:
    """Return what serves a package as its ``__getattr__``.

    Parameters
    ----------
    package : str
        Its ``__name__``.
    names : mapping of str to sequence of str
        The public names of each of its modules.

    Returns
    -------
    callable
        It imports the module of a name and returns the name's value; AttributeError for a name that no module has.
    """
    module_of = {name: module for module, each in names.items() for name in each}

    def look_up(name: str) -> Any:
        if name not in module_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{module_of[name]}"), name)

    return look_up
