"""Whether a data file that a script wrote can be read back, as its reader would read it."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np


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

    Parameters
    ----------
    path : Path
        A file that a script has written; its ending tells what reads it.
    """
    size = path.stat().st_size
    try:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        readable, values = _CONTENT.get(path.suffix.lower(), _bytes)(path)
        return Readable(size, readable, values, digest)
    except Exception:
        return Readable(size, False, 0)


def _npy(path: Path) -> tuple[bool, int]:
    rows = np.load(path, mmap_mode="r", allow_pickle=False)
    if rows.dtype.names and "t" in rows.dtype.names:  # a pose log: rows not reached are NaN
        reached = int(np.sum(~np.isnan(rows["t"])))
        return reached > 0, reached
    return True, rows.size


def _npz(path: Path) -> tuple[bool, int]:
    # Opened here: numpy leaves the file of a torn archive open.
    with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
        return True, sum(arrays[name].size for name in arrays)


def _mat(path: Path) -> tuple[bool, int]:
    from scipy.io import loadmat

    return True, sum(np.size(value) for value in loadmat(path).values())


def _json(path: Path) -> tuple[bool, int]:
    json.loads(path.read_text())
    return True, path.stat().st_size


def _text(path: Path) -> tuple[bool, int]:
    text = path.read_text()
    return bool(text.strip()), len(text.splitlines())


def _bytes(path: Path) -> tuple[bool, int]:
    size = path.stat().st_size
    return size > 0, size


#: By the ending of a data file: whether it can be read, and how many values it holds.
_CONTENT = {".npy": _npy, ".npz": _npz, ".mat": _mat, ".json": _json} | dict.fromkeys(
    (".txt", ".csv", ".dat", ".log"), _text
)
