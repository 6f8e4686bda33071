"""What reaches a terminal: only characters that show something, and only those that it has."""

from __future__ import annotations

import contextlib
import io
import re
import select
import sys
from collections.abc import Iterator

#: What a terminal obeys instead of showing it: control characters but line end and tab, changes of
#: direction, line ends of other alphabets, and halves of characters.
_COMMANDS = re.compile(
    r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)


def printable(text: str) -> str:
    r"""Return text in which whatever would command a terminal is written out, as ``\u001b``.

    For text that is not ours: names of files, what scripts and logs say. In JSON the result means
    the same as before.

    Parameters
    ----------
    text : str
        Any text; its lines stay lines.

    Examples
    --------
    >>> printable("run \x1b[2J of Müller")
    'run \\u001b[2J of Müller'
    """
    return _COMMANDS.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


@contextlib.contextmanager
def showable_output() -> Iterator[None]:
    """Let standard output take any character within the ``with`` block.

    What the terminal's encoding lacks, as ASCII lacks ``°``, is shown escaped instead of ending
    the program in a UnicodeEncodeError.
    """
    changed = []
    for stream in (sys.stdout, sys.stderr):
        # "surrogateescape" is what Python chooses in the C locale: it fails as "strict" does.
        if isinstance(stream, io.TextIOWrapper) and stream.errors in ("strict", "surrogateescape"):
            changed.append((stream, stream.errors))
            stream.reconfigure(errors="backslashreplace")
    try:
        yield
    finally:
        for stream, errors in changed:
            with contextlib.suppress(ValueError):  # it was closed
                stream.reconfigure(errors=errors)


def reader_is_gone() -> bool:
    """Whether standard output is a pipe that nobody reads any more."""
    try:
        number = sys.stdout.fileno()
        watched = select.poll()
    except (AttributeError, OSError, ValueError):  # no file, or no such call, as on Windows
        return False
    watched.register(number, select.POLLOUT)
    return any(found & select.POLLERR for _, found in watched.poll(0))
