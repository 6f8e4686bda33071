"""What an exception says about a script: which of its lines, which file that is not there."""

from __future__ import annotations

import os
import traceback
from pathlib import Path

from rps_compat.running.outcome import Failure

#: Characters of a message that are kept.
_MESSAGE = 500


def failure_of(error: BaseException, home: Path) -> Failure:
    """Describe an exception of a script.

    Parameters
    ----------
    error : BaseException
        What ended the script, with its traceback.
    home : Path
        Folder in which the script's files lie.
    """
    frames = [(frame.lineno, frame.filename) for frame in traceback.extract_tb(error.__traceback__)]
    if isinstance(error, SyntaxError) and error.filename:
        frames.append((error.lineno, error.filename))
    lines = [(line, file) for line, name in frames if (file := file_in(str(home), name))]
    line, file = lines[-1] if lines else (None, "")
    kind = type(error)
    return Failure(
        type=kind.__name__,
        full_type=kind.__name__
        if kind.__module__ in ("builtins", "__main__")
        else f"{kind.__module__}.{kind.__qualname__}",
        kinds=tuple(base.__name__ for base in kind.__mro__),
        message=str(error).replace(str(home) + os.sep, "")[:_MESSAGE],
        line=line,
        file=file,
        lines=tuple((number, name) for number, name in lines if number),
        missing=_missing_file(error, home),
        module=error.name if isinstance(error, ModuleNotFoundError) else None,
        number=error.errno if isinstance(error, OSError) else None,
    )


def _missing_file(error: BaseException, home: Path) -> str:
    """Return the file beside the script that an error says is not there, or nothing."""
    name = error.filename if isinstance(error, FileNotFoundError) else None
    if not isinstance(name, (str, bytes, os.PathLike)):
        return ""
    path = os.path.join(home, os.fsdecode(name))
    return os.path.basename(path) if os.path.dirname(path) == str(home) else ""


def file_in(home: str, name: str) -> str:
    """Return the bare name of the file that code comes from, if it lies in the folder `home`.

    Parameters
    ----------
    home : str
        Folder of a script, and the working directory that it began in.
    name : str
        As the code has it: a script that is called by its bare name goes by that.
    """
    path = name if name.startswith("<") else os.path.join(home, name)
    return os.path.basename(path) if path.startswith(home + os.sep) else ""
