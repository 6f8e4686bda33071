"""A script's text, read once, and by everyone in the same way.

Python decodes a file by its byte order mark or by the comment that declares its encoding (PEP
263), UTF-8 where there is neither, and refuses what it cannot decode, parse or compile. What
Python refuses is refused here, whoever asks, with one sentence that names the line.

Positions in a syntax tree count bytes of the text in UTF-8, whatever the file's encoding is;
:meth:`Script.encoded` brings an edited text back into that.
"""

from __future__ import annotations

import ast
import codecs
import io
import tokenize
import warnings
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from rps_compat.bounded_files import read_bounded
from rps_compat.errors import ScriptError
from rps_compat.scripts.syntax import newer_than_the_testbeds, newer_than_this_python

#: Byte order marks of encodings in which Python reads no source.
_WIDE = {codecs.BOM_UTF16_LE: "UTF-16", codecs.BOM_UTF16_BE: "UTF-16"}


class UnreadableError(ScriptError):
    """A file that is not Python.

    Parameters
    ----------
    name : str
        Of the file.
    reason : str
        What is wrong with it, in words.
    line : int, optional
        Where, counted from 1.
    newer : str, optional
        What of a newer Python than this one it uses; None if it is no Python at all.
    """

    def __init__(
        self, name: str, reason: str, line: int | None = None, newer: str | None = None
    ) -> None:
        self.name, self.reason, self.line, self.newer = name, reason, line, newer
        where = f", line {line}" if line else ""
        super().__init__(f"{name}{where}: {reason}")


@dataclass(frozen=True)
class Script:
    """A Python file that Python can read.

    Attributes
    ----------
    path : Path
        Where it lies.
    data : bytes
        As it lies there.
    encoding : str
        In which it is written, as Python names it; ``utf-8-sig`` is with a byte order mark.
    text : str
        Decoded, with its own line endings.
    tree : ast.Module
        Parsed.
    """

    path: Path
    data: bytes
    encoding: str
    text: str
    tree: ast.Module

    @cached_property
    def utf8(self) -> bytes:
        """The text in UTF-8: what positions in the tree count."""
        return self.text.encode()

    def encoded(self, utf8: bytes) -> bytes:
        """Return an edited text in the file's own encoding.

        Parameters
        ----------
        utf8 : bytes
            The text in UTF-8.
        """
        return utf8.decode().encode(self.encoding)


def read_script(path: Path | str) -> Script:
    """Read a Python file.

    Parameters
    ----------
    path : Path or str
        Where the file lies.

    Raises
    ------
    ScriptError
        There is no such file, it may not be read, or it is no plain file.
    UnreadableError
        Python refuses it.
    """
    path = Path(path)
    try:
        data = read_bounded(path)
    except OSError as error:
        raise ScriptError(f"{path}: {error.strerror or error}") from error
    return parse_script(data, path)


def parse_script(data: bytes, path: Path | str = "script") -> Script:
    """Parse the bytes of a Python file.

    Parameters
    ----------
    data : bytes
        What the file holds, in its own encoding.
    path : Path or str
        Where the file lies, or would lie.

    Raises
    ------
    UnreadableError
        Python refuses them.
    """
    name = str(path)
    encoding, text = _decoded(data, name)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # such as invalid escapes: the script's own affair
            tree = ast.parse(data, name)
            compile(tree, name, "exec", dont_inherit=True)
    except SyntaxError as error:
        newer = newer_than_this_python(error)
        reason = (
            f"not valid Python: {error.msg}" if newer is None else newer_than_the_testbeds(newer)
        )
        raise UnreadableError(name, reason, error.lineno, newer) from error
    except (RecursionError, MemoryError) as error:
        raise UnreadableError(name, "not valid Python: nested too deeply") from error
    return Script(Path(path), data, encoding, text, tree)


def _decoded(data: bytes, name: str) -> tuple[str, str]:
    """Return a source's encoding and its text, or say why Python cannot decode it."""
    for mark, encoding in _WIDE.items():
        if data.startswith(mark):
            raise UnreadableError(name, f"not valid Python: {encoding} text; save it as UTF-8")
    if b"\0" in data:
        line = data.count(b"\n", 0, data.index(b"\0")) + 1
        raise UnreadableError(name, "not valid Python: a null byte; save it as plain text", line)
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(data).readline)
    except SyntaxError as error:  # an encoding that there is not, or two that contradict
        if not error.msg.startswith("invalid or missing"):
            reason = f"not valid Python: {error.msg}".replace(f" for {name!r}", "")
            raise UnreadableError(name, reason) from error
        encoding = "utf-8"  # which the first lines are not
    try:
        return encoding, data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        reason = f"not valid Python: byte 0x{data[error.start]:02x} is not {encoding} text"
        advice = "save it as UTF-8, or declare its encoding in the first line"
        raise UnreadableError(name, f"{reason}; {advice}", line) from error
