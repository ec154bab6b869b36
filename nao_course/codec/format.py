"""The format of frames, shared by reading and writing: prefix, limits, and permitted numbers, texts and keys."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

MAGIC = b"NAO1"
PREFIX = struct.Struct("<4sQQ")  # magic number, length of the header, length of the buffers
PREFIX_SIZE = PREFIX.size
DTYPES = {
    np.dtype(name).str: np.dtype(name)
    for name in ("?", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f2", "f4", "f8", "c8", "c16")
}
GENERATOR = "PCG64"  # NumPy's default random generator, whose state contains only plain integers
_MOST_ALIKE = 20  # dict keys with the same hash: they can be constructed, and n of them take n^2 steps
_MOST_BITS = 512  # of an integer; the state of a random generator needs 128


class CodecError(ValueError):
    """Raised for a value that cannot be encoded, and for bytes that are not a valid frame."""


@dataclass(frozen=True)
class Limits:
    """Limits for the size of a frame.

    Parameters
    ----------
    size : int
        Largest size of all buffers, bytes.
    header : int
        Largest size of the header, bytes. To parse JSON takes up to 30 times its length in memory.
    nodes : int
        Largest number of values, including the items of lists.
    depth : int
        Largest depth of nested lists.
    """

    size: int = 256 * 2**20
    header: int = 8 * 2**20
    nodes: int = 200_000
    depth: int = 40


def frame_lengths(prefix: bytes | bytearray, limits: Limits | None = None) -> tuple[int, int]:
    """Return the lengths of header and buffers from the first `PREFIX_SIZE` bytes of a frame.

    Raises
    ------
    CodecError
        If the bytes are not the beginning of a frame, or if the frame is too large.
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
    """Return a text unchanged; raise a CodecError for half of a surrogate pair, which no file could store."""
    if not text.isascii() and any("\ud800" <= letter <= "\udfff" for letter in text):
        raise CodecError("a text with half a character in it")
    return text


def whole_number(number: int) -> int:
    """Return an integer unchanged; raise a CodecError if it is too large."""
    if number.bit_length() > _MOST_BITS:
        raise CodecError(f"an integer of more than {_MOST_BITS} bits")
    return number


def as_key(key: object) -> object:
    """Return a dict's key unchanged; refuse all but None, bools, numbers, texts and tuples of these (CodecError).

    NaN is refused too, because it is not equal to itself.
    """
    if type(key) is tuple:
        for each in key:
            as_key(each)
    elif not (key is None or type(key) in (bool, int, float, str)) or key != key:
        raise CodecError("a dict's keys must be texts, numbers, None, or tuples of these")
    return key


def refuse_keys_alike(keys: Iterable[object]) -> None:
    """Raise a CodecError if many keys have the same hash, because a dict of them would take very long to build."""
    if max(Counter(map(hash, keys)).values(), default=0) > _MOST_ALIKE:
        raise CodecError("a dict with keys that are made to be alike")
