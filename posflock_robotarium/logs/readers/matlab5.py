"""Variables of MATLAB 5 files, every length checked before it is believed.

scipy's reader looks element types up in a table without a bound, and a file with one wrong byte
can end the whole process; a report must survive any file. The part of the format that holds
numbers is small: a header of 128 bytes, then elements, each a type, a length and that many bytes
(MathWorks, *MAT-File Format*, chapter 1). An array is an element made of others: flags,
dimensions, name, values. A cell has arrays in the place of values, a structure the names of its
fields and then arrays.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.bounds import BOUNDS, Bounds
from posflock_robotarium.logs.readers.matlab_trees import Opaque, Tree

Floats = NDArray[np.float64]

HEADER = 128
MATRIX, COMPRESSED = 14, 15
_TYPES = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
_CELL, _STRUCT, _OBJECT, _OPAQUE = 1, 2, 3, 17
_NUMERIC_CLASSES = range(6, 16)  # double, single and the integers; not text, sparse, functions
_COMPLEX = 0x800
_DEEPEST = 16
"""Cells in structures in cells: more than that nobody writes."""


def read_matlab5(path: Path, bounds: Bounds = BOUNDS) -> dict[str, Tree]:
    """Return the variables of a file by name: real numeric arrays, and what is made of them.

    Parameters
    ----------
    path : Path
        A file ``.mat`` of version 5.
    bounds : Bounds
        To how much its elements may unpack.

    Returns
    -------
    dict of trees
        Arrays of floats, axes in MATLAB's order; structures and cells of them.

    Raises
    ------
    LogError
        Where the file is damaged.
    """
    bounds.require_size(path.stat().st_size, str(path))
    content = path.read_bytes()
    if len(content) < HEADER:
        raise LogError(f"{path}: cut off within its header, {len(content)} bytes")
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if order is None:
        raise LogError(f"{path}: not a MATLAB 5 file: its mark of byte order is damaged")
    arrays: dict[str, Tree] = {}
    left = bounds.bytes
    for kind, data in _elements(content[HEADER:], order, str(path)):
        if kind == COMPRESSED:
            unpacked = _unpacked(data, left, bounds, str(path))
            left -= len(unpacked)
            for inner, matrix in _elements(unpacked, order, str(path)):
                if inner == MATRIX:
                    arrays |= _array(matrix, order, str(path))
        elif kind == MATRIX:
            arrays |= _array(data, order, str(path))
    return arrays


def _elements(content: bytes, order: str, where: str) -> Iterator[tuple[int, bytes]]:
    """Yield the type and the data of each element."""
    at = 0
    while at + 8 <= len(content):
        first, length = np.frombuffer(content, f"{order}u4", 2, at).tolist()
        if first >> 16:  # a small element keeps its data, four bytes at most, within its tag
            kind, length, begin, after = first & 0xFFFF, first >> 16, at + 4, at + 8
            if length > 4:
                raise LogError(f"{where}: damaged at byte {at}: small element of {length} bytes")
        else:
            kind, begin = first, at + 8
            # Elements begin at multiples of eight bytes, except after compressed ones.
            after = begin + (length if kind == COMPRESSED else -(-length // 8) * 8)
        if begin + length > len(content):
            raise LogError(
                f"{where}: cut off: an element of {length} bytes where "
                f"{max(0, len(content) - begin)} are left"
            )
        yield kind, content[begin : begin + length]
        at = after


def _array(content: bytes, order: str, where: str) -> dict[str, Tree]:
    """Return a variable under its name; nothing for text and the like."""
    label, tree = _tree(content, order, where, 0)
    return {} if tree is None else {label: tree}


def _tree(content: bytes, order: str, where: str, depth: int) -> tuple[str, Tree | None]:
    """Return the name and the content of an array; None for text, functions and complex numbers."""
    parts = list(islice(_elements(content, order, where), 3))
    if len(parts) < 3:  # an empty array of another kind
        return "", None
    (_, flags), (_, dimensions), (_, name) = parts
    if len(flags) != 8:
        raise LogError(f"{where}: damaged flags of an array")
    flag = int(np.frombuffer(flags, f"{order}u4")[0])
    kind = flag & 0xFF
    if kind == _OPAQUE:  # it has no dimensions: its name comes in their place
        return dimensions.decode("latin-1").rstrip("\0"), Opaque()
    label = name.decode("latin-1").rstrip("\0")
    if kind == _OBJECT:
        return label, Opaque()
    if depth > _DEEPEST:
        raise LogError(f"{where}: {label}: nested deeper than {_DEEPEST}")
    rest = islice(_elements(content, order, where), 3, None)
    if kind == _CELL:
        return label, [_tree(data, order, where, depth + 1)[1] for _, data in rest]
    if kind == _STRUCT:
        return label, _struct(list(rest), order, f"{where}: {label}", depth)
    if kind not in _NUMERIC_CLASSES or flag & _COMPLEX:
        return label, None
    values = next(rest, None)
    if values is None:
        return label, None
    return label, _numbers(dimensions, values, order, f"{where}: {label}")


def _struct(parts: list[tuple[int, bytes]], order: str, where: str, depth: int) -> Tree:
    """Return a structure as its fields, or an array of structures as a list of them."""
    if len(parts) < 2 or len(parts[0][1]) != 4:
        raise LogError(f"{where}: damaged structure")
    length = int(np.frombuffer(parts[0][1], f"{order}i4")[0])
    letters = parts[1][1]
    if length < 1 or len(letters) % length:
        raise LogError(f"{where}: damaged names of fields")
    fields = [
        letters[k : k + length].split(b"\0")[0].decode("latin-1")
        for k in range(0, len(letters), length)
    ]
    values = parts[2:]
    if not fields or len(values) % len(fields):
        raise LogError(f"{where}: {len(values)} values for {len(fields)} fields")
    trees = [_tree(data, order, where, depth + 1)[1] for _, data in values]
    structs: list[Tree | None] = [
        dict(zip(fields, trees[k : k + len(fields)], strict=True))
        for k in range(0, len(trees), len(fields))
    ]
    return structs[0] if len(structs) == 1 and structs[0] is not None else structs


def _numbers(dimensions: bytes, element: tuple[int, bytes], order: str, where: str) -> Floats:
    kind, values = element
    if kind not in _TYPES:
        raise LogError(f"{where}: values of unknown type {kind}")
    if len(dimensions) % 4 or not dimensions or len(dimensions) > 4 * 32:
        raise LogError(f"{where}: damaged dimensions")
    shape = np.frombuffer(dimensions, f"{order}i4").tolist()
    numbers = np.dtype(f"{order}{_TYPES[kind]}")
    if min(shape) < 0 or math.prod(shape) * numbers.itemsize != len(values):
        raise LogError(f"{where}: {len(values)} bytes for an array of shape {shape}")
    with np.errstate(all="ignore"):
        flat: Floats = np.frombuffer(values, numbers).astype(np.float64)
    return np.asarray(flat.reshape(shape, order="F"))


def _unpacked(data: bytes, most: int, bounds: Bounds, where: str) -> bytes:
    """Decompress one element, to no more than `most` bytes."""
    machine = zlib.decompressobj()
    try:
        unpacked = machine.decompress(data, max(most, 1))  # 0 would be no bound
    except zlib.error as error:
        raise LogError(f"{where}: damaged compressed element ({error})") from error
    if machine.unconsumed_tail:
        bounds.require_size(bounds.bytes + 1, f"{where}: unpacked")
    if not machine.eof:
        raise LogError(f"{where}: a compressed element is cut off")
    return unpacked
