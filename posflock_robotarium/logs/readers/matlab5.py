"""Numeric arrays of MATLAB 5 files, every length checked before it is believed.

scipy's reader looks element types up in a table without a bound, and a file with one wrong byte
can end the whole process; a report must survive any file. The part of the format that holds
numeric arrays is small: a header of 128 bytes, then elements, each a type, a length and that many
bytes (MathWorks, *MAT-File Format*, chapter 1). An array is an element made of others: flags,
dimensions, name, values.
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
_NUMERIC_CLASSES = range(6, 16)  # double, single and the integers; not cell, struct, text, sparse
_COMPLEX = 0x800


def read_matlab5(path: Path, bounds: Bounds = BOUNDS) -> dict[str, Floats]:
    """Return the real numeric arrays of a file by name.

    Parameters
    ----------
    path : Path
        A file ``.mat`` of version 5.
    bounds : Bounds
        To how much its elements may unpack.

    Returns
    -------
    dict of (...) arrays
        Arrays of floats, axes in MATLAB's order.

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
    arrays: dict[str, Floats] = {}
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


def _array(content: bytes, order: str, where: str) -> dict[str, Floats]:
    """Return a real numeric array under its name; nothing for cells, text and the like."""
    parts = list(islice(_elements(content, order, where), 4))
    if len(parts) < 4:  # an empty array of another kind
        return {}
    (_, flags), (_, dimensions), (_, name), (kind, values) = parts
    if len(flags) != 8:
        raise LogError(f"{where}: damaged flags of an array")
    flag = int(np.frombuffer(flags, f"{order}u4")[0])
    if flag & 0xFF not in _NUMERIC_CLASSES or flag & _COMPLEX:
        return {}
    label = name.decode("latin-1").rstrip("\0")
    if kind not in _TYPES:
        raise LogError(f"{where}: {label}: values of unknown type {kind}")
    if len(dimensions) % 4 or not dimensions or len(dimensions) > 4 * 32:
        raise LogError(f"{where}: {label}: damaged dimensions")
    shape = np.frombuffer(dimensions, f"{order}i4").tolist()
    numbers = np.dtype(f"{order}{_TYPES[kind]}")
    if min(shape) < 0 or math.prod(shape) * numbers.itemsize != len(values):
        raise LogError(f"{where}: {label}: {len(values)} bytes for an array of shape {shape}")
    with np.errstate(all="ignore"):
        flat = np.frombuffer(values, numbers).astype(np.float64)
    return {label: flat.reshape(shape, order="F")}


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
