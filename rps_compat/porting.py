"""Calls of the API's functions, brought from an older generation to generation 2.

The names of functions are one thing (:mod:`rps_compat.scripts.renaming`), what they are given is
another: arguments have other names, other places and other defaults. Where a script leaves an
argument out, the older default is written into the call, so that it does what it did.
"""

from __future__ import annotations

import ast
import importlib
import inspect
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

from barrier_certificates.word_enum import WordEnum
from rps_compat.scripts.api import renamed_parameters
from rps_compat.scripts.edits import Edit, Text
from rps_compat.scripts.faces import API_MODULES, has, parameters
from rps_compat.scripts.generation_names import (
    CONSTRUCTOR,
    FIRST_OF_TWO,
    FUNCTIONS,
    MADE_FIRST,
    OLD_ARGUMENTS,
    OLD_AT_ONCE,
    OLD_CONSTRUCTOR,
    OLD_COUNTED,
    ROBOTARIUM,
    counterpart,
)
from rps_compat.scripts.program import Program
from rps_compat.scripts.renaming import Renaming
from rps_compat.scripts.uses import api_function, constructor_arguments
from rps_compat.scripts.values import origins

_EMPTY = inspect.Parameter.empty


class ChangeKind(WordEnum):
    """What has to be changed in a line."""

    NAME = "name"
    #: An argument with another name, place or meaning.
    ARGUMENT = "argument"
    #: What a call leaves out, and generation 2 fills in differently.
    DEFAULT = "default"
    #: A name that the testbed's version of a library or Python has not.
    VERSION = "version"
    #: A name that only newer versions than the testbed's have not: nothing, there.
    LATER = "later"


@dataclass(frozen=True)
class Ported:
    """What is to be known of a call, besides the names in it.

    Attributes
    ----------
    line : int
        Where.
    kind : ChangeKind
        A name, an argument or a default.
    message : str
        What is other in generation 2.
    edits : tuple of Edit
        What rewriting does about it.
    """

    line: int
    kind: ChangeKind
    message: str
    edits: tuple[Edit, ...] = ()


