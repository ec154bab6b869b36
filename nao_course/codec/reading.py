"""Decoding of frames, which may come from untrusted code."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course.codec import sparse
from nao_course.codec.format import (
    DTYPES,
    PREFIX_SIZE,
    CodecError,
    Limits,
    as_key,
    frame_lengths,
    refuse_keys_alike,
    whole_characters,
    whole_number,
)
from nao_course.codec.registry import find_function, find_type


def decode(frame: bytes | bytearray, limits: Limits | None = None, *, trusted: bool = False) -> Any:
    """Decode a frame.

    Parameters
    ----------
    frame : bytes
        Frame from any source.
    limits : Limits, optional
        Limits for its size.
    trusted : bool
        Whether modules of this package may be imported to find the registered types and functions of the frame.

    Returns
    -------
    object
        Value of the frame. Its arrays own their memory.

    Raises
    ------
    CodecError
        If the bytes are not a complete and valid frame.
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
    except Exception as error:  # noqa: BLE001 - a registered class may raise any error for invalid values
        raise CodecError(f"not a frame: {type(error).__name__}") from None
    if reader.at != body_length:
        raise CodecError("a frame with bytes that belong to nothing")
    return value


class _Reader:
    def __init__(self, body: memoryview, limits: Limits, trusted: bool) -> None:
        self.body, self.limits, self.trusted = body, limits, trusted
        self.at, self.count = 0, 0

    def value(self, node: Any, depth: int) -> Any:
        self.count += 1
        if self.count > self.limits.nodes or depth > self.limits.depth:
            raise CodecError("too many values, or nested too deeply")
        if node is None or type(node) is bool:
            return node
        if type(node) is int:
            return whole_number(node)
        if type(node) is not dict:
            raise CodecError("not a frame")
        read = _READERS.get(next(iter(node), ""))
        if read is None:
            raise CodecError("not a frame")
        return read(self, node, depth + 1)

    def values(self, nodes: object, depth: int) -> list[Any]:
        return [self.value(each, depth) for each in _list(nodes)]

    def take(self, length: object) -> memoryview:
        if type(length) is not int or length < 0 or self.at + length > len(self.body):
            raise CodecError("a buffer that is not there")
        self.at += length
        return self.body[self.at - length : self.at]

    def array(self, node: dict[str, Any]) -> np.ndarray[Any, Any]:
        dtype = DTYPES.get(node["a"])
        shape = _list(node["shape"])
        if dtype is None or not all(type(size) is int and size >= 0 for size in shape):
            raise CodecError("an array of an unknown kind")
        flat = np.frombuffer(self.take(node["b"]), dtype=dtype)
        if dtype.kind == "b":  # a byte of 2 would be neither True nor False
            flat = flat.view(np.uint8) != 0
        return flat.reshape(shape).copy()

    def registered(self, node: dict[str, Any], depth: int) -> Any:
        found = find_type(_string(node["o"]), trusted=self.trusted)
        return found.cls(**{key: self.value(each, depth) for key, each in node["v"].items()})

    def mapping(self, node: dict[str, Any], depth: int) -> dict[Any, Any]:
        pairs = [_pair(each) for each in _list(node["m"])]
        keys = [as_key(self.value(key, depth)) for key, _ in pairs]
        refuse_keys_alike(keys)
        values = {key: self.value(each, depth) for key, (_, each) in zip(keys, pairs, strict=True)}
        if len(values) < len(pairs):
            raise CodecError("a dict with two keys that are equal")
        return values

    def sparse(self, node: dict[str, Any]) -> Any:
        parts = [self.array(each) for each in _list(node["parts"])]
        return sparse.put_together(_string(node["q"]), _list(node["shape"]), parts)


_READERS: dict[str, Callable[[_Reader, dict[str, Any], int], Any]] = {
    "i": lambda _, node, __: whole_number(int(_string(node["i"]), 16)),
    "f": lambda _, node, __: float.fromhex(_string(node["f"])),
    "s": lambda _, node, __: _string(node["s"]),
    "b": lambda reader, node, _: bytes(reader.take(node["b"])),
    "a": lambda reader, node, _: reader.array(node),
    "n": lambda reader, node, _: _single(reader.array(node["n"])),
    "l": lambda reader, node, depth: reader.values(node["l"], depth),
    "t": lambda reader, node, depth: tuple(reader.values(node["t"], depth)),
    "d": lambda reader, node, depth: {
        _string(key): reader.value(each, depth) for key, each in node["d"].items()
    },
    "g": lambda reader, node, depth: _generator(reader.value(node["g"], depth)),
    "o": lambda reader, node, depth: reader.registered(node, depth),
    "c": lambda _, node, __: _complex(_list(node["c"])),
    "m": lambda reader, node, depth: reader.mapping(node, depth),
    "u": lambda reader, node, _: find_function(_string(node["u"]), trusted=reader.trusted),
    "q": lambda reader, node, _: reader.sparse(node),
}


def _list(value: Any) -> list[Any]:
    if type(value) is not list:
        raise CodecError("not a frame")
    return value


def _string(value: Any) -> str:
    if type(value) is not str:
        raise CodecError("not a frame")
    return whole_characters(value)


def _pair(value: Any) -> list[Any]:
    if len(_list(value)) != 2:
        raise CodecError("not a frame")
    return _list(value)


def _complex(parts: list[Any]) -> complex:
    real, imaginary = (float.fromhex(_string(each)) for each in parts)
    return complex(real, imaginary)


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
