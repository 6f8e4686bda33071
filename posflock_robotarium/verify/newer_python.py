"""What a newer Python accepts and the testbed's Python 3.10 does not.

``ast.parse(feature_version=(3, 10))`` refuses new statements (``except*``, ``type``, type
parameters).  It says itself that this is "best effort": f-strings of 3.12, stars in subscripts
and the library are ours to look at.  Where a Python 3.10 is installed, :func:`compiled_by_310`
asks it, which settles the syntax.
"""

from __future__ import annotations

import ast
import io
import re
import subprocess
import sys
import token
import tokenize
from collections.abc import Iterator

from posflock_robotarium import import_graph
from rps_compat.scripts import libraries

#: Names of the standard library that came after 3.10.
NEWER_NAMES = {
    "typing": "Self LiteralString Never assert_never assert_type reveal_type Required NotRequired"
    " Unpack TypeVarTuple dataclass_transform override TypeAliasType get_protocol_members"
    " is_protocol NoDefault ReadOnly TypeIs clear_overloads get_overloads",
    "itertools": "batched",
    "math": "cbrt exp2 sumprod fma",
    "datetime": "UTC",
    "enum": "StrEnum ReprEnum EnumCheck FlagBoundary global_enum member nonmember property"
    " show_flag_values verify",
    "contextlib": "chdir",
    "hashlib": "file_digest",
    "asyncio": "TaskGroup Runner timeout timeout_at Barrier",
    "random": "binomialvariate",
    "operator": "call is_none is_not_none",
    "inspect": "getmembers_static",
    "copy": "replace",
    "functools": "Placeholder",
    "statistics": "kde kde_random",
    "collections.abc": "Buffer",
    "warnings": "deprecated",
    "string": "templatelib",
}
NEWER_BUILTINS = frozenset(["ExceptionGroup", "BaseExceptionGroup", "PythonFinalizationError"])

#: Names that numpy 2 no longer has → what to write.
REMOVED_FROM_NUMPY = {
    "float_": "float64",
    "complex_": "complex128",
    "unicode_": "str_",
    "string_": "bytes_",
    "Inf": "inf",
    "Infinity": "inf",
    "infty": "inf",
    "PINF": "inf",
    "NINF": "-np.inf",
    "NaN": "nan",
    "NAN": "nan",
    "PZERO": "0.0",
    "NZERO": "-0.0",
    "product": "prod",
    "cumproduct": "cumprod",
    "sometrue": "any",
    "alltrue": "all",
    "float": "float, Python's own",
    "int": "int, Python's own",
    "object": "object, Python's own",
    "str": "str, Python's own",
    "complex": "complex, Python's own",
    "bool8": "bool_",
    "int0": "intp",
    "uint0": "uintp",
    "asfarray": "asarray(…, dtype=float)",
    "find_common_type": "result_type",
    "cast": "asarray(…, dtype=…)",
    "source": "inspect.getsource",
    "lookfor": "the documentation",
    "who": "dir()",
    "msort": "sort(…, axis=0)",
    "asscalar": "array.item()",
    "mat": "asmatrix",
    "recfromcsv": "genfromtxt",
    "recfromtxt": "genfromtxt",
    "safe_eval": "ast.literal_eval",
    "issubclass_": "issubclass",
    "set_string_function": "set_printoptions",
}


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


def newer_than_this_python(error: SyntaxError) -> str | None:
    """Return what of a newer Python the line uses that this Python cannot read; None if nothing.

    This Python may itself be too old to parse what it is to warn of.
    """
    if "backslash" in error.msg and error.msg.startswith("f-string"):
        return "an f-string with a backslash inside, as of Python 3.12"
    line = error.text or ""
    return next((what for form, what in _NEWER_LINES.items() if re.match(form, line)), None)


def newer_syntax(source: str) -> tuple[int, str] | None:
    """Return line and reason of the first syntax that Python 3.10 refuses; None if none.

    `source` must be valid for the Python that runs this.
    """
    try:
        tree = ast.parse(source, feature_version=libraries.PYTHON)
    except SyntaxError as error:
        groups = [n for n in ast.walk(ast.parse(source)) if type(n).__name__ == "TryStar"]
        if "xception group" in error.msg and groups:  # Python names a line after it
            return min(node.handlers[0].lineno for node in groups), error.msg  # type: ignore[attr-defined]
        return error.lineno or 1, error.msg
    found = [*_starred_subscripts(tree), *_newer_fstrings(source)]
    if found:
        return min(found)
    return _asked_of_310(source)


