"""Whether a data file that a script wrote can be read back, as its reader would read it."""

from __future__ import annotations

import hashlib
import json
import math
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
from numpy.lib import format as npy

#: Bytes, and rows of a log, that are read at a time.
_BLOCK, _ROWS = 1 << 20, 1 << 16
#: Bytes of a file, or of its arrays in memory, that are loaded as a whole.
_MOST_LOADED = 64 << 20
#: Bytes of an archive, unpacked, that are read at all.
_MOST_UNPACKED = 1 << 30


@dataclass(frozen=True)
class Readable:
    """Whether a data file can be read back, and how much is in it.

    Attributes
    ----------
    size : int
        Of the file, in bytes.
    readable : bool
        Whether its reader opens it; a pose log, a text or what is read as bytes must not be empty.
    values : int
        How much is in it: elements of arrays, rows reached of a pose log, lines of text, or bytes
        of anything else; 0 where its reader fails.
    digest : str
        SHA-256 of its bytes, in hexadecimal; empty where its reader fails.
    """

    size: int
    readable: bool
    values: int
    digest: str = ""


def read_back(path: Path) -> Readable:
    """Open a data file as its reader would, and count what is in it.

    Whatever the file holds, it takes little memory: what its reader would have to load as a whole,
    and is too large for that, is read as bytes.

    Parameters
    ----------
    path : Path
        A file that a script has written; its ending tells what reads it.
    """
    size = path.stat().st_size
    try:
        with path.open("rb") as file:
            digest = _digest(file)
        readable, values = _CONTENT.get(path.suffix.lower(), _bytes)(path)
        return Readable(size, readable, values, digest)
    except Exception:
        return Readable(size, False, 0)


def _digest(file: IO[bytes]) -> str:
    digest = hashlib.sha256()
    while block := file.read(_BLOCK):
        digest.update(block)
    return digest.hexdigest()


def _npy(path: Path) -> tuple[bool, int]:
    rows = np.load(path, mmap_mode="r", allow_pickle=False)
    if rows.dtype.names and "t" in rows.dtype.names:  # a pose log: rows not reached are NaN
        times = rows["t"].reshape(-1)
        reached = sum(
            int(np.sum(~np.isnan(times[first : first + _ROWS])))
            for first in range(0, len(times), _ROWS)
        )
        return reached > 0, reached
    return True, rows.size


def _npz(path: Path) -> tuple[bool, int]:
    """Read every array's header, and the rest for its length and its checksum."""
    values, left = 0, _MOST_UNPACKED
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            with archive.open(name) as member:
                shape, width = _header(member)
                count = math.prod(shape)
                length = 0
                while length <= left and (block := member.read(_BLOCK)):
                    length += len(block)
                left -= length
            if left >= 0 and width and length != count * width:
                raise ValueError(f"{name}: expected {count} values, got {length / width:g}")
            values += count
    return True, values


def _header(member: IO[bytes]) -> tuple[tuple[int, ...], int]:
    """Return shape of an array, and the bytes of one value, from its file's first bytes."""
    major, _ = npy.read_magic(member)
    if major == 1:
        shape, _, kind = npy.read_array_header_1_0(member)
    else:
        shape, _, kind = npy.read_array_header_2_0(member)
    if kind.hasobject:
        raise ValueError("objects, which nobody but Python reads")
    return shape, kind.itemsize


def _mat(path: Path) -> tuple[bool, int]:
    from scipy.io import loadmat, whosmat

    if path.stat().st_size > _MOST_LOADED or _unpacked(whosmat(path)) > _MOST_LOADED:
        return _bytes(path)
    return True, sum(np.size(value) for value in loadmat(path).values())


def _unpacked(arrays: Sequence[tuple[str, tuple[int, ...], str]]) -> int:
    """Return the bytes that the arrays of a file may take in memory."""
    return sum(16 * math.prod(shape) for _, shape, _ in arrays)


def _json(path: Path) -> tuple[bool, int]:
    if path.stat().st_size <= _MOST_LOADED // 8:  # objects take several times their text
        json.loads(path.read_text())
    return True, path.stat().st_size


def _text(path: Path) -> tuple[bool, int]:
    lines, any_words, last = 0, False, "\n"
    with path.open() as file:
        while block := file.read(_BLOCK):
            lines += block.count("\n")
            any_words = any_words or bool(block.strip())
            last = block[-1]
    return any_words, lines + (last != "\n")


def _bytes(path: Path) -> tuple[bool, int]:
    size = path.stat().st_size
    return size > 0, size


#: By the ending of a data file: whether it can be read, and how many values it holds.
_CONTENT = {".npy": _npy, ".npz": _npz, ".mat": _mat, ".json": _json} | dict.fromkeys(
    (".txt", ".csv", ".dat", ".log"), _text
)
