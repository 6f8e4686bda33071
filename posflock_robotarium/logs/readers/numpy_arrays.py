"""``.npy`` files, plain or structured. Pickled objects are refused.

The header is read before any data: what it promises must be in the file, byte for byte, so that a
damaged header costs an error and not gigabytes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.bounds import BOUNDS, Bounds
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.layouts import split_time, to_states
from posflock_robotarium.logs.readers.named_arrays import floats, poses_among

Floats = NDArray[np.float64]

SIGNATURE = b"\x93NUMPY"


def find(file: Path, options: ReadOptions) -> Found:
    """Find the poses in an array: among its fields, if it has any, else by its shape.

    Parameters
    ----------
    file : Path
        A file ``.npy``.
    options : ReadOptions
        Its ``layout`` and a column order say how the poses lie in the array, where its shape leaves
        that open; ``array`` names the field that holds them.

    Raises
    ------
    LogError, LayoutError
        When the file is damaged, or more than one reading fits.
    """
    array, where = read_npy(file, options.bounds), str(file)
    if array.dtype.names is not None:
        return poses_among(fields_of(array, where), where, options, "structured NumPy array")
    return _by_shape(floats(array, where), where, options)


NPY = Form(
    name="npy",
    label="`.npy`",
    summary="(T, 3, N) in any order, (T, 3N), (3N, T), (5N, T), with a column of time or without; "
    "positions alone; structured",
    told_by=Sign.SIGNATURE,
    recognises=lambda file, start: start.startswith(SIGNATURE),
    read=find,
    endings=(".npy",),
)


def _by_shape(array: Floats, where: str, options: ReadOptions) -> Found:
    """Find the poses, and a time if there is one, in a single array without names."""
    notes = [f"NumPy array of shape {array.shape}"]
    t: Floats | None = None
    layout = options.layout
    if array.ndim == 2 and layout is None and array.size:
        t, array, along = split_time(array)
        if along is not None:
            notes.append(f"the first {along} increases throughout: taken for the time")
    samples = None if t is None else len(t)
    poses, commands, how = to_states(array, where, layout, options.order, samples=samples)
    return Found(t, poses, (*notes, how), commands)


def read_npy(path: Path, bounds: Bounds = BOUNDS) -> NDArray[Any]:
    """Read one array, memory-mapped where that is possible.

    Parameters
    ----------
    path : Path
        A file ``.npy``.
    bounds : Bounds
        How large it may be.

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
        shape, dtype = read_header(file, str(path))
        offset = file.tell()
    promised = offset + math.prod(shape) * dtype.itemsize
    there = path.stat().st_size
    if there < promised:
        row = (there - offset) // max(1, dtype.itemsize * math.prod(shape[1:]))
        raise LogError(
            f"{path}: cut off at row {row} of {shape[0] if shape else 1}: "
            f"{there} bytes of {promised}"
        )
    bounds.require_size(promised, str(path))
    try:
        return np.asarray(np.load(path, mmap_mode="r", allow_pickle=False))
    except (ValueError, OSError, EOFError, OverflowError) as error:
        raise LogError(f"{path}: not a readable NumPy file ({error})") from error


def read_header(file: IO[bytes], where: str) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return the shape and the type that the header of an array promises.

    Parameters
    ----------
    file : binary file
        Open for reading, at the first byte of the array; left at the first byte of its data.
    where : str
        File (and array) name for messages.

    Returns
    -------
    shape : tuple of int
        Lengths of the axes.
    dtype : numpy.dtype
        Of one element.

    Raises
    ------
    LogError
        When it is no header, is of a format version other than 1.0 and 2.0, or promises pickled
        objects or a negative length.
    """
    try:
        version = npy.read_magic(file)
        if version == (1, 0):
            shape, _, dtype = npy.read_array_header_1_0(file)
        elif version == (2, 0):
            shape, _, dtype = npy.read_array_header_2_0(file)
        else:
            raise LogError(f"format version {version}")
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