def newer_library(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield line and reason of every feature of the standard library newer than 3.10."""
    modules: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                modules[alias.asname or alias.name] = alias.name
    for statement in import_graph.imports(tree):
        if statement.top in libraries.NEWER_MODULES and not statement.guarded:
            yield statement.line, f"the module {statement.top}"
    for node in import_graph.run_on_the_testbed(tree):
        if isinstance(node, ast.ImportFrom) and not node.level:
            for alias in node.names:
                if alias.name in NEWER_NAMES.get(node.module or "", "").split():
                    yield node.lineno, f"{node.module}.{alias.name}"
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            module = modules.get(node.value.id, "")
            if node.attr in NEWER_NAMES.get(module, "").split():
                yield node.lineno, f"{module}.{node.attr}"
        elif isinstance(node, ast.Name) and node.id in NEWER_BUILTINS:
            yield node.lineno, node.id


def removed_from_numpy(tree: ast.Module) -> Iterator[tuple[int, str, str]]:
    """Yield line, name and replacement of every use of what numpy 2 has removed."""
    aliases = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            aliases |= {a.asname or a.name for a in node.names if a.name == "numpy"}
        elif isinstance(node, ast.ImportFrom) and node.module == "numpy" and not node.level:
            for alias in node.names:
                if alias.name in REMOVED_FROM_NUMPY:
                    yield node.lineno, alias.name, REMOVED_FROM_NUMPY[alias.name]
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name)
            and node.value.id in aliases
            and node.attr in REMOVED_FROM_NUMPY
        ):
            yield node.lineno, node.attr, REMOVED_FROM_NUMPY[node.attr]


def _starred_subscripts(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """``a[*b]`` is 3.11; ``a[(*b,)]`` has the same tree, but starts a column later."""
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Subscript)
            and isinstance(node.slice, ast.Tuple)
            and any(isinstance(entry, ast.Starred) for entry in node.slice.elts)
            and node.slice.col_offset == node.slice.elts[0].col_offset
            and node.slice.lineno == node.slice.elts[0].lineno
        ):
            yield node.lineno, "a star in a subscript is Python 3.11"


def _newer_fstrings(source: str) -> Iterator[tuple[int, str]]:
    """Before 3.12 a field of an f-string could hold neither its quote, nor a backslash, nor #.

    An older Python than that has no tokens for the inside of f-strings, and refuses these itself.
    """
    open_quotes: list[str] = []
    reason = "in an f-string field is Python 3.12"
    try:
        for piece in tokenize.generate_tokens(io.StringIO(source).readline):
            kind = token.tok_name[piece.type]
            if kind == "FSTRING_START":
                quote = piece.string.lstrip("rRfFbBuU")
                if any(outer[0] == quote[0] and len(outer) <= len(quote) for outer in open_quotes):
                    yield piece.start[0], f"the same quote {reason}"
                open_quotes.append(quote)
            elif kind == "FSTRING_END":
                open_quotes.pop()
            elif open_quotes and kind == "STRING":
                inner = piece.string.lstrip("rRfFbBuU")
                if any(outer in inner for outer in open_quotes):
                    yield piece.start[0], f"the same quote {reason}"
                elif "\\" in piece.string:
                    yield piece.start[0], f"a backslash {reason}"
            elif open_quotes and kind == "COMMENT":
                yield piece.start[0], f"a comment {reason}"
    except (tokenize.TokenError, IndentationError):
        return


def _asked_of_310(source: str) -> tuple[int, str] | None:
    """Ask a Python 3.10 on this machine to compile `source`, where there is one."""
    from posflock_robotarium.interpreters import find_python

    python = find_python(libraries.PYTHON)
    if python is None or sys.version_info[:2] == libraries.PYTHON:
        return None
    program = (
        "import sys\n"
        "try:\n    compile(sys.stdin.buffer.read(), 'script', 'exec', dont_inherit=True)\n"
        "except SyntaxError as error:\n    print(error.lineno or 1, error.msg)\n"
    )
    answer = subprocess.run(
        [str(python), "-I", "-S", "-W", "ignore", "-c", program],
        input=source.encode(),
        capture_output=True,
        timeout=20,
        check=False,
    ).stdout.decode(errors="replace")
    line, _, reason = answer.strip().partition(" ")
    return (int(line), reason) if line.isdigit() else None
