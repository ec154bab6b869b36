"""Variables of MATLAB files from unknown sources.

SciPy 1.17's ``loadmat`` is not used here because a damaged file can end Python with a segmentation fault.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.datasets.files import brief, contents

# MAT-File Format (MathWorks), chapter 1: "Level 5 MAT-File Format".
HEADER = 128  # bytes
BYTE_ORDER = {b"IM": "<", b"MI": ">"}  # by the header's last two bytes
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
UTF_8, UTF_16 = {1, 2, 16}, {4, 17}  # types of characters
MATRIX, COMPRESSED = 14, 15  # types of elements
CELLS, STRUCT, TEXT, NUMBERS = 1, 2, 4, range(6, 16)  # classes of variables
COMPLEX = 0x800


def matlab_variables(path: Path, largest: int, names: tuple[str, ...]) -> dict[str, Any]:
    """Return variables of a MATLAB file of version 5 to 7 in the order of `names`.

    Real numbers are an array without dimensions of length 1, text is a str, and a struct is a dict. Several structs or
    cells are a list. Any other variable, for example complex numbers, is None.

    Raise ValueError if the file is malformed, larger than `largest` bytes before or after it is decompressed, or if it
    lacks a name.
    """
    data = contents(path, largest)
    found = dict[str, Any]()
    try:
        order = BYTE_ORDER[data[HEADER - 2 : HEADER]]
        for part in _matrices(memoryview(data)[HEADER:], order, largest):
            name = _name(part, order)
            if name in names:
                found[name] = _value(part, order)
    except (ValueError, KeyError, RecursionError, struct.error, zlib.error) as error:
        raise ValueError(
            f"{path}: cannot be read as a MATLAB file of version 5 to 7 ({brief(str(error))})"
        ) from None
    if missing := [name for name in names if name not in found]:
        raise ValueError(f"{path}: the variable {missing[0]} is missing; expected {', '.join(names)}")
    return {name: found[name] for name in names}


def _matrices(data: memoryview, order: str, largest: int) -> Iterator[memoryview]:
    """Yield the content of each variable, decompressed."""
    for kind, part in _elements(data, order):
        if kind == COMPRESSED:
            plain = zlib.decompressobj().decompress(part, largest + 1)
            largest -= len(plain)
            if largest < 0:
                raise ValueError("it is too large after it has been decompressed")
            yield from (inner for kind, inner in _elements(memoryview(plain), order) if kind == MATRIX)
        elif kind == MATRIX:
            yield part


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
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


def _name(part: memoryview, order: str) -> str:
    """Return the name of a variable."""
    _, _, (_, word), *_ = _elements(part, order)
    return bytes(word).decode("latin-1")


def _value(part: memoryview, order: str) -> Any:
    """Return the value of a variable, a cell or a field."""
    if not part:
        return np.empty(0)
    (_, flags), (_, lengths), _, *rest = _elements(part, order)
    flag = struct.unpack_from(f"{order}I", flags)[0]
    shape = np.frombuffer(lengths, f"{order}i4").tolist()
    if flag & 0xFF == STRUCT:
        return _structs(rest, order, math.prod(shape))
    if flag & 0xFF == CELLS:
        return _one_or_all([_value(each, order) for _, each in rest])
    if not rest or flag & COMPLEX:
        return None
    kind, values = rest[0]
    if flag & 0xFF in NUMBERS:
        array = np.frombuffer(values, f"{order}{TYPES[kind]}").astype(float)
        return array.reshape(shape, order="F").squeeze()
    if flag & 0xFF == TEXT and kind in UTF_8 | UTF_16:
        return str(values, "utf-8" if kind in UTF_8 else "utf-16-le" if order == "<" else "utf-16-be")
    return None


def _structs(parts: list[tuple[int, memoryview]], order: str, number: int) -> Any:
    """Return a struct as a dict, or several as a list of dicts."""
    (_, width), (_, words), *rest = parts
    step = struct.unpack_from(f"{order}i", width)[0]
    fields = [str(words[at : at + step], "latin-1").partition("\0")[0] for at in range(0, len(words), step)]
    if len(rest) != number * len(fields):
        raise ValueError(f"{number} structs of {len(fields)} fields have {len(rest)} values")
    values = iter([_value(each, order) for _, each in rest])
    rows = zip(*[values] * len(fields), strict=True)
    return _one_or_all([dict(zip(fields, row, strict=True)) for row in rows])


def _one_or_all(values: list[Any]) -> Any:
    return values[0] if len(values) == 1 else values
