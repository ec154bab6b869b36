"""Values as bytes and back, without pickle: what check data, workers and the grader speak.

A frame is a JSON header, which says what the value is made of, and the raw buffers of its arrays. Every length is
checked against limits before anything is allocated, so a frame from a stranger can be read.
"""

from __future__ import annotations

import importlib
import json
import struct
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

MAGIC = b"NAO1"
_PREFIX = struct.Struct("<4sQQ")  # magic, length of the header, length of the buffers
PREFIX_SIZE = _PREFIX.size
_DTYPES = {
    np.dtype(name).str: np.dtype(name)
    for name in ("?", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f2", "f4", "f8", "c8", "c16")
}
_PLAINER = {"g": np.dtype("<f8"), "G": np.dtype("<c16")}  # long doubles differ from machine to machine
_MOST_BITS = 512  # of a whole number; a random generator's state needs 128
_GENERATOR = "PCG64"
_TYPES: dict[str, type] = {}

T = TypeVar("T")


class CodecError(ValueError):
    """A value that cannot be encoded, or bytes that are no frame."""


@dataclass(frozen=True)
class Limits:
    """How much a frame may hold.

    Parameters
    ----------
    size : int
        Bytes in all.
    header : int
        Bytes of the header: reading JSON takes up to 30 times its length in memory.
    nodes : int
        Values in it, each item of a list counted.
    depth : int
        Lists in lists.
    """

    size: int = 256 * 2**20
    header: int = 8 * 2**20
    nodes: int = 200_000
    depth: int = 40


def register(cls: type[T]) -> type[T]:
    """Let values of a dataclass travel; use as a decorator.

    Raises
    ------
    TypeError
        If it is no dataclass, or another class of its name is registered.
    """
    if not is_dataclass(cls):
        raise TypeError(f"only dataclasses can be registered, got {cls.__name__}")
    if _TYPES.setdefault(_type_name(cls), cls) is not cls:
        raise TypeError(f"a class named {_type_name(cls)} is registered already")
    return cls


def _type_name(cls: type) -> str:
    return f"{cls.__module__}:{cls.__qualname__}"


def encode(value: object, limits: Limits | None = None) -> bytes:
    """Turn a value into a frame.

    Parameters
    ----------
    value : object
        Arrays of numbers, numbers, strings, bytes, lists, tuples, dicts with string keys, None, registered dataclasses,
        and random generators (their state).
    limits : Limits, optional
        How large it may become.

    Returns
    -------
    bytes
        The frame.

    Raises
    ------
    CodecError
        For a value of another kind, or too large a one.
    """
    writer = _Writer(limits or Limits())
    try:
        node = writer.node(value, 0)
    except CodecError:
        raise
    except Exception as error:  # noqa: BLE001 - properties of a stranger's class may raise what they like
        raise CodecError(f"a value that cannot be sent ({type(error).__name__})") from None
    header = json.dumps(node, separators=(",", ":")).encode()
    writer.refuse_a_header_of(len(header))
    length = sum(map(len, writer.buffers))
    return b"".join((_PREFIX.pack(MAGIC, len(header), length), header, *writer.buffers))


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
        if item is None or kind is bool:
            return item
        if kind is int:
            return self.whole(item)
        if kind is float:
            return {"f": item.hex()}
        if kind is str:
            return {"s": self.text(item)}
        if kind is bytes:
            return {"b": self.buffer(len(item), lambda: item)}
        if kind is list or kind is tuple:
            return {"l" if kind is list else "t": [self.node(each, depth + 1) for each in item]}
        if kind is dict:
            return {"d": {self.key(key): self.node(each, depth + 1) for key, each in item.items()}}
        if issubclass(kind, np.ndarray):  # `isinstance` would believe what an object says of itself
            return self.array(np.asarray(item))
        if issubclass(kind, np.generic):
            return {"n": self.array(np.asarray(item))}
        if issubclass(kind, np.random.Generator):
            return {"g": self.node(_state(item), depth + 1)}
        name = _type_name(kind)
        if _TYPES.get(name) is kind:
            values = {each.name: self.node(getattr(item, each.name), depth + 1) for each in fields(item)}
            return {"o": name, "v": values}
        raise CodecError(f"a value of type {kind.__name__} cannot be sent")

    def whole(self, item: int) -> Any:
        return item if _whole(item).bit_length() <= 53 else {"i": hex(item)}

    def text(self, item: str) -> str:
        self.spend(len(item))
        self.letters += len(item)
        self.refuse_a_header_of(self.letters)  # before JSON makes up to twelve bytes of each
        return _whole_characters(item)

    def refuse_a_header_of(self, length: int) -> None:
        if length > self.limits.header:
            raise CodecError(f"a value with more than {self.limits.header} bytes beside its arrays")

    def key(self, item: object) -> str:
        if type(item) is not str:
            raise CodecError("a dict's keys must be strings")
        return self.text(item)

    def array(self, item: np.ndarray[Any, Any]) -> Any:
        kind = _PLAINER.get(item.dtype.char) or item.dtype.newbyteorder("<")
        if kind.str not in _DTYPES:
            raise CodecError(f"an array of dtype {item.dtype} cannot be sent")
        length = self.buffer(item.size * kind.itemsize, lambda: item.astype(kind, copy=False).tobytes())
        return {"a": kind.str, "shape": list(item.shape), "b": length}

    def buffer(self, length: int, data: Callable[[], bytes]) -> int:
        self.spend(length)
        self.buffers.append(data())
        return length

    def spend(self, length: int) -> None:
        """Count bytes before they are made: one array may stand in a list a million times."""
        self.size += length
        if self.size > self.limits.size:
            raise CodecError(f"a value larger than {self.limits.size} bytes")


def _state(rng: np.random.Generator) -> dict[str, Any]:
    """A generator's state; only that of numpy's default holds nothing but plain numbers."""
    state = dict(rng.bit_generator.state)
    if state["bit_generator"] != _GENERATOR:
        raise CodecError(f"a random generator of {state['bit_generator']} cannot be sent")
    return state


def decode(frame: bytes | bytearray, limits: Limits | None = None, *, trusted: bool = False) -> Any:
    """Turn a frame back into a value.

    Parameters
    ----------
    frame : bytes
        From anyone.
    limits : Limits, optional
        How large it may be.
    trusted : bool
        Whether it may have modules of this package imported: those that register the types in it.

    Returns
    -------
    object
        The value; arrays are plain, and its own.

    Raises
    ------
    CodecError
        For anything that is not a whole frame.
    """
    limits = limits or Limits()
    header_length, body_length = frame_lengths(frame[:PREFIX_SIZE], limits)
    start = PREFIX_SIZE + header_length
    if len(frame) != start + body_length:
        raise CodecError(f"a frame of {len(frame)} bytes that says it has {start + body_length}")
    try:
        reader = _Reader(memoryview(frame)[start:], limits, trusted)
        value = reader.value(json.loads(str(frame[PREFIX_SIZE:start], "ascii")), 0)
    except CodecError:
        raise
    except Exception as error:  # noqa: BLE001 - a registered class may raise what it likes at what it is given
        raise CodecError(f"not a frame: {type(error).__name__}") from None
    if reader.at != body_length:
        raise CodecError("a frame with bytes that belong to nothing")
    return value


def frame_lengths(prefix: bytes | bytearray, limits: Limits | None = None) -> tuple[int, int]:
    """Lengths of header and buffers, from a frame's first bytes; `PREFIX_SIZE` of them.

    Raises
    ------
    CodecError
        If it is no frame's beginning, or too large.
    """
    limits = limits or Limits()
    if len(prefix) < PREFIX_SIZE:
        raise CodecError("a frame that ends in its first bytes")
    magic, header, body = _PREFIX.unpack(prefix[:PREFIX_SIZE])
    if magic != MAGIC:
        raise CodecError("not a frame")
    if header > limits.header or body > limits.size:
        raise CodecError("a frame larger than allowed")
    return header, body


class _Reader:
    def __init__(self, body: memoryview, limits: Limits, trusted: bool) -> None:
        self.body, self.limits, self.trusted, self.at, self.count = body, limits, trusted, 0, 0
        self.readers: dict[str, Callable[[dict[str, Any], int], Any]] = {
            "i": lambda node, _: _whole(int(_string(node["i"]), 16)),
            "f": lambda node, _: float.fromhex(_string(node["f"])),
            "s": lambda node, _: _string(node["s"]),
            "b": lambda node, _: bytes(self.take(node["b"])),
            "a": lambda node, _: self.array(node),
            "n": lambda node, _: _single(self.array(node["n"])),
            "l": lambda node, depth: [self.value(each, depth) for each in _list(node["l"])],
            "t": lambda node, depth: tuple(self.value(each, depth) for each in _list(node["t"])),
            "d": lambda node, depth: {
                _string(key): self.value(each, depth) for key, each in node["d"].items()
            },
            "g": lambda node, depth: _generator(self.value(node["g"], depth)),
            "o": self.registered,
        }

    def value(self, node: Any, depth: int) -> Any:
        self.count += 1
        if self.count > self.limits.nodes or depth > self.limits.depth:
            raise CodecError("too many values, or nested too deeply")
        if node is None or type(node) is bool:
            return node
        if type(node) is int:
            return _whole(node)
        if type(node) is not dict:
            raise CodecError("not a frame")
        read = self.readers.get(next(iter(node), ""))
        if read is None:
            raise CodecError("not a frame")
        return read(node, depth + 1)

    def take(self, length: object) -> memoryview:
        if type(length) is not int or length < 0 or self.at + length > len(self.body):
            raise CodecError("a buffer that is not there")
        self.at += length
        return self.body[self.at - length : self.at]

    def array(self, node: dict[str, Any]) -> np.ndarray[Any, Any]:
        dtype = _DTYPES.get(node["a"])
        shape = _list(node["shape"])
        if dtype is None or not all(type(size) is int and size >= 0 for size in shape):
            raise CodecError("an array of an unknown kind")
        flat = np.frombuffer(self.take(node["b"]), dtype=dtype)
        if dtype.kind == "b":  # a byte of 2 would be neither True nor False
            flat = flat.view(np.uint8) != 0
        return flat.reshape(shape).copy()

    def registered(self, node: dict[str, Any], depth: int) -> Any:
        name = _string(node["o"])
        if self.trusted and name not in _TYPES and name.startswith("nao_course."):
            importlib.import_module(name.split(":")[0])
        cls = _TYPES.get(name)
        if cls is None:
            raise CodecError(f"a value of an unknown type {name[:80]!r}")
        return cls(**{key: self.value(each, depth) for key, each in node["v"].items()})


def _list(value: Any) -> list[Any]:
    if type(value) is not list:
        raise CodecError("not a frame")
    return value


def _string(value: Any) -> str:
    if type(value) is not str:
        raise CodecError("not a frame")
    return _whole_characters(value)


def _whole_characters(text: str) -> str:
    """A text as it is; one with half a character could be written to no file."""
    if not text.isascii() and any("\ud800" <= letter <= "\udfff" for letter in text):
        raise CodecError("a text with half a character in it")
    return text


def _whole(number: int) -> int:
    if number.bit_length() > _MOST_BITS:
        raise CodecError(f"a whole number of more than {_MOST_BITS} bits")
    return number


def _single(array: np.ndarray[Any, Any]) -> Any:
    if array.shape != ():
        raise CodecError("not a frame")
    return array[()]


def _generator(state: Any) -> np.random.Generator:
    match state:
        case {
            "bit_generator": "PCG64",
            "state": {"state": int(), "inc": int()},
            "has_uint32": int(),
            "uinteger": int(),
        }:
            bits: Any = np.random.PCG64(0)
            bits.state = state
            return np.random.Generator(bits)
    raise CodecError("a random generator that is not numpy's default")
