"""``.npz`` files: several NumPy arrays by name.

What an archive claims to hold is checked before it is read.
"""

from __future__ import annotations

import math
import zipfile
import zlib
from pathlib import Path
from typing import Any

from numpy.lib import format as npy
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.bounds import BOUNDS, Bounds
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.named_arrays import poses_among
from posflock_robotarium.logs.readers.numpy_arrays import read_header


def find(file: Path, options: ReadOptions) -> Found:
    """Find the poses among the arrays of an archive.

    Parameters
    ----------
    file : Path
        A file ``.npz``.
    options : ReadOptions
        Its ``array`` names the array that holds the poses, where that is not plain; ``layout`` and
        a column order say how they lie in it.

    Raises
    ------
    LogError, LayoutError
        When the file is damaged, or more than one reading fits.
    """
    return poses_among(read_npz(file, options.bounds), str(file), options, "NumPy archive")


NPZ = Form(
    name="npz",
    label="`.npz`",
    summary="the same by name, with a time or `dt`; x, y and theta apart",
    told_by=Sign.SIGNATURE,
    recognises=lambda file, start: start.startswith((b"PK\x03\x04", b"PK\x05\x06")),
    read=find,
    endings=(".npz",),
)


def read_npz(path: Path, bounds: Bounds = BOUNDS) -> dict[str, NDArray[Any]]:
    """Read every array of a ``.npz`` archive.

    Parameters
    ----------
    path : Path
        A file ``.npz``.
    bounds : Bounds
        To how much it may unpack.

    Returns
    -------
    dict of (...) arrays
        By name, of whatever types.

    Raises
    ------
    LogError
        When the archive is damaged, holds pickled objects or claims more than it can hold.
    """
    arrays: dict[str, NDArray[Any]] = {}
    try:
        with zipfile.ZipFile(path) as archive:
            members = [info for info in archive.infolist() if info.filename.endswith(".npy")]
            bounds.require_size(sum(info.file_size for info in members), f"{path}: unpacked")
            for info in members:
                name = info.filename[:-4]
                with archive.open(info) as file:
                    where = f"{path}: {name}"
                    shape, dtype = read_header(file, where)
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
