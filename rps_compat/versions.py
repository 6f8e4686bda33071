"""Names and syntax that the testbed's numpy 2.2 and Python 3.10 do not have."""

import ast
import io
import tokenize
from collections.abc import Iterator
from typing import Any

#: Gone from numpy by 2.2 → what to write; None where it depends.
NUMPY_GONE: dict[str, str | None] = {
    "mat": "asmatrix",
    "float": "float64",
    "int": "int_",
    "complex": "complex128",
    "object": "object_",
    "str": "str_",
    "float_": "float64",
    "complex_": "complex128",
    "longfloat": "longdouble",
    "singlecomplex": "complex64",
    "cfloat": "complex128",
    "longcomplex": "clongdouble",
    "string_": "bytes_",
    "unicode_": "str_",
    "Inf": "inf",
    "Infinity": "inf",
    "infty": "inf",
    "PINF": "inf",
    "NINF": None,
    "NaN": "nan",
    "PZERO": None,
    "NZERO": None,
    "round_": "round",
    "product": "prod",
    "cumproduct": "cumprod",
    "sometrue": "any",
    "alltrue": "all",
    "asfarray": None,
    "msort": None,
    "cast": None,
    "source": None,
    "lookfor": None,
    "who": None,
    "disp": None,
    "find_common_type": None,
    "issubclass_": None,
    "issubsctype": None,
    "maximum_sctype": None,
    "obj2sctype": None,
    "sctype2char": None,
    "sctypes": None,
    "nbytes": None,
    "set_string_function": None,
    "set_numeric_ops": None,
    "geterrobj": None,
    "seterrobj": None,
    "recfromcsv": None,
    "recfromtxt": None,
    "safe_eval": None,
    "tracemalloc_domain": None,
    "MachAr": None,
    "DataSource": None,
    "ModuleDeprecationWarning": None,
    "deprecate": None,
    "byte_bounds": None,
    "compare_chararrays": None,
    "add_newdoc_ufunc": None,
    "compat": None,
}
#: Modules and names of the standard library that came after Python 3.10.
LIBRARY_LATER = {
    "tomllib": {""},
    "typing": {
        "Self", "Never", "LiteralString", "TypeVarTuple", "Unpack", "Required", "NotRequired",
        "assert_never", "assert_type", "reveal_type", "override", "dataclass_transform", "ReadOnly",
    },
    "enum": {"StrEnum", "ReprEnum", "EnumCheck", "verify", "member", "nonmember"},
    "datetime": {"UTC"},
    "asyncio": {"TaskGroup", "Runner", "timeout", "Barrier"},
    "itertools": {"batched"},
    "math": {"cbrt", "exp2", "sumprod", "fma"},
    "contextlib": {"chdir"},
    "operator": {"call"},
    "statistics": {"kde"},
    "warnings": {"deprecated"},
}  # fmt: skip

Report = tuple[int, str, Any, str | None]


def version_findings(tree: ast.Module, source: bytes) -> Iterator[Report]:
    """Yield (line, message, node to replace or None, replacement or None)."""
    yield from _numpy_names(tree)
    yield from _later_library(tree)
    yield from _later_syntax(tree)
    yield from _later_strings(source)


def _numpy_names(tree: ast.Module) -> Iterator[Report]:
    aliases = {
        alias.asname or alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import)
        for alias in node.names
        if alias.name == "numpy"
    } | {"np"}  # many scripts get np from a star import
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name)
            and node.value.id in aliases
            and node.attr in NUMPY_GONE
        ):
            new, owner = NUMPY_GONE[node.attr], node.value.id
            message = f"numpy 2.2 has no {node.attr}"
            if new:
                yield node.lineno, f"{message}; write {owner}.{new}", node, f"{owner}.{new}"
            else:
                yield node.lineno, message, None, None
        elif isinstance(node, ast.ImportFrom) and node.module == "numpy":
            for alias in node.names:
                if alias.name in NUMPY_GONE:
                    yield node.lineno, f"numpy 2.2 has no {alias.name}", None, None


def _later_library(tree: ast.Module) -> Iterator[Report]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if "" in LIBRARY_LATER.get(alias.name, ()):
                    yield node.lineno, f"Python 3.10 has no module {alias.name}", None, None
        elif isinstance(node, ast.ImportFrom):
            later = LIBRARY_LATER.get(node.module or "", set())
            if "" in later:
                yield node.lineno, f"Python 3.10 has no module {node.module}", None, None
            for alias in node.names:
                if alias.name in later:
                    name = f"{node.module}.{alias.name}"
                    yield node.lineno, f"Python 3.10 has no {name}", None, None
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if node.attr in LIBRARY_LATER.get(node.value.id, ()):
                name = f"{node.value.id}.{node.attr}"
                yield node.lineno, f"Python 3.10 has no {name}", None, None
        elif isinstance(node, ast.Name) and node.id in ("ExceptionGroup", "BaseExceptionGroup"):
            yield node.lineno, f"Python 3.10 has no {node.id}", None, None


def _later_syntax(tree: ast.Module) -> Iterator[Report]:
    for node in ast.walk(tree):
        kind = type(node).__name__
        if kind == "TryStar":
            yield node.lineno, "Python 3.10 does not know except*", None, None  # type: ignore[attr-defined]
        elif kind == "TypeAlias":
            yield node.lineno, "Python 3.10 does not know the type statement", None, None  # type: ignore[attr-defined]
        elif getattr(node, "type_params", None):
            message = "Python 3.10 does not know type parameters in brackets"
            yield node.lineno, message, None, None  # type: ignore[attr-defined]
        elif isinstance(node, ast.Subscript):
            index = node.slice
            parts = index.elts if isinstance(index, ast.Tuple) else [index]
            if any(isinstance(part, ast.Starred) for part in parts):
                yield node.lineno, "Python 3.10 does not know a star within an index", None, None


def _later_strings(source: bytes) -> Iterator[Report]:
    """Find strings within f-strings that use the f-string's own quotes, new in Python 3.12."""
    if not hasattr(tokenize, "FSTRING_START"):  # older Pythons refuse such a script themselves
        return
    quotes: list[str] = []
    for token in tokenize.tokenize(io.BytesIO(source).readline):
        kind = tokenize.tok_name[token.type]
        if kind == "FSTRING_START":
            if quotes and _quote(token.string) in quotes:
                yield token.start[0], _REUSED, None, None
            quotes.append(_quote(token.string))
        elif kind == "FSTRING_END":
            quotes.pop()
        elif kind == "STRING" and quotes and _quote(token.string) in quotes:
            yield token.start[0], _REUSED, None, None


_REUSED = "Python 3.10 does not know an f-string's own quotes within its braces"


def _quote(text: str) -> str:
    body = text.lstrip("rRbBuUfF")
    return body[:3] if body[:3] in ('"""', "'''") else body[:1]
