"""The text of a file, in whatever alphabet it was written: UTF-8, -16 and -32, or Latin-1."""

from __future__ import annotations

import codecs
from pathlib import Path

import numpy as np

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.bounds import TEXT_TAKES, Bounds
from posflock_robotarium.logs.readers.no_logs import no_log

_MARKED = (
    (codecs.BOM_UTF32_LE, "utf-32", "UTF-32"),
    (codecs.BOM_UTF32_BE, "utf-32", "UTF-32"),
    (codecs.BOM_UTF16_LE, "utf-16", "UTF-16"),
    (codecs.BOM_UTF16_BE, "utf-16", "UTF-16"),
)
"""By the first bytes; the mark of UTF-32 begins as that of UTF-16."""


def text_of(path: Path, bounds: Bounds) -> tuple[str, tuple[str, ...]]:
    """Return the text of a file, and the alphabet that it is in where that is not UTF-8.

    Parameters
    ----------
    path : Path
        Where it lies.
    bounds : Bounds
        How much memory its reading may take.

    Raises
    ------
    LogError
        Where it is no text, or text in no alphabet that is known here.
    """
    bounds.require_size(TEXT_TAKES * path.stat().st_size, str(path))
    raw = path.read_bytes()
    try:
        for mark, codec, name in _MARKED:
            if raw.startswith(mark):
                return raw.decode(codec), (f"text in {name}",)
        if (what := no_log(raw)) is not None:
            raise LogError(f"{path}: {what}")
        for first, codec in ((0, "utf-16-le"), (1, "utf-16-be")):
            letters, rest = raw[first:400:2], raw[1 - first : 400 : 2]
            if rest and not any(rest) and 0 not in letters:
                return raw.decode(codec), ("text in UTF-16, without its mark",)
        if b"\0" in raw[:4096]:
            raise LogError(f"{path}: a binary file, not text; expected .npy, .npz, .mat or CSV")
        return raw.decode("utf-8-sig"), ()
    except UnicodeDecodeError as error:
        if error.encoding != "utf-8" or not _is_latin(raw):
            line = raw.count(b"\n", 0, error.start) + 1
            raise LogError(f"{path}: line {line}: not text in UTF-8 or UTF-16") from error
        return raw.decode("latin-1"), ("text in Latin-1, since it is not UTF-8",)


def without_zero_bytes(lines: list[str]) -> tuple[list[str], tuple[str, ...]]:
    """Blank out lines with zero bytes, which a computer leaves that lost its power as it wrote.

    Parameters
    ----------
    lines : list of str
        Of the whole file; there are as many afterwards.

    Returns
    -------
    lines : list of str
        Blank where one was damaged.
    notes : tuple of str
        How many were.
    """
    damaged = sum("\0" in line for line in lines)
    if not damaged:
        return lines, ()
    told = f"{damaged} line(s) with zero bytes, as a loss of power leaves them, are left out"
    return ["" if "\0" in line else line for line in lines], (told,)


def _is_latin(raw: bytes) -> bool:
    """Whether bytes can be Latin-1: no control characters, and few letters beyond ASCII."""
    codes = np.frombuffer(raw, np.uint8)
    control = (codes < 32) & ~np.isin(codes, (9, 10, 12, 13))
    beyond = (codes >= 128).mean()
    return bool(not control.any() and not ((codes >= 128) & (codes < 160)).any() and beyond < 0.1)