class Porting:
    """Brings the calls of one script to generation 2.

    Parameters
    ----------
    program : Program
        The script and the modules beside it.
    text : Text
        Its text, in which names have been edited already.
    renaming : Renaming
        What edits names.
    second : bool
        Whether it is a script of generation 2, in which functions that both have mean its defaults.
    older : bool
        Whether it is one of generation 0.
    """

    def __init__(
        self, program: Program, text: Text, renaming: Renaming, *, second: bool, older: bool
    ) -> None:
        self._program, self._text, self._renaming = program, text, renaming
        self._second, self._older = second, older
        #: Edits of calls, by the node of what they mend: the function's name, or an argument.
        self.edits_at: dict[ast.AST, tuple[Edit, ...]] = {}

    def run(self) -> list[Ported]:
        """Go through all calls, inner ones first, and list what is to be known of them."""
        return [
            found
            for call in _inner_first(self._program.main.script.tree)
            for found in self._call(call)
        ]

    def _call(self, call: ast.Call) -> Iterator[Ported]:
        if any(isinstance(argument, ast.Starred) for argument in call.args):
            return
        positional = constructor_arguments(self._program, call)
        name = api_function(self._program, call)
        if positional is not None:
            self._constructor(call, positional)
        elif name in MADE_FIRST:
            yield self._made_first(call, name)
        elif name in OLD_AT_ONCE:
            self._at_once(call, name)
        elif name in FUNCTIONS or (not self._second and parameters(name, 1)):
            yield from self._utility(call, name)
        elif not self._second and self._commands(call):
            yield from self._ids(call)

    def _mends(self, edits: tuple[Edit, ...], *nodes: ast.AST) -> None:
        for node in nodes:
            self.edits_at[node] = (*self.edits_at.get(node, ()), *edits)

    def _constructor(self, call: ast.Call, positional: list[ast.expr]) -> None:
        names = OLD_CONSTRUCTOR if self._older else CONSTRUCTOR
        dropped = [k for k in call.keywords if OLD_ARGUMENTS.get(k.arg or "", "") is None]
        gone = [
            a for n, a in zip(names, positional, strict=False) if OLD_ARGUMENTS.get(n, "") is None
        ]
        if dropped or gone:
            kept = [self._text.of(a) for a in call.args if a not in positional]
            kept += [
                f"{OLD_ARGUMENTS.get(name) or name}={self._text.of(argument)}"
                for name, argument in zip(names, positional, strict=False)
                if argument not in gone
            ]
            kept += [
                f"{OLD_ARGUMENTS.get(k.arg, k.arg) if k.arg else '**'}"
                f"{'=' if k.arg else ''}{self._text.of(k.value)}"
                for k in call.keywords
                if k not in dropped
            ]
            edit = self._all_arguments(call, kept)
            self._mends((edit,), call, *(k.value for k in call.keywords))
            return
        for keyword in call.keywords:
            new = OLD_ARGUMENTS.get(keyword.arg or "")
            if new:
                at = self._text.start(keyword)
                edit = self._text.make(at, at + len(keyword.arg or ""), new)
                self._mends((edit,), keyword.value)
        self._mends(
            tuple(
                self._text.make(at, at, f"{OLD_ARGUMENTS.get(name) or name}=")
                for name, argument in zip(names, positional, strict=False)
                for at in [self._text.start(argument)]
            ),
            call,
        )

    def _all_arguments(self, call: ast.Call, kept: list[str]) -> Edit:
        return self._text.make(self._text.opening(call), self._text.end(call) - 1, ", ".join(kept))

    def _commands(self, call: ast.Call) -> bool:
        return bool(call.args) and f"{ROBOTARIUM}().set_velocities" in origins(
            self._program.values.get(call.func, frozenset())
        )

    def _ids(self, call: ast.Call) -> Iterator[Ported]:
        ids = call.args[0]
        if isinstance(ids, ast.Constant | ast.List) and (
            not isinstance(ids, ast.List) or len(ids.elts) < 2
        ):
            yield Ported(
                call.lineno,
                ChangeKind.ARGUMENT,
                f"set_velocities({self._text.of(ids)}, ...): generation 1 ignores the ids, "
                "generation 2 commands these robots only; pass np.arange(N) for all",
            )

    def _prefix(self, call: ast.Call) -> str:
        func = call.func
        return f"{self._text.of(func.value)}." if isinstance(func, ast.Attribute) else ""

    def _made_first(self, call: ast.Call, name: str) -> Ported:
        """``at_pose(x, goal, e, r)`` → ``create_at_pose(e, r)(x, goal)[1].nonzero()``."""
        new, first = FUNCTIONS[name] or "", MADE_FIRST[name]
        names = list(parameters(name, 1))[:first]
        given = dict(zip(names, call.args, strict=False))
        given |= {k.arg: k.value for k in call.keywords if k.arg in names}
        options = [self._text.of(argument) for argument in call.args[first:]]
        options += [
            f"{k.arg}={self._text.of(k.value)}" for k in call.keywords if k.arg not in names
        ]
        if name == "at_position" and not options:
            options = ["position_error=0.02"]
        edits: tuple[Edit, ...] = ()
        if len(given) == len(names) and not any(k.arg is None for k in call.keywords):
            what = ", ".join(self._text.of(given[parameter]) for parameter in names)
            made = f"{self._prefix(call)}{new}({', '.join(options)})({what})[1].nonzero()"
            edits = (self._text.replace(call, made), *self._brought(call, new))
            self._mends(edits, call.func)
        return Ported(
            call.lineno, ChangeKind.NAME, f"{new} makes the function that {name} is", edits
        )

    def _at_once(self, call: ast.Call, name: str) -> None:
        """``single_integrator_to_unicycle2(dxi, x)`` → ``create_si_to_uni_dynamics()(dxi, x)``."""
        new, known = counterpart(name, 2) or "", OLD_AT_ONCE[name]
        options = [k for k in call.keywords if k.arg in known]
        if len(call.args) != 2 or len(options) < len(call.keywords):
            return
        made = ", ".join(f"{k.arg}={self._text.of(k.value)}" for k in options)
        what = ", ".join(self._text.of(argument) for argument in call.args)
        first = "[0]" if name in FIRST_OF_TWO else ""
        whole = f"{self._prefix(call)}{new}({made}){first}({what})"
        self._mends((self._text.replace(call, whole), *self._brought(call, new)), call.func)

    def _brought(self, call: ast.Call, name: str) -> tuple[Edit, ...]:
        starred = call.func in self._program.starred
        return self._renaming.brought(name) if starred else ()

    def _utility(self, call: ast.Call, name: str) -> Iterator[Ported]:
        new = FUNCTIONS.get(name, name)
        fresh = _signature(new, 2) if new else {}
        if new is None or not fresh:
            return
        if name in FIRST_OF_TWO:
            end = self._text.end(call)
            yield Ported(
                call.lineno,
                ChangeKind.NAME,
                f"{new} returns two functions, {name} the first of them",
                (self._text.make(end, end, "[0]"),),
            )
        yield from self._arguments(call, name, new, fresh)

    def _arguments(
        self, call: ast.Call, name: str, new: str, fresh: dict[str, Any]
    ) -> Iterator[Ported]:
        old = _signature(name, 1)
        renamed = renamed_parameters(name, 2)
        counted = name in OLD_COUNTED and self._older
        positional = call.args[1:] if counted else call.args
        given: dict[str, ast.expr] = dict(zip(old, positional, strict=False))
        given |= {k.arg: k.value for k in call.keywords if k.arg}
        changed = counted and (len(call.args) > 0 or "number_of_agents" in given)
        if counted:
            given.pop("number_of_agents", None)
        kept: list[str] = []
        for position, (argument, value) in enumerate(given.items()):
            target = renamed.get(argument, argument)
            if target not in fresh and argument in old:
                changed = True
                yield Ported(
                    call.lineno,
                    ChangeKind.ARGUMENT,
                    f"{new} has no argument {argument}; it is left out",
                )
                continue
            text = self._text.of(value)
            if position < len(positional) and not changed and list(fresh).index(target) == position:
                kept.append(text)
                continue
            changed |= position < len(positional) or target != argument
            kept.append(f"{target}={text}")
        for argument, default in old.items():
            target = renamed.get(argument, argument)
            if argument in given or target in given or target not in fresh:
                continue
            if default is not _EMPTY and not _same(default, fresh[target]):
                changed = True
                kept.append(f"{target}={_written(default)}")
                yield Ported(
                    call.lineno,
                    ChangeKind.DEFAULT,
                    f"{argument} of {name} is {_written(default)} by default, "
                    f"in generation 2 {_written(fresh[target])}",
                )
        if changed and not any(keyword.arg is None for keyword in call.keywords):
            edit = self._all_arguments(call, kept)
            self._mends((edit,), *call.args, *(keyword.value for keyword in call.keywords))
            message = f"arguments of {new} in generation 2: {', '.join(kept) or 'none'}"
            yield Ported(call.lineno, ChangeKind.ARGUMENT, message, (edit,))


@cache
def _signature(function: str, generation: int) -> dict[str, Any]:
    """Return the parameters of a function of the API and their defaults, in order."""
    home = next((m for m in API_MODULES if has(m, function, generation)), None)
    if home is None:
        return {}
    module = importlib.import_module(f"rps_compat.v{generation}{home.removeprefix('rps')}")
    signature = inspect.signature(getattr(module, function))
    return {p.name: p.default for p in signature.parameters.values()}


def _inner_first(tree: ast.AST) -> Iterator[ast.Call]:
    """Yield all calls, those within others before them."""
    for child in ast.iter_child_nodes(tree):
        yield from _inner_first(child)
    if isinstance(tree, ast.Call):
        yield tree


def _same(one: Any, other: Any) -> bool:
    if other is None:  # generation 2 leaves the arena's own boundaries out
        return hasattr(one, "shape")
    try:
        return bool((one == other) is True or (one == other).all())
    except (AttributeError, ValueError):
        return False


def _written(value: Any) -> str:
    return str(value.tolist()) if hasattr(value, "tolist") else repr(value)
