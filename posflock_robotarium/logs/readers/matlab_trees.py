"""Structures and cells of MATLAB as plain arrays with dotted names.

``data.poses`` is the field of a structure. What scripts collect in a cell or an array of
structures, one entry a step or a robot, becomes one array: entries of the same shape are stacked
along a last axis, as MATLAB itself would with ``cat``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Opaque:
    """An object of MATLAB's, of which nobody else knows what its bytes mean."""


Tree: TypeAlias = "Floats | Opaque | Mapping[str, Tree | None] | Sequence[Tree | None]"
"""A variable: an array, an object, a structure by its fields, or a cell as its entries."""


def by_dotted_name(trees: Mapping[str, Tree | None]) -> dict[str, Floats]:
    """Return every numeric array under its dotted name.

    Parameters
    ----------
    trees : mapping of str to trees
        Variables by name.

    Returns
    -------
    dict of (...) arrays
        Entries that differ in shape, and what is not numeric, are left out.
    """
    arrays: dict[str, Floats] = {}
    for name, tree in trees.items():
        for tail, array in _arrays(tree).items():
            arrays[f"{name}.{tail}" if tail else name] = array
    return arrays


def objects_in(trees: Mapping[str, Tree | None]) -> list[str]:
    """Return the names of the variables that are objects or hold some.

    Parameters
    ----------
    trees : mapping of str to trees
        Variables by name.
    """
    return [name or "a variable" for name, tree in trees.items() if _holds_object(tree)]


def _holds_object(tree: Tree | None) -> bool:
    if isinstance(tree, Mapping):
        return any(map(_holds_object, tree.values()))
    if isinstance(tree, Sequence):
        return any(map(_holds_object, tree))
    return isinstance(tree, Opaque)


def _arrays(tree: Tree | None) -> dict[str, Floats]:
    """Return the arrays of one variable by what is to be added to its name."""
    if isinstance(tree, np.ndarray):
        return {"": tree}
    if isinstance(tree, Mapping):
        return by_dotted_name(tree)
    if isinstance(tree, Sequence):
        return _stacked([_arrays(entry) for entry in tree])
    return {}


def _stacked(entries: list[dict[str, Floats]]) -> dict[str, Floats]:
    """Stack what all entries have, in the same shape, along a last axis."""
    stacked: dict[str, Floats] = {}
    for tail in entries[0] if entries else {}:
        parts = [entry[tail] for entry in entries if tail in entry]
        if len(parts) == len(entries) and len({part.shape for part in parts}) == 1:
            # A row or a column is a list of numbers, and a scalar one number.
            line = parts[0].size == max(parts[0].shape, default=1)
            flat = [part.reshape(-1) if part.size > 1 else part.reshape(()) for part in parts]
            stacked[tail] = np.stack(flat if line and parts[0].size else parts, axis=-1)
    return stacked
