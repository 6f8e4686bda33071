"""The constants at the top of a script: which there are, and the script with others in their place.

A constant is a name that the script's outermost level binds once, to a number, a string or a truth
value that can be read off: ``SPEED = 0.12`` or ``STEPS = 60 * 30``. What stands in functions, in
branches or in files beside the script is none. Nothing is run to find them.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator, Mapping

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.sweep.experiments import Value
from posflock_robotarium.verify.constants import Names, constant
from rps_compat.scripts.edits import Text, rewritten
from rps_compat.scripts.source import Script


def constants_in(script: Script) -> dict[str, Value]:
    """Return the constants of a script in their order.

    Parameters
    ----------
    script : Script
        As it was read.

    Examples
    --------
    >>> from rps_compat.scripts.source import parse_script
    >>> constants_in(parse_script(b"SPEED = 0.1; STEPS = 30 * 60; N = [1, 2]; SPREAD = abs(-1)"))
    {'SPEED': 0.1, 'STEPS': 1800}
    """
    found: dict[str, Value] = {}
    known: Names = {}
    for name, node in _bound_once(script.tree).items():
        value = constant(node, known)
        if isinstance(value, (bool, int, float, str)):
            found[name] = known[name] = value
    return found


def with_constants(script: Script, values: Mapping[str, Value]) -> bytes:
    """Return a script's bytes with other values in the place of its own; all else stays.

    Parameters
    ----------
    script : Script
        As it was read.
    values : mapping
        By name, of constants that are among `constants_in`.

    Raises
    ------
    ParameterError
        Where the script has no such constant.
    """
    text, bound, own = Text(script), _bound_once(script.tree), constants_in(script)
    missing = sorted(set(values) - set(own))
    if missing:
        raise ParameterError(
            f"{script.path.name}: no constant {missing[0]!r} at its top; expected one of"
            f" {', '.join(own) or 'none: it has no constants'}"
        )
    changed = {name: value for name, value in values.items() if value != own[name]}
    # Lines stay where they are, so that errors name those of the user's file.
    lines = {name: "\n" * _further_lines(bound[name]) for name in changed}
    edits = [
        text.replace(bound[name], f"({value!r}{lines[name]})" if lines[name] else repr(value))
        for name, value in changed.items()
    ]
    return rewritten(script, edits)


def _bound_once(tree: ast.Module) -> dict[str, ast.expr]:
    """Return what statements of the outermost level bind names to that nothing else binds."""
    found: dict[str, ast.expr] = {}
    for statement in tree.body:
        if isinstance(statement, ast.Assign) and len(statement.targets) == 1:
            target: ast.expr = statement.targets[0]
        elif isinstance(statement, ast.AnnAssign):
            target = statement.target
        else:
            continue
        if isinstance(target, ast.Name) and statement.value is not None:
            found[target.id] = statement.value
    times = Counter(_bound_at_module_level(tree))
    return {name: value for name, value in found.items() if times[name] == 1}


def _bound_at_module_level(node: ast.AST) -> Iterator[str]:
    """Yield a name for each place that binds it in the module; functions bind their own."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            for inner in ast.walk(child):
                if isinstance(inner, ast.Global):
                    yield from inner.names
            continue
        if isinstance(child, ast.Name) and not isinstance(child.ctx, ast.Load):
            yield child.id
        yield from _bound_at_module_level(child)


def _further_lines(node: ast.expr) -> int:
    return (node.end_lineno or node.lineno) - node.lineno
