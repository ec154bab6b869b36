"""Arrays of numbers in MATLAB files from unknown sources.

SciPy 1.17's ``loadmat`` is not used here because a damaged file can end Python with a segmentation fault.
"""

from __future__ import annotations

import itertools
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from nao_course.datasets.files import brief, contents
from nao_course.geometry import FloatArray

# MAT-File Format (MathWorks), chapter 1: "Level 5 MAT-File Format".
HEADER = 128  # bytes
BYTE_ORDER = {b"IM": "<", b"MI": ">"}  # by the header's last two bytes
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
MATRIX, COMPRESSED = 14, 15  # types of elements
NUMBERS = range(6, 16)  # classes of arrays of numbers
COMPLEX = 0x800


def matlab_arrays(path: Path, largest: int, names: tuple[str, ...]) -> dict[str, FloatArray]:
    """Return arrays of a MATLAB file of version 5 to 7, without dimensions of length 1, in the order of `names`.

    Raise ValueError if the file is malformed, larger than `largest` bytes before or after it is decompressed, or if it
    lacks a name.
    """
    data = contents(path, largest)
    found = dict[str, FloatArray]()
    try:
        order = BYTE_ORDER[data[HEADER - 2 : HEADER]]
        for part in _matrices(data[HEADER:], order, largest):
            found |= _array(part, order, names)
    except (ValueError, KeyError, struct.error, zlib.error) as error:
        raise ValueError(
            f"{path}: cannot be read as a MATLAB file of version 5 to 7 ({brief(str(error))})"
        ) from None
    if missing := [name for name in names if name not in found]:
        raise ValueError(f"{path}: expected the variables {', '.join(names)}, but {missing[0]} is missing")
    return {name: found[name] for name in names}


def _matrices(data: bytes, order: str, largest: int) -> Iterator[bytes]:
    """Yield the content of each variable, decompressed."""
    for kind, part in _elements(data, order):
        if kind == COMPRESSED:
            plain = zlib.decompressobj().decompress(part, largest + 1)
            largest -= len(plain)
            if largest < 0:
                raise ValueError("it is too large after it has been decompressed")
            yield from (inner for kind, inner in _elements(plain, order) if kind == MATRIX)
        elif kind == MATRIX:
            yield part


def _elements(data: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Yield the type and the bytes of each element."""
    place = 0
    while place < len(data):
        kind, size = struct.unpack_from(f"{order}II", data, place)
        if kind >> 16:  # up to 4 bytes, beside their type
            kind, size, begin, end = kind & 0xFFFF, kind >> 16, place + 4, place + 8
        else:
            begin = place + 8
            end = begin + size + (0 if kind == COMPRESSED else -size % 8)
        if begin + size > len(data):
            raise ValueError("it ends too early")
        yield kind, data[begin : begin + size]
        place = end


def _array(part: bytes, order: str, names: tuple[str, ...]) -> dict[str, FloatArray]:
    """Return a variable by its name if it is one of the names."""
    (_, flags), (_, shape), (_, word), *rest = itertools.islice(_elements(part, order), 4)
    name = word.decode("latin-1")
    if name not in names:
        return {}
    flag = struct.unpack_from(f"{order}I", flags)[0]
    if flag & 0xFF not in NUMBERS or flag & COMPLEX or not rest:
        raise ValueError(f"{name} is not an array of real numbers")
    kind, values = rest[0]
    array = np.frombuffer(values, f"{order}{TYPES[kind]}").astype(float)
    return {name: array.reshape(np.frombuffer(shape, f"{order}i4"), order="F").squeeze()}
