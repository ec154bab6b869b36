"""What travels by its name: dataclasses and named tuples of this package, and functions that a table names."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from types import BuiltinFunctionType, FunctionType
from typing import Any, TypeVar

import numpy as np

from nao_course.exercises.codec.format import CodecError

T = TypeVar("T", bound=Callable[..., Any])
_FUNCTION_TYPES = (FunctionType, BuiltinFunctionType, np.ufunc)


@dataclass(frozen=True)
class Registered:
    """A class whose values travel.

    Parameters
    ----------
    cls : type
        The class.
    fields : tuple of str
        What its values are made of, as it was when the class was registered.
    """

    cls: type
    fields: tuple[str, ...]


_TYPES: dict[str, Registered] = {}
_FUNCTIONS: dict[str, Callable[..., Any]] = {}
_NAMES: dict[
    int, str
] = {}  # of those functions, by id: asking a stranger's object for its hash runs its code


def register(thing: T) -> T:
    """Let values of a dataclass or named tuple travel, or a function of a module; use as a decorator.

    A value of such a class is built from what a stranger's frame says: let its `__post_init__` refuse what makes no
    sense. Of a function nothing but its name travels.

    Raises
    ------
    TypeError
        If it is none of these, or another one of its name is registered.
    """
    if isinstance(thing, FunctionType):
        if "<" in thing.__qualname__:
            raise TypeError(f"only functions of a module can be registered, got {thing.__qualname__}")
        register_function(name_of(thing), thing)
        return thing
    names = _fields(thing)
    if names is None:
        kind = getattr(thing, "__name__", type(thing).__name__)
        raise TypeError(f"only dataclasses, named tuples and functions can be registered, got {kind}")
    if _TYPES.setdefault(name_of(thing), Registered(thing, names)).cls is not thing:  # type: ignore[arg-type]
        raise TypeError(f"a class named {name_of(thing)} is registered already")
    return thing


def register_function(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """Let a function travel by a name, also one of another package.

    Parameters
    ----------
    name : str
        "nao_course.lessons.my_lesson.tables:hypot": before the colon stands the module that registers it: it can
        be imported where the name arrives.
    function : callable
        Such as np.hypot.

    Raises
    ------
    TypeError
        If it is no plain function, or another one of that name is registered.
    """
    if not isinstance(function, _FUNCTION_TYPES):
        raise TypeError(f"only functions can be registered, got {type(function).__name__}")
    if _FUNCTIONS.setdefault(name, function) is not function:
        raise TypeError(f"a function named {name} is registered already")
    _NAMES.setdefault(id(function), name)
    return function


def name_of(thing: Any) -> str:
    """Name of a class or function in a frame: its module and its own."""
    return f"{thing.__module__}:{thing.__qualname__}"


def fields_of(cls: type) -> tuple[str, ...] | None:
    """What values of a class are made of; None where it is not registered."""
    found = _TYPES.get(name_of(cls))
    return found.fields if found is not None and found.cls is cls else None


def name_of_function(function: object) -> str | None:
    """The name that a function travels by; None where it is not registered."""
    return _NAMES.get(id(function)) if type(function) in _FUNCTION_TYPES else None


def find_type(name: str, *, trusted: bool) -> Registered:
    """Return a registered class.

    Parameters
    ----------
    name : str
        Its module and name.
    trusted : bool
        Whether its module, if one of this package, may be imported for it.

    Raises
    ------
    CodecError
        If none of that name is registered.
    """
    return _found(_TYPES, name, "a value of an unknown type", trusted)


def find_function(name: str, *, trusted: bool) -> Callable[..., Any]:
    """Return a registered function; parameters and errors as in `find_type`."""
    return _found(_FUNCTIONS, name, "a function that is not registered:", trusted)


def _found(table: dict[str, Any], name: str, unknown: str, trusted: bool) -> Any:
    if trusted and name not in table and name.startswith("nao_course."):
        importlib.import_module(name.split(":")[0])
    if name not in table:
        raise CodecError(f"{unknown} {name[:80]!r}")
    return table[name]


def _fields(thing: object) -> tuple[str, ...] | None:
    if not isinstance(thing, type):
        return None
    if is_dataclass(thing):
        return tuple(each.name for each in fields(thing))
    names = getattr(thing, "_fields", None)
    return tuple(names) if issubclass(thing, tuple) and names is not None else None
