"""MATLAB 7.3 files, which are HDF5: arrays, structures as groups, cells as references.

Every array has its axes reversed, and is turned back here. What lies in other files is not this
file's to give.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.bounds import BOUNDS, Bounds
from posflock_robotarium.logs.readers.matlab_trees import Opaque, Tree

Floats = NDArray[np.float64]

_DEEPEST = 16
_MATLABS_OWN = ("#refs#", "#subsystem#")
"""Where cells keep their entries, and objects their insides."""


def read_matlab73(path: Path, bounds: Bounds = BOUNDS) -> dict[str, Tree]:
    """Return the variables of a file by name.

    Parameters
    ----------
    path : Path
        A file ``.mat`` of version 7.3, or another HDF5 file.
    bounds : Bounds
        To how much it may unpack.

    Raises
    ------
    LogError
        Where the file is damaged, or would unpack to more, or h5py is not installed.
    """
    try:
        import h5py
    except ImportError as error:
        raise LogError(f"{path}: reading MATLAB 7.3 needs h5py: pip install h5py") from error
    try:
        with h5py.File(path, "r") as file:
            return _Walk(file, bounds, str(path)).group(file, 0)
    except LogError:
        raise
    except Exception as error:  # h5py passes on whatever the HDF5 library reports
        raise LogError(f"{path}: not a readable MATLAB 7.3 file ({error})") from error


class _Walk:
    """One walk through a file, which counts the bytes that it takes."""

    def __init__(self, file: Any, bounds: Bounds, where: str) -> None:
        self._file, self._bounds, self._where = file, bounds, where
        self._taken = 0

    def group(self, group: Any, depth: int) -> dict[str, Tree]:
        """Return what a group holds, by name."""
        import h5py

        if depth > _DEEPEST:
            raise LogError(f"{self._where}: {group.name}: nested deeper than {_DEEPEST}")
        found: dict[str, Tree] = {}
        for name in group:
            if name in _MATLABS_OWN or isinstance(group.get(name, getlink=True), h5py.ExternalLink):
                continue
            tree = self._item(group.get(name), depth + 1)
            if tree is not None:
                found[str(name)] = tree
        return found

    def _item(self, item: Any, depth: int) -> Tree | None:
        import h5py

        if isinstance(item, (h5py.Group, h5py.Dataset)) and "MATLAB_object_decode" in item.attrs:
            return Opaque()
        if isinstance(item, h5py.Group):
            return self.group(item, depth)
        if not isinstance(item, h5py.Dataset) or item.is_virtual or item.external:
            return None
        if item.dtype == h5py.ref_dtype:
            return self._cell(item, depth)
        if item.dtype.kind not in "fiu" or item.attrs.get("MATLAB_class") == b"char":
            return None
        self._take(item, max(item.dtype.itemsize, 8))
        if item.attrs.get("MATLAB_empty", 0):
            return None
        array: Floats = np.asarray(item[()], dtype=np.float64).T
        return array

    def _cell(self, item: Any, depth: int) -> Tree | None:
        """Follow the references of a cell; those of an array of structures are alike."""
        if depth > _DEEPEST:
            raise LogError(f"{self._where}: {item.name}: nested deeper than {_DEEPEST}")
        self._take(item, 64)
        entries = np.asarray(item[()]).reshape(-1)
        return [self._item(self._file[entry] if entry else None, depth + 1) for entry in entries]

    def _take(self, item: Any, each: int) -> None:
        self._taken += (item.size or 0) * each
        self._bounds.require_size(
            self._taken, f"{self._where}: {item.name.lstrip('/')}: claims shape {item.shape}"
        )
