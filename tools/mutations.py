"""The changes of mutation testing: one small fault after another in a syntax tree.

Faults that people make: a comparison that takes its bound in or leaves it out, a sign, a factor
that is divided by, a number that is one off, an argument or an entry of a table that is missing, a
name taken for its neighbour (``min`` for ``max``), a condition the wrong way round, a statement
that was left out.

Left alone is what says nothing of behaviour: annotations, docstrings, ``assert``, the words of
messages (strings with spaces, formatted strings, what is raised).
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any


@dataclass(frozen=True)
class Mutation:
    """A change of a syntax tree: where, what in words, and the function that makes it."""

    line: int
    what: str
    apply: Callable[[], object]


_ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Add,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
_COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.GtE),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.LtE),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
_NEIGHBOURS = {
    name: other
    for pair in (
        ("min", "max"),
        ("minimum", "maximum"),
        ("argmin", "argmax"),
        ("nanmin", "nanmax"),
        ("any", "all"),
        ("sin", "cos"),
        ("mean", "sum"),
        ("reached", "beyond"),
        ("within", "short_of"),
        ("mean", "median"),
    )
    for name, other in (pair, pair[::-1])
}


def mutations(tree: ast.Module) -> Iterator[Mutation]:
    """Yield every change of a module's tree, in an order that is always the same."""
    for node in _changeable(tree):
        for what, apply in _changes(node):
            yield Mutation(getattr(node, "lineno", 0), what, apply)
        yield from _without_statements(node)


def _changeable(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a tree that may be changed."""
    yield node
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not _is_left_alone(child):
                yield from _changeable(child)


def _is_left_alone(node: ast.AST) -> bool:
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Constant)  # a docstring
    if isinstance(node, ast.Assign):
        return ast.unparse(node.targets[0]) == "__all__"
    if isinstance(node, ast.If):
        return ast.unparse(node.test) == "TYPE_CHECKING"
    if isinstance(node, ast.Subscript):
        return ast.unparse(node.value) == "Literal"
    return isinstance(node, (ast.JoinedStr, ast.Raise, ast.Assert))


def _changes(node: ast.AST) -> Iterator[tuple[str, Callable[[], object]]]:
    """Yield the changes of one node: in words, and what makes them."""
    if isinstance(node, (ast.BinOp, ast.AugAssign)) and type(node.op) in _ARITHMETIC:
        new = _ARITHMETIC[type(node.op)]
        yield f"{type(node.op).__name__} to {new.__name__}", partial(setattr, node, "op", new())
    elif isinstance(node, ast.Compare):
        for k, old in enumerate(node.ops):
            for other in _COMPARISONS[type(old)]:
                what = f"{type(old).__name__} to {other.__name__}"
                yield what, partial(node.ops.__setitem__, k, other())
    elif isinstance(node, ast.BoolOp):
        swapped = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield f"to {type(swapped).__name__.lower()}", partial(setattr, node, "op", swapped)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield "without minus", partial(setattr, node, "op", ast.UAdd())
    elif isinstance(node, ast.Constant):
        yield from _constants(node)
    elif isinstance(node, ast.Name) and node.id in _NEIGHBOURS:
        yield f"to {_NEIGHBOURS[node.id]}", partial(setattr, node, "id", _NEIGHBOURS[node.id])
    elif isinstance(node, ast.Attribute) and node.attr in _NEIGHBOURS:
        yield f"to {_NEIGHBOURS[node.attr]}", partial(setattr, node, "attr", _NEIGHBOURS[node.attr])
    elif isinstance(node, ast.Call):
        for k, keyword in enumerate(node.keywords):
            yield f"without argument {keyword.arg}", partial(node.keywords.pop, k)
    elif isinstance(node, ast.Dict):
        for k, key in enumerate(node.keys):
            yield (
                f"without entry {key and ast.unparse(key)}",
                partial(_drop, k, node.keys, node.values),
            )
    elif isinstance(node, (ast.List, ast.Set)) and len(node.elts) > 1:
        for k, element in enumerate(node.elts):
            yield f"without element {ast.unparse(element)[:30]}", partial(node.elts.pop, k)
    elif isinstance(node, (ast.If, ast.IfExp, ast.While)):
        negated = ast.UnaryOp(ast.Not(), node.test)
        yield "condition negated", partial(setattr, node, "test", negated)
    elif isinstance(node, ast.comprehension):
        for k in range(len(node.ifs)):
            yield "without its if", partial(node.ifs.pop, k)


def _constants(node: ast.Constant) -> Iterator[tuple[str, Callable[[], object]]]:
    value: Any = node.value
    if isinstance(value, bool):
        yield f"to {not value}", partial(setattr, node, "value", not value)
    elif isinstance(value, (int, float)):
        yield f"{value} to {value + 1}", partial(setattr, node, "value", value + 1)
    elif isinstance(value, str) and value and " " not in value:
        yield f"{value!r} to another word", partial(setattr, node, "value", f"{value}_")


def _without_statements(node: ast.AST) -> Iterator[Mutation]:
    """Yield what leaves out a statement whose absence is no error of its own."""
    for body in (getattr(node, name, None) for name in ("body", "orelse")):
        for k, statement in enumerate(body if isinstance(body, list) else []):
            kept = isinstance(statement, (ast.Expr, ast.AugAssign, ast.Raise, ast.Continue))
            if isinstance(statement, ast.Assign):
                kept = isinstance(statement.targets[0], (ast.Attribute, ast.Subscript))
            if kept and not (isinstance(statement, ast.Expr) and _is_left_alone(statement)):
                yield Mutation(
                    statement.lineno, "left out", partial(body.__setitem__, k, ast.Pass())
                )


def _drop(k: int, *lists: list[Any]) -> None:
    for values in lists:
        del values[k]
