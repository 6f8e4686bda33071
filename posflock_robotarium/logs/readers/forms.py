"""Which forms of files can be read: a registry, one entry a form, one module each.

A form says how its files are recognised, and reads them. To add one, write a module with a function
that returns the poses as `Found` and with a `Form`, and give it its line in ``__init__.py`` of this
package; a module elsewhere calls `register`. docs/reference/log-forms.md shows a whole one.

Forms are asked from the surest sign to the weakest, so that an entry need not know which others
there are: what a file's content says beats its first bytes, and these beat its ending.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.run import Run

START = 520
"""Bytes of a file that its forms are told by; MATLAB 7.3 has its signature behind 512."""


class Sign(IntEnum):
    """What a form is told by; the surest sign is asked first."""

    CONTENT = 0
    """What lies within: names of fields, say. Asked of every file, so it looks at `start` first."""
    SIGNATURE = 1
    """The first bytes. A file with such a form's ending and other bytes is damaged."""
    ENDING = 2
    """The end of the file's name."""
    NOTHING = 3
    """Any file that nobody else knows."""


@dataclass(frozen=True)
class Form:
    """A form in which a file may hold a run.

    Attributes
    ----------
    name : str
        What it goes by, once in the registry.
    label : str
        How the documentation shows it: its ending, or a name.
    summary : str
        What such a file may hold, in one line, for the documentation.
    told_by : Sign
        What it is recognised by.
    recognises : function of (file, start)
        Whether a file is of this form, by its path and its first `START` bytes.
    read : function of (file, options)
        Returns the poses as found, which are then timed and checked; or a whole `Run`, where such a
        file leaves nothing to be said about it. Raises LogError where it is damaged or refused.
    endings : tuple of str
        The endings of such files, with their dots.
    """

    name: str
    label: str
    summary: str
    told_by: Sign
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path, ReadOptions], Found | Run]
    endings: tuple[str, ...] = ()


_FORMS: dict[str, Form] = {}


def register(form: Form) -> None:
    """Enter a form.

    Parameters
    ----------
    form : Form
        Asked from now on of every file, at the place that its `Form.told_by` gives it.

    Raises
    ------
    ParameterError
        Where there is one of that name.
    """
    if form.name in _FORMS:
        raise ParameterError(f"form {form.name!r} is registered already; expected another name")
    _FORMS[form.name] = form


@contextmanager
def registered(form: Form) -> Iterator[None]:
    """Have a form in the registry for a while: within a ``with`` block.

    Parameters
    ----------
    form : Form
        Entered as by `register`, and taken out when the block ends, by an error too.
    """
    register(form)
    try:
        yield
    finally:
        del _FORMS[form.name]


def known_forms() -> tuple[Form, ...]:
    """Return every form in the order in which they are asked."""
    return tuple(sorted(_FORMS.values(), key=lambda form: form.told_by))


def form_of(file: Path) -> Form:
    """Return the form of a file.

    Parameters
    ----------
    file : Path
        Told by its first `START` bytes and its ending; where a form needs it, by what lies within.

    Raises
    ------
    LogError
        Where the file is empty or cannot be opened, or its beginning is not what its ending
        promises.
    """
    start = _start(file)
    for form in known_forms():
        if form.told_by is Sign.NOTHING:
            _refuse_broken_promise(file)
        if form.recognises(file, start):
            return form
    raise LogError(f"{file}: of no known form; expected one of {', '.join(_FORMS)}")


def _start(file: Path) -> bytes:
    try:
        with file.open("rb") as stream:
            start = stream.read(START)
    except OSError as error:
        raise LogError(f"{file}: cannot be read ({error.strerror})") from error
    if not start:
        raise LogError(f"{file}: empty file")
    return start


def _refuse_broken_promise(file: Path) -> None:
    """Refuse a file whose ending is of a form with a signature that it does not have."""
    if any(file.suffix in f.endings for f in known_forms() if f.told_by is Sign.SIGNATURE):
        raise LogError(f"{file}: not a {file.suffix} file, or its beginning is damaged")
