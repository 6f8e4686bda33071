"""Syntax that newer Pythons accept and the testbed's Python 3.10 does not.

The Python that looks may itself be too old to read what it is to warn of: then the line that it
stops at tells (:func:`newer_than_this_python`). What it does read is looked for in the tree and in
the tokens (:func:`newer_syntax`), since ``ast.parse(feature_version=(3, 10))`` says of itself that
it does its best only.
"""

from __future__ import annotations

import ast
import io
import re
import token
import tokenize
from collections.abc import Iterator

from rps_compat.scripts.libraries import PYTHON

#: What a line looks like that only a newer Python reads → what it uses, and since when.
_NEWER_LINES = {
    r"\s*except\s*\*": "except*, of Python 3.11",
    r".*\w\[\s*(.*,\s*)?\*\w": "a star in a subscript, of Python 3.11",
    r"\s*type\s+\w+\s*(\[.*\]\s*)?=": "the type statement, of Python 3.12",
    r"\s*((async\s+)?def|class)\s+\w+\s*\[": "type parameters, of Python 3.12",
    r".*\b[rR]?[fF][rR]?(['\"])[^'\"{]*\{[^{}]*\1.*\}": "an f-string that uses its own quotes"
    " inside, as of Python 3.12",
    r".*\b[tT]['\"].*\{": "a template string, of Python 3.14",
    r"\s*except\s+\w[\w.]*\s*,.*:": "except without parentheses, of Python 3.14",
}
#: What a node of the tree is called → what it is, and since when.
_NEWER_NODES = {
    "TryStar": "except*, of Python 3.11",
    "TypeAlias": "the type statement, of Python 3.12",
    "TemplateStr": "a template string, of Python 3.14",
}


def newer_than_the_testbeds(what: str) -> str:
    """Say of syntax or of a name that the testbed's Python does not have it.

    Parameters
    ----------
    what : str
        The syntax or the name.
    """
    return f"newer than Python {PYTHON[0]}.{PYTHON[1]}: {what}"


def newer_than_this_python(error: SyntaxError) -> str | None:
    """Return what of a newer Python the line uses that this Python cannot read; None if nothing.

    Parameters
    ----------
    error : SyntaxError
        What this Python says of the line.
    """
    if "backslash" in error.msg and error.msg.startswith("f-string"):
        return "an f-string with a backslash inside, as of Python 3.12"
    line = error.text or ""
    return next((what for form, what in _NEWER_LINES.items() if re.match(form, line)), None)


def newer_syntax(text: str, tree: ast.Module) -> list[tuple[int, str]]:
    """Return line and description of what the testbed's Python refuses, by line.

    Parameters
    ----------
    text : str
        A source that this Python reads.
    tree : ast.Module
        Of it.
    """
    found = {*_newer_nodes(tree), *_newer_fstrings(text)}
    if not found:
        try:
            ast.parse(text, feature_version=PYTHON)
        except SyntaxError as error:
            found.add((error.lineno or 1, error.msg))
    return sorted(found)


def _newer_nodes(tree: ast.Module) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        kind = type(node).__name__
        if kind == "TryStar":
            yield node.handlers[0].lineno, _NEWER_NODES[kind]  # type: ignore[attr-defined]
        elif kind in _NEWER_NODES:
            yield node.lineno, _NEWER_NODES[kind]  # type: ignore[attr-defined]
        elif getattr(node, "type_params", None):
            yield node.lineno, "type parameters, of Python 3.12"  # type: ignore[attr-defined]
        elif isinstance(node, ast.Subscript) and _is_starred(node):
            yield node.lineno, "a star in a subscript, of Python 3.11"


def _is_starred(node: ast.Subscript) -> bool:
    """``a[*b]``; ``a[(*b,)]`` has the same tree, but its tuple starts a column earlier."""
    index = node.slice
    if not isinstance(index, ast.Tuple):
        return False
    first = index.elts[0] if index.elts else index
    written = (index.lineno, index.col_offset) == (first.lineno, first.col_offset)
    return written and any(isinstance(entry, ast.Starred) for entry in index.elts)


def _newer_fstrings(text: str) -> Iterator[tuple[int, str]]:
    """Before 3.12 a field of an f-string could hold none of its quote, a backslash, #, a new line.

    An older Python than that has no tokens for the inside of f-strings, and refuses these itself.
    """
    open_quotes: list[str] = []
    since = "in an f-string field, as of Python 3.12"
    try:
        for piece in tokenize.generate_tokens(io.StringIO(text).readline):
            kind, line = token.tok_name[piece.type], piece.start[0]
            if kind == "FSTRING_START":
                quote = piece.string.lstrip("rRfFbBuU")
                if any(outer[0] == quote[0] and len(outer) <= len(quote) for outer in open_quotes):
                    yield line, f"the same quote {since}"
                open_quotes.append(quote)
            elif kind == "FSTRING_END":
                open_quotes.pop()
            elif open_quotes and kind == "STRING":
                inner = piece.string.lstrip("rRfFbBuU")
                if any(outer in inner for outer in open_quotes):
                    yield line, f"the same quote {since}"
                elif "\\" in piece.string:
                    yield line, f"a backslash {since}"
            elif open_quotes and kind == "COMMENT":
                yield line, f"a comment {since}"
            elif kind == "NL" and any(len(quote) == 1 for quote in open_quotes):
                yield line, f"a new line {since}"
    except (tokenize.TokenError, IndentationError):
        return
