"""The skeleton of a MAT v5 file, walked before SciPy reads it: SciPy trusts the lengths and type
codes of a file and can crash the whole process on one that was mangled.

A file is 128 bytes of header, then elements: type code and length (4 bytes each; both in one word
for up to 4 bytes), data, padding to 8 bytes.          [MathWorks, MAT-File Format, "Level 5"]
"""

from __future__ import annotations

import math
import struct
import zlib

HEADER = 128
MATRIX, COMPRESSED, INT8, UINT32, INT32 = 14, 15, 1, 6, 5
SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 16: 1, 17: 2, 18: 4}
"""Bytes of a number by type code."""
CELL, STRUCT, CHAR, NUMERIC, OPAQUE = 1, 2, 4, range(6, 16), 17
COMPLEX = 0x0800
DEEPEST = 20


class BrokenError(ValueError):
    """Why the file is not a sound MAT v5 file."""


class ObjectError(ValueError):
    """A variable is an object of MATLAB's, whose layout is not published: its name and class."""

    def __init__(self, name: str, kind: str) -> None:
        super().__init__(name, kind)
        self.name, self.kind = name, kind


def walk(data: bytes) -> None:
    """Check every element of a file; BrokenError tells the first that is wrong, ObjectError one
    that nobody but MATLAB can read."""
    mark = data[126:128]
    if len(data) <= HEADER or mark not in (b"IM", b"MI"):
        raise BrokenError("no MAT v5 header")
    _elements(memoryview(data)[HEADER:], "<" if mark == b"IM" else ">", 0)


def _elements(data: memoryview, order: str, depth: int) -> None:
    at = 0
    while at < len(data):
        kind, body, at = _tag(data, at, order)
        if kind == COMPRESSED and depth == 0:
            try:
                _elements(memoryview(zlib.decompress(body)), order, 1)
            except zlib.error as error:
                raise BrokenError(f"compressed variable: {error}") from None
        elif kind == MATRIX:
            _matrix(body, order, depth + 1)
        else:
            raise BrokenError(f"type {kind} where a variable should be")


def _tag(data: memoryview, at: int, order: str) -> tuple[int, memoryview, int]:
    """Type, data and where the next element begins."""
    if at + 8 > len(data):
        raise BrokenError("cut off in a tag")
    kind, size = struct.unpack_from(order + "II", data, at)
    if kind >> 16:  # length and type share a word
        kind, size = kind & 0xFFFF, kind >> 16
        if size > 4:
            raise BrokenError("a small element is too long")
        begin, after = at + 4, at + 8
    else:
        begin = at + 8
        # compressed variables are not padded
        after = begin + size + (0 if kind == COMPRESSED else -size % 8)
    if begin + size > len(data) or (kind not in SIZES and kind not in (MATRIX, COMPRESSED)):
        raise BrokenError(f"an element of type {kind} with {size} bytes")
    if kind in SIZES and size % SIZES[kind]:
        raise BrokenError(f"{size} bytes of type {kind}")
    return kind, data[begin : begin + size], after


def _matrix(data: memoryview, order: str, depth: int) -> None:
    if depth > DEEPEST:
        raise BrokenError("nested too deeply")
    if not len(data):
        return
    kind, flags, at = _tag(data, 0, order)
    if kind != UINT32 or len(flags) != 8:
        raise BrokenError("a variable without flags")
    word = struct.unpack_from(order + "I", flags)[0]
    if word & 0xFF == OPAQUE:
        called, _, of = _texts(data, at, order)
        raise ObjectError(called, of)
    kind, shape, at = _tag(data, at, order)
    dims = struct.unpack(order + f"{len(shape) // 4}i", shape) if kind == INT32 else ()
    if len(dims) < 2 or min(dims) < 0 or len(dims) > 32:
        raise BrokenError("a variable without size")
    kind, name, at = _tag(data, at, order)
    if kind != INT8 or not bytes(name).replace(b"_", b"a").isascii():
        raise BrokenError("a variable without name")
    _content(data, at, order, depth, word, math.prod(dims))


def _texts(data: memoryview, at: int, order: str) -> list[str]:
    """Name of an object, how it is stored and its class."""
    texts = []
    for _ in range(3):
        _, body, at = _tag(data, at, order)
        texts.append(bytes(body).decode("ascii", errors="replace"))
    return texts


def _content(data: memoryview, at: int, order: str, depth: int, word: int, count: int) -> None:
    sort = word & 0xFF
    if sort in NUMERIC or sort == CHAR:
        for _ in range(2 if word & COMPLEX else 1):
            kind, body, at = _tag(data, at, order)
            numbers = len(body) // SIZES.get(kind, 1)
            if kind not in SIZES or (numbers != count and sort != CHAR):
                raise BrokenError(f"{numbers} numbers of type {kind} for {count}")
        return
    fields = 1
    if sort == STRUCT:
        kind, length, at = _tag(data, at, order)
        if kind != INT32 or len(length) != 4:
            raise BrokenError("a struct without fields")
        size = struct.unpack(order + "i", length)[0]
        kind, names, at = _tag(data, at, order)
        if kind != INT8 or size < 1 or len(names) % size:
            raise BrokenError("a struct without names of fields")
        fields = len(names) // size
    elif sort != CELL:
        raise BrokenError(f"a variable of class {sort}: save numbers, texts and structs")
    if count * fields > len(data):
        raise BrokenError(f"{count} cells do not fit")
    for _ in range(count * fields):
        kind, body, at = _tag(data, at, order)
        if kind != MATRIX:
            raise BrokenError(f"type {kind} where a cell should be")
        _matrix(body, order, depth + 1)
