"""Pickles, which are refused: reading one runs whatever code it holds."""

from __future__ import annotations

from pathlib import Path

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions


def refuse(file: Path, options: ReadOptions) -> Found:
    """Refuse a pickle, and say what to do instead.

    Parameters
    ----------
    file : Path
        The pickle, of which nothing is read; the message names it.
    options : ReadOptions
        Whatever they are: no option admits a pickle.

    Raises
    ------
    LogError
        Always.
    """
    raise LogError(f"{file}: a pickle, which can run code when read: refused; save an .npz")


_ENDINGS = (".pkl", ".pickle")

PICKLE = Form(
    name="pickle",
    label="`.pkl`",
    summary="refused, since reading a pickle runs code",
    told_by=Sign.SIGNATURE,
    recognises=lambda file, start: start[:1] == b"\x80" or file.suffix in _ENDINGS,
    read=refuse,
    endings=_ENDINGS,
)
