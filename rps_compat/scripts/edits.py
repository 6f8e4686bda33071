"""Edits of a script that change a stretch of its text and nothing else.

A rewritten script keeps its formatting and its comments. Edits may lie within each other: the
outer one is made from a text in which the inner ones have been made already.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from rps_compat.scripts.source import Script


@dataclass(frozen=True)
class Edit:
    """One stretch of a script's text and what takes its place.

    Attributes
    ----------
    start : int
        First byte that is replaced, of the text in UTF-8.
    end : int
        First byte after it that stays.
    text : str
        What stands there instead.
    """

    start: int
    end: int
    text: str


class Text:
    """The text of a script, by the positions of its syntax nodes.

    Parameters
    ----------
    script : Script
        Whose text it is.
    """

    def __init__(self, script: Script) -> None:
        self._script = script
        self._utf8 = script.utf8
        self._starts = [0]
        for line in self._utf8.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))
        self._made: list[Edit] = []

    def start(self, node: Any) -> int:
        """Return where a node begins, in bytes.

        Parameters
        ----------
        node : ast.AST
            Anything that has a line and a column.
        """
        at: int = self._starts[node.lineno - 1] + node.col_offset
        return at

    def end(self, node: Any) -> int:
        """Return where a node ends, in bytes.

        Parameters
        ----------
        node : ast.AST
            Anything that has a last line and column.
        """
        at: int = self._starts[node.end_lineno - 1] + node.end_col_offset
        return at

    def make(self, start: int, end: int, text: str) -> Edit:
        """Make an edit, and take note of it for those around it.

        Parameters
        ----------
        start : int
            First byte that is replaced.
        end : int
            First byte after it that stays.
        text : str
            What stands there instead.
        """
        edit = Edit(start, end, text)
        if edit not in self._made:
            self._made.append(edit)
        return edit

    def replace(self, node: Any, text: str) -> Edit:
        """Replace a node.

        Parameters
        ----------
        node : ast.AST
            What is replaced, from its start to its end.
        text : str
            What stands there instead.
        """
        return self.make(self.start(node), self.end(node), text)

    def rename(self, node: ast.expr | ast.alias, name: str) -> Edit:
        """Replace the name that a name, attribute or import ends or begins with.

        Parameters
        ----------
        node : ast.expr or ast.alias
            The name, attribute or import.
        name : str
            The new name.
        """
        if isinstance(node, ast.Attribute):
            end = self.end(node)
            return self.make(end - len(node.attr.encode()), end, name)
        start = self.start(node)
        old = node.id if isinstance(node, ast.Name) else getattr(node, "name", "")
        return self.make(start, start + len(old.encode()), name)

    def of(self, node: Any) -> str:
        """Return the text of a node, with what was edited within it so far.

        Parameters
        ----------
        node : ast.AST
            Anything that has a start and an end in the text.
        """
        start, end = self.start(node), self.end(node)
        inside = [edit for edit in self._made if start <= edit.start and edit.end <= end]
        return _applied(self._utf8, inside, start, end).decode()

    def opening(self, call: ast.Call) -> int:
        """Return where the arguments of a call begin, in bytes: behind its parenthesis.

        Parameters
        ----------
        call : ast.Call
            Whose parenthesis is looked for.
        """
        return self._utf8.index(b"(", self.end(call.func)) + 1

    def line_after(self, statement: ast.stmt) -> tuple[int, str] | None:
        """Return where a line may be put behind a statement, and what indents it.

        None where the statement does not have its lines for itself.

        Parameters
        ----------
        statement : ast.stmt
            Behind which the line is to stand.
        """
        first, last = self._starts[statement.lineno - 1], statement.end_lineno or statement.lineno
        indent = self._utf8[first : self.start(statement)]
        rest = self._utf8[self.end(statement) : self._starts[last]].strip()
        if indent.strip() or (rest and not rest.startswith(b"#")):
            return None
        end = self.end(statement) + len(self._utf8[self.end(statement) :].split(b"\n")[0])
        return end - self._utf8[:end].endswith(b"\r"), indent.decode()

    @property
    def newline(self) -> str:
        """What ends a line of this script."""
        return "\r\n" if b"\r\n" in self._utf8 else "\n"


def rewritten(script: Script, edits: Iterable[Edit]) -> bytes:
    """Return a script's bytes, in its own encoding, with edits made.

    Parameters
    ----------
    script : Script
        Whose bytes they are.
    edits : iterable of Edit
        What is replaced; the same edit may come twice.
    """
    if not (made := set(edits)):
        return script.data
    return script.encoded(_applied(script.utf8, made, 0, len(script.utf8)))


def _applied(source: bytes, edits: Iterable[Edit], start: int, end: int) -> bytes:
    out, done = bytearray(), start
    # Of two that begin together the longer is the outer one, and was made from the inner.
    for edit in sorted(set(edits), key=lambda edit: (edit.start, -edit.end)):
        if edit.start < done:
            continue
        out += source[done : edit.start] + edit.text.encode()
        done = edit.end
    return bytes(out + source[done:end])
