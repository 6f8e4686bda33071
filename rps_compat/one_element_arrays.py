"""Arrays of one element as numbers, which the testbed's numpy takes and newer ones do not."""

from __future__ import annotations

import contextlib
import ctypes
import sys
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

_CONVERSIONS = ("__float__", "__int__", "__complex__")
#: Where in a type's memory CPython keeps its flags, in words, and the one that locks the type.
_FLAGS_AT, _LOCKED = 21, 1 << 8


def takes_one_element() -> bool:
    """Whether this numpy makes a number of an array of one element, as the testbed's does."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # deprecated since numpy 1.25
        try:
            return float(np.ones(1)) == 1.0
        except TypeError:
            return False


@contextlib.contextmanager
def one_element_conversions() -> Iterator[None]:
    """Let ``float(a)``, ``math.sqrt(a)`` and ``b[k] = a`` take arrays `a` of one element.

    The testbed's numpy does; from 2.4 on numpy refuses. All of them go through the array's own
    ``__float__`` (``__int__``, ``__complex__``), and numpy's array type does not let anybody
    replace that: so its lock is lifted for as long as it takes. Where that cannot be done, nothing
    is changed, and :func:`takes_one_element` stays False.
    """
    if takes_one_element():
        yield
        return
    flags = _flags_of(np.ndarray)
    if flags is None:
        yield
        return
    before = {name: np.ndarray.__dict__[name] for name in _CONVERSIONS}
    _set(flags, {name: _of_one(name, convert) for name, convert in before.items()})
    try:
        yield
    finally:
        _set(flags, before)


def _of_one(name: str, convert: Callable[[Any], Any]) -> Callable[[Any], Any]:
    kind: Any = {"__float__": float, "__int__": int, "__complex__": complex}[name]

    def converted(array: Any) -> Any:
        return kind(array.item()) if array.ndim and array.size == 1 else convert(array)

    return converted


def _flags_of(kind: type) -> ctypes.c_ulong | None:
    """Return the memory that holds a type's flags; None where it is not where CPython has it."""
    if sys.implementation.name != "cpython":
        return None
    offset = _FLAGS_AT * ctypes.sizeof(ctypes.c_void_p)
    for known in (kind, int, type):
        if ctypes.c_ulong.from_address(id(known) + offset).value != known.__flags__:
            return None
    return ctypes.c_ulong.from_address(id(kind) + offset)


def _set(flags: ctypes.c_ulong, methods: dict[str, Any]) -> None:
    flags.value &= ~_LOCKED
    try:
        for name, method in methods.items():
            setattr(np.ndarray, name, method)
    finally:
        flags.value |= _LOCKED
