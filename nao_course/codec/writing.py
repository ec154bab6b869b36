"""Encoding of values. Instances of untrusted subclasses are read with the methods of the base class."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterable
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any

import numpy as np

from nao_course.codec import sparse
from nao_course.codec.format import (
    DTYPES,
    GENERATOR,
    MAGIC,
    PREFIX,
    CodecError,
    Limits,
    as_key,
    whole_characters,
    whole_number,
)
from nao_course.codec.registry import fields_of, name_of, name_of_function

# Long doubles differ from machine to machine, so 64 bits of each part are written.
_PLAINER = {"g": np.dtype("<f8"), "G": np.dtype("<c16")}
_JSON = json.JSONEncoder(separators=(",", ":"))
_PLAIN: dict[type, Callable[[Any], Any]] = {  # converts an instance of a subclass to the class itself
    str: str.__str__,
    bytes: lambda item: bytes.__getitem__(item, slice(None)),
    int: int.__index__,
    float: float.__float__,
    complex: complex.__complex__,
    list: lambda item: list(list.__iter__(item)),
    tuple: lambda item: tuple(tuple.__iter__(item)),
    dict: lambda item: dict(dict.items(item)),
}


def encode(value: object, limits: Limits | None = None) -> bytes:
    """Encode a value as a frame.

    Parameters
    ----------
    value : object
        Arrays of numbers, sparse matrices, numbers, strings, bytes, lists, tuples, dicts, None, registered dataclasses,
        named tuples and functions, and random generators (their state). An instance of a subclass is encoded as an
        instance of the class itself.
    limits : Limits, optional
        Limits for the size of the frame.

    Returns
    -------
    bytes
        Frame that `decode` reads.

    Raises
    ------
    CodecError
        If the value has another type, or is too large.
    """
    writer = _Writer(limits or Limits())
    try:
        node = writer.node(value, 0)
    except CodecError:
        raise
    except Exception as error:  # noqa: BLE001 - properties of an untrusted class may raise any error
        raise CodecError(f"a value that cannot be sent ({type(error).__name__})") from None
    header = _JSON.encode(node).encode()
    writer.refuse_a_header_of(len(header))
    length = sum(map(len, writer.buffers))
    return b"".join((PREFIX.pack(MAGIC, len(header), length), header, *writer.buffers))


class _Writer:
    def __init__(self, limits: Limits) -> None:
        self.limits, self.buffers = limits, list[bytes]()
        self.count, self.size, self.letters = 0, 0, 0

    def node(self, item: Any, depth: int) -> Any:
        self.count += 1
        if self.count > self.limits.nodes:
            raise CodecError(f"more than {self.limits.nodes} values")
        if depth > self.limits.depth:
            raise CodecError(f"nested deeper than {self.limits.depth}")
        kind = type(item)
        if (plain := _OF_PLAIN.get(kind)) is not None:
            return plain(self, item, depth)
        if issubclass(kind, np.ndarray):  # because `isinstance` would use the object's own __class__
            return self.array(np.asarray(item))
        if issubclass(kind, np.generic) and not issubclass(kind, np.character):
            return {"n": self.array(np.asarray(item))}
        if issubclass(kind, np.random.Generator):
            return {"g": self.node(_state(item), depth + 1)}
        if sparse.is_sparse(kind):
            return self.sparse(item)
        return self.named(item, kind, depth)

    def named(self, item: Any, kind: type, depth: int) -> Any:
        """Encode a registered value by its name, or an instance of a subclass as a plain value."""
        names = fields_of(kind)
        if names is not None:
            values: Iterable[Any] = (getattr(item, name) for name in names)
            if issubclass(kind, tuple):
                values = tuple.__iter__(item)
            pairs = zip(names, values, strict=True)
            return {"o": name_of(kind), "v": {name: self.node(each, depth + 1) for name, each in pairs}}
        function = name_of_function(item)
        if function is not None:
            return {"u": function}
        plain = _as_plain(item, kind)
        if plain is None:
            raise CodecError(f"a value of type {kind.__name__} cannot be sent{_why(kind)}")
        return _OF_PLAIN[type(plain)](self, plain, depth)

    def nodes(self, items: Iterable[Any], depth: int) -> list[Any]:
        return [self.node(each, depth + 1) for each in items]

    def dict(self, item: dict[Any, Any], depth: int) -> Any:
        keys = [as_key(_plain_key(key)) for key in item]
        if len(set(keys)) < len(keys):
            raise CodecError("a dict with two keys that are equal")
        if all(type(key) is str for key in keys):
            names = map(self.text, keys)  # type: ignore[arg-type]
            return {"d": dict(zip(names, self.nodes(item.values(), depth), strict=True))}
        pairs = zip(self.nodes(keys, depth), self.nodes(item.values(), depth), strict=True)
        return {"m": [list(pair) for pair in pairs]}

    def whole(self, item: int) -> Any:
        return item if whole_number(item).bit_length() <= 53 else {"i": hex(item)}

    def text(self, item: str) -> str:
        self.spend(len(item))
        self.letters += len(item)
        self.refuse_a_header_of(self.letters)  # early, because JSON makes up to twelve bytes of each letter
        return whole_characters(item)

    def refuse_a_header_of(self, length: int) -> None:
        if length > self.limits.header:
            raise CodecError(f"a value with more than {self.limits.header} bytes besides its arrays")

    def array(self, item: np.ndarray[Any, Any]) -> Any:
        kind = _PLAINER.get(item.dtype.char) or item.dtype.newbyteorder("<")
        if kind.str not in DTYPES:
            kinds = map(type, item.flat) if item.dtype == object else ()
            why = next(filter(None, map(_why, itertools.islice(kinds, self.limits.nodes))), "")
            raise CodecError(f"an array of dtype {item.dtype} cannot be sent{why}")
        length = self.buffer(item.size * kind.itemsize, lambda: item.astype(kind, copy=False).tobytes())
        return {"a": kind.str, "shape": list(item.shape), "b": length}

    def sparse(self, item: Any) -> Any:
        left = self.limits.size - self.size
        matrix = sparse.taken_apart(item, left)
        parts = [self.array(each) for each in matrix.arrays]
        return {"q": matrix.kind, "shape": list(matrix.shape), "parts": parts}

    def buffer(self, length: int, data: Callable[[], bytes]) -> int:
        self.spend(length)
        self.buffers.append(data())
        return length

    def spend(self, length: int) -> None:
        """Count bytes before they are allocated, because a list may contain the same array a million times."""
        self.size += length
        if self.size > self.limits.size:
            raise CodecError(f"a value larger than {self.limits.size} bytes")


# Made once, because this takes longer than to write a short frame.
_OF_PLAIN: dict[type, Callable[[_Writer, Any, int], Any]] = {
    type(None): lambda _, item, __: item,
    bool: lambda _, item, __: item,
    int: lambda writer, item, _: writer.whole(item),
    float: lambda _, item, __: {"f": item.hex()},
    complex: lambda _, item, __: {"c": [item.real.hex(), item.imag.hex()]},
    str: lambda writer, item, _: {"s": writer.text(item)},
    bytes: lambda writer, item, _: {"b": writer.buffer(len(item), lambda: item)},
    list: lambda writer, item, depth: {"l": writer.nodes(item, depth)},
    tuple: lambda writer, item, depth: {"t": writer.nodes(item, depth)},
    dict: lambda writer, item, depth: writer.dict(item, depth),
    np.ndarray: lambda writer, item, _: writer.array(item),
}


def _as_plain(item: Any, kind: type) -> Any:
    """Convert an instance of a subclass to its plain base class; return None if there is no such class."""
    return next((plain(item) for base, plain in _PLAIN.items() if issubclass(kind, base)), None)


def _plain_key(key: Any) -> Any:
    """Convert the key of a dict, which may be a NumPy integer, to a plain value."""
    kind = type(key)
    if key is None or kind is bool:
        return key
    if issubclass(kind, np.integer | np.bool_):
        return key.item()
    if issubclass(kind, tuple):
        return tuple(map(_plain_key, tuple.__iter__(key)))
    plain = _as_plain(key, kind)
    return key if plain is None else plain


def _why(kind: type) -> str:
    """Return a hint for functions that were not called, and for SymPy, if cos is called instead of np.cos."""
    if kind in (FunctionType, BuiltinFunctionType, MethodType, np.ufunc):
        return "; call this function with its arguments, and return its result"
    if str(kind.__module__).partition(".")[0] != "sympy":
        return ""
    return (
        "; it contains expressions of SymPy: use np.cos, np.sin, np.sqrt and np.arctan2 instead of cos, sin, sqrt "
        "and atan2; np.array(matrix, dtype=float) turns a SymPy matrix without symbols into numbers"
    )


def _state(rng: np.random.Generator) -> dict[str, Any]:
    """Return the state of a random generator, or raise an error if it is not NumPy's default generator."""
    state = dict(rng.bit_generator.state)
    if state["bit_generator"] != GENERATOR:
        raise CodecError(f"a random generator of {state['bit_generator']} cannot be sent")
    return state
