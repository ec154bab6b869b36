"""Values as bytes and back, without pickle: what check data, workers and the grader speak.

A frame is a JSON header, which says what the value is made of, and the raw buffers of its arrays. Every length is
checked against limits before anything is allocated, so a frame from a stranger can be read.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

MAGIC = b"NAO1"
_PREFIX = struct.Struct("<4sQQ")  # magic, length of the header, length of the buffers
_DTYPES = {
    np.dtype(name).str: np.dtype(name)
    for name in ("?", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f4", "f8", "c8", "c16")
}
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
    nodes : int
        Values in it, each item of a list counted.
    depth : int
        Lists in lists.
    """

    size: int = 256 * 2**20
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
    if _TYPES.setdefault(cls.__name__, cls) is not cls:
        raise TypeError(f"a class named {cls.__name__} is registered already")
    return cls


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
    limits = limits or Limits()
    buffers: list[bytes] = []
    count = 0

    def buffer(data: bytes) -> int:
        buffers.append(data)
        return len(data)

    def node(item: object, depth: int) -> Any:
        nonlocal count
        count += 1
        if count > limits.nodes:
            raise CodecError(f"more than {limits.nodes} values")
        if depth > limits.depth:
            raise CodecError(f"nested deeper than {limits.depth}")
        if item is None or isinstance(item, bool):
            return item
        if type(item) is int:
            return {"i": hex(item)} if abs(item) > 2**53 else item
        if type(item) is float:
            return {"f": item.hex()}
        if type(item) is str:
            return (
                {"s": item}
                if item.isprintable() or item.isascii()
                else {"b": buffer(item.encode()), "str": 1}
            )
        if type(item) is bytes:
            return {"b": buffer(item)}
        if isinstance(item, np.ndarray):
            return array(item)
        if isinstance(item, np.generic):
            return {"n": array(np.asarray(item))}
        if type(item) in (list, tuple):
            return {"l" if type(item) is list else "t": [node(each, depth + 1) for each in item]}  # type: ignore[attr-defined]
        if type(item) is dict:
            if not all(type(key) is str for key in item):
                raise CodecError("a dict's keys must be strings")
            return {"d": {key: node(each, depth + 1) for key, each in item.items()}}
        if isinstance(item, np.random.Generator):
            state = item.bit_generator.state
            return {"g": node(_plain(state), depth + 1)}
        if _TYPES.get(type(item).__name__) is type(item):
            values = {each.name: node(getattr(item, each.name), depth + 1) for each in fields(item)}  # type: ignore[arg-type]
            return {"o": type(item).__name__, "v": values}
        raise CodecError(f"a value of type {type(item).__name__} cannot be sent")

    def array(item: np.ndarray[Any, Any]) -> Any:
        if item.nbytes > limits.size:
            raise CodecError(f"a value larger than {limits.size} bytes")
        plain = np.ascontiguousarray(item.view(np.ndarray))
        plain = plain.astype(plain.dtype.newbyteorder("<"), copy=False)
        if plain.dtype.str not in _DTYPES:
            raise CodecError(f"an array of dtype {plain.dtype} cannot be sent")
        return {"a": plain.dtype.str, "shape": list(item.shape), "b": buffer(plain.tobytes())}

    header = json.dumps(node(value, 0), separators=(",", ":"), ensure_ascii=False).encode()
    body = b"".join(buffers)
    if len(header) + len(body) > limits.size:
        raise CodecError(f"a value larger than {limits.size} bytes")
    return _PREFIX.pack(MAGIC, len(header), len(body)) + header + body


def _plain(value: Any) -> Any:
    """A bit generator's state with numpy's numbers turned into Python's."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    return value.item() if isinstance(value, np.generic) else value


def decode(frame: bytes, limits: Limits | None = None) -> Any:
    """Turn a frame back into a value.

    Parameters
    ----------
    frame : bytes
        From anyone.
    limits : Limits, optional
        How large it may be.

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
    header_length, body_length = frame_lengths(frame[: _PREFIX.size], limits)
    start = _PREFIX.size + header_length
    if len(frame) != start + body_length:
        raise CodecError(f"a frame of {len(frame)} bytes that says it has {start + body_length}")
    try:
        header = json.loads(frame[_PREFIX.size : start])
        reader = _Reader(frame[start:], limits)
        value = reader.value(header, 0)
    except CodecError:
        raise
    except (
        ValueError,
        TypeError,
        KeyError,
        AttributeError,
        OverflowError,
        RecursionError,
        MemoryError,
    ) as error:
        raise CodecError(f"not a frame: {type(error).__name__}") from None
    if reader.at != body_length:
        raise CodecError("a frame with bytes that belong to nothing")
    return value


