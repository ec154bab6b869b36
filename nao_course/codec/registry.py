"""Registry of the classes and functions that are encoded by name."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from types import BuiltinFunctionType, FunctionType
from typing import Any, TypeVar

import numpy as np

from nao_course.codec.format import CodecError

T = TypeVar("T", bound=Callable[..., Any])
_FUNCTION_TYPES = (FunctionType, BuiltinFunctionType, np.ufunc)


@dataclass(frozen=True)
class Registered:
    """A class whose values can be encoded, with the names of its fields at the time of registration."""

    cls: type
    fields: tuple[str, ...]


_TYPES: dict[str, Registered] = {}
_FUNCTIONS: dict[str, Callable[..., Any]] = {}
# Names of these functions by their ids. A lookup by the object itself would run the __hash__ of untrusted objects.
_NAMES: dict[int, str] = {}


def register(thing: T) -> T:
    """Register a dataclass, a named tuple or a function for encoding; use as a decorator.

    Values of the class are constructed from the contents of frames, which may come from untrusted code. Its
    `__post_init__` must therefore refuse invalid values. Of a function, only the name is encoded.

    Raises
    ------
    TypeError
        If it is neither of these, or if its name is already registered for something else.
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
    """Register a function, also of another package, under a name by which it is encoded.

    Parameters
    ----------
    name : str
        Name such as "nao_course.lessons.my_lesson.tables:hypot". Before the colon is the module that registers the
        function, so that the reader of a frame can import it.
    function : callable
        Function such as np.hypot.

    Raises
    ------
    TypeError
        If it is not a plain function, or if the name is already registered for another function.
    """
    if not isinstance(function, _FUNCTION_TYPES):
        raise TypeError(f"only functions can be registered, got {type(function).__name__}")
    if _FUNCTIONS.setdefault(name, function) is not function:
        raise TypeError(f"a function named {name} is registered already")
    _NAMES.setdefault(id(function), name)
    return function


def name_of(thing: Any) -> str:
    """Return the name of a class or function in a frame: its module, a colon, and its qualified name."""
    return f"{thing.__module__}:{thing.__qualname__}"


def fields_of(cls: type) -> tuple[str, ...] | None:
    """Return the field names of a registered class; None if the class is not registered."""
    found = _TYPES.get(name_of(cls))
    return found.fields if found is not None and found.cls is cls else None


def name_of_function(function: object) -> str | None:
    """Return the name under which a function is registered; None if it is not registered."""
    return _NAMES.get(id(function)) if type(function) in _FUNCTION_TYPES else None


def find_type(name: str, *, trusted: bool) -> Registered:
    """Return the registered class of a name such as "module:Class", or raise a CodecError if there is none.

    If `trusted`, its module may be imported, if it belongs to this package.
    """
    return _found(_TYPES, name, "a value of an unknown type", trusted)


def find_function(name: str, *, trusted: bool) -> Callable[..., Any]:
    """Return the registered function of a name, with the parameters and errors of `find_type`."""
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
