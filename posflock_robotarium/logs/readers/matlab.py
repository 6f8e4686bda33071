"""MATLAB files: ``.mat`` of version 5, and 7.3, which is HDF5.

MATLAB stores the first axis first; version 7.3 files hold every array with its axes reversed, and
are turned back here. Only numeric arrays are read: structures, cells, objects and functions are
left out and named.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.bounds import BOUNDS, Bounds
from posflock_robotarium.logs.readers.forms import START, Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.matlab5 import read_matlab5
from posflock_robotarium.logs.readers.named_arrays import poses_among

Floats = NDArray[np.float64]


def find(file: Path, options: ReadOptions) -> Found:
    """Find the poses among the variables of a MATLAB file.

    Parameters
    ----------
    file : Path
        A file ``.mat``, of version 5 or 7.3.
    options : ReadOptions
        Its ``array`` names the variable that holds the poses, where that is not plain; ``layout``
        and a column order say how they lie in it.

    Raises
    ------
    LogError, LayoutError
        When the file is damaged, or more than one reading fits.
    """
    variables, version = read_mat(file, options.bounds)
    return poses_among(variables, str(file), options, f"{version} file")


def _is_hdf5(start: bytes) -> bool:
    """Whether a file is HDF5, behind 512 bytes of MATLAB's own or at once."""
    return b"\x89HDF\r\n\x1a\n" in (start[:8], start[512:520])


MATLAB = Form(
    name="mat",
    label="`.mat`",
    summary="versions 5 and 7.3; as `.npz`",
    told_by=Sign.SIGNATURE,
    recognises=lambda file, start: start.startswith(b"MATLAB") or _is_hdf5(start),
    read=find,
    endings=(".mat",),
)


def read_mat(path: Path, bounds: Bounds = BOUNDS) -> tuple[dict[str, Floats], str]:
    """Read every numeric variable of a MATLAB file.

    Parameters
    ----------
    path : Path
        A file ``.mat``.
    bounds : Bounds
        To how much it may unpack.

    Returns
    -------
    variables : dict of (...) arrays
        Arrays of floats, axes in MATLAB's order.
    kind : str
        ``MATLAB 5`` or ``MATLAB 7.3``.

    Raises
    ------
    LogError
        When the file is damaged or holds no numeric variable.
    """
    with path.open("rb") as file:
        start = file.read(START)
    if _is_hdf5(start):
        variables, kind = _read_hdf5(path, bounds), "MATLAB 7.3"
    else:
        variables, kind = read_matlab5(path, bounds), "MATLAB 5"
    if not variables:
        raise LogError(f"{path}: no numeric variable in it")
    return variables, kind


def _read_hdf5(path: Path, bounds: Bounds) -> dict[str, Floats]:
    import h5py

    variables: dict[str, Floats] = {}
    taken = 0
    try:
        with h5py.File(path, "r") as file:
            for name in file:
                # What lies in other files is not this file's to give.
                if isinstance(file.get(name, getlink=True), h5py.ExternalLink):
                    continue
                item = file.get(name)
                if not isinstance(item, h5py.Dataset) or item.dtype.kind not in "fiu":
                    continue
                if item.is_virtual or item.external:
                    continue
                taken += (item.size or 0) * max(item.dtype.itemsize, 8)
                bounds.require_size(taken, f"{path}: {name}: claims shape {item.shape}")
                if item.attrs.get("MATLAB_empty", 0):
                    continue
                variables[str(name)] = np.asarray(item[()], dtype=np.float64).T
    except LogError:
        raise
    except Exception as error:  # h5py passes on whatever the HDF5 library reports
        raise LogError(f"{path}: not a readable MATLAB 7.3 file ({error})") from error
    return variables
