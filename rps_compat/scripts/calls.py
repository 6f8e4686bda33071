"""What a call of a script returns, and what it tells of the parameters of whoever is called."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from typing import Protocol

from rps_compat.scripts.lookup import attribute, member
from rps_compat.scripts.program import Program
from rps_compat.scripts.scopes import parameters_of
from rps_compat.scripts.values import (
    ANYTHING,
    NONE,
    Class,
    Function,
    Held,
    Instance,
    Method,
    Origin,
    Super,
    Value,
    Values,
    elements,
    held,
)

#: Built-in functions that give a container with the same in it.
_SAME_HELD = frozenset({"list", "tuple", "set", "sorted", "reversed", "iter", "frozenset"})
#: Methods of containers that give what they hold, and such that give the like of them.
_TAKING = frozenset({"pop", "get", "popleft", "popitem", "setdefault"})
_LIKE = frozenset({"copy", "values", "items"})


class CallSite(Protocol):
    """Where a call stands.

    Attributes
    ----------
    program : Program
        The script and the modules beside it.
    classes : list of Class
        Classes around the call, the innermost last.
    """

    program: Program
    classes: list[Class]


def called(
    at: CallSite,
    function: Values,
    node: ast.Call,
    given: Sequence[Values],
    named: Mapping[str | None, Values],
) -> Values:
    """Return what calling `function` gives.

    Parameters
    ----------
    at : CallSite
        Where the call stands.
    function : frozenset
        What is called.
    node : ast.Call
        Where it is called, with its arguments.
    given, named : sequence and mapping of frozenset
        Its arguments; of unpacked ones what they hold, and None for ``**``.
    """
    out: Values = frozenset()
    for value in function:
        out |= _called_one(at, value, node, given, named)
    on = node.func
    if isinstance(on, ast.Attribute):
        owners = at.program.values.get(on.value, NONE)
        inside = frozenset(value for value in owners if isinstance(value, Held))
        if inside and on.attr in _TAKING | _LIKE:
            return elements(inside) if on.attr in _TAKING else inside
    return out


def _called_one(
    at: CallSite,
    value: Value,
    node: ast.Call,
    given: Sequence[Values],
    named: Mapping[str | None, Values],
) -> Values:
    if isinstance(value, Origin):
        return _imported(at, value.path, node, given, named)
    if isinstance(value, Function):
        return _enter(at, value, node, given, named)
    if isinstance(value, Method):
        return _enter(at, value.function, node, [frozenset({value.owner}), *given], named)
    if isinstance(value, Class):
        made = Instance(value)
        for start in member(value, "__init__", made):
            if isinstance(start, Method):
                _called_one(at, start, node, given, named)
        if value.is_dataclass:
            _fill_fields(at, value, given, named)
        return frozenset({made})
    if isinstance(value, Instance):
        out: Values = frozenset()
        for call in member(value.of, "__call__", value):
            if isinstance(call, Method):
                out |= _called_one(at, call, node, given, named)
        return out or ANYTHING
    return ANYTHING


def _imported(
    at: CallSite,
    path: str,
    node: ast.Call,
    given: Sequence[Values],
    named: Mapping[str | None, Values],
) -> Values:
    """Return what calling something imported, or one of Python's own functions, gives."""
    name = path.removeprefix("builtins.")
    if path == "builtins.super":
        return frozenset({Super(at.classes[-1])}) if at.classes else ANYTHING
    if path == "builtins.getattr" and len(node.args) > 1:
        asked = node.args[1]
        if isinstance(asked, ast.Constant) and isinstance(asked.value, str):
            return attribute(at.program, given[0], asked.value).union(*given[2:])
    if name in _SAME_HELD and path.startswith("builtins.") and given:
        return held(elements(given[0]))
    if path.endswith(("Thread", "Timer", "Process")):
        for target in named.get("target", NONE):
            passed = elements(named.get("args", NONE))
            if isinstance(target, (Function, Method)) and passed:
                _called_one(at, target, node, [passed] * _takes(target), {})
    return frozenset({Origin(path + "()")}) if path.count("()") < 2 else ANYTHING


def _takes(target: Function | Method) -> int:
    """How many arguments a function takes besides ``self``."""
    function = target.function if isinstance(target, Method) else target
    return len(parameters_of(function.node)) - isinstance(target, Method)


def _enter(
    at: CallSite,
    function: Function,
    node: ast.Call,
    given: Sequence[Values],
    named: Mapping[str | None, Values],
) -> Values:
    """Tell a function of the script's own what it is called with, and return what it returns."""
    of, program = function.node.args, at.program
    positional = [parameter.arg for parameter in (*of.posonlyargs, *of.args)]
    starred = next((k for k, a in enumerate(node.args) if isinstance(a, ast.Starred)), None)
    ahead = len(given) - len(node.args)  # self
    for k, values in enumerate(given):
        unpacked = starred is not None and k - ahead >= starred
        if k < len(positional):
            for name in positional[k:] if unpacked else positional[k : k + 1]:
                program.add(function.given, name, values)
        elif of.vararg:
            program.add(function.given, of.vararg.arg, held(values))
    names = {parameter.arg for parameter in parameters_of(function.node)}
    for keyword, values in named.items():
        if keyword in names:
            program.add(function.given, str(keyword), values)
        elif keyword is None:
            for name in positional[len(given) :]:
                program.add(function.given, name, elements(values))
    return function.returns


def _fill_fields(
    at: CallSite,
    of: Class,
    given: Sequence[Values],
    named: Mapping[str | None, Values],
) -> None:
    """Give a dataclass the fields that its constructor is called with."""
    fields = [
        entry.target.id
        for entry in of.node.body
        if isinstance(entry, ast.AnnAssign) and isinstance(entry.target, ast.Name)
    ]
    for name, values in zip(fields, given, strict=False):
        at.program.add(of.attributes, name, values)
    for keyword, values in named.items():
        if keyword in fields:
            at.program.add(of.attributes, str(keyword), values)
