"""MATLAB files: ``.mat`` of versions 4 and 5, and 7.3, which is HDF5.

MATLAB stores the first axis first; version 7.3 files hold every array with its axes reversed, and
are turned back here. Structures and cells are walked, and their arrays have dotted names
(``data.poses``). Objects (tables, timeseries) can be read by MATLAB alone: the file is refused
where nothing else is in it, with the line that exports them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.bounds import BOUNDS, Bounds
from posflock_robotarium.logs.readers.forms import START, Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.matlab4 import is_matlab4, read_matlab4
from posflock_robotarium.logs.readers.matlab5 import read_matlab5
from posflock_robotarium.logs.readers.matlab73 import read_matlab73
from posflock_robotarium.logs.readers.matlab_trees import by_dotted_name, objects_in
from posflock_robotarium.logs.readers.named_arrays import poses_among

Floats = NDArray[np.float64]


def find(file: Path, options: ReadOptions) -> Found:
    """Find the poses among the variables of a MATLAB file.

    Parameters
    ----------
    file : Path
        A file ``.mat``, of version 4, 5 or 7.3.
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
    summary="versions 4, 5 and 7.3; as `.npz`; structures and cells by dotted names "
    "(`data.poses`); `robotarium_data`",
    told_by=Sign.SIGNATURE,
    recognises=lambda file, start: (
        start.startswith(b"MATLAB")
        or _is_hdf5(start)
        or (file.suffix == ".mat" and is_matlab4(start))
    ),
    read=find,
    endings=(".mat",),
)


def read_mat(path: Path, bounds: Bounds = BOUNDS) -> tuple[dict[str, Floats], str]:
    """Read every numeric array of a MATLAB file, those in structures and cells by dotted names.

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
        ``MATLAB 4``, ``MATLAB 5`` or ``MATLAB 7.3``.

    Raises
    ------
    LogError
        When the file is damaged, or holds no numeric variable or objects alone.
    """
    with path.open("rb") as file:
        start = file.read(START)
    if _is_hdf5(start):
        trees, kind = read_matlab73(path, bounds), "MATLAB 7.3"
    elif start.startswith(b"MATLAB"):
        trees, kind = read_matlab5(path, bounds), "MATLAB 5"
    else:
        trees, kind = read_matlab4(path, bounds), "MATLAB 4"
    variables = by_dotted_name(trees)
    if not variables and (objects := objects_in(trees)):
        name = objects[0]
        raise LogError(
            f"{path}: {', '.join(objects)}: MATLAB objects (a table, a timeseries or a class of "
            "your own), which MATLAB alone can read; export them there, for example "
            f"writetable({name}, 'run.csv'), or t = {name}.Time; poses = {name}.Data; "
            "save('run.mat', 't', 'poses')"
        )
    if not variables:
        raise LogError(f"{path}: no numeric variable in it")
    return variables, kind
