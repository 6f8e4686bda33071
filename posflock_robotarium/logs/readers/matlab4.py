"""MATLAB 4 files: matrices one after the other, without a header.

Each is five whole numbers (type, rows, columns, whether it is complex, letters of its name), its
name and its values, column by column (MathWorks, *MAT-File Format*, appendix). There is no
signature: a file is one if its first five numbers can be these.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.bounds import BOUNDS, Bounds
from posflock_robotarium.logs.readers.matlab_trees import Tree

Floats = NDArray[np.float64]

_NUMBERS = ("f8", "f4", "i4", "i2", "u2", "u1")
_LONGEST_NAME = 64
_HEAD = 20


def is_matlab4(start: bytes) -> bool:
    """Tell whether a file begins as one of MATLAB 4.

    Parameters
    ----------
    start : bytes
        Its first 20 bytes, or more.
    """
    return _order(start) is not None


def read_matlab4(path: Path, bounds: Bounds = BOUNDS) -> dict[str, Tree]:
    """Return the real full matrices of a file by name.

    Parameters
    ----------
    path : Path
        A file ``.mat`` of version 4.
    bounds : Bounds
        How large it may be.

    Raises
    ------
    LogError
        Where the file is damaged or cut off.
    """
    bounds.require_size(path.stat().st_size, str(path))
    content = path.read_bytes()
    order = _order(content)
    if order is None:
        raise LogError(f"{path}: not a MATLAB 4 file")
    matrices: dict[str, Tree] = {}
    at = 0
    while at < len(content):
        head = np.frombuffer(content[at : at + _HEAD], f"{order}i4").tolist()
        if len(head) < 5 or not _plausible(head, order):
            raise LogError(f"{path}: damaged or cut off at byte {at}")
        kind, rows, columns, imaginary, letters = head
        numbers = np.dtype(f"{order}{_NUMBERS[kind % 100 // 10]}")
        begin = at + _HEAD + letters
        end = begin + rows * columns * numbers.itemsize
        if end > len(content):
            raise LogError(f"{path}: cut off, {len(content)} bytes of {end}")
        name = content[at + _HEAD : begin].split(b"\0")[0].decode("latin-1")
        if kind % 10 == 0 and not imaginary:  # neither text nor sparse
            flat = np.frombuffer(content[begin:end], numbers).astype(np.float64)
            matrices[name] = flat.reshape((rows, columns), order="F")
        at = end + (end - begin if imaginary else 0)
    return matrices


def _order(start: bytes) -> str | None:
    if len(start) < _HEAD:
        return None
    for order in "<>":
        if _plausible(np.frombuffer(start[:_HEAD], f"{order}i4").tolist(), order):
            return order
    return None


def _plausible(head: list[int], order: str) -> bool:
    kind, rows, columns, imaginary, letters = head
    machine, rest, number, matrix = kind // 1000, kind % 1000 // 100, kind % 100 // 10, kind % 10
    return (
        machine == (0 if order == "<" else 1)
        and rest == 0
        and number < len(_NUMBERS)
        and matrix in (0, 1, 2)
        and min(rows, columns) >= 0
        and imaginary in (0, 1)
        and 1 < letters <= _LONGEST_NAME
    )
