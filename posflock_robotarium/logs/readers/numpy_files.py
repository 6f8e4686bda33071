"""NumPy files: ``.npy`` (plain or structured) and ``.npz``. Pickled objects are refused.

The header is read before any data: what it promises must be in the file, byte for byte, so that a
damaged header costs an error and not gigabytes.
"""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError

Floats = NDArray[np.float64]

LARGEST = 1 << 30
"""Bytes of one array beyond which a file is refused (900 s of 50 robots are 33 MB)."""

LARGEST_ARCHIVE = 1 << 28
"""Bytes to which an archive may unpack."""


def read_npy(path: Path) -> NDArray[Any]:
    """Read one array, memory-mapped where that is possible.

    Parameters
    ----------
    path : Path
        A file ``.npy``.

    Returns
    -------
    (...) array
        The array, of whatever type.

    Raises
    ------
    LogError
        When the file is cut off, holds pickled objects, or is no NumPy file.
    """
    if path.stat().st_size == 0:
        raise LogError(f"{path}: empty file")
    with path.open("rb") as file:
        shape, dtype = _header(file, str(path))
        offset = file.tell()
    promised = offset + math.prod(shape) * dtype.itemsize
    there = path.stat().st_size
    if there < promised:
        row = (there - offset) // max(1, dtype.itemsize * math.prod(shape[1:]))
        raise LogError(
            f"{path}: cut off at row {row} of {shape[0] if shape else 1}: "
            f"{there} bytes of {promised}"
        )
    if promised > LARGEST:
        raise LogError(f"{path}: {promised / 1e9:.1f} GB, larger than any run of the testbed")
    try:
        return np.asarray(np.load(path, mmap_mode="r", allow_pickle=False))
    except (ValueError, OSError, EOFError, OverflowError) as error:
        raise LogError(f"{path}: not a readable NumPy file ({error})") from error


def read_npz(path: Path) -> dict[str, NDArray[Any]]:
    """Read every array of a ``.npz`` archive.

    Parameters
    ----------
    path : Path
        A file ``.npz``.

    Returns
    -------
    dict of (...) arrays
        By name.

    Raises
    ------
    LogError
        When the archive is damaged, holds pickled objects or claims more than it can hold.
    """
    arrays: dict[str, NDArray[Any]] = {}
    try:
        with zipfile.ZipFile(path) as archive:
            members = [info for info in archive.infolist() if info.filename.endswith(".npy")]
            if sum(info.file_size for info in members) > LARGEST_ARCHIVE:
                raise LogError(f"{path}: claims more than {LARGEST_ARCHIVE >> 20} MB when unpacked")
            for info in members:
                name = info.filename[:-4]
                with archive.open(info) as file:
                    where = f"{path}: {name}"
                    shape, dtype = _header(file, where)
                    size = math.prod(shape) * dtype.itemsize
                    if size > info.file_size:
                        raise LogError(f"{where}: cut off, {info.file_size} bytes of {size}")
                with archive.open(info) as file:
                    arrays[name] = npy.read_array(file, allow_pickle=False)
    except (
        zipfile.BadZipFile,
        zlib.error,
        ValueError,
        OSError,
        EOFError,
        KeyError,
        RuntimeError,  # an encrypted member
        NotImplementedError,  # a compression that zipfile does not know
        OverflowError,
    ) as error:
        raise LogError(f"{path}: not a readable .npz archive ({error})") from error
    if not arrays:
        raise LogError(f"{path}: no array in it")
    return arrays


def _header(file: IO[bytes], where: str) -> tuple[tuple[int, ...], np.dtype[Any]]:
    try:
        version = npy.read_magic(file)
        if version == (1, 0):
            shape, _, dtype = npy.read_array_header_1_0(file)
        elif version == (2, 0):
            shape, _, dtype = npy.read_array_header_2_0(file)
        else:
            raise ValueError(f"format version {version}")
    except Exception as error:  # the header is parsed as a Python literal: anything may surface
        raise LogError(f"{where}: not a NumPy file, or a damaged header ({error})") from error
    if dtype.hasobject:
        raise LogError(f"{where}: holds pickled objects, which can run code when read: refused")
    if any(length < 0 for length in shape):
        raise LogError(f"{where}: damaged header, shape {shape}")
    return shape, dtype


def fields_of(array: NDArray[Any], where: str) -> Mapping[str, NDArray[Any]]:
    """Return the fields of a structured array as separate arrays.

    Parameters
    ----------
    array : (T,) array
        A structured array.
    where : str
        File (and variable) name for messages.

    Returns
    -------
    mapping of str to (T, ...) arrays
        By the field's name.

    Raises
    ------
    LogError
        When the array has no fields.
    """
    if array.dtype.names is None:
        raise LogError(f"{where}: expected an array with named fields, got {array.dtype}")
    return {name: array[name] for name in array.dtype.names}
