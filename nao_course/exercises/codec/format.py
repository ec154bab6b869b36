"""What reading and writing a frame agree on: its first bytes, its limits, and which numbers and texts it may hold."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

MAGIC = b"NAO1"
PREFIX = struct.Struct("<4sQQ")  # magic, length of the header, length of the buffers
PREFIX_SIZE = PREFIX.size
DTYPES = {
    np.dtype(name).str: np.dtype(name)
    for name in ("?", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f2", "f4", "f8", "c8", "c16")
}
GENERATOR = "PCG64"  # numpy's default: its state holds nothing but plain numbers
_MOST_ALIKE = 20  # keys of one hash in a dict: of numbers anyone can make them, and n of them take n^2 steps
_MOST_BITS = 512  # of a whole number; a random generator's state needs 128


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
    magic, header, body = PREFIX.unpack(prefix[:PREFIX_SIZE])
    if magic != MAGIC:
        raise CodecError("not a frame")
    if header > limits.header or body > limits.size:
        raise CodecError("a frame larger than allowed")
    return header, body


def whole_characters(text: str) -> str:
    """Return a text as it is; one with half a character could be written to no file.

    Raises
    ------
    CodecError
        For such a text.
    """
    if not text.isascii() and any("\ud800" <= letter <= "\udfff" for letter in text):
        raise CodecError("a text with half a character in it")
    return text


def whole_number(number: int) -> int:
    """Return a whole number as it is.

    Raises
    ------
    CodecError
        For one that is too long.
    """
    if number.bit_length() > _MOST_BITS:
        raise CodecError(f"a whole number of more than {_MOST_BITS} bits")
    return number


def as_key(key: object) -> object:
    """Return a dict's key as it is: None, a bool, a number, a text, or a tuple of such.

    Raises
    ------
    CodecError
        For another key; NaN is none, for it is not even equal to itself.
    """
    if type(key) is tuple:
        for each in key:
            as_key(each)
    elif not (key is None or type(key) in (bool, int, float, str)) or key != key:
        raise CodecError("a dict's keys must be texts, numbers, None, or tuples of these")
    return key


def refuse_keys_alike(keys: Iterable[object]) -> None:
    """Refuse keys that a dict could hold in a long time only: thousands of one hash are no accident.

    Raises
    ------
    CodecError
        If there are too many of one hash.
    """
    if max(Counter(map(hash, keys)).values(), default=0) > _MOST_ALIKE:
        raise CodecError("a dict with keys that are made to be alike")