def frame_lengths(prefix: bytes, limits: Limits | None = None) -> tuple[int, int]:
    """Lengths of header and buffers, from a frame's first bytes; `PREFIX_SIZE` of them.

    Raises
    ------
    CodecError
        If it is no frame's beginning, or too large.
    """
    limits = limits or Limits()
    if len(prefix) < _PREFIX.size:
        raise CodecError("a frame that ends in its first bytes")
    magic, header, body = _PREFIX.unpack(prefix[: _PREFIX.size])
    if magic != MAGIC:
        raise CodecError("not a frame")
    if header + body > limits.size:
        raise CodecError(f"a frame larger than {limits.size} bytes")
    return header, body


PREFIX_SIZE = _PREFIX.size


class _Reader:
    def __init__(self, body: bytes, limits: Limits) -> None:
        self.body, self.limits, self.at, self.count = body, limits, 0, 0

    def take(self, length: object) -> bytes:
        if type(length) is not int or length < 0 or self.at + length > len(self.body):
            raise CodecError("a buffer that is not there")
        self.at += length
        return self.body[self.at - length : self.at]

    def value(self, node: Any, depth: int) -> Any:
        self.count += 1
        if self.count > self.limits.nodes or depth > self.limits.depth:
            raise CodecError("too many values, or nested too deeply")
        if node is None or isinstance(node, bool | int):
            return node
        if not isinstance(node, dict):
            raise CodecError("not a frame")
        read = self._readers().get(next(iter(node), ""))
        if read is None:
            raise CodecError("not a frame")
        return read(node, depth + 1)

    def _readers(self) -> dict[str, Callable[[dict[str, Any], int], Any]]:
        return {
            "i": lambda node, _: int(node["i"], 16),
            "f": lambda node, _: float.fromhex(node["f"]),
            "s": lambda node, _: _string(node["s"]),
            "b": lambda node, _: self.take(node["b"]).decode() if "str" in node else self.take(node["b"]),
            "a": lambda node, _: self.array(node),
            "n": lambda node, _: self.array(node["n"])[()],
            "l": lambda node, depth: [self.value(each, depth) for each in _list(node["l"])],
            "t": lambda node, depth: tuple(self.value(each, depth) for each in _list(node["t"])),
            "d": lambda node, depth: {str(key): self.value(each, depth) for key, each in node["d"].items()},
            "g": lambda node, depth: _generator(self.value(node["g"], depth)),
            "o": self.registered,
        }

    def array(self, node: dict[str, Any]) -> np.ndarray[Any, Any]:
        dtype = _DTYPES.get(node["a"])
        shape = [size for size in _list(node["shape"]) if type(size) is int and size >= 0]
        if dtype is None or len(shape) != len(node["shape"]) or len(shape) > 16:
            raise CodecError("an array of an unknown kind")
        data = self.take(node["b"])
        expected = dtype.itemsize
        for size in shape:
            expected *= size
        if expected != len(data):
            raise CodecError("an array whose shape is not its length")
        return np.frombuffer(data, dtype=dtype).reshape(shape).copy()

    def registered(self, node: dict[str, Any], depth: int) -> Any:
        cls = _TYPES.get(node["o"])
        if cls is None:
            raise CodecError(f"a value of an unknown type {str(node['o'])[:40]!r}")
        return cls(**{str(key): self.value(each, depth) for key, each in node["v"].items()})


def _list(value: Any) -> list[Any]:
    if type(value) is not list:
        raise CodecError("not a frame")
    return value


def _string(value: Any) -> str:
    if type(value) is not str:
        raise CodecError("not a frame")
    return value


def _generator(state: Any) -> np.random.Generator:
    if not isinstance(state, dict) or state.get("bit_generator") != "PCG64":
        raise CodecError("a random generator that is not numpy's default")
    bits: Any = np.random.PCG64(0)
    bits.state = state
    return np.random.Generator(bits)
