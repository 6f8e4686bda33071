"""Values that can be read off a source: numbers, strings, paths, and names bound once to them."""

from __future__ import annotations

import ast
import operator
from pathlib import PurePosixPath
from types import EllipsisType

Constant = int | float | complex | str | bytes | EllipsisType | PurePosixPath
"""What can be read off: a Python constant, or a path."""
Names = dict[str, Constant]
"""What names are bound to, for good."""

#: What stands for ``__file__``.
SCRIPT = PurePosixPath("__file__")
_OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}


def constants_of(tree: ast.Module) -> Names:
    """Return every name that is bound exactly once, to a value that can be read off.

    Parameters
    ----------
    tree : ast.Module
        Syntax tree of the script.
    """
    bound: dict[str, list[ast.expr | None]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            target = node.targets[0]
            for bound_name, value in _pairs(target, node.value):
                bound.setdefault(bound_name.id, []).append(value)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value:
            bound.setdefault(node.target.id, []).append(node.value)
        elif isinstance(node, ast.arg):
            bound.setdefault(node.arg, []).append(None)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            # Targets of plain assignments come here as well, once each.
            bound.setdefault(node.id, [])
            if not _is_plain_target(tree, node):
                bound[node.id].append(None)
    known: Names = {}
    while True:
        before = len(known)
        for name, values in bound.items():
            if name not in known and len(values) == 1 and values[0] is not None:
                found = constant(values[0], known)
                if found is not None:
                    known[name] = found
        if len(known) == before:
            return known


def constant(node: ast.expr, names: Names) -> Constant | None:
    """Return the value of an expression of constants and known names, or None.

    Parameters
    ----------
    node : ast.expr
        An expression of the script.
    names : dict
        Known names and their values, as `constants_of` gives them.
    """
    if isinstance(node, ast.Constant):
        return node.value  # None, too, which is no more than unknown
    if isinstance(node, ast.Name):
        return SCRIPT if node.id == "__file__" else names.get(node.id)
    if isinstance(node, ast.Attribute) and node.attr == "parent":
        return _parent(constant(node.value, names))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        value = constant(node.operand, names)
        return -value if isinstance(value, (int, float)) else None
    if isinstance(node, ast.BinOp):
        left, right = constant(node.left, names), constant(node.right, names)
        apply = _OPERATORS.get(type(node.op))
        if left is None or right is None or apply is None:
            return None
        try:
            result: Constant = apply(left, right)
        except (TypeError, ValueError, ArithmeticError):
            return None
        return result
    if isinstance(node, ast.JoinedStr):
        parts = [
            constant(part.value, names)
            if isinstance(part, ast.FormattedValue)
            else constant(part, names)
            for part in node.values
        ]
        return None if any(part is None for part in parts) else "".join(map(str, parts))
    if isinstance(node, ast.Call) and not node.keywords:
        return _path(node, names)
    return None


def _path(call: ast.Call, names: Names) -> PurePosixPath | None:
    """``Path("a", "b")``, ``os.path.join("a", "b")``, and ways to the folder of the script."""
    func = call.func
    name = func.attr if isinstance(func, ast.Attribute) else getattr(func, "id", "")
    if name in ("cwd", "getcwd") and not call.args:
        return PurePosixPath()
    arguments = list(call.args)
    if name == "with_name" and isinstance(func, ast.Attribute):
        name, arguments = "joinpath", [ast.Attribute(func.value, "parent", ast.Load()), *arguments]
    elif name in ("resolve", "absolute", "joinpath") and isinstance(func, ast.Attribute):
        arguments.insert(0, func.value)
    elif name not in ("Path", "PurePath", "join", "dirname", "abspath", "realpath", "str"):
        return None
    found = [constant(argument, names) for argument in arguments]
    parts = [part for part in found if isinstance(part, (str, PurePosixPath))]
    if not parts or len(parts) < len(found):
        return None
    path = PurePosixPath(*parts)
    return _parent(path) if name == "dirname" else path


def _parent(path: Constant | None) -> PurePosixPath | None:
    """Return the folder of a path; the working folder is the script's own."""
    if not isinstance(path, PurePosixPath):
        return None
    return path.parent if path.name else path / ".."


def _pairs(target: ast.expr, value: ast.expr) -> list[tuple[ast.Name, ast.expr]]:
    """Return the names that an assignment binds, each with its own value: ``a, b = 1, 2``."""
    if isinstance(target, ast.Name):
        return [(target, value)]
    if (
        isinstance(target, ast.Tuple)
        and isinstance(value, ast.Tuple)
        and len(target.elts) == len(value.elts)
        and not any(isinstance(entry, ast.Starred) for entry in (*target.elts, *value.elts))
    ):
        entries = zip(target.elts, value.elts, strict=True)
        return [pair for one in entries for pair in _pairs(*one)]
    return []


def _is_plain_target(tree: ast.Module, name: ast.Name) -> bool:
    cache: set[int] | None = getattr(tree, "_plain_targets", None)
    if cache is None:
        cache = {
            id(name)
            for node in ast.walk(tree)
            if isinstance(node, ast.Assign) and len(node.targets) == 1
            for name, _ in _pairs(node.targets[0], node.value)
        }
        cache |= {id(node.target) for node in ast.walk(tree) if isinstance(node, ast.AnnAssign)}
        tree._plain_targets = cache  # type: ignore[attr-defined]
    return id(name) in cache
