"""Output on terminals that cannot show every character."""

from __future__ import annotations

import contextlib
import io
import sys
from collections.abc import Iterator


@contextlib.contextmanager
def showable_output() -> Iterator[None]:
    """Let standard output take any character within the ``with`` block.

    What the terminal's encoding lacks, as ASCII lacks ``°``, is shown escaped instead of ending
    the program in a UnicodeEncodeError.
    """
    changed = []
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")
            changed.append(stream)
    try:
        yield
    finally:
        for stream in changed:
            with contextlib.suppress(ValueError):  # it was closed
                stream.reconfigure(errors="strict")
