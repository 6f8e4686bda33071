"""Which names a function binds itself, and which it takes from around it.

Python decides that before anything runs: a name that is assigned anywhere in a function is the
function's own, unless it is declared ``global`` or ``nonlocal``. Bound is what is assigned
(``=``, ``+=``, ``:=``, ``for``, ``with``, ``except``, ``match``, ``del``), defined or imported. A
comprehension has its targets to itself, but what it assigns by ``:=`` is the function's.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)
_COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)


@dataclass(frozen=True)
class Names:
    """Names of one function or module.

    Attributes
    ----------
    local : frozenset of str
        What it binds for itself; parameters are among them.
    taken_global, taken_nonlocal : frozenset of str
        What it declares to be the module's, or of a function around it.
    """

    local: frozenset[str]
    taken_global: frozenset[str]
    taken_nonlocal: frozenset[str]


def names_of(node: ast.Module | ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) -> Names:
    """Return the names of a function or module.

    Parameters
    ----------
    node : ast.Module, ast.FunctionDef, ast.AsyncFunctionDef or ast.Lambda
        Where it is defined.
    """
    body: list[ast.AST] = [node.body] if isinstance(node, ast.Lambda) else list(node.body)
    bound = {parameter.arg for parameter in parameters_of(node)}
    declared: dict[type, set[str]] = {ast.Global: set(), ast.Nonlocal: set()}
    for inner in _own_nodes(body):
        bound |= set(_bound_by(inner))
        if isinstance(inner, (ast.Global, ast.Nonlocal)):
            declared[type(inner)] |= set(inner.names)
    taken = declared[ast.Global] | declared[ast.Nonlocal]
    return Names(
        frozenset(bound - taken),
        frozenset(declared[ast.Global]),
        frozenset(declared[ast.Nonlocal]),
    )


def parameters_of(node: ast.AST) -> list[ast.arg]:
    """Return all parameters of a function, in the order of its signature; none of anything else.

    Parameters
    ----------
    node : ast.AST
        Where it is defined.
    """
    if not isinstance(node, _FUNCTIONS):
        return []
    of = node.args
    starred = [of.vararg] if of.vararg else []
    double = [of.kwarg] if of.kwarg else []
    return [*of.posonlyargs, *of.args, *starred, *of.kwonlyargs, *double]


def _own_nodes(roots: list[ast.AST], comprehension: bool = False) -> Iterator[ast.AST]:
    """Walk what belongs to a scope; of a comprehension's targets only what ``:=`` leaks."""
    for node in roots:
        if comprehension and isinstance(node, ast.Name):
            continue
        yield node
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)):
            yield from _own_nodes(_around(node), comprehension)
        elif isinstance(node, ast.NamedExpr):
            yield from _own_nodes([node.value], comprehension)
        else:
            inside = comprehension or isinstance(node, _COMPREHENSIONS)
            yield from _own_nodes(list(ast.iter_child_nodes(node)), inside)


def _around(node: ast.AST) -> list[ast.AST]:
    """Return what of a definition is computed outside it: decorators, defaults, bases."""
    if isinstance(node, ast.ClassDef):
        return [*node.decorator_list, *node.bases, *(k.value for k in node.keywords)]
    assert isinstance(node, _FUNCTIONS)
    defaults = [*node.args.defaults, *(d for d in node.args.kw_defaults if d is not None)]
    return [*getattr(node, "decorator_list", []), *defaults]


def _bound_by(node: ast.AST) -> Iterator[str]:
    """Yield the names that a node binds."""
    if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
        yield node.id
    elif isinstance(node, ast.NamedExpr):
        yield node.target.id
    elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
        yield node.name
    elif isinstance(node, (ast.Import, ast.ImportFrom)):
        for alias in node.names:
            if alias.name != "*":
                yield alias.asname or alias.name.partition(".")[0]
    elif (isinstance(node, ast.ExceptHandler) and node.name) or (
        isinstance(node, (ast.MatchAs, ast.MatchStar)) and node.name
    ):
        yield node.name
    elif isinstance(node, ast.MatchMapping) and node.rest:
        yield node.rest
