"""What libraries dropped, renamed or brought: one index of all tables of names.

A name is looked up by its dotted path, ``numpy.NaN``. Three things can be the matter with it: the
testbed's version has it no more (*gone*), not yet (*newer*), or has it while newer versions, such
as the one that runs a script here, have not (*later*). The last is no fault of a script.
"""

from __future__ import annotations

import enum
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache

from rps_compat.scripts import library_names, numpy_names, python_names
from rps_compat.scripts.libraries import IMPORT_NAMES, LIBRARIES, NEWER_MODULES, PYTHON


class Kind(enum.Enum):
    """What is the matter with a name."""

    GONE = "gone"
    NEWER = "newer"
    LATER = "later"


@dataclass(frozen=True)
class Change:
    """One name that not all versions of a library have.

    Attributes
    ----------
    path : str
        Its dotted path.
    kind : Kind
        What is the matter with it on the testbed.
    code : str
        What means the same, to be written in its place: with a leading dot a name of the same
        module, with ``{}`` something of that module; "" where nothing does.
    advice : str
        What to do, in words; "" where there is nothing like it.
    since : str
        The version that brought it, for newer names.
    """

    path: str
    kind: Kind
    code: str = ""
    advice: str = ""
    since: str = ""

    @property
    def name(self) -> str:
        """Last part of the path."""
        return self.path.rpartition(".")[2]

    @property
    def library(self) -> str:
        """The library as imported, with the testbed's version: ``numpy 2.2.6``."""
        if self._version is None:
            return f"Python {PYTHON[0]}.{PYTHON[1]}"
        return f"{self._top} {self._version}"

    @property
    def _top(self) -> str:
        return self.path.partition(".")[0]

    @property
    def _version(self) -> str | None:
        """The testbed's version of the library; None for Python's own."""
        return LIBRARIES.get(IMPORT_NAMES.get(self._top, ""))

    @property
    def is_pythons_newer(self) -> bool:
        """Whether it is of a newer Python."""
        return self.kind is Kind.NEWER and self._version is None

    @property
    def what(self) -> str:
        """The matter in words."""
        shown = self.path.removeprefix("builtins.")
        if self.kind is Kind.GONE:
            return f"{shown} is gone from {self.library}"
        if self.kind is Kind.NEWER:
            return f"{shown} is newer than {self.library}"
        return f"{shown} is in {self.library}, and gone from newer versions"

    @property
    def remedy(self) -> str:
        """What to do about it, in words."""
        if self.code:
            return f"write {self.written(self.path.rpartition('.')[0])}"
        if self.kind is Kind.NEWER:
            top = self.library.partition(" ")[0]
            return f"it came with {top} {self.since}: write it the older way"
        return self.advice or "there is nothing like it"

    def written(self, module: str) -> str:
        """Return the code to be written instead.

        Parameters
        ----------
        module : str
            The module that the name is asked of, as the script calls it; may be empty.
        """
        if self.code.startswith("."):
            return f"{module}{self.code}" if module else self.code[1:]
        return self.code.replace("{}", module)


def _table(module: str, names: Mapping[str, str], kind: Kind, prefix: str = "") -> Iterator[Change]:
    for name, text in names.items():
        path = f"{module}.{name}" if module else name
        is_code = text.startswith(".") or "{}" in text or prefix == "code"
        if is_code:
            yield Change(path, kind, code=text)
        else:
            yield Change(path, kind, advice=text)


def _all() -> Iterator[Change]:
    gone, later, newer = Kind.GONE, Kind.LATER, Kind.NEWER
    yield from _table("numpy", numpy_names.GONE, gone, prefix="code")
    yield from _table("numpy", numpy_names.GONE_OTHERWISE, gone)
    yield from _table("numpy", dict.fromkeys(numpy_names.GONE_MODULES, ""), gone)
    yield from _table("numpy", numpy_names.LATER, later)
    yield from _table("", library_names.GONE_MODULES, gone)
    yield from _table("", python_names.GONE_MODULES, gone)
    for table, kind in (
        (numpy_names.GONE_ELSEWHERE, gone),
        (library_names.GONE, gone),
        (library_names.LATER, later),
        (python_names.GONE, gone),
        (python_names.LATER, later),
    ):
        for module, names in table.items():
            yield from _table(module, names, kind)
    for since_of in (numpy_names.NEWER, library_names.NEWER):
        for module, names in since_of.items():
            for name, since in names.items():
                yield Change(f"{module}.{name}", newer, since=since)
    for module, versions in python_names.NEWER.items():
        for since, listed in versions.items():
            for name in listed.split():
                yield Change(f"{module}.{name}", newer, since=since)
    for name, since in (NEWER_MODULES | python_names.NEWER_MODULES).items():
        yield Change(name, newer, since=since)


#: Every change that is written down, by dotted path.
CHANGES: dict[str, Change] = {change.path: change for change in _all()}


@cache
def change_of(path: str) -> Change | None:
    """Return what is the matter with the name at a dotted path, or None.

    ``scipy.array`` and ``numpy.lib.pad`` are not written down one by one: those modules handed on
    what is numpy's, and do not any more.

    Parameters
    ----------
    path : str
        Dotted path.
    """
    found = CHANGES.get(path)
    if found is not None:
        return found
    module, _, name = path.rpartition(".")
    kept = {"scipy": library_names.SCIPY_KEPT, "numpy.lib": numpy_names.LIB_KEPT}.get(module)
    if kept is None or name in kept or name.startswith("_") or not is_numpys(name):
        return None
    known = CHANGES.get(f"numpy.{name}")
    if known is not None and known.kind is Kind.GONE:
        return Change(path, Kind.GONE, advice=known.remedy)
    return Change(path, Kind.GONE, advice=f"write numpy.{name}")


def is_numpys(name: str) -> bool:
    """Return whether a name is, or was, one of numpy's own.

    Parameters
    ----------
    name : str
        The name, without ``numpy.``.
    """
    import numpy as np

    return name in dir(np) or f"numpy.{name}" in CHANGES
